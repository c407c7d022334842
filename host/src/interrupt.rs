//! Ctrl-C and termination: a flag that long work looks at, so that results so far are written. Work
//! that writes nothing ends at once.

use std::cell::Cell;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::error::{Error, Result};
use crate::terminal;

static ASKED: AtomicBool = AtomicBool::new(false);
static ENDS_AT_ONCE: AtomicBool = AtomicBool::new(false);
static BESIDES: OnceLock<Box<dyn Fn() + Send + Sync>> = OnceLock::new();

/// A repeat within this span is the same wish: signals reach a process and its group at once.
const SAME_WISH: Duration = Duration::from_millis(500);

/// Catches SIGINT, SIGTERM and SIGHUP from here on. Asking once more ends the process at once.
pub fn install() -> Result<()> {
    let mut first = None;
    ctrlc::set_handler(move || {
        ASKED.store(true, Ordering::SeqCst);
        if ENDS_AT_ONCE.load(Ordering::SeqCst) {
            terminal::note(format_args!("chaincell: {}", Error::Interrupted));
            std::process::exit(Error::Interrupted.exit_code().into());
        }
        if let Some(work) = BESIDES.get() {
            work();
        }
        let since = first.get_or_insert_with(Instant::now).elapsed();
        if since > SAME_WISH {
            terminal::note("chaincell: interrupted twice; results are lost");
            std::process::exit(130);
        }
    })
    .map_err(|why| Error::check(format!("cannot catch Ctrl-C: {why}")))
}

/// The first such work is done besides when the user asks to stop, in a thread of its own: it lets go what
/// the loop may hang in.
pub fn besides(work: impl Fn() + Send + Sync + 'static) {
    let _ = BESIDES.set(Box::new(work));
}

/// From here on asking to stop ends the process at once: for work that writes nothing.
///
/// # Errors
/// [`Error::Interrupted`] where the user asked before.
pub fn end_at_once() -> Result<()> {
    ENDS_AT_ONCE.store(true, Ordering::SeqCst);
    if ASKED.load(Ordering::SeqCst) { Err(Error::Interrupted) } else { Ok(()) }
}

/// Does work that writes nothing, before something is written: asking to stop ends the process at once
/// meanwhile.
///
/// # Errors
/// Those of the work; [`Error::Interrupted`] where the user asked before.
pub fn at_once<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    end_at_once()?;
    let done = work();
    ENDS_AT_ONCE.store(false, Ordering::SeqCst);
    check()?;
    done
}

thread_local! {
    static IGNORED: Cell<bool> = const { Cell::new(false) };
}

/// Whether the user asked to stop.
#[must_use]
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed) && !IGNORED.get()
}

/// Ends work that looks here when the user asked to stop.
///
/// # Errors
/// [`Error::Interrupted`].
pub fn check() -> Result<()> {
    if asked() { Err(Error::Interrupted) } else { Ok(()) }
}

/// Does `work` to its end even though the user asked to stop: the check of what was done so far.
pub fn ignoring<T>(work: impl FnOnce() -> T) -> T {
    IGNORED.set(true);
    let done = work();
    IGNORED.set(false);
    done
}
