//! How the records of a trace end.

use core::fmt;

use super::{KIND_COMMAND, KIND_PART, KIND_POSE, KIND_TOOL_COMMAND};

/// The end of the records of a trace.
///
/// ```
/// use chaincell_kernel::trace::End;
///
/// assert_eq!(End::Cut(7).to_string(), "cut within record 7"); // the records before it are sound
/// assert!(End::Damaged(7).to_string().ends_with("copy it again"));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The records end with the trace.
    Complete,
    /// The trace ends within this record: it was cut, or its writer was stopped.
    Cut(u32),
    /// This record's bytes were changed, or belong to another trace.
    Damaged(u32),
    /// This record is of a kind that is not known here.
    Kind(u32, u16),
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Complete => f.write_str("complete"),
            Self::Cut(record) => write!(f, "cut within record {record}"),
            Self::Damaged(record) => {
                write!(f, "record {record} is damaged (its checksum does not match): copy it again")
            }
            Self::Kind(record, KIND_COMMAND | KIND_TOOL_COMMAND) => {
                write!(f, "record {record} is a command, which only a host's replay carries out")
            }
            Self::Kind(record, KIND_PART | KIND_POSE) => write!(
                f,
                "record {record} is of tools that were chosen by their parts: it stands in no order \
                 that is known here, or is for a host's replay alone"
            ),
            Self::Kind(record, kind) => write!(
                f,
                "record {record} of kind {kind} holds what is unknown here: take the release that \
                 wrote it"
            ),
        }
    }
}
