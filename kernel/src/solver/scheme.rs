//! What a scheme does, and what it works on.

use super::awake::Awake;
use super::coarse::{Coarse, CoarseTouch};
use super::level::Level;
use super::loops::Loops;
use crate::backend::VectorUnit;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{Cell, add, from_single, peak};
use crate::number::kept::Kept;
use crate::number::two_float::Eight;
use crate::terms::held::Contact;
use crate::terms::residual::Terms;
use crate::terms::state::States;

/// How far a tick goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// Sweeps of a tick.
    pub sweeps: u16,
    /// Step of an `euler` sweep [dimensionless time].
    pub step: f32,
    /// Time that super-steps advance in a tick [dimensionless time].
    pub tick_time: f32,
}

/// What a scheme works on during one sweep.
pub(crate) struct Body<'a, 'm, N = f32> {
    pub terms: Terms<'a, 'm>,
    pub pace: Pace,
    /// Cells that the tool acts on: those it holds, or those that a current flows into.
    pub contacts: &'a [Contact<N>],
    /// Cells the tool holds: they do not move in a sweep.
    pub held: &'a [Contact<N>],
    /// Where the tool holds them, relative to their origins.
    pub applied: [f32; 3],
    /// State v of every cell; its output is published.
    pub state: &'a mut [Cell<N>],
    /// Room for the residual.
    pub residual: &'a mut [Cell<N>],
    /// The scheme's own arrays, one after the other, each as long as `state`; those that its sweeps
    /// use, once they have begun.
    pub own: &'a mut [Cell<N>],
    /// Room for a coarse level.
    pub room: &'a mut [Eight],
    /// How the coarse level leaves the held cells alone; `None` where it cannot.
    pub coarse: Option<Coarse>,
    /// What a sphere makes of an elastic coarse level.
    pub coarse_touch: Option<&'a CoarseTouch>,
    /// The slices that a sweep looks at.
    pub awake: &'a mut Awake,
    pub level: &'a mut Level,
}

impl<N: Number> Body<'_, '_, N> {
    /// Puts the held cells back where the tool has them; whether one of them is beyond K.
    pub fn restore_held(&mut self) -> bool {
        let mut beyond = false;
        let k = N::from_single(self.terms.model.saturation());
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

/// The arrays of a body whose tool is chosen, cut to its size.
pub(crate) struct Memory<'a, N = f32> {
    pub state: &'a [Cell<N>],
    pub residual: &'a mut [Cell<N>],
    /// The scheme's own arrays.
    pub own: &'a mut [Cell<N>],
    /// Room for a coarse level.
    pub room: &'a mut [Eight],
    /// What the terms keep of the cells.
    pub states: States<'a>,
    /// The vector unit to use.
    pub vectors: Option<VectorUnit>,
}

/// What a scheme does; sealed, since the guarantees rest on it.
pub trait Scheme: Kept {
    /// What cells and links are computed in.
    type Number: Loops;

    /// A tick's sweeps begin.
    #[allow(private_interfaces)]
    fn begin(&mut self, body: &mut Body<'_, '_, Self::Number>) {
        let _ = body;
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

    /// The tool moved them by `way`.
    fn follow(&mut self, way: [f32; 3]) {
        let _ = way;
    }

    /// Tools moved on the surface, by this share of what they did in the last tick.
    fn goes_on(&mut self, share: f32) {
        let _ = share;
    }

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

    /// Blocks of room for a model and a number of held cells.
    fn room(model: &Model<'_>, held: usize) -> usize {
        let _ = (model, held);
        0
    }

    /// Whether it is prepared for the cells that were chosen last, so many.
    fn is_prepared(&self, held: usize) -> bool {
        let _ = held;
        false
    }

    /// The tool has a probe from now on.
    fn release(&mut self) {}

    /// These cells are the ones the tool will hold.
    #[allow(private_interfaces)]
    fn hold(
        &mut self,
        model: &Model<'_>,
        memory: Memory<'_, Self::Number>,
        held: &[Contact<Self::Number>],
    ) {
        let _ = (model, memory, held);
    }

    /// Blocks of room for a model and a probe.
    fn probe_room(model: &Model<'_>) -> usize {
        let _ = model;
        0
    }

    /// Something resists these cells from now on, infinite where they are held: the number of basis
    /// functions that the coarse level has at them, `None` where it cannot take that in.
    fn deflate(
        model: &Model<'_>,
        room: &mut [Eight],
        cells: impl Iterator<Item = (usize, f32)>,
    ) -> Option<u16> {
        let _ = (model, room, cells);
        Some(0)
    }

    /// The bands changed: forget the momentum.
    fn interrupt(&mut self);
}
