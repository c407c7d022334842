//! Which ticks of a motion count: those from tick 30 on, and apart from them those in which the
//! body snaps from one equilibrium to another.
//!
//! A snap is a tick in which the reference's force changes by more than 5 % of its largest value,
//! with the 15 ticks after it. A setting is judged by the ticks outside; its errors inside have a
//! column of their own. Where snaps would take more than 15 % of the ticks that count, none is left
//! out: such a press says little about a scheme.

use chaincell_host::engine::convergence::Errors;
use serde::Serialize;

use crate::experiments::page::table::percent;
use crate::reference::vectors::{minus, norm};

/// First tick whose error counts: before it everything is small.
pub const FIRST_TICK: usize = 30;
/// A change of the force in a tick beyond this part of its largest value is a snap.
pub const CHANGE: f64 = 0.05;
/// Ticks after it that belong to it.
pub const TICKS_AFTER: usize = 15;
/// Largest part of the ticks that count which snaps may take.
pub const SHARE_MAX: f64 = 0.15;

/// The snaps of a reference's path.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Snaps {
    /// Ticks in which the force jumps, of ticks in a row the first.
    pub ticks: Vec<usize>,
    /// Part of the ticks that count which they would take.
    pub share: f64,
    /// Whether that is more than they may take, so that none is left out.
    pub too_many: bool,
    #[serde(skip)]
    jumps: Vec<usize>,
}

/// Largest, median and other values of an error \[fraction\].
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Spread {
    /// Half of the ticks outside snaps are below.
    pub median: f64,
    /// Nine of ten are.
    pub p90: f64,
    /// Largest outside snaps.
    pub largest: f64,
    /// Largest inside snaps; none without such ticks.
    pub in_snaps: Option<f64>,
}

impl Snaps {
    /// The snaps of a path of forces, tick by tick.
    pub fn of(forces: &[[f64; 3]]) -> Self {
        let limit = CHANGE * forces.iter().map(|force| norm(*force)).fold(0.0, f64::max);
        let changes = forces.windows(2).map(|pair| norm(minus(pair[1], pair[0])));
        let jumps: Vec<usize> = (1..)
            .zip(changes)
            .filter(|(_, change)| *change > limit)
            .map(|(tick, _)| tick)
            .collect();
        let follows = |tick: usize| jumps.contains(&(tick.wrapping_sub(1)));
        let ticks = jumps.iter().copied().filter(|&tick| !follows(tick)).collect();
        let mut snaps = Self { ticks, jumps, ..Self::default() };
        let counted = FIRST_TICK..forces.len();
        let inside = counted.clone().filter(|&tick| snaps.is_near(tick)).count();
        snaps.share = inside as f64 / counted.len().max(1) as f64;
        snaps.too_many = snaps.share > SHARE_MAX;
        snaps
    }

    fn is_near(&self, tick: usize) -> bool {
        self.jumps.iter().any(|&jump| (jump..=jump + TICKS_AFTER).contains(&tick))
    }

    /// Whether a tick is left out as part of a snap.
    pub fn hold(&self, tick: usize) -> bool {
        !self.too_many && self.is_near(tick)
    }

    /// Errors by tick, those that count, apart by whether they are inside snaps.
    pub fn spread(&self, errors: &[(usize, f64)]) -> Spread {
        let counted = errors.iter().copied().filter(|(tick, _)| *tick >= FIRST_TICK);
        let (inside, outside): (Vec<_>, Vec<_>) = counted.partition(|(tick, _)| self.hold(*tick));
        let outside = Errors::of(outside.into_iter().map(|(_, error)| error));
        let within = |percent| outside.as_ref().map_or(0.0, |errors| errors.within(percent));
        let inside = inside.into_iter().map(|(_, error)| error);
        Spread {
            median: within(50),
            p90: within(90),
            largest: within(100),
            in_snaps: inside.max_by(f64::total_cmp),
        }
    }

    /// The part of the ticks that is left out, for a table.
    pub fn share_words(&self) -> String {
        let share = percent(self.share);
        if self.too_many { format!("0 (snaps take {share})") } else { share }
    }

    /// The rule, for the text of a report.
    pub fn rule() -> String {
        format!(
            "Errors count from tick {FIRST_TICK} on. A snap is a tick in which the force of the \
             reference changes by more than {:.0} % of its largest value, with the {TICKS_AFTER} \
             ticks after it; errors inside stand apart. Where snaps would take more than {:.0} % of \
             the ticks that count, none is left out, and the table says so.",
            100.0 * CHANGE,
            100.0 * SHARE_MAX
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force that falls slowly from 2 N, and by `fall` more at each of `jumps`.
    fn path(end: usize, jumps: &[usize], fall: f64) -> Vec<[f64; 3]> {
        let fallen = |tick: usize| jumps.iter().filter(|&&jump| jump <= tick).count() as f64;
        let force = |tick: usize| 2.0 - tick as f64 / end as f64 - fall * fallen(tick);
        (0..=end).map(|tick| [0.0, force(tick), 0.0]).collect()
    }

    fn held(snaps: &Snaps, end: usize) -> Vec<usize> {
        (0..=end).filter(|&tick| snaps.hold(tick)).collect()
    }

    #[test]
    fn a_jump_of_the_force_and_the_fifteen_ticks_after_are_a_snap() {
        let snaps = Snaps::of(&path(300, &[200], 0.11));
        assert_eq!((snaps.ticks.clone(), snaps.too_many), (vec![200], false));
        assert_eq!(held(&snaps, 300), (200..=215).collect::<Vec<_>>());
        assert!((snaps.share - 16.0 / 271.0).abs() < 1e-12, "{}", snaps.share);
        // 5 % of the largest force of 2 N, less what the force changes anyway.
        assert!(Snaps::of(&path(300, &[200], 0.09)).ticks.is_empty());
    }

    #[test]
    fn jumps_in_a_row_are_one_snap_that_lasts_until_fifteen_ticks_after_the_last() {
        let snaps = Snaps::of(&path(300, &[200, 201, 205], 0.15));
        assert_eq!(snaps.ticks, [200, 205]);
        assert_eq!(held(&snaps, 300), (200..=220).collect::<Vec<_>>());
    }

    #[test]
    fn snaps_that_take_more_than_the_share_are_not_left_out() {
        // 32 of 271 ticks, then 48 of them: 11.8 % and 17.7 %.
        let few = Snaps::of(&path(300, &[100, 200], 0.15));
        assert!(!few.too_many && few.share < SHARE_MAX && few.hold(100));
        let many = Snaps::of(&path(300, &[100, 150, 200], 0.15));
        assert!(many.too_many && many.share > SHARE_MAX);
        assert!(held(&many, 300).is_empty());
        assert!(many.share_words().contains("18"), "{}", many.share_words());
        let errors = [(99, 0.01), (100, 0.5)];
        assert_eq!(many.spread(&errors).largest, 0.5);
    }

    #[test]
    fn errors_count_from_the_thirtieth_tick_and_apart_inside_snaps() {
        let snaps = Snaps::of(&path(300, &[200], 0.15));
        let errors: Vec<(usize, f64)> = (0..=300)
            .map(|tick| match tick {
                0..30 => (tick, 9.0),
                30 => (tick, 0.4),
                200..=215 => (tick, 0.7),
                216 => (tick, 0.3),
                _ => (tick, 0.1),
            })
            .collect();
        let found = snaps.spread(&errors);
        let expected = Spread { median: 0.1, p90: 0.1, largest: 0.4, in_snaps: Some(0.7) };
        assert_eq!(found, expected);
        assert_eq!(Snaps::default().spread(&errors).in_snaps, None);
    }
}
