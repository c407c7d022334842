//! Waits and long work that Ctrl-C ends, and spans of time.

use std::cell::RefCell;
use std::panic::resume_unwind;
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::thread::Builder;
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use crate::errors::Class;
use crate::numbers::{Arg, brief};

/// How long Ctrl-C may take.
pub(crate) const LOOK: Duration = Duration::from_millis(20);
/// Longest span that can be waited \[s\]: an hour.
const SPAN_S_MAX: f64 = 3600.0;
/// Stack of a thread that works aside, that of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// The exception of a handler of Python's, for a thread that is not attached. None where the interpreter
/// has ended: its threads go on until the process does.
pub(crate) fn caught() -> PyResult<()> {
    Python::try_attach(|py| py.check_signals()).unwrap_or(Ok(()))
}

/// Looks now and then for a signal that Python has caught, and keeps the exception that its handler
/// raised.
#[derive(Debug)]
pub(crate) struct Signals(RefCell<(Instant, Option<PyErr>)>);

impl Signals {
    pub(crate) fn new() -> Self {
        Self(RefCell::new((Instant::now(), None)))
    }

    /// Whether to stop; attaches to Python once in [`LOOK`].
    pub(crate) fn stop(&self) -> bool {
        let mut state = self.0.borrow_mut();
        if state.1.is_none() && state.0.elapsed() >= LOOK {
            state.1 = caught().err();
            state.0 = Instant::now();
        }
        state.1.is_some()
    }

    /// The exception, where there was one.
    pub(crate) fn raised(&self) -> PyResult<()> {
        self.0.borrow_mut().1.take().map_or(Ok(()), Err)
    }
}

/// Does long work that cannot be stopped, while Python runs on. Ctrl-C raises at once; the work, which
/// owns all that it uses, then goes to its end in its own thread, and nobody gets what it makes.
pub(crate) fn aside<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    py.detach(|| {
        let (done, wait) = sync_channel(1);
        let run = move || _ = done.send(work());
        let thread = Builder::new().name("chaincell".into()).stack_size(STACK_BYTES).spawn(run);
        let thread = thread.map_err(|why| {
            Class::Base
                .error(format!("no thread for the work: {why}; end other threads, or free memory"))
        })?;
        let signals = Signals::new();
        loop {
            match wait.recv_timeout(LOOK) {
                Ok(found) => return Ok(found),
                Err(RecvTimeoutError::Timeout) if signals.stop() => signals.raised()?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
        match thread.join() {
            Err(panic) => resume_unwind(panic),
            Ok(()) => Err(Class::Base.error("the work ended without a result")),
        }
    })
}

/// A span of seconds from 0 to an hour \[ns\].
pub(crate) fn span_ns(name: &str, seconds: Arg<'_, f64>) -> PyResult<u64> {
    let seconds = seconds.real(name)?;
    if (0.0..=SPAN_S_MAX).contains(&seconds) {
        return Ok((seconds * 1e9) as u64);
    }
    let text = format!("`{name}` {}: must be from 0 to {SPAN_S_MAX} seconds", brief(seconds));
    Err(Class::Argument.error(text))
}
