//! Ramps from one force to another without a jump.

use chaincell_kernel::TOOLS_MAX;
use chaincell_kernel::stage::{on_ramp, ramp_share, slew_limited};
use nalgebra::Vector3;

use crate::clock::MILLISECOND_NS;

/// Shortest time in which a force grows after a limit was raised \[ns\].
const RAISE_NS: u64 = 1000 * MILLISECOND_NS;

/// Forces and torques of all tools as the device gets them; a server without `--tool` sets only the
/// first force.
///
/// ```
/// use chaincell_client::ramp::Shown;
///
/// let shown = Shown::of([0.0, 0.0, 2.0]);
/// assert_eq!((shown.force_n[0], shown.force_n[1]), ([0.0, 0.0, 2.0], [0.0; 3])); // [N]
/// assert_eq!(shown.torque_n_m, [[0.0; 3]; 8]); // [N m]
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shown {
    /// Force of each \[N\].
    pub force_n: [[f32; 3]; TOOLS_MAX],
    /// Torque of each \[N m\].
    pub torque_n_m: [[f32; 3]; TOOLS_MAX],
}

impl Shown {
    /// No force and no torque.
    pub const ZERO: Self =
        Self { force_n: [[0.0; 3]; TOOLS_MAX], torque_n_m: [[0.0; 3]; TOOLS_MAX] };

    /// One force.
    pub fn of(force_n: [f32; 3]) -> Self {
        let mut shown = Self::ZERO;
        shown.force_n[0] = force_n;
        shown
    }

    /// Replaces vectors that are not finite by 0.
    fn finite(self) -> Self {
        let finite = |v: [f32; 3]| if v.iter().all(|x| x.is_finite()) { v } else { [0.0; 3] };
        Self { force_n: self.force_n.map(finite), torque_n_m: self.torque_n_m.map(finite) }
    }

    /// Interpolates on the straight line from `self` to `to`; `share` is from 0 to 1.
    fn on_ramp(&self, to: &Self, share: f32) -> Self {
        let mut between = *to;
        let pairs = between.force_n.iter_mut().zip(&self.force_n);
        for (to, from) in pairs.chain(between.torque_n_m.iter_mut().zip(&self.torque_n_m)) {
            *to = on_ramp(*from, *to, share);
        }
        between
    }

    /// Largest force of a tool \[N\].
    fn largest_n(&self) -> f32 {
        self.step_n(&Self::ZERO)
    }

    /// Largest change of a tool's force between `from` and `self` \[N\].
    fn step_n(&self, from: &Self) -> f32 {
        let steps = self.force_n.iter().zip(&from.force_n);
        let steps = steps.map(|(to, from)| (Vector3::from(*to) - Vector3::from(*from)).norm());
        steps.fold(0.0, f32::max)
    }
}

/// Shapes a force: after each cause for a jump the shown force goes from its last value to the
/// target along a straight line, in the ramp's length.
///
/// A step advances a ramp by a millisecond at most, however late it comes: a suspended process makes
/// the ramp longer, never steeper. A step is also limited by the slew limit: the ramp then ends when
/// the shown force has reached the target. Forces and torques of several tools share one ramp; the
/// slew limit of the output stage applies to each force.
///
/// ```
/// use chaincell_client::clock::MILLISECOND_NS;
/// use chaincell_client::ramp::{Ramp, Shown};
///
/// let mut ramp = Ramp::new(4, f32::INFINITY); // 4 ms, no slew limit
/// ramp.show(&Shown::of([0.0, 0.0, 8.0]), 0);
/// ramp.begin_fall();
/// let mut falling_n = [0.0; 4];
/// for (ms, force_n) in (1..).zip(&mut falling_n) {
///     *force_n = ramp.show(&Shown::ZERO, ms * MILLISECOND_NS).force_n[0][2];
/// }
/// assert_eq!(falling_n, [6.0, 4.0, 2.0, 0.0]); // [N]
/// assert!(ramp.is_done() && ramp.largest_step_n() == 8.0); // the first force came at once
/// ```
#[derive(Debug, Clone)]
pub struct Ramp {
    /// Length of a ramp, 0 for none, and length of the active one for growing forces \[ns\].
    length_ns: u64,
    rise_ns: u64,
    /// Largest step of a force, that of a millisecond at the slew limit; infinite for no limit \[N\].
    step_max_n: f32,
    from: Shown,
    /// Time done of the ramp \[ns\].
    done_ns: u64,
    /// True if the target force itself is shown.
    has_ended: bool,
    shown: Shown,
    shown_at_ns: u64,
    largest_step_n: f32,
}

