//! The C interface of the client: a static library and `include/chaincell_client.h`.
//!
//! ```sh
//! cargo build --release -p chaincell-client-ffi    # target/release/libchaincell_client_ffi.a
//! ```
//!
//! `host/client/cmake` installs it as `libchaincell_client`, static and shared, with the header and a
//! package for `find_package(chaincell)`.
//!
//! Handles are numbers that are looked up: one that was closed is refused. Every call answers with a
//! [`Code`]; every pointer is checked for null and alignment; no panic leaves a call. What cannot be
//! checked is said under `# Safety` of each function.
//!
//! Poses, what a tool feels and flags are those of `chaincell.h`, which the header includes: types and numbers
//! alone, without a function of that library.
//!
//! The header is written from these sources; a test compares it and says how to renew it.
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]
#![allow(unsafe_code)]

mod beside;
mod code;
mod handles;
mod memory;
mod step;
#[cfg(test)]
mod tests;
mod types;

pub use beside::{
    COMMAND_GRIP, COMMAND_LET_GO, COMMAND_PAUSE, COMMAND_PIN, COMMAND_RESET, COMMAND_RESUME,
    COMMAND_SET, COMMAND_SNAPSHOT, COMMAND_UNPIN, PARAMETER_CUT, PARAMETER_MAX_FORCE,
    PARAMETER_MAX_TOOL_STEP, PARAMETER_SWEEPS, PARAMETER_UNLOADING, chaincell_client_command,
    chaincell_client_contacts, chaincell_client_pin_at, chaincell_client_release,
    chaincell_client_state,
};
pub use code::Code;
pub use step::{
    Handle, chaincell_client_close, chaincell_client_open, chaincell_client_send,
    chaincell_client_step, chaincell_client_try_receive,
};
pub use types::{Contact, Contacts, Node, Options, Reply, Role, Shown, State, TOOLS_MAX, WaitMode};

use std::ffi::c_char;

/// Version of this interface: major 65,536, minor 256, patch 1.
pub const VERSION: u32 = 0x0400;

/// A code in words, for logs: never null, whatever the number. Of what this thread's last refused call has
/// answered it says the place and the remedy too, until the next one that is refused.
#[unsafe(no_mangle)]
pub extern "C" fn chaincell_client_error_text(code: i32) -> *const c_char {
    if let Some(kept) = code::kept(code) {
        return kept;
    }
    Code::text_of(code).unwrap_or(c"unknown code").as_ptr()
}
