//! Ramp: the share of the force that is given, from 0 to 1 and back in steps of a tick.

use crate::number::cell::{add, scale, sub};
use crate::number::kept::kept;

/// The share of a ramp, 0 to 1, after so much of its length, in ticks or in any unit of time. A
/// ramp of length 0 is at its end.
#[must_use]
pub fn ramp_share(done: f32, length: f32) -> f32 {
    if done >= length { 1.0 } else { done / length }
}

/// What a share of a ramp from one force to another gives \[N\].
#[must_use]
pub fn on_ramp(from_n: [f32; 3], to_n: [f32; 3], share: f32) -> [f32; 3] {
    add(from_n, scale(share, sub(to_n, from_n)))
}

/// Where the ramp stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ramp {
    /// Steps taken of `of`.
    taken: u16,
    of: u16,
    /// Ticks until the next step of a slow rise.
    rest: u16,
}

kept!(Ramp { taken: u16, of: u16, rest: u16 });

/// How much slower a slow rise is.
const SLOWER: u16 = 12;

impl Ramp {
    /// At the bottom of a ramp of so many ticks; 0 for one that goes up and down at once.
    pub(super) const fn new(ticks: u16) -> Self {
        Self { taken: 0, of: if ticks == 0 { 1 } else { ticks }, rest: 0 }
    }

    /// As it stands, on a ramp of the length of this one.
    pub(super) fn along(self, of: Self) -> Self {
        Self { taken: of.taken.min(self.of), of: self.of, rest: of.rest.min(SLOWER) }
    }

    pub(super) fn fall(&mut self) {
        self.taken = 0;
    }

    pub(super) fn up(&mut self) {
        self.taken = self.taken.saturating_add(1).min(self.of);
    }

    /// Up by a step in [`SLOWER`] calls: a hand's swing dies away meanwhile.
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

    /// Down by a step and the share `fast`, 0 to 1, of an eighth; false without a ramp, which stays as it
    /// is.
    pub(super) fn back_off(&mut self, fast: f32) -> bool {
        let is_ramp = self.of > 1;
        if is_ramp {
            let steps = 1 + (fast * f32::from(self.of) / 8.0) as u16;
            self.taken = self.taken.saturating_sub(steps);
        }
        is_ramp
    }

    /// The share, 0 to 1.
    pub(super) fn share(&self) -> f32 {
        ramp_share(self.taken.into(), self.of.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
