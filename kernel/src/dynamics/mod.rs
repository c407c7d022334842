//! The schemes that move the network's state, one file each.

mod conjugate;
mod euler;
mod gauss_seidel;
mod guard;
mod rkl1;
mod rkl2;
mod super_step;
mod track;

pub use euler::Euler;
pub use gauss_seidel::GaussSeidel;
pub use rkl1::Rkl1;
pub use rkl2::Rkl2;
pub use track::Track;

use crate::awake::Awake;
use crate::cell::{Cell, add, from_single, peak};
use crate::contact::Contact;
use crate::hats::{Coarse, Eight};
use crate::model::Model;
use crate::number::Number;
use crate::pass::Links;
use crate::settings::Settings;
use crate::two_float::TwoFloat;

/// The certified level: an upper bound of the energy of the published state, internal units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    value: TwoFloat,
    /// The next pass at the published state sets the level anew.
    forgotten: bool,
    /// While the tool drives by a current: its work W at the published state, rounded up. The level
    /// is then one of E - W, see [`current`](crate::current).
    work: Option<TwoFloat>,
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

    /// Whether the tool drives by a current.
    pub(crate) fn is_driven(&self) -> bool {
        self.work.is_some()
    }

    /// The tool takes hold to drive by a current, which is 0 yet.
    pub(crate) fn begin_work(&mut self) {
        self.work = Some(TwoFloat::ZERO);
    }

    /// The current has done this work, up to the published state.
    pub(crate) fn note_work(&mut self, work: TwoFloat) {
        self.work = Some(work);
    }

    /// The current is 0 from here on: the level is one of E again.
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

    /// The same as it is published; rounded up where a current's work is part of it.
    pub(crate) fn published(&self) -> f32 {
        let energy = self.energy();
        if self.is_driven() && energy.lo > 0.0 { energy.hi.next_up() } else { energy.hi }
    }

    /// The bands changed: the next pass at the published state sets the level anew.
    pub(crate) fn forget(&mut self) {
        self.forgotten = true;
    }

    /// The tool moved cells, which changed the energy by at most `change`.
    pub(crate) fn shift(&mut self, change: TwoFloat) {
        self.put(self.value.plus(change));
    }

    /// A sweep certified `level`; the level never rises by a sweep.
    pub(crate) fn certify(&mut self, level: TwoFloat) {
        let lowest = if self.forgotten { level } else { self.value.min(level) };
        self.set(lowest);
    }

    /// A pass found the energy itself.
    pub(crate) fn set(&mut self, level: TwoFloat) {
        self.forgotten = false;
        self.put(level);
    }

    /// The largest that the energy may be, `most` where that is not known yet.
    pub(crate) fn at_most(&self, most: f32) -> f32 {
        if self.forgotten { most } else { self.leading() }
    }

    fn put(&mut self, level: TwoFloat) {
        self.value = if level.hi > 0.0 || self.is_driven() { level } else { TwoFloat::ZERO };
    }
}

/// What a scheme works on during one sweep.
pub(crate) struct Body<'a, 'm, N = f32> {
    pub links: Links<'a, 'm>,
    pub settings: &'a Settings,
    /// Cells that the tool acts on: those it holds, or those that the links' current flows into.
    pub contacts: &'a [Contact<N>],
    /// Cells the tool holds: they do not move in a sweep.
    pub held: &'a [Contact<N>],
    /// Where the tool holds them, relative to their origins.
    pub applied: [f32; 3],
    /// State v of every cell; its output is published.
    pub state: &'a mut [Cell<N>],
    /// Room for the residual.
    pub residual: &'a mut [Cell<N>],
    /// The scheme's own arrays, one after the other, each as long as `state`.
    pub own: &'a mut [Cell<N>],
    /// Room for a coarse level.
    pub room: &'a mut [Eight],
    /// How the coarse level leaves the held cells alone; `None` where it cannot.
    pub coarse: Option<Coarse>,
    /// The slices that a sweep looks at.
    pub awake: &'a mut Awake,
    pub level: &'a mut Level,
}

impl<N: Number> Body<'_, '_, N> {
    /// Puts the held cells back where the tool has them; whether one of them is beyond K.
    pub fn restore_held(&mut self) -> bool {
        let mut beyond = false;
        let k = N::from_single(self.links.model.saturation());
        let applied = from_single(self.applied);
        for contact in self.held {
            let position = add(contact.origin, applied);
            if let Some(state) = self.state.get_mut(contact.cell()) {
                *state = Cell::at(position);
            }
            beyond |= peak(position) > k;
        }
        beyond
    }
}

/// Arrays of cells whose number is part of the scheme's type.
pub trait CellArrays<N> {
    /// All +0.0.
    const ZERO: Self;
    /// The arrays one after the other.
    fn flat(&mut self) -> &mut [Cell<N>];
}

