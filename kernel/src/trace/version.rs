//! The versions of the format: what differs between them.

use core::ops::Range;

use super::header::{COMMON_BYTES, Origin};
use super::stage::STAGE_BYTES;
use super::{HEADER_BYTES, RECORD_BYTES, TraceError, VERSION, VERSION_OF_SAMPLES};
use crate::tick::choice::Choice;
use crate::tick::choices::Scheme;

/// Codes of the schemes in versions 1 and 2.
const SCHEMES_BEFORE_3: [(u16, Scheme); 3] =
    [(1, Scheme::Euler), (2, Scheme::Track), (4, Scheme::Rkl2)];

/// The releases that wrote versions 1 and 2.
const ORIGIN_BEFORE_3: Origin = Origin { revision: 1, release: [0, 1, 0] };

/// A version of the format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Version {
    /// Version 1: no output stage.
    Plain,
    /// Version 2: an output stage.
    Staged,
    /// Version 3.
    Current,
    /// Version 4: version 3 with tools.
    Tools,
}

impl Version {
    pub(super) fn of(number: u32) -> Result<Self, TraceError> {
        match number {
            1 => Ok(Self::Plain),
            2 => Ok(Self::Staged),
            VERSION_OF_SAMPLES => Ok(Self::Current),
            VERSION => Ok(Self::Tools),
            _ => Err(TraceError::Version(number)),
        }
    }

    /// Whether a header with so many contact cells may be so long.
    pub(super) fn may_have(self, bytes: usize, contacts: usize) -> bool {
        let (plain, staged) = match self {
            Self::Plain => (COMMON_BYTES, COMMON_BYTES),
            Self::Staged => (COMMON_BYTES + STAGE_BYTES, COMMON_BYTES + STAGE_BYTES),
            Self::Current | Self::Tools => (HEADER_BYTES, HEADER_BYTES + STAGE_BYTES),
        };
        [plain, staged].iter().any(|front| (front + 4 * contacts).next_multiple_of(8) == bytes)
    }

    /// What wrote the trace, where its header holds the settings of the output stage, and the word of
    /// the friction.
    pub(super) fn extension(
        self,
        header: &[u8],
    ) -> Result<(Origin, Range<usize>, u32), TraceError> {
        match self {
            Self::Plain => Ok((ORIGIN_BEFORE_3, COMMON_BYTES..COMMON_BYTES, 0)),
            Self::Staged => Ok((ORIGIN_BEFORE_3, COMMON_BYTES..COMMON_BYTES + STAGE_BYTES, 0)),
            Self::Current | Self::Tools => {
                let words: &[u8; HEADER_BYTES - COMMON_BYTES] = header
                    .get(COMMON_BYTES..)
                    .and_then(<[u8]>::first_chunk)
                    .ok_or(TraceError::Layout)?;
                let [revision, low, high, friction]: [u32; 4] = bytemuck::cast(*words);
                let [major, minor, patch, parts]: [u16; 4] = bytemuck::cast([low, high]);
                if parts > 1 {
                    return Err(TraceError::Layout);
                }
                let end = HEADER_BYTES + usize::from(parts) * STAGE_BYTES;
                Ok((
                    Origin { revision, release: [major, minor, patch] },
                    HEADER_BYTES..end,
                    friction,
                ))
            }
        }
    }

    /// The scheme of a code.
    pub(super) fn scheme(self, code: u16) -> Option<Scheme> {
        match self {
            Self::Plain | Self::Staged => {
                SCHEMES_BEFORE_3.iter().find(|of| of.0 == code).map(|of| of.1)
            }
            Self::Current | Self::Tools => Scheme::from_code(code),
        }
    }

    /// Bytes of a record.
    pub(super) fn record_bytes(self) -> usize {
        match self {
            Self::Plain | Self::Staged => 40,
            Self::Current | Self::Tools => RECORD_BYTES,
        }
    }
}
