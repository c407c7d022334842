//! The trace: the tool sample and the state hash of every tick, so that a run can be replayed and checked bit
//! by bit, on a workstation or in firmware.
//!
//! It is a little-endian file or memory area, without padding other than shown here:
//!
//! ```text
//! header
//!      0      8  magic "CHAINTRC"
//!      8      4  format version: 5
//!     12      4  bytes of the header: 80, 48 with an output stage, 4 n, up to a multiple of 8
//!     16      4  checksum of the model image
//!     20      2  scheme, the code of `Scheme`
//!     22      2  number type, the code of `Arithmetic`
//!     24   4, 7  settings, a word each in the order of `Settings`: whole number, f32 bits or code
//!     52      4  n = number of contact cells
//!     56      4  the number of tools, 1 to 8; 0 with contact cells
//!     60      4  CRC-32 (ISO-HDLC) of all bytes of the header but these four
//!     64      4  revision of the arithmetic, see REVISION
//!     68      6  release that wrote the trace: major, minor, patch (u16 x 3)
//!     74      2  bit 0: an output stage follows; bit 1: tools that were chosen by their parts
//!     76      4  coefficient of friction (f32 bits), 0 with contact cells
//! with an output stage
//!     80  4, 12  its settings, a word each in the order of `StageSettings`: whole number or f32 bits; before the
//!                fields of coupling and passivity 1, or 0 for none, and then they are zero
//! from 80, with an output stage from 128
//!      .    4 n  input ids of the contact cells, in the order of the model's cells; then zeros
//! record r = 0, 1, ... of 48 bytes
//!      0      8  tick
//!      8     12  tool position [m] (f32 bits x 3)
//!     20      2  engaged
//!     22      2  opening of scissors [2^-16 turn]
//!     24      8  hash of the state after the tick, 0 where none was taken
//!     32      2  kind: 1 = sample; 2 = command, 5 = command to a tool (grip, let go) or pins, whose bytes
//!                from 0 to 24 are described at [`Command`]; with tools also 3 = part, 4 = pose, see below
//!     34      2  bit 0: a hash was taken; bit 1: the sweeps were counted; bit 2: the output
//!                stage's ramp restarted before the tick; bit 3: the delay was measured
//!     36      2  sweeps of the tick where they were counted: 0 = it was late
//!     38      2  delay of the loop where it was measured, 0 to 1,000 [ticks of the stage]
//!     40      4  zero
//!     44      4  CRC-32 of: the header's CRC, r (u32), the 44 bytes before
//! with tools, kind 3: a part of a tool, two consecutive records, before all other kinds
//!      0     12  first: its middle [m] (f32 bits x 3)          second: 0, 16: its orientation
//!     12      4  its radius [m] (f32 bits)                             x, y, z, w (f32 bits x 4)
//!     16     12  half its edges [m] (f32 bits x 3)                     16, 16: zero
//!     28      4  zero
//!     32      4  3
//!     36      1  tool
//!     37      1  part
//!     38      2  0 = first, 1 = second
//!     40      4  zero
//!     44      4  CRC-32 as above
//! with tools, kind 4: the pose of a tool in a tick
//!      0     12  position [m] (f32 bits x 3)
//!     12      2  engaged
//!     14      2  opening of scissors [2^-16 turn]
//!     16     16  orientation x, y, z, w (f32 bits x 4)
//!     32      4  4
//!     36      4  tool
//!     40      4  zero
//!     44      4  CRC-32 as above
//! ```
//!
//! **Tools** that were chosen by their parts are numbered from 0. Their parts come first, by ascending tool
//! and part. The poses of all tools precede each tick's record, by ascending number, with nothing between;
//! the record itself repeats position and `engaged` of tool 0. A trace that ends with poses and no tick after
//! them counts as cut.
//!
//! Other versions are refused: [`TraceError::Version`] names the releases that read them.
//!
//! Commands to a tool have their own kind: a release that does not know it stops at the first one, and
//! reports an unknown record.
//!
//! If the sweeps of a tick were not counted, it has those of the settings.
//!
//! A record is one executed tick or one command between two; numbers of ticks are those of the session, and
//! need not be consecutive. With an output stage a sample is the device's, as received; ticks without a
//! sample move no cell and leave no record. The trace ends with its bytes, with an incomplete record (it was
//! cut), or where only zeros follow (preallocated memory). A writer that stores the checksum last also leaves
//! an incomplete record if it is stopped within one: the checksum is zero and only zeros follow. A record's
//! checksum is valid only at its place in its own trace, so remains of an earlier trace in the same memory
//! are not taken for records. Cost: [`Writer::record`] works over 52 bytes, table-driven; no memory.
//!
//! # Use
//!
//! On a workstation `run`, `serve` and `cosim` leave `session.trace` next to `model.chaincell` in the folder
//! of `--out`, and `serve --record FILE` writes a trace alone. `chaincell replay` replays a folder or a file.
//! It ends with exit code 0 for the same bits, with 1 and the first tick that differs, or with 2 for a trace
//! that is damaged, of an unknown version, or of another revision of the arithmetic: the message then names
//! the release to take.
//!
//! A firmware writes and reads the same format without a heap. To record, take a [`Header`] with
//! [`Header::of`] after the reset, begin with [`Writer::begin`], and store the bytes of
//! [`Writer::record`] after each tick. To play a recording, open it with [`Reader::open`] and
//! follow the example of [`Reader::play`], which names the first tick that differs. A trace with
//! commands or an output stage is read with [`Reader::entries`] and [`Header::output_stage`].
//!
//! ```
//! use chaincell_kernel::trace::{Header, RECORD_BYTES, Record, Writer};
//! use chaincell_kernel::{Budget, Network, TissueMut, ToolPose, Track};
//!
//! /// Writes the header to the front of a log, and gives its length.
//! fn begin(network: &Network<'_>, held_ids: &[u32], log: &mut [u8]) -> Option<(Writer, usize)> {
//!     Writer::begin(&Header::of::<Track>(network)?, held_ids, log)
//! }
//!
//! /// One tick, and the bytes of its record.
//! fn recorded_tick(
//!     tissue: &mut TissueMut<'_, Track>,
//!     network: &Network<'_>,
//!     (tick, sample): (u64, ToolPose),
//!     writer: &mut Writer,
//! ) -> [u8; RECORD_BYTES] {
//!     tissue.tick(network, &[sample], Budget::All);
//!     let state_hash = Some(tissue.state_hash(network.model()));
//!     writer.record(&Record { state_hash, ..Record::of(tick, sample) })
//! }
//! # let _ = (begin, recorded_tick);
//! ```

