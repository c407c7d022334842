//! Waits that Ctrl-C ends, and spans of time.

use std::cell::RefCell;
use std::time::{Duration, Instant};

use pyo3::prelude::*;

use crate::errors::Class;

/// How long Ctrl-C may take.
pub(crate) const LOOK: Duration = Duration::from_millis(20);
/// Longest span that can be waited \[s\]: an hour.
const SPAN_S_MAX: f64 = 3600.0;

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
            state.1 = Python::attach(|py| py.check_signals()).err();
            state.0 = Instant::now();
        }
        state.1.is_some()
    }

    /// The exception, where there was one.
    pub(crate) fn raised(&self) -> PyResult<()> {
        self.0.borrow_mut().1.take().map_or(Ok(()), Err)
    }
}

/// A span of seconds from 0 to an hour \[ns\].
pub(crate) fn span_ns(name: &str, seconds: f64) -> PyResult<u64> {
    if (0.0..=SPAN_S_MAX).contains(&seconds) {
        return Ok((seconds * 1e9) as u64);
    }
    let text = format!("`{name}` {seconds}: must be from 0 to {SPAN_S_MAX} seconds");
    Err(Class::Argument.error(text))
}
