//! Error of a model that exceeds the range of a number type.

/// A model whose numbers leave the range of the number type.
///
/// ```
/// use chaincell_kernel::RangeError;
///
/// let stiff = RangeError::Degree { degree: 75.0, max: 60.0 };
/// assert_eq!(stiff.limit(), 60.0);
/// assert!(stiff.to_string().ends_with("the number type carries 60: take f32"));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RangeError {
    /// The saturation K.
    #[error(
        "K of the model is {k} mean link lengths, the number type carries {max}: bake it with a \
         smaller `saturation_m`"
    )]
    Saturation {
        /// Value in the model [mean link lengths].
        k: f32,
        /// Largest value that the type supports.
        max: f32,
    },
    /// The largest mean weight of two linked cells.
    #[error(
        "two linked cells have a mean weight of {degree}, the number type carries {max}: take \
         f32"
    )]
    Degree {
        /// Value in the model.
        degree: f32,
        /// Largest value that the type supports.
        max: f32,
    },
    /// The smallest weight of a link.
    #[error(
        "the softest link has {weight} of the mean stiffness, the number type carries {min}: \
         take f32"
    )]
    Weight {
        /// Value in the model.
        weight: f32,
        /// Smallest value that the type supports.
        min: f32,
    },
}

impl RangeError {
    /// The limit that the model exceeds.
    #[must_use]
    pub fn limit(&self) -> f32 {
        match *self {
            Self::Saturation { max, .. } | Self::Degree { max, .. } => max,
            Self::Weight { min, .. } => min,
        }
    }
}
