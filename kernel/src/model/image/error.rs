//! Why an image is refused.

use core::fmt;

/// Why [`Model::from_bytes`](crate::Model::from_bytes) refused an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ModelError {
    /// The bytes do not start at a multiple of 16: use `include_model!` or aligned memory.
    Misaligned,
    /// The image ends before it is complete.
    Truncated,
    /// The first bytes are not those of a model image.
    Magic,
    /// The image's format version, which this kernel does not read.
    Version(u32),
    /// The checksum does not match: the bytes were changed after the bake.
    Checksum,
    /// The header or the section table contradicts itself.
    Layout,
    /// A required section is missing (its kind).
    Missing(u32),
    /// A section has a version this kernel does not read (its kind).
    SectionVersion(u32),
    /// A section has the wrong size (its kind).
    SectionSize(u32),
    /// A value of `PARAMS` is outside its range (its word).
    Parameter(u32),
    /// An index is out of range or out of order (section kind, position in the section).
    Index(u32, u32),
    /// A number is not finite or outside its range (section kind, position in the section).
    Value(u32, u32),
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Misaligned => f.write_str("the image does not start at a multiple of 16 bytes"),
            Self::Truncated => f.write_str("the image is truncated: copy or bake it again"),
            Self::Magic => f.write_str("not a chaincell model: bake one with `chaincell bake`"),
            Self::Version(version) => write!(
                f,
                "format version {version} is not version {} that this kernel reads: bake again",
                super::FORMAT_VERSION
            ),
            Self::Checksum => f.write_str("the checksum does not match: copy or bake it again"),
            Self::Layout => f.write_str("the section table contradicts itself: bake again"),
            Self::Missing(kind) => write!(f, "section {kind} is missing: bake again"),
            Self::SectionVersion(kind) => {
                write!(f, "section {kind} has an unknown version: bake again with this release")
            }
            Self::SectionSize(kind) => write!(f, "section {kind} has the wrong size: bake again"),
            Self::Parameter(word) => write!(f, "parameter word {word} is out of range: bake again"),
            Self::Index(kind, at) => {
                write!(f, "section {kind}, entry {at}: index out of range or order: bake again")
            }
            Self::Value(kind, at) => {
                write!(f, "section {kind}, entry {at}: value out of range: bake again")
            }
        }
    }
}

impl core::error::Error for ModelError {}
