//! When the links' bands close (unloading, the paper's Fig. 5b).

use super::choices::Unloading;
use super::order::Tick;
use super::sample::Flags;
use crate::number::cell::{dot, sub};
use crate::number::sqrt::sqrt;
use crate::solver::Dynamics;

/// How far the tool comes back from its deepest point before the bands close [mean link lengths].
const RETREAT: f32 = 0.1;

impl<D: Dynamics> Tick<'_, '_, D> {
    /// Closes or reopens the bands.
    pub(super) fn unload(&mut self) {
        let way = sub(self.head.applied, self.head.touched_at);
        let depth = sqrt(dot(way, way));
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
