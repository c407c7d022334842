//! Checks that a model fits a tissue, and computes the memory that it needs.

use super::error::ResetError;
use super::tissue::TissueMut;
use crate::energy::held::Contact;
use crate::model::Model;
use crate::number::cell::Cell;
use crate::number::two_float::Eight;
#[cfg(feature = "relax")]
use crate::relax::memory;
use crate::solver::Dynamics;

/// RAM of a body's arrays under the scheme `D`, without the scalars and without the terms' states \[bytes\];
/// `room` in blocks of eight `f32`.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, include_model};
/// use chaincell_kernel::{
///     Cell, Contact, CutRoom, Dynamics, Head, Team, TermStates, TissueMut, TouchRoom, Track, array_bytes,
/// };
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// let cells = model.cells();
/// let mut head = Head::<Track>::NEW;
/// let (mut state, mut residual) = (vec![Cell::ZERO; cells], vec![Cell::ZERO; cells]);
/// let mut own = vec![Cell::ZERO; Track::<0>::ARRAYS * cells];
/// let mut contacts = [Contact::NONE; 4];
/// let mut tissue = TissueMut {
///     head: &mut head,
///     state: &mut state,
///     residual: &mut residual,
///     own: &mut own,
///     room: &mut [], // the model has no coarse level
///     contacts: &mut contacts,
///     states: TermStates::new(&mut []), // nor nodal shapes
///     touch: TouchRoom::none(), // nor a contact surface
///     cut: CutRoom::none(), // nor tetrahedra to part
///     team: Team::ALONE,
/// };
/// tissue.reset(&network)?;
/// assert_eq!(array_bytes::<Track>(cells, 4, 0), 64 * cells + 16 * 4); // of the four arrays
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub const fn array_bytes<D: Dynamics>(cells: usize, contacts: usize, room: usize) -> usize {
    (2 + D::ARRAYS) * cells * size_of::<Cell<D::Number>>()
        + contacts * size_of::<Contact<D::Number>>()
        + room * size_of::<Eight>()
}

impl<D: Dynamics> TissueMut<'_, D> {
    /// Checks that memory and scheme suffice for a model.
    pub(crate) fn check_fit(&self, model: &Model<'_>) -> Result<(), ResetError> {
        let cells = model.cells();
        let own = self.own.len().checked_div(D::ARRAYS).unwrap_or(usize::MAX);
        let capacity = self.state.len().min(self.residual.len()).min(own);
        if cells > capacity {
            return Err(ResetError::Capacity { needed: cells, capacity });
        }
        let (needed, capacity) = (model.kept_states(), self.states.capacity());
        if needed > capacity {
            return Err(ResetError::States { needed, capacity });
        }
        #[cfg(feature = "relax")]
        if let Some(sizes) = memory::sizes(model) {
            let (needed, room) = (sizes.iter().sum(), self.cut.words().len());
            if needed > room {
                return Err(ResetError::Memory { needed, room });
            }
        }
        if model.moves_singly() && !D::TAKES_SHAPES {
            return Err(ResetError::Shapes);
        }
        let (needed, room) = (D::room(model, 0), self.room.len());
        if needed > room {
            return Err(ResetError::CoarseRoom { needed, room });
        }
        Ok(())
    }
}
