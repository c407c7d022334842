//! The trace: every tick's tool sample and state hash, so that a run can be played again and
//! checked bit by bit, on a workstation or in firmware.
//!
//! A little-endian file or memory area, no padding but what stands here:
//!
//! ```text
//! header
//!      0      8  magic "CHAINTRC"
//!      8      4  format version (1)
//!     12      4  bytes of the header, 64 + 4 n rounded up to a multiple of 8
//!     16      4  checksum of the model image
//!     20      2  scheme, see SCHEMES
//!     22      2  number type, see NUMBERS
//!     24      4  unloading: 0 off, 1 release, 2 retreat
//!     28      4  sweeps a tick
//!     32      4  step (f32 bits, as the next three)
//!     36      4  time a tick
//!     40      4  largest motion a tick [m]
//!     44      4  largest force [N]
//!     48      4  n = number of contact cells
//!     52      4  radius of the probe [m] (f32 bits), 0 with contact cells
//!     56      4  contacts that a probe has room for, 0 with contact cells
//!     60      4  CRC-32 (ISO-HDLC) of all bytes of the header but these four
//!     64    4 n  input ids of the contact cells, in the order of the model's cells; then zeros
//! record r = 0, 1, ... of 40 bytes
//!      0      8  tick
//!      8     12  tool position [m] (f32 bits x 3)
//!     20      4  engaged
//!     24      8  hash of the state after the tick, 0 where none was taken
//!     32      2  kind: 1 = sample; 2 is reserved for commands
//!     34      2  bit 0: a hash was taken
//!     36      4  CRC-32 of: the header's CRC, r (u32), the 36 bytes before
//! ```
//!
//! A record is one executed tick; numbers of ticks are those of the session, and need not be
//! consecutive. The trace ends with its bytes, with an incomplete record (it was cut), or where
//! nothing but zeros follow (memory taken beforehand). A record's checksum holds for its place in
//! its own trace alone, so remains of an earlier trace in the same memory are not taken for
//! records. Cost: [`Writer::record`] works over 44 bytes, table-driven; no memory.

mod header;
mod record;
#[cfg(test)]
mod tests;

pub use header::{Header, RecordedProbe, TraceError, header_bytes};
pub use record::{End, Played, Reader, Record, ReplayError, Writer};

use crc::{CRC_32_ISO_HDLC, Crc, Table};

static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Puts a word's bytes in their place; unlike `copy_from_slice` without a panic for other lengths.
fn put(place: &mut [u8], word: u32) {
    for (place, byte) in place.iter_mut().zip(word.to_le_bytes()) {
        *place = byte;
    }
}

/// First bytes of every trace.
pub const MAGIC: [u8; 8] = *b"CHAINTRC";
/// Version of the format written and read here.
pub const FORMAT_VERSION: u32 = 1;
/// Bytes of the header before the contact cells.
pub const HEADER_BYTES: usize = 64;
/// Bytes of a record.
pub const RECORD_BYTES: usize = 40;
/// Kind of a record that holds a tool sample.
pub const KIND_SAMPLE: u16 = 1;
/// Kind reserved for commands beside samples; refused by this release.
pub const KIND_COMMAND: u16 = 2;
/// Number types by the names of `--number`, with their codes.
pub const NUMBERS: [(&str, u16); 3] = [("f32", 1), ("fixed", 2), ("f64", 3)];
/// Schemes by the names of `--dynamics`, with their codes.
pub const SCHEMES: [(&str, u16); 5] =
    [("euler", 1), ("track", 2), ("rkl1", 3), ("rkl2", 4), ("gauss-seidel", 5)];
