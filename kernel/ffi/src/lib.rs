//! The C interface of the kernel: a static library and `include/chaincell.h`.
//!
//! ```sh
//! cargo build --release -p chaincell-ffi                                   # for this machine
//! cargo build --release -p chaincell-ffi --target thumbv7em-none-eabihf    # for a Cortex-M7
//! cc -std=c99 -Ikernel/ffi/include kernel/ffi/examples/press.c target/release/libchaincell_ffi.a -lpthread -ldl -lm
//! ```
//!
//! The caller owns all memory: a model and a tissue live in storage that C hands over, sized by
//! `chaincell_model_size` at run time or `CHAINCELL_TISSUE_BYTES` at compile time, so one library
//! serves bodies of any size. No heap, no global state: several bodies may be ticked at the same
//! time, each by one thread. Every call answers with a [`Code`]; every pointer is checked for null
//! and alignment, and storage for what was initialised there. What cannot be checked is said under
//! `# Safety` of each function.
//!
//! On bare metal the library refers to `chaincell_would_panic`, which does not exist, wherever it
//! can panic: a firmware that links (`--gc-sections`) has no panic in it. That holds for the
//! release profile; for size (`opt-level = "s"`) the compiler leaves a check in that it could do
//! without, and the link fails. On other targets the library brings Rust's own handler, and a
//! panic ends the process instead of unwinding into C.
//!
//! The header is written from these sources; a test compares it and says how to renew it.
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]
#![allow(unsafe_code)]

#[cfg(not(target_os = "none"))]
extern crate std;

mod code;
mod cut;
mod layout;
mod memory;
mod model;
mod pins;
mod refusal;
mod settings;
mod stage;
mod storage;
mod stress;
#[cfg(test)]
mod tests;
mod tick;
mod tools;
mod touch;

pub use code::{Code, Detail};
pub use cut::{CUT_TOOL_BYTES, Cuts, Face, Triangle, chaincell_cut, chaincell_triangles};
pub use layout::{
    CELL_BYTES_EULER, CELL_BYTES_PREDICT, CELL_BYTES_RKL2, CELL_BYTES_SHAPE, CELL_BYTES_TRACK,
    TISSUE_BYTES, TISSUE_WORDS, Tissue,
};
pub use memory::{ALIGN, SHAPE_ALIGN};
pub use model::{
    Info, MODEL_WORDS, ModelStorage, chaincell_model_info, chaincell_model_init,
    chaincell_model_input_id,
};
pub use pins::{
    PinOutput, chaincell_pin_at, chaincell_pin_force, chaincell_pin_held, chaincell_unpin,
};
pub use settings::{Scheme, Settings, chaincell_settings_default};
pub use stage::{
    STAGE_WORDS, StageNews, StageSettings, StageStorage, chaincell_stage_default,
    chaincell_stage_init, chaincell_stage_output, chaincell_stage_restore, chaincell_stage_sample,
    chaincell_stage_save,
};
pub use storage::{
    chaincell_change_settings, chaincell_choose_contacts, chaincell_model_size,
    chaincell_tissue_init, chaincell_tissue_reset, chaincell_tissue_restore, chaincell_tissue_save,
};
pub use stress::{CellStress, chaincell_stress};
pub use tick::{
    Budget, More, Output, ToolOutput, ToolPose, chaincell_position, chaincell_positions,
    chaincell_set_positions, chaincell_state_hash, chaincell_tick,
};
pub use tools::{
    ContactForce, ToolPart, chaincell_choose_tools, chaincell_contact_forces, chaincell_grip,
    chaincell_gripped, chaincell_let_go, chaincell_opening_torque,
};
pub use touch::{
    CELL_BYTES_TOUCH, PIN_BYTES, Room, SAMPLE_BYTES, TOOL_BYTES, TOUCH_BYTES, TRIANGLE_BYTES,
};

use code::Refusal;

/// Version of this interface: major 65,536, minor 256, patch 1.
pub const VERSION: u32 = 0x0b00;

/// Version of the library, to compare with `CHAINCELL_VERSION` of the header.
#[unsafe(no_mangle)]
pub extern "C" fn chaincell_version() -> u32 {
    VERSION
}

/// A code in words, for logs: a string that is always there. Never null, whatever the number.
#[unsafe(no_mangle)]
pub extern "C" fn chaincell_code_text(code: i32) -> *const core::ffi::c_char {
    Code::text_of(code).unwrap_or(c"unknown code").as_ptr()
}

impl Code {
    /// The code of a result.
    fn of(result: Result<(), Self>) -> Self {
        result.err().unwrap_or(Self::Ok)
    }
}

/// Does the work and writes the detail of what came of it, if anybody asked.
///
/// # Safety
/// `detail` is null or, where aligned, storage for a detail.
unsafe fn answer(detail: *mut Detail, work: impl FnOnce() -> Result<(), Refusal>) -> Code {
    // SAFETY: the caller's promise is handed on.
    if let Err(code) = unsafe { memory::write_if_asked(detail, Detail::default()) } {
        return code;
    }
    let Err(Refusal { code, detail: why }) = work() else { return Code::Ok };
    // SAFETY: the caller's promise is handed on.
    Code::of(unsafe { memory::write_if_asked(detail, why) }.and(Err(code)))
}

#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        /// Nobody defines it.
        fn chaincell_would_panic() -> !;
    }
    // SAFETY: never reached: a program with a call to it does not link.
    unsafe { chaincell_would_panic() }
}
