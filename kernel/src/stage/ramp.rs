//! Ramp: the share of the force that the device receives. It goes from 0 to 1 and back in a step per tick.

use crate::number::cell::{add, scale, sub};
use crate::number::kept::kept;

/// The share of a ramp, 0 to 1, after `done` of its `length`, in ticks or any unit of time. A ramp of length
/// 0 is complete.
#[must_use]
pub fn ramp_share(done: f32, length: f32) -> f32 {
    if done >= length { 1.0 } else { done / length }
}

/// Interpolates between two forces by a ramp's share \[N\].
#[must_use]
pub fn on_ramp(from_n: [f32; 3], to_n: [f32; 3], share: f32) -> [f32; 3] {
    add(from_n, scale(share, sub(to_n, from_n)))
}

kept! {
    /// State of the ramp.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub(super) struct Ramp {
        /// Steps taken, of `of`.
        taken: u16,
        of: u16,
        /// Ticks until the next step of a slow rise.
        rest: u16,
    }
}

/// Factor by which a slow rise is slower.
const SLOWER: u16 = 12;

impl Ramp {
    /// A ramp of `ticks` ticks at its bottom; with 0 it goes up and down at once.
    pub(super) const fn new(ticks: u16) -> Self {
        Self { taken: 0, of: if ticks == 0 { 1 } else { ticks }, rest: 0 }
    }

    /// Takes over the state of `of` on a ramp of this one's length.
    pub(super) fn along(self, of: Self) -> Self {
        Self { taken: of.taken.min(self.of), of: self.of, rest: of.rest.min(SLOWER) }
    }

    pub(super) fn fall(&mut self) {
        self.taken = 0;
    }

    pub(super) fn up(&mut self) {
        self.taken = self.taken.saturating_add(1).min(self.of);
    }

    /// Goes up a step every [`SLOWER`] calls, so that the hand's oscillation decays meanwhile.
    pub(super) fn creep_up(&mut self) {
        if self.rest == 0 {
            self.up();
            self.rest = SLOWER;
        }
        self.rest -= 1;
    }

    pub(super) fn down(&mut self) {
        self.taken = self.taken.saturating_sub(1);
    }

    /// Goes down by a step plus `fast` (0 to 1) times an eighth of the ramp. Without a ramp it does nothing
    /// and returns false.
    pub(super) fn back_off(&mut self, fast: f32) -> bool {
        let is_ramp = self.of > 1;
        if is_ramp {
            let steps = 1 + (fast * f32::from(self.of) / 8.0) as u16;
            self.taken = self.taken.saturating_sub(steps);
        }
        is_ramp
    }

    /// The ramp's share, 0 to 1.
    pub(super) fn share(&self) -> f32 {
        ramp_share(self.taken.into(), self.of.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // REQ-STG-06
    #[test]
    fn up_and_down_in_as_many_ticks() {
        let mut ramp = Ramp::new(4);
        let mut shares = std::vec::Vec::new();
        for _ in 0..5 {
            ramp.up();
            shares.push(ramp.share());
        }
        for _ in 0..5 {
            ramp.down();
            shares.push(ramp.share());
        }
        assert_eq!(shares, [0.25, 0.5, 0.75, 1.0, 1.0, 0.75, 0.5, 0.25, 0.0, 0.0]);
        let mut none = Ramp::new(0);
        none.up();
        assert_eq!(none.share(), 1.0);
        none.down();
        assert_eq!(none.share(), 0.0);
    }

    #[test]
    fn another_ramp_creeps_on_as_this_one_would() {
        let mut ramp = Ramp::new(100);
        for _ in 0..17 {
            ramp.creep_up();
        }
        assert_eq!(ramp.taken, 2);
        assert_eq!(Ramp::new(100).along(ramp), ramp);
    }
}
