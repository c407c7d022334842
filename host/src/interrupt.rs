//! Ctrl-C and termination: a flag that long work looks at, so that results so far are written.

use std::cell::Cell;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::{Error, Result};

static ASKED: AtomicBool = AtomicBool::new(false);

/// Catches SIGINT, SIGTERM and SIGHUP from here on. A second signal ends the process at once.
pub fn install() -> Result<()> {
    ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    })
    .map_err(|why| Error::check(format!("cannot catch Ctrl-C: {why}")))
}

thread_local! {
    static IGNORED: Cell<bool> = const { Cell::new(false) };
}

/// Whether the user asked to stop.
#[must_use]
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed) && !IGNORED.get()
}

/// Does `work` to its end even though the user asked to stop: the check of what was done so far.
pub fn ignoring<T>(work: impl FnOnce() -> T) -> T {
    IGNORED.set(true);
    let done = work();
    IGNORED.set(false);
    done
}
