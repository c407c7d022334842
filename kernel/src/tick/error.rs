//! Why a tissue refuses a model or a state.

use core::fmt;

use crate::model::COORDINATE_MAX;
use crate::number::float_env::FloatEnvironmentError;
use crate::terms::links::range::RangeError;

/// Why a tissue cannot take a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ResetError {
    /// The model has more cells than the tissue has room for.
    Capacity {
        /// Cells of the model.
        needed: usize,
        /// Room.
        capacity: usize,
    },
    /// The model has a coarse level, for which the scheme has too little room: size it with
    /// [`coarse_room`](crate::coarse_room), or bake the model without one.
    CoarseRoom {
        /// Blocks needed.
        needed: usize,
        /// Blocks there.
        room: usize,
    },
    /// The scheme goes by colours, and the model has none: bake it with `--colours`.
    Colours,
    /// The number type does not carry the model.
    Range(RangeError),
    /// The thread's arithmetic is not what the bits rely on.
    Float(FloatEnvironmentError),
}

impl fmt::Display for ResetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Capacity { needed, capacity } => {
                write!(f, "the model has {needed} cells, the tissue room for {capacity}")
            }
            Self::CoarseRoom { needed, room } => write!(
                f,
                "the model's coarse level needs {needed} blocks of eight f32, the tissue has {room}: \
                 size it with coarse_room, or bake with --hats none"
            ),
            Self::Colours => f.write_str("the model has no colours: bake it with --colours"),
            Self::Range(why) => write!(f, "{why}"),
            Self::Float(why) => write!(f, "{why}"),
        }
    }
}

impl core::error::Error for ResetError {}

/// Why a state is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StateError {
    /// The tissue was not reset to this network.
    Model,
    /// Fewer or more positions than cells.
    Count {
        /// Cells of the model.
        needed: usize,
        /// Positions given.
        given: usize,
    },
    /// The position of this cell is not finite, or beyond [`COORDINATE_MAX`].
    Position(usize),
}

impl fmt::Display for StateError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Model => f.write_str("the tissue belongs to another network: reset it first"),
            Self::Count { needed, given } => write!(f, "{given} positions for {needed} cells"),
            Self::Position(cell) => {
                write!(f, "cell {cell}: coordinates must be finite and at most {COORDINATE_MAX}")
            }
        }
    }
}

impl core::error::Error for StateError {}
