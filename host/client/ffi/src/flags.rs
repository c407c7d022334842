//! Flags by their names: of the server, and notes of the client itself.

use chaincell_client::{Flags, Notes};

/// The motion of the tool, or the change of its current, was shortened.
pub const FLAG_MOTION_CLAMPED: u32 = 1;
/// The last good sample stands in, or the safe state answers.
pub const FLAG_BAD_SAMPLE: u32 = 2;
/// The server had no pose within the time of its watchdog.
pub const FLAG_STALE: u32 = 4;
/// The force was shortened to its limit.
pub const FLAG_FORCE_CLAMPED: u32 = 8;
/// The force is 0.
pub const FLAG_SAFE_STATE: u32 = 16;
/// The bands are closed (unloading).
pub const FLAG_BAND_CLOSED: u32 = 32;
/// The energy guard discarded a pass.
pub const FLAG_ROLLED_BACK: u32 = 64;
/// More in contact than there is room for.
pub const FLAG_CONTACT_CAPACITY: u32 = 128;
/// The force is not of this pose: newer ones had come, or the tissue cannot keep up.
pub const FLAG_LATE: u32 = 256;
/// The tool counts as not engaged until it was released once.
pub const FLAG_RELEASE_FIRST: u32 = 512;
/// The output stage lets the force go along its ramp.
pub const FLAG_FORCE_WITHHELD: u32 = 1024;
/// The tool was engaged inside the tissue: it has no force until it has been outside once.
pub const FLAG_STARTS_INSIDE: u32 = 2048;

/// No answer has come yet.
pub const NOTE_NOTHING_YET: u32 = 1;
/// No answer for the time of the watchdog: the force falls, or is 0.
pub const NOTE_SILENT: u32 = 2;
/// The force is on a ramp, and not yet that of the tissue.
pub const NOTE_RAMP: u32 = 4;
/// The server is another one than before: its tissue is at rest, and its tools count as not engaged until
/// they were released. It stays until the first answer of a tool that was.
pub const NOTE_NEW_SESSION: u32 = 8;

const _: () = {
    assert!(FLAG_MOTION_CLAMPED == Flags::MOTION_CLAMPED.0);
    assert!(FLAG_BAD_SAMPLE == Flags::BAD_SAMPLE.0);
    assert!(FLAG_STALE == Flags::STALE.0);
    assert!(FLAG_FORCE_CLAMPED == Flags::FORCE_CLAMPED.0);
    assert!(FLAG_SAFE_STATE == Flags::SAFE_STATE.0);
    assert!(FLAG_BAND_CLOSED == Flags::BAND_CLOSED.0);
    assert!(FLAG_ROLLED_BACK == Flags::ROLLED_BACK.0);
    assert!(FLAG_CONTACT_CAPACITY == Flags::CONTACT_CAPACITY.0);
    assert!(FLAG_LATE == Flags::LATE.0);
    assert!(FLAG_RELEASE_FIRST == Flags::RELEASE_FIRST.0);
    assert!(FLAG_FORCE_WITHHELD == Flags::FORCE_WITHHELD.0);
    assert!(FLAG_STARTS_INSIDE == Flags::STARTS_INSIDE.0);
    assert!(NOTE_NOTHING_YET == Notes::NOTHING_YET.0);
    assert!(NOTE_SILENT == Notes::SILENT.0);
    assert!(NOTE_RAMP == Notes::RAMP.0);
    assert!(NOTE_NEW_SESSION == Notes::NEW_SESSION.0);
};
