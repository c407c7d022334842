//! Errors of a tissue that refuses a model or a state.

use crate::energy::links::range::RangeError;
use crate::model::COORDINATE_MAX;
use crate::number::float_env::FloatEnvironmentError;

/// Why a tissue cannot take a model.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, include_model};
/// use chaincell_kernel::{ResetError, Tissue, Track};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
///
/// let mut small = Tissue::<64, Track>::new();
/// let refused = small.reset(&network).unwrap_err();
/// assert_eq!(refused, ResetError::Capacity { needed: 81, capacity: 64 });
/// assert_eq!(refused.to_string(), "the model has 81 cells, the tissue room for 64");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ResetError {
    /// The model has more cells than the tissue has memory for.
    #[error("the model has {needed} cells, the tissue room for {capacity}")]
    Capacity {
        /// Cells of the model.
        needed: usize,
        /// Cells that the memory holds.
        capacity: usize,
    },
    /// The model's coarse level needs more memory than the tissue has: size it with
    /// [`coarse_room`](crate::coarse_room), or bake the model without a coarse level.
    #[error(
        "the model's coarse level needs {needed} blocks of eight f32, the tissue has {room}: \
         size it with coarse_room, or bake it with `coarse` none"
    )]
    CoarseRoom {
        /// Blocks needed.
        needed: usize,
        /// Blocks that the tissue has.
        room: usize,
    },
    /// Energy terms keep states of the model's cells, for which the tissue has too little memory.
    #[error("the model needs room for the states of {needed} cells, the tissue has {capacity}")]
    States {
        /// Cells of the model.
        needed: usize,
        /// Cells whose states the memory holds.
        capacity: usize,
    },
    /// The body relaxes and the tissue has too little memory for its strain: size it with
    /// [`cut_words`](crate::cut_words).
    #[error(
        "the body relaxes and needs {needed} words for its memory, the tissue has {room}: size it with cut_words"
    )]
    Memory {
        /// Words needed.
        needed: usize,
        /// Words that the tissue has.
        room: usize,
    },
    /// The scheme supports neither nodal shapes nor a body that can be cut.
    #[error(
        "a body of nodal shapes moves under track or predict in single precision alone, and so does one that \
         can be cut or relaxes: take one of these"
    )]
    Shapes,
    /// The model is outside the range of the number type.
    #[error("{0}")]
    Range(RangeError),
    /// The thread's floating-point environment is not the one that the results rely on.
    #[error("{0}")]
    Float(FloatEnvironmentError),
}

/// Why a state is refused.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, Tissue, Track, include_model};
/// use chaincell_kernel::StateError;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
///
/// let mut positions: Vec<[f32; 3]> = (0..81).map(|cell| model.rest_position(cell)).collect();
/// assert_eq!(tissue.view().set_positions(&network, &positions), Ok(()));
/// positions[47][2] = f32::INFINITY;
/// let refused = tissue.view().set_positions(&network, &positions);
/// assert_eq!(refused, Err(StateError::Position(47)));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StateError {
    /// The tissue was not reset to this network.
    #[error("the tissue belongs to another network: reset it first")]
    Model,
    /// The number of positions differs from the number of cells.
    #[error("{given} positions for {needed} cells")]
    Count {
        /// Cells of the model.
        needed: usize,
        /// Positions given.
        given: usize,
    },
    /// The position of this cell is not finite, or beyond [`COORDINATE_MAX`].
    #[error("cell {0}: coordinates must be finite and at most {max}", max = COORDINATE_MAX)]
    Position(usize),
}
