//! The certified level: an upper bound of the energy that never rises by itself.

use crate::number::kept::kept;
use crate::number::two_float::TwoFloat;

kept! {
    /// The certified level: an upper bound of the energy of the published state, internal units.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Level {
        value: TwoFloat,
        /// True if the next pass at the published state sets the level anew.
        pub(super) forgotten: bool,
        /// Under a current drive: its work W at the published state, rounded up. The level then bounds E - W, see
        /// [`current`](crate::energy::current).
        work: Option<TwoFloat>,
    }
}

impl Level {
    /// The level of the rest shape.
    pub(crate) const REST: Self = Self { value: TwoFloat::ZERO, forgotten: false, work: None };

    /// Leading part of the level.
    pub(crate) fn leading(&self) -> f32 {
        self.value.hi
    }

    pub(crate) fn value(&self) -> TwoFloat {
        self.value
    }

    /// Returns true if the tool drives by a current.
    pub(crate) fn is_driven(&self) -> bool {
        self.work.is_some()
    }

    /// Starts a current drive, with a current of 0.
    pub(crate) fn begin_work(&mut self) {
        self.work = Some(TwoFloat::ZERO);
    }

    /// Sets the current's work up to the published state.
    pub(crate) fn note_work(&mut self, work: TwoFloat) {
        self.work = Some(work);
    }

    /// Ends the current drive: the level bounds E again.
    pub(crate) fn end_work(&mut self) {
        let energy = self.energy();
        self.work = None;
        self.put(energy);
    }

    /// Upper bound of the energy E of the published state.
    pub(crate) fn energy(&self) -> TwoFloat {
        let Some(work) = self.work else { return self.value };
        let energy = self.value.plus(work);
        if energy.hi > 0.0 { energy } else { TwoFloat::ZERO }
    }

    /// The published value of that bound; rounded up if it includes a current's work.
    pub(crate) fn published(&self) -> f32 {
        let energy = self.energy();
        if self.is_driven() && energy.lo > 0.0 { energy.hi.next_up() } else { energy.hi }
    }

    /// Drops the level after a change of the bands: the next pass at the published state sets it anew.
    pub(crate) fn forget(&mut self) {
        self.forgotten = true;
    }

    /// Returns true if the energy has to be computed anew.
    pub(crate) fn is_forgotten(&self) -> bool {
        self.forgotten
    }

    /// Adds the change of the energy, at most `change`, after the tool moved cells.
    pub(crate) fn shift(&mut self, change: TwoFloat) {
        self.put(self.value.plus(change));
    }

    /// Takes the level certified by a sweep; the level never rises by a sweep.
    pub(crate) fn certify(&mut self, level: TwoFloat) {
        let lowest = if self.forgotten { level } else { self.value.min(level) };
        self.set(lowest);
    }

    /// Sets the level to the energy that a pass computed.
    pub(crate) fn set(&mut self, level: TwoFloat) {
        self.forgotten = false;
        self.put(level);
    }

    /// Upper bound of the energy; `most` if the level is unknown.
    pub(crate) fn at_most(&self, most: f32) -> f32 {
        if self.forgotten { most } else { self.leading() }
    }

    /// Least by which the level has fallen since it was `before`, which was known or not; 0 if that is not known.
    pub(crate) fn fallen(&self, before: &Self) -> f32 {
        if before.forgotten || self.forgotten {
            return 0.0;
        }
        let fallen = before.value.minus(self.value);
        let least = if fallen.lo < 0.0 { fallen.hi.next_down() } else { fallen.hi };
        if least > 0.0 { least } else { 0.0 }
    }

    fn put(&mut self, level: TwoFloat) {
        self.value = if level.hi > 0.0 || self.is_driven() { level } else { TwoFloat::ZERO };
    }
}