impl Ramp {
    /// Starts with force 0 shown and no ramp active.
    pub fn new(length_ms: u32, max_slew_n_per_s: f32) -> Self {
        let length_ns = u64::from(length_ms) * MILLISECOND_NS;
        Self {
            length_ns,
            rise_ns: length_ns,
            step_max_n: 1e-3 * max_slew_n_per_s,
            from: Shown::ZERO,
            done_ns: length_ns,
            has_ended: true,
            shown: Shown::ZERO,
            shown_at_ns: 0,
            largest_step_n: 0.0,
        }
    }

    /// Begins a ramp at the force shown last.
    pub fn begin(&mut self) {
        self.from = self.shown;
        (self.done_ns, self.rise_ns) = (0, self.length_ns);
        self.has_ended = self.length_ns == 0 && self.step_max_n == f32::INFINITY;
    }

    /// As [`Self::begin`], for a limit that was changed: a growing force takes at least a second.
    pub fn begin_raise(&mut self) {
        self.begin();
        (self.rise_ns, self.has_ended) = (self.length_ns.max(RAISE_NS), false);
    }

    /// Begins a ramp at force 0, for a reader that was shown no force yet.
    pub fn begin_at_zero(&mut self) {
        self.shown = Shown::ZERO;
        self.begin();
    }

    /// As [`Self::begin`], towards force 0: the ramp has ended if 0 is shown already.
    pub fn begin_fall(&mut self) {
        self.begin();
        self.has_ended |= self.shown == Shown::ZERO;
    }

    /// Returns true if the target force itself is shown.
    pub fn is_done(&self) -> bool {
        self.has_ended
    }

    /// Returns the forces and torques to show at `now_ns`, on the ramp to `target`; 0 for vectors that
    /// are not finite.
    pub fn show(&mut self, target: &Shown, now_ns: u64) -> Shown {
        let target = target.finite();
        let since_ns = now_ns.saturating_sub(self.shown_at_ns).min(MILLISECOND_NS);
        let grows = target.largest_n() > self.from.largest_n();
        let length_ns = if grows { self.rise_ns } else { self.length_ns };
        self.done_ns = self.done_ns.saturating_add(since_ns).min(length_ns);
        let mut shown = target;
        if !self.has_ended {
            let share = ramp_share(self.done_ns as f32, length_ns as f32);
            if share < 1.0 {
                shown = self.from.on_ramp(&target, share);
            }
            let wanted_n = shown.force_n;
            for (to, from) in shown.force_n.iter_mut().zip(&self.shown.force_n) {
                *to = slew_limited(*from, *to, self.step_max_n);
            }
            self.has_ended = share >= 1.0 && shown.force_n == wanted_n;
        }
        self.largest_step_n = self.largest_step_n.max(shown.step_n(&self.shown));
        self.shown = shown;
        self.shown_at_ns = now_ns;
        shown
    }

