//! Unloading: closes the links' bands (the paper's Fig. 5b).
//!
//! Closed bands admit only the rest length, so every link restores the rest shape. Flag 32 is set while they
//! are closed.
//!
//! | unloading | bands are closed |
//! |---|---|
//! | `off` | never |
//! | `release` | from the tool's release until it engages again |
//! | `retreat` | also while the tool has retreated by more than 0.1 mean link lengths from its deepest point, until it passes that point |
//!
//! Closing a band may raise the energy: it is the only external action besides a motion of the tool. With
//! `release` it acts on a free body. With `retreat` it acts on the tool, which then gets back more energy
//! than it gave: 2.4 to 4.8 mJ on the paper's plane (`chaincell paper`). With alpha 0 the bands admit only
//! the rest length anyway, and unloading changes no force. Every change of the bands computes the certified
//! level anew and wakes the whole body.

use super::choices::Unloading;
use super::order::Tick;
use super::sample::Flags;
use crate::number::cell::dot;
use crate::number::sqrt::sqrt;
use crate::solver::Dynamics;

/// Distance by which the tool retreats from its deepest point before the bands close [mean link lengths].
const RETREAT: f32 = 0.1;

impl<D: Dynamics> Tick<'_, '_, D> {
    /// Closes or reopens the bands.
    pub(super) fn unload(&mut self) {
        let depth = sqrt(dot(self.head.applied, self.head.applied));
        let released = self.head.released;
        let closed = match self.network.settings().unloading {
            Unloading::Off => false,
            Unloading::Release => released,
            Unloading::Retreat if released => true,
            Unloading::Retreat if depth > self.head.deepest => false,
            Unloading::Retreat => self.head.closed || depth < self.head.deepest - RETREAT,
        };
        if depth > self.head.deepest {
            self.head.deepest = depth;
        }
        if closed != self.head.closed {
            self.head.closed = closed;
            self.head.level.forget();
            self.head.dynamics.interrupt();
            self.head.awake.wake_all(self.network.model());
        }
        if closed {
            self.flags.insert(Flags::BAND_CLOSED);
        }
    }
}
