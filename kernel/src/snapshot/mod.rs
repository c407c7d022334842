//! Snapshots: the whole state of a tissue or an output stage as bytes, from which it continues with the same
//! bits, also on another processor.
//!
//! ```text
//! offset  bytes  content, little-endian
//!      0      8  magic "CHAINSNP"
//!      8      4  format version (1)
//!     12      4  layout: a hash of the names, types and order of all stored fields, of the scheme and
//!                of its numbers
//!     16      4  checksum of the model; 0 for an output stage
//!     20      4  bytes of the whole snapshot
//!     24      4  CRC-32 (ISO-HDLC) of all bytes but these four
//!     28      4  zero
//!     32      …  words
//! ```
//!
//! A snapshot is for programs of one release of the kernel: the layout says which. For long-term storage use
//! a trace: its reader names the release that replays it.
//!
//! Settings are not part of it: the caller provides them, and the same bits need the same settings. A refused
//! snapshot changes nothing. CRC-32 detects accidents, not manipulation: like a forged model image, a forged
//! snapshot may break the energy bound, but it causes no access to other memory and no force that is not
//! finite.

mod stage;
mod tissue;

use crate::model::image::checksum_but;
use crate::number::kept::PassError;
use crate::tick::error::ResetError;

/// First bytes of every snapshot.
pub const SNAPSHOT_MAGIC: [u8; 8] = *b"CHAINSNP";
/// Version of the format.
pub const SNAPSHOT_VERSION: u32 = 1;
/// Bytes before the words.
pub const SNAPSHOT_HEADER_BYTES: usize = 32;
/// Offset of the checksum.
const CRC_AT: usize = 24;

/// The reason for which a snapshot is not taken, or is refused; nothing has changed.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, Tissue, Track, include_model};
/// use chaincell_kernel::snapshot::SnapshotError;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
///
/// let short = tissue.view().save(&network, &mut [0; 100]);
/// assert!(matches!(short, Err(SnapshotError::Buffer { given: 100, .. })));
/// assert_eq!(tissue.view().restore(&network, b"no snapshot"), Err(SnapshotError::Magic));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SnapshotError {
    /// The tissue was not reset to this network.
    #[error("the tissue belongs to another network: reset it first")]
    NotReset,
    /// The buffer is shorter than the snapshot.
    #[error("the buffer has {given} bytes, the snapshot needs {needed}")]
    Buffer {
        /// Bytes needed.
        needed: usize,
        /// Bytes given.
        given: usize,
    },
    /// The bytes are no snapshot.
    #[error("not a snapshot")]
    Magic,
    /// Another version of the format.
    #[error("snapshot version {0}, not version 1 that this kernel reads")]
    Version(u32),
    /// Another scheme, number type, set of features, or release of the kernel.
    #[error("the snapshot is of another scheme, number type or release: use the one that saved it")]
    Layout,
    /// The snapshot is of another model (its checksum).
    #[error("the snapshot is of the model {0:08x}: load that one")]
    Model(u32),
    /// The bytes end early, or do not end where they should.
    #[error("the snapshot is not whole: copy or save it again")]
    Length,
    /// The checksum does not match.
    #[error("the snapshot's checksum does not match: copy or save it again")]
    Checksum,
    /// A word has an invalid value (its index after the header, from 0).
    #[error("word {0} of the snapshot cannot be: save it again")]
    Value(u32),
    /// The tissue has capacity for fewer contact cells, tools, triangles or blocks.
    #[error("the snapshot needs room for {needed}, the tissue has {room}")]
    Room {
        /// Items in the snapshot.
        needed: usize,
        /// Capacity of the tissue.
        room: usize,
    },
    /// The tissue cannot take the model.
    #[error("{0}")]
    Reset(ResetError),
}

impl From<PassError> for SnapshotError {
    fn from(why: PassError) -> Self {
        match why {
            PassError::Word(word) => Self::Value(word as u32),
            PassError::Room { needed, room } => Self::Room { needed, room },
        }
    }
}

/// Writes the header before the words, which have been written already.
fn seal(bytes: &mut [u8], layout: u32, model: u32) {
    let length = bytes.len() as u32;
    let head = [SNAPSHOT_VERSION, layout, model, length, 0, 0];
    let words = SNAPSHOT_MAGIC.into_iter().chain(head.into_iter().flat_map(u32::to_le_bytes));
    bytes.iter_mut().zip(words).for_each(|(slot, byte)| *slot = byte);
    let sum = checksum_but(bytes, CRC_AT);
    if let Some(slot) = bytes.get_mut(CRC_AT..).and_then(<[u8]>::first_chunk_mut) {
        *slot = sum.to_le_bytes();
    }
}

/// Checks the header and returns the words after it.
fn open(bytes: &[u8], layout: u32, model: u32) -> Result<&[u8], SnapshotError> {
    let word = |at: usize| bytes.get(at..).and_then(<[u8]>::first_chunk).copied();
    let word = |at: usize| word(at).map(u32::from_le_bytes).ok_or(SnapshotError::Length);
    if !bytes.starts_with(&SNAPSHOT_MAGIC) {
        return Err(SnapshotError::Magic);
    }
    match word(8)? {
        SNAPSHOT_VERSION => {}
        other => return Err(SnapshotError::Version(other)),
    }
    if word(20)? as usize != bytes.len() {
        return Err(SnapshotError::Length);
    }
    if word(CRC_AT)? != checksum_but(bytes, CRC_AT) {
        return Err(SnapshotError::Checksum);
    }
    if word(12)? != layout || word(28)? != 0 {
        return Err(SnapshotError::Layout);
    }
    match word(16)? {
        of if of == model => bytes.get(SNAPSHOT_HEADER_BYTES..).ok_or(SnapshotError::Length),
        other => Err(SnapshotError::Model(other)),
    }
}