impl<N: Number, const CELLS: usize, const ARRAYS: usize> CellArrays<N>
    for [[Cell<N>; CELLS]; ARRAYS]
{
    const ZERO: Self = [[Cell::ZERO; CELLS]; ARRAYS];

    fn flat(&mut self) -> &mut [Cell<N>] {
        self.as_flattened_mut()
    }
}

/// Memory in octets of `f32` whose size is part of the scheme's type.
pub trait Octets {
    /// All +0.0.
    const ZERO: Self;
    /// The octets.
    fn flat(&mut self) -> &mut [Eight];
}

impl<const OCTETS: usize> Octets for [Eight; OCTETS] {
    const ZERO: Self = [[0.0; 8]; OCTETS];

    fn flat(&mut self) -> &mut [Eight] {
        self
    }
}

pub(crate) mod scheme {
    use super::{Body, Cell, Contact, Eight, Model, Number, Settings};

    /// What a scheme does; sealed, since the guarantees rest on it.
    pub trait Scheme {
        /// What cells and links are computed in.
        type Number: Number;

        /// A tick's sweeps begin.
        fn begin(&mut self, model: &Model<'_>, settings: &Settings) {
            let _ = (model, settings);
        }

        /// One sweep: at most one link pass and one update. Whether the pass was rolled back.
        #[allow(private_interfaces)]
        fn sweep(&mut self, body: &mut Body<'_, '_, Self::Number>) -> bool;

        /// A cell was put at `position`, in the scheme's own arrays too; `k` is the saturation.
        fn place(
            &mut self,
            own: &mut [Cell<Self::Number>],
            cell: usize,
            position: Cell<Self::Number>,
            k: f32,
        );

        /// The tool moved the cells it holds.
        fn pushed(&mut self) {}

        /// Whether a cell has moved since the last pass, or has momentum.
        fn has_moved(
            state: &[Cell<Self::Number>],
            own: &[Cell<Self::Number>],
            residual: &[Cell<Self::Number>],
            cell: usize,
        ) -> bool {
            let _ = (state, own);
            residual.get(cell).is_some_and(|r| r.xyz() != [Self::Number::ZERO; 3])
        }

        /// Whether the scheme lacks the model's colours.
        fn needs_colours(model: &Model<'_>) -> bool {
            let _ = model;
            false
        }

        /// Octets of room for a model and a number of held cells.
        fn room(model: &Model<'_>, held: usize) -> usize {
            let _ = (model, held);
            0
        }

        /// These cells are the ones the tool will hold.
        fn hold(model: &Model<'_>, room: &mut [Eight], held: &[Contact<Self::Number>]) {
            let _ = (model, room, held);
        }

        /// Octets of room for a model and a probe.
        fn probe_room(model: &Model<'_>) -> usize {
            let _ = model;
            0
        }

        /// A probe holds these cells from now on: the number of hats taken out for them, `None`
        /// where that cannot be done.
        fn take_out(
            model: &Model<'_>,
            room: &mut [Eight],
            held: &[Contact<Self::Number>],
        ) -> Option<u16> {
            let _ = (model, room, held);
            Some(0)
        }

        /// The bands changed: forget the momentum.
        fn interrupt(&mut self);
    }
}

/// What a scheme computes cells and links in.
pub type NumberOf<D> = <D as scheme::Scheme>::Number;

/// A scheme, with its own scalar state.
pub trait Dynamics: scheme::Scheme + Copy {
    /// Name as in the command's `--dynamics`.
    const NAME: &'static str;
    /// The scheme at rest.
    const REST: Self;
    /// Arrays for the residual: one, or none for a scheme that moves cells in place.
    const RESIDUALS: usize = 1;
    /// Arrays of cells the scheme needs besides state and residual.
    const ARRAYS: usize;
    /// The residual for a number of cells, [`Self::RESIDUALS`] arrays.
    type Residual<const CELLS: usize>: CellArrays<Self::Number>;
    /// Those arrays for a number of cells.
    type Arrays<const CELLS: usize>: CellArrays<Self::Number>;
    /// Room for a coarse level, see [`hats_room`](crate::hats_room).
    type Room: Octets;
    /// What [`Settings::tick_time`] may be so that a number of sweeps covers it; for schemes
    /// without it what `euler` covers [dimensionless time].
    #[must_use]
    fn tick_time(model: &Model<'_>, sweeps: u16) -> f32 {
        f32::from(sweeps) * model.step_max()
    }
    /// Octets of room that a model needs with a number of contact cells.
    #[must_use]
    fn room_octets(model: &Model<'_>, held: usize) -> usize {
        Self::room(model, held)
    }
    /// Octets of room that a model needs with a probe.
    #[must_use]
    fn probe_octets(model: &Model<'_>) -> usize {
        Self::probe_room(model)
    }
}
