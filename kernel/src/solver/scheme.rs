//! The interface of a scheme, and its data.

use super::awake::Awake;
use super::coarse::{Coarse, CoarseTouch};
use super::level::Level;
use super::loops::Loops;
use crate::backend::VectorUnit;
use crate::energy::held::Contact;
use crate::energy::residual::Terms;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{Cell, add, from_single, peak};
use crate::number::kept::Kept;
use crate::number::two_float::Eight;

/// Extent of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// Sweeps of a tick.
    pub sweeps: u16,
    /// Step of an `euler` sweep [dimensionless time].
    pub step: f32,
    /// Time that super-steps advance in a tick [dimensionless time].
    pub tick_time: f32,
}

/// Stands for an r . z that is not known.
pub(crate) const UNKNOWN: f32 = -1.0;

/// Data of a scheme during one sweep.
pub(crate) struct Body<'a, 'm, N = f32> {
    pub terms: Terms<'a, 'm, N>,
    pub pace: Pace,
    /// Displacement of the held cells from their origins.
    pub applied: [f32; 3],
    /// State v of every cell; its output is published.
    pub state: &'a mut [Cell<N>],
    /// Memory for the residual.
    pub residual: &'a mut [Cell<N>],
    /// The scheme's arrays in sequence, each as long as `state`; after `begin` only those that the sweeps
    /// use.
    pub own: &'a mut [Cell<N>],
    /// Memory for a coarse level.
    pub room: &'a mut [Eight],
    /// Method by which the coarse level keeps the held cells fixed; `None` if it cannot.
    pub coarse: Option<Coarse>,
    /// Effect of tools on an elastic coarse level.
    pub coarse_touch: Option<&'a CoarseTouch>,
    /// The slices that a sweep updates.
    pub awake: &'a mut Awake,
    pub level: &'a mut Level,
    /// r . z of the last pass that was accepted, z the preconditioned residual of both levels; [`UNKNOWN`] without an
    /// elastic level, and beyond K.
    pub off_balance: &'a mut f32,
}

impl<N: Loops> Body<'_, '_, N> {
    /// Restores the held cells to the tool's displacement. Returns true if one of them is beyond K.
    pub fn restore_held(&mut self) -> bool {
        let mut beyond = false;
        let k = N::from_single(self.terms.model.saturation());
        let applied = from_single(self.applied);
        for contact in self.terms.held() {
            let position = add(contact.origin, applied);
            if let Some(state) = self.state.get_mut(contact.cell()) {
                *state = Cell::at(position);
            }
            beyond |= peak(position) > k;
        }
        beyond
    }
}

/// The arrays of a body whose tool is being chosen, cut to its size.
pub(crate) struct Memory<'a, N = f32> {
    pub state: &'a [Cell<N>],
    pub residual: &'a mut [Cell<N>],
    /// The scheme's arrays.
    pub own: &'a mut [Cell<N>],
    /// Memory for a coarse level.
    pub room: &'a mut [Eight],
    /// The vector unit to use.
    pub vectors: Option<VectorUnit>,
}

/// Interface of a scheme; sealed, since the guarantees depend on it.
pub trait Scheme: Kept {
    /// Number type of cells and links.
    type Number: Loops;

    /// Starts a tick's sweeps.
    #[allow(private_interfaces)]
    fn begin(&mut self, body: &mut Body<'_, '_, Self::Number>) {
        let _ = body;
    }

    /// Makes one sweep: at most one link pass and one update. Returns true if the pass was rolled back.
    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_, Self::Number>) -> bool;

    /// Notes that a cell was set to `position`, and sets it in the scheme's arrays too; `k` is the
    /// saturation.
    fn place(
        &mut self,
        own: &mut [Cell<Self::Number>],
        cell: usize,
        position: Cell<Self::Number>,
        k: f32,
    );

    /// Notes that the tool moved the cells that it holds.
    fn pushed(&mut self) {}

    /// Notes that the tool moved them by `way`.
    fn follow(&mut self, way: [f32; 3]) {
        let _ = way;
    }

    /// Way of the held cells since the last pass [mean link lengths]; 0 under a scheme that does not keep it.
    fn ahead(&self) -> [f32; 3] {
        [0.0; 3]
    }

    /// Notes that tools moved on the surface, by this share of their last tick's motion.
    fn goes_on(&mut self, share: f32) {
        let _ = share;
    }

    /// Returns the points of the next pass, among the scheme's arrays `own` of a body of `cells` cells; `None`
    /// if it starts at the published points.
    fn next_points<'a>(
        &self,
        own: &'a [Cell<Self::Number>],
        cells: usize,
    ) -> Option<&'a [Cell<Self::Number>]> {
        let _ = (own, cells);
        None
    }

    /// Returns true if a cell has moved since the last pass, or has momentum.
    fn has_moved(
        state: &[Cell<Self::Number>],
        own: &[Cell<Self::Number>],
        residual: &[Cell<Self::Number>],
        cell: usize,
    ) -> bool {
        let _ = (state, own);
        residual.get(cell).is_some_and(|r| r.xyz() != [Self::Number::ZERO; 3])
    }

    /// Blocks of memory for a model and a number of held cells.
    fn room(model: &Model<'_>, held: usize) -> usize {
        let _ = (model, held);
        0
    }

    /// Returns true if it is prepared for the last choice of cells, `held` in number.
    fn is_prepared(&self, held: usize) -> bool {
        let _ = held;
        false
    }

    /// Notes that tools are chosen from now on.
    fn release(&mut self) {}

    /// Prepares for the cells that the tool will hold.
    #[allow(private_interfaces)]
    fn hold(
        &mut self,
        model: &Model<'_>,
        memory: Memory<'_, Self::Number>,
        held: &[Contact<Self::Number>],
    ) {
        let _ = (model, memory, held);
    }

    /// Blocks of memory for a model and tools.
    fn tool_room(model: &Model<'_>) -> usize {
        let _ = model;
        0
    }

    /// Prepares the coarse level for cells with a resistance. Returns the number of basis functions at these
    /// cells; `None` if the level cannot handle them.
    fn resist(
        model: &Model<'_>,
        room: &mut [Eight],
        cells: impl Iterator<Item = (usize, f32)>,
    ) -> Option<u16> {
        let _ = (model, room, cells);
        Some(0)
    }

    /// Drops the momentum after a change of the bands.
    fn interrupt(&mut self);
}
