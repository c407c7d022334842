//! From one force to another without a jump.

use chaincell_kernel::stage::{on_ramp, ramp_share, slew_limited};
use nalgebra::Vector3;

use crate::session::timing::clock::MILLISECOND_NS;

/// What is shown of a force: after each cause for a jump it goes from what was shown last to the
/// force itself along a straight line, in a time of its own.
///
/// A step of a ramp is a millisecond of it at most, however late it comes: a process that stood
/// still makes the ramp longer, never steeper. Nor is it longer than a slew limit allows: the ramp
/// then ends where it has caught up.
#[derive(Debug, Clone)]
pub(crate) struct Ramp {
    /// Length of a ramp, 0 for none \[ns\].
    length_ns: u64,
    /// Largest step of a ramp in a millisecond, infinite for none \[N\].
    step_max_n: f32,
    from_n: [f32; 3],
    /// How much of the ramp is done \[ns\].
    done_ns: u64,
    /// Whether the force itself is shown.
    has_ended: bool,
    shown_n: [f32; 3],
    shown_at_ns: u64,
    largest_step_n: f32,
}

impl Ramp {
    /// Shows force 0 so far, and no ramp is under way.
    pub(crate) fn new(length_ms: u32, max_slew_n_per_s: f32) -> Self {
        let length_ns = u64::from(length_ms) * MILLISECOND_NS;
        Self {
            length_ns,
            step_max_n: 1e-3 * max_slew_n_per_s,
            from_n: [0.0; 3],
            done_ns: length_ns,
            has_ended: true,
            shown_n: [0.0; 3],
            shown_at_ns: 0,
            largest_step_n: 0.0,
        }
    }

    /// Begins a ramp at what was shown last.
    pub(crate) fn begin(&mut self) {
        self.from_n = self.shown_n;
        self.done_ns = 0;
        self.has_ended = self.length_ns == 0 && self.step_max_n == f32::INFINITY;
    }

    /// Begins a ramp at force 0, for somebody who was shown nothing yet.
    pub(crate) fn begin_at_zero(&mut self) {
        self.shown_n = [0.0; 3];
        self.begin();
    }

    /// As [`Self::begin`], towards force 0: nothing is left to do where 0 is shown already.
    pub(crate) fn begin_fall(&mut self) {
        self.begin();
        self.has_ended |= self.shown_n == [0.0; 3];
    }

    /// Whether the force itself is shown.
    pub(crate) fn is_done(&self) -> bool {
        self.has_ended
    }

    /// What to show of a force at a moment. One that is not finite is shown as 0.
    pub(crate) fn show(&mut self, force_n: [f32; 3], now_ns: u64) -> [f32; 3] {
        let is_finite = force_n.iter().all(|x| x.is_finite());
        let force_n = if is_finite { force_n } else { [0.0; 3] };
        let since_ns = now_ns.saturating_sub(self.shown_at_ns).min(MILLISECOND_NS);
        self.done_ns = self.done_ns.saturating_add(since_ns).min(self.length_ns);
        let mut shown_n = force_n;
        if !self.has_ended {
            let share = ramp_share(self.done_ns as f32, self.length_ns as f32);
            if share < 1.0 {
                shown_n = on_ramp(self.from_n, force_n, share);
            }
            let limited_n = slew_limited(self.shown_n, shown_n, self.step_max_n);
            self.has_ended = share >= 1.0 && limited_n == shown_n;
            shown_n = limited_n;
        }
        let step_n = (Vector3::from(shown_n) - Vector3::from(self.shown_n)).norm();
        self.largest_step_n = self.largest_step_n.max(step_n);
        self.shown_n = shown_n;
        self.shown_at_ns = now_ns;
        shown_n
    }

    /// Largest change between two forces shown one after the other \[N\].
    pub(crate) fn largest_step_n(&self) -> f32 {
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

    #[test]
    fn without_a_cause_the_force_itself_is_shown() {
        let mut ramp = Ramp::new(20, f32::INFINITY);
        assert_eq!(ramp.show(FORCE, 0), FORCE);
        assert_eq!(ramp.show([0.5; 3], 10), [0.5; 3]);
        assert_eq!(ramp.show([f32::NAN, 0.0, 0.0], 20), [0.0; 3]);
        assert_eq!(ramp.largest_step_n(), 13.0_f32.max(size([2.5, -4.5, 11.5])));
    }

    #[test]
    fn a_fall_and_a_rise_take_their_time_and_no_step_is_larger_than_its_share() {
        let mut ramp = Ramp::new(20, f32::INFINITY);
        let mut now_ns = MILLISECOND_NS;
        ramp.show(FORCE, now_ns);
        ramp.begin_fall();
        let mut last_n = 13.0;
        // Steps come early, in time and 40 ms late.
        for (step, span_ns) in [1, 1, 40, 1, 1].repeat(4).into_iter().enumerate() {
            assert!(!ramp.is_done(), "step {step}");
            now_ns += span_ns * MILLISECOND_NS;
            let shown_n = size(ramp.show([0.0; 3], now_ns));
            assert!((last_n - shown_n - 13.0 / 20.0).abs() < 1e-4, "step {step}: {shown_n}");
            last_n = shown_n;
        }
        assert!(ramp.is_done());
        ramp.begin();
        assert_eq!(ramp.show(FORCE, now_ns), [0.0; 3], "a burst of poses makes no force");
        for step in 1..=40 {
            now_ns += MILLISECOND_NS / 2;
            let shown_n = size(ramp.show(FORCE, now_ns));
            assert!((shown_n - 13.0 * step as f32 / 40.0).abs() < 1e-4, "step {step}: {shown_n}");
        }
        assert_eq!(ramp.show(FORCE, now_ns), FORCE);
    }

    #[test]
    fn a_ramp_that_is_cut_short_goes_on_from_where_it_was() {
        let mut ramp = Ramp::new(4, f32::INFINITY);
        ramp.show(FORCE, 0);
        ramp.begin_fall();
        assert_eq!(size(ramp.show([0.0; 3], MILLISECOND_NS)), 9.75);
        ramp.begin();
        assert_eq!(size(ramp.show(FORCE, MILLISECOND_NS)), 9.75);
        assert_eq!(ramp.show(FORCE, 9 * MILLISECOND_NS).map(f32::signum), [1.0, -1.0, 1.0]);
        assert!(!ramp.is_done());
    }

    #[test]
    fn nothing_falls_from_zero_and_a_ramp_of_0_ms_is_a_jump() {
        let mut ramp = Ramp::new(20, f32::INFINITY);
        ramp.show([0.0; 3], 0);
        ramp.begin_fall();
        assert!(ramp.is_done());
        let mut jump = Ramp::new(0, f32::INFINITY);
        jump.show(FORCE, 0);
        jump.begin_fall();
        assert!(jump.is_done());
        assert_eq!(jump.show([0.0; 3], 0), [0.0; 3]);
        assert_eq!(jump.largest_step_n(), 13.0);
    }

    #[test]
    fn a_slew_limit_holds_back_both_ways() {
        let mut ramp = Ramp::new(4, 2000.0);
        ramp.begin();
        let mut shown = Vec::new();
        for ms in 1..=8 {
            shown.push(size(ramp.show(FORCE, ms * MILLISECOND_NS)));
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
        let falls = (9..=15).map(|ms| size(ramp.show([0.0; 3], ms * MILLISECOND_NS)));
        assert!(falls.zip([11.0, 9.0, 7.0, 5.0, 3.0, 1.0, 0.0]).all(|(a, b)| near(a, b)));
        assert!(ramp.is_done() && near(ramp.largest_step_n(), 2.0));
    }
}
