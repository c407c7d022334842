//! Why a number type cannot carry a model.

use core::fmt;

/// A model whose numbers leave the range of the number type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RangeError {
    /// The saturation K.
    Saturation {
        /// Of the model [mean link lengths].
        k: f32,
        /// Largest that the type carries.
        max: f32,
    },
    /// The largest mean weight of two linked cells.
    Degree {
        /// Of the model.
        degree: f32,
        /// Largest that the type carries.
        max: f32,
    },
    /// The smallest weight of a link.
    Weight {
        /// Of the model.
        weight: f32,
        /// Smallest that the type carries.
        min: f32,
    },
}

impl RangeError {
    /// The limit that the model leaves.
    #[must_use]
    pub fn limit(&self) -> f32 {
        match *self {
            Self::Saturation { max, .. } | Self::Degree { max, .. } => max,
            Self::Weight { min, .. } => min,
        }
    }
}

impl fmt::Display for RangeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Saturation { k, max } => write!(
                f,
                "K of the model is {k} mean link lengths, the number type carries {max}: bake it \
                 with a smaller --k-m"
            ),
            Self::Degree { degree, max } => write!(
                f,
                "two linked cells have a mean weight of {degree}, the number type carries {max}: \
                 take f32"
            ),
            Self::Weight { weight, min } => write!(
                f,
                "the softest link has {weight} of the mean stiffness, the number type carries \
                 {min}: take f32"
            ),
        }
    }
}

impl core::error::Error for RangeError {}
