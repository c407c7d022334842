//! Notes of the client by their names.

use chaincell_client::Notes;

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
    assert!(NOTE_NOTHING_YET == Notes::NOTHING_YET.0);
    assert!(NOTE_SILENT == Notes::SILENT.0);
    assert!(NOTE_RAMP == Notes::RAMP.0);
    assert!(NOTE_NEW_SESSION == Notes::NEW_SESSION.0);
};
