//! Watchdog: counts the ticks without a sample.

use crate::number::kept::kept;

kept! {
    /// Ticks since the last sample.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub(super) struct Watchdog {
        silent: u32,
    }
}

impl Watchdog {
    pub(super) const NEW: Self = Self { silent: 0 };

    /// Notes a sample.
    pub(super) fn hear(&mut self) {
        self.silent = 0;
    }

    /// Notes a tick without a sample. Returns true if the force has to fall: after more than `ticks` such
    /// ticks in a row, and never if `ticks` is 0.
    pub(super) fn miss(&mut self, ticks: u16) -> bool {
        self.silent = self.silent.saturating_add(1);
        ticks > 0 && self.silent > u32::from(ticks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // REQ-STG-06
    #[test]
    fn the_force_falls_after_so_many_ticks_without_a_sample() {
        let mut dog = Watchdog::NEW;
        assert_eq!([dog.miss(2), dog.miss(2), dog.miss(2)], [false, false, true]);
        dog.hear();
        assert!(!dog.miss(1) && dog.miss(1));
        assert!((0..100).all(|_| !dog.miss(0)));
    }
}