mod command;
mod decoder;
mod end;
mod error;
mod header;
mod order;
mod reader;
mod record;
mod stage;
#[cfg(test)]
mod tests;
mod writer;

pub use command::{Command, CommandError};
pub use decoder::Decoder;
pub use end::End;
pub use error::{Origin, TraceError};
pub use header::{Header, RecordedTools, header_bytes};
pub use reader::{Played, Reader};
pub use record::{CommandRecord, Entry, PartRecord, PoseRecord, Record, ReplayError};
pub use writer::Writer;

use crc::{CRC_32_ISO_HDLC, Crc, Table};

static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Writes the bytes of a word; unlike `copy_from_slice` it does not panic for other lengths.
fn put(place: &mut [u8], word: u32) {
    for (place, byte) in place.iter_mut().zip(word.to_le_bytes()) {
        *place = byte;
    }
}

/// First bytes of every trace.
pub const MAGIC: [u8; 8] = *b"CHAINTRC";
/// The version of the format that is written and read.
pub const VERSION: u32 = 5;
/// Bytes of the header before the output stage and the contact cells.
pub const HEADER_BYTES: usize = header::COMMON_BYTES + 16;
/// Bytes of a record.
pub const RECORD_BYTES: usize = 48;
/// Kind of a record that holds a tool sample.
pub const KIND_SAMPLE: u16 = 1;
/// Kind of a record that holds a command; only [`Reader::entries`] reads it.
pub const KIND_COMMAND: u16 = 2;
/// Kind of a record that holds a command to a tool; only [`Reader::entries`] reads it.
pub const KIND_TOOL_COMMAND: u16 = 5;
/// Kind of a record that holds half of a tool's part; only [`Reader::entries`] reads it.
pub const KIND_PART: u16 = 3;
/// Kind of a record that holds a tool's pose; only [`Reader::entries`] reads it.
pub const KIND_POSE: u16 = 4;
