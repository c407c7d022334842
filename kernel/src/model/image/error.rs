//! The reasons to refuse an image.

use crate::number::float_env::FloatEnvironmentError;

/// The reason for which [`Model::from_bytes`](crate::Model::from_bytes) refused an image.
///
/// ```
/// use chaincell_kernel::{Model, ModelError};
///
/// #[repr(align(16))]
/// struct Aligned([u8; 64]);
/// let error = Model::from_bytes(&Aligned([0; 64]).0).unwrap_err();
/// assert_eq!(error, ModelError::Magic);
/// assert_eq!(error.to_string(), "not a chaincell model: bake one with `chaincell bake`");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// The bytes do not start at a multiple of 16: use `include_model!` or aligned memory.
    #[error("the image does not start at a multiple of 16 bytes")]
    Misaligned,
    /// The image ends before it is complete.
    #[error("the image is truncated: copy or bake it again")]
    Truncated,
    /// The first bytes are not those of a model image.
    #[error("not a chaincell model: bake one with `chaincell bake`")]
    Magic,
    /// The image's format version, which this kernel does not read.
    #[error(
        "format version {0} is not version {known} that this kernel reads: bake again",
        known = super::FORMAT_VERSION
    )]
    Version(u32),
    /// The checksum does not match: the bytes were changed after the bake.
    #[error("the checksum does not match: copy or bake it again")]
    Checksum,
    /// The header or the section table contradicts itself.
    #[error("the section table contradicts itself: bake again")]
    Layout,
    /// A required section is missing (its kind).
    #[error("section {0} is missing: bake again")]
    Missing(u32),
    /// A section has a version this kernel does not read (its kind).
    #[error("section {0} has an unknown version: bake again with this release")]
    SectionVersion(u32),
    /// The kernel is built without the feature that reads a section (its kind).
    #[error(
        "section {0}: this program is built without the feature that reads it: build it with `nodal`, for bodies \
         that can be cut with `cut`, for those that relax with `relax`, or bake again without such a body"
    )]
    Unbuilt(u32),
    /// A section has the wrong size (its kind).
    #[error("section {0} has the wrong size: bake again")]
    SectionSize(u32),
    /// A value of `PARAMS` is outside its range (its word).
    #[error("parameter word {0} is out of range: bake again")]
    Parameter(u32),
    /// An index is out of range or out of order (section kind, position in the section).
    #[error("section {0}, entry {1}: index out of range or order: bake again")]
    Index(u32, u32),
    /// A number is not finite or outside its range (section kind, position in the section).
    #[error("section {0}, entry {1}: value out of range: bake again")]
    Value(u32, u32),
    /// The thread's floating-point environment is not the one on which the checks rely.
    #[error("{0}")]
    Float(FloatEnvironmentError),
}
