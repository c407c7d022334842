//! A board that stands by: it follows a session over a serial line, compares every hash, and goes on with the session
//! when the line falls silent. `host/GUIDE.md` runs it in an emulator.
//!
//! It says on the debugger's channel, one `name value` a line, how far it came. A stream that is damaged, or a tick
//! that differs, ends it: there is no force, and nothing is taken over, as the session may go on elsewhere.
#![no_std]
#![no_main]

#[path = "../../image/src/console.rs"]
mod console;
mod follow;
mod hand;
mod line;
#[path = "../../image/src/panic.rs"]
mod panic;
mod session;
mod snapshot;
mod stream;

use chaincell_kernel::{Tissue, include_model};
use cortex_m_rt::entry;
use semihosting::process;
use static_cell::ConstStaticCell;

use line::Line;
use session::{CELLS, HELD, Scheme};
use snapshot::ROOM_BYTES;

/// The model, in flash: the board takes it from no line.
static IMAGE: &[u8] =
    include_model!(env!("CHAINCELL_MODEL", "set it to the path of the session's model"));
static TISSUE: ConstStaticCell<Tissue<CELLS, Scheme, HELD>> = ConstStaticCell::new(Tissue::new());
/// Memory for a snapshot.
static SNAPSHOT: ConstStaticCell<[u8; ROOM_BYTES]> = ConstStaticCell::new([0; ROOM_BYTES]);

/// The board's only run. `None` where nothing can be followed.
fn stand_by() -> Option<()> {
    let (tissue, memory) = (TISSUE.try_take()?.view(), SNAPSHOT.try_take()?);
    let mut line = Line::begin();
    follow::stand_by(|| line.next(), IMAGE, tissue, memory)
}

#[entry]
fn main() -> ! {
    console::log_here();
    process::exit(i32::from(stand_by().is_none()))
}
