//! The program of the board that stands by, on this machine: the same sources, on other lines.

use std::cell::RefCell;
use std::path::Path;

use anyhow::{Context, Result};
use chaincell_kernel::Tissue;

use crate::case::aligned;
use crate::emulate::Said;

#[path = "../../stand-by/src/follow.rs"]
mod follow;
#[path = "../../stand-by/src/hand.rs"]
mod hand;
#[path = "../../stand-by/src/session.rs"]
mod session;
#[path = "../../stand-by/src/snapshot.rs"]
mod snapshot;
#[path = "../../stand-by/src/stream.rs"]
mod stream;

/// What the board says on the debugger's channel.
mod console {
    use super::SAID;

    pub fn say(name: &str, text: &str) {
        SAID.with_borrow_mut(|said| said.add(name, text));
    }

    pub fn number(name: &str, value: u32) {
        say(name, &value.to_string());
    }

    pub fn bits(name: &str, value: u64) {
        say(name, &format!("{value:016x}"));
    }
}

thread_local! {
    static SAID: RefCell<Said> = RefCell::default();
}

/// What the board's program says of these bytes on its line.
pub fn follow(model: &Path, stream: &[u8]) -> Result<Said> {
    let image = std::fs::read(model).with_context(|| format!("{}", model.display()))?;
    let tissue =
        Box::leak(
            Box::new(Tissue::<{ session::CELLS }, session::Scheme, { session::HELD }>::new()),
        );
    let mut bytes = stream.iter().copied();
    let mut memory = vec![0; snapshot::ROOM_BYTES];
    follow::stand_by(|| bytes.next(), aligned(&image), tissue.view(), &mut memory);
    Ok(SAID.take())
}
