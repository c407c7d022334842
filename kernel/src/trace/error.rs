//! Reasons for which a trace cannot be read or played.

use core::fmt;

use super::VERSION;
use crate::stage::StageError;
use crate::tick::hash::REVISION;
use crate::tick::settings::SettingsError;

/// The reason for which a trace cannot be read or played.
///
/// ```
/// use chaincell_kernel::trace::{Reader, TraceError};
///
/// let error = Reader::open(b"not a trace").unwrap_err();
/// assert_eq!(error, TraceError::Magic);
/// assert_eq!(error.to_string(), "not a chaincell trace: record one with `chaincell run --trace`");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TraceError {
    /// The first bytes are not those of a trace.
    Magic,
    /// A format version that is not read here.
    Version(u32),
    /// The trace stops within its header.
    Truncated,
    /// The header's bytes were changed.
    Checksum,
    /// The header has content that this release does not know.
    Layout,
    /// A scheme or number type that is not known here.
    Scheme(u16, u16),
    /// The trace belongs to another model.
    Model {
        /// Checksum of the model it was recorded with.
        recorded: u32,
        /// Checksum of the model given.
        given: u32,
    },
    /// The release that wrote the trace has arithmetic with other bits than this release.
    Revision(Origin),
    /// The settings do not fit the model.
    Settings(SettingsError),
    /// The output stage's settings are out of range.
    Stage(StageError),
    /// This input id is no cell of the model.
    Contact(u32),
    /// The trace was recorded with this number of tools, chosen by their parts, not with contact cells.
    Tools(u32),
    /// The trace has more contact cells than the memory given for them.
    Contacts {
        /// Contact cells of the trace.
        needed: usize,
        /// Contact cells that fit.
        room: usize,
    },
}

impl fmt::Display for TraceError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Magic => {
                f.write_str("not a chaincell trace: record one with `chaincell run --trace`")
            }
            Self::Version(version) => write!(
                f,
                "format version {version} is not {VERSION}, the one that this release reads: take \
                 the release that wrote it (versions 1 and 2: chaincell 0.1; 3 and 4: 0.2 before \
                 version {VERSION}), or record again"
            ),
            Self::Truncated => f.write_str("the trace stops within its header: copy it again"),
            Self::Checksum => {
                f.write_str("the header is damaged (its checksum does not match): copy it again")
            }
            Self::Layout => f.write_str("the header contradicts itself: record again"),
            Self::Scheme(scheme, number) => write!(
                f,
                "scheme {scheme} in number type {number} is not known here: take the release that \
                 wrote the trace"
            ),
            Self::Model { recorded, given } => write!(
                f,
                "recorded with the model of checksum {recorded:08x}, this one has {given:08x}: \
                 give the model of the recording (`chaincell info` shows the checksum)"
            ),
            Self::Revision(Origin { revision, release: [major, minor, patch] }) => write!(
                f,
                "recorded with revision {revision} of the arithmetic, this release has revision \
                 {REVISION}, whose ticks differ in their last bits: replay it with chaincell \
                 {major}.{minor}.{patch}"
            ),
            Self::Settings(why) => write!(f, "its settings do not fit the model: {why}"),
            Self::Stage(why) => write!(f, "its output stage cannot be: {why}"),
            Self::Contact(id) => {
                write!(f, "its contact node {id} is no cell of the model: record again")
            }
            Self::Tools(count) => write!(
                f,
                "it was recorded with {count} tools that were chosen by their parts, not with contact \
                 cells: replay it with the chaincell command"
            ),
            Self::Contacts { needed, room } => {
                write!(f, "it has {needed} contact cells, here is room for {room}")
            }
        }
    }
}

impl core::error::Error for TraceError {}

/// The release that wrote a trace.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Origin {
    /// Revision of its arithmetic, see [`REVISION`].
    pub revision: u32,
    /// Its release: major, minor, patch.
    pub release: [u16; 3],
}

impl Origin {
    /// This release.
    pub const HERE: Self = Self {
        revision: REVISION,
        release: [
            number(env!("CARGO_PKG_VERSION_MAJOR")),
            number(env!("CARGO_PKG_VERSION_MINOR")),
            number(env!("CARGO_PKG_VERSION_PATCH")),
        ],
    };
}

/// Returns the number of decimal digits.
const fn number(digits: &str) -> u16 {
    match u16::from_str_radix(digits, 10) {
        Ok(number) => number,
        Err(_) => u16::MAX,
    }
}