    /// Returns the largest change between two forces shown one after the other \[N\].
    pub fn largest_step_n(&self) -> f32 {
        self.largest_step_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FORCE: [f32; 3] = [3.0, -4.0, 12.0];

    fn size(force_n: [f32; 3]) -> f32 {
        Vector3::from(force_n).norm()
    }

    impl Ramp {
        /// Shows a single force.
        fn force_n(&mut self, force_n: [f32; 3], now_ns: u64) -> [f32; 3] {
            self.show(&Shown::of(force_n), now_ns).force_n[0]
        }
    }

    /// All fall along their own lines in the same time, and end at exactly 0.
    #[test]
    fn forces_and_torques_of_all_tools_go_along_together() {
        let mut all = Shown::of(FORCE);
        all.force_n[3] = [0.0, -2.0, 0.0];
        (all.torque_n_m[0], all.torque_n_m[7]) = ([0.5, 0.0, 0.0], [f32::NAN, 0.0, 0.0]);
        let mut ramp = Ramp::new(4, f32::INFINITY);
        let shown = ramp.show(&all, 0);
        assert_eq!((shown.torque_n_m[0], shown.torque_n_m[7]), ([0.5, 0.0, 0.0], [0.0; 3]));
        ramp.begin_fall();
        for ms in 1..=4_u8 {
            assert!(!ramp.is_done());
            let shown = ramp.show(&Shown::ZERO, u64::from(ms) * MILLISECOND_NS);
            let left = f32::from(4 - ms) / 4.0;
            let near = |a: [f32; 3], b: [f32; 3]| (0..3).all(|x| (a[x] - left * b[x]).abs() < 1e-6);
            assert!(near(shown.force_n[0], FORCE) && near(shown.force_n[3], [0.0, -2.0, 0.0]));
            assert!(near(shown.torque_n_m[0], [0.5, 0.0, 0.0]), "{ms}: {shown:?}");
            assert_eq!(shown == Shown::ZERO, ms == 4);
        }
        // A torque alone is something to let fall.
        let mut torque = Shown::ZERO;
        torque.torque_n_m[1] = [0.0, 0.0, 0.25];
        let mut ramp = Ramp::new(4, f32::INFINITY);
        ramp.show(&torque, 0);
        ramp.begin_fall();
        assert!(!ramp.is_done());
    }

    #[test]
    fn without_a_cause_the_force_itself_is_shown() {
        let mut ramp = Ramp::new(20, f32::INFINITY);
        assert_eq!(ramp.force_n(FORCE, 0), FORCE);
        assert_eq!(ramp.force_n([0.5; 3], 10), [0.5; 3]);
        assert_eq!(ramp.force_n([f32::NAN, 0.0, 0.0], 20), [0.0; 3]);
        assert_eq!(ramp.largest_step_n(), 13.0_f32.max(size([2.5, -4.5, 11.5])));
    }

    #[test]
    fn a_fall_and_a_rise_take_their_time_and_no_step_is_larger_than_its_share() {
        let mut ramp = Ramp::new(20, f32::INFINITY);
        let mut now_ns = MILLISECOND_NS;
        ramp.force_n(FORCE, now_ns);
        ramp.begin_fall();
        let mut last_n = 13.0;
        // Steps come early, in time and 40 ms late.
        for (step, span_ns) in [1, 1, 40, 1, 1].repeat(4).into_iter().enumerate() {
            assert!(!ramp.is_done(), "step {step}");
            now_ns += span_ns * MILLISECOND_NS;
            let shown_n = size(ramp.force_n([0.0; 3], now_ns));
            assert!((last_n - shown_n - 13.0 / 20.0).abs() < 1e-4, "step {step}: {shown_n}");
            last_n = shown_n;
        }
        assert!(ramp.is_done());
        ramp.begin();
        assert_eq!(ramp.force_n(FORCE, now_ns), [0.0; 3], "a burst of poses makes no force");
        for step in 1..=40 {
            now_ns += MILLISECOND_NS / 2;
            let shown_n = size(ramp.force_n(FORCE, now_ns));
            assert!((shown_n - 13.0 * step as f32 / 40.0).abs() < 1e-4, "step {step}: {shown_n}");
        }
        assert_eq!(ramp.force_n(FORCE, now_ns), FORCE);
    }

    #[test]
    fn a_ramp_that_is_cut_short_goes_on_from_where_it_was() {
        let mut ramp = Ramp::new(4, f32::INFINITY);
        ramp.force_n(FORCE, 0);
        ramp.begin_fall();
        assert_eq!(size(ramp.force_n([0.0; 3], MILLISECOND_NS)), 9.75);
        ramp.begin();
        assert_eq!(size(ramp.force_n(FORCE, MILLISECOND_NS)), 9.75);
        assert_eq!(ramp.force_n(FORCE, 9 * MILLISECOND_NS).map(f32::signum), [1.0, -1.0, 1.0]);
        assert!(!ramp.is_done());
    }

    #[test]
    fn nothing_falls_from_zero_and_a_ramp_of_0_ms_is_a_jump() {
        let mut ramp = Ramp::new(20, f32::INFINITY);
        ramp.force_n([0.0; 3], 0);
        ramp.begin_fall();
        assert!(ramp.is_done());
        let mut jump = Ramp::new(0, f32::INFINITY);
        jump.force_n(FORCE, 0);
        jump.begin_fall();
        assert!(jump.is_done());
        assert_eq!(jump.force_n([0.0; 3], 0), [0.0; 3]);
        assert_eq!(jump.largest_step_n(), 13.0);
    }

    #[test]
    fn a_slew_limit_holds_back_both_ways() {
        let mut ramp = Ramp::new(4, 2000.0);
        ramp.begin();
        let mut shown = Vec::new();
        for ms in 1..=8 {
            shown.push(size(ramp.force_n(FORCE, ms * MILLISECOND_NS)));
        }
        let near = |a: f32, b: f32| (a - b).abs() < 1e-5;
        assert!(
            shown
                .iter()
                .zip([2.0, 4.0, 6.0, 8.0, 10.0, 12.0, 13.0, 13.0])
                .all(|(&a, b)| near(a, b)),
            "{shown:?}"
        );
        assert!(ramp.is_done());
        ramp.begin_fall();
        let falls = (9..=15).map(|ms| size(ramp.force_n([0.0; 3], ms * MILLISECOND_NS)));
        assert!(falls.zip([11.0, 9.0, 7.0, 5.0, 3.0, 1.0, 0.0]).all(|(a, b)| near(a, b)));
        assert!(ramp.is_done() && near(ramp.largest_step_n(), 2.0));
    }
}
