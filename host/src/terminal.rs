//! Printing that survives a closed pipe, and progress that only a terminal sees.

use std::fmt;
use std::io::{self, IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::error::{Error, Result};

/// Writes one line to standard output. A reader that has gone away is not an error.
pub fn say(line: impl fmt::Display) -> Result<()> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{line}").and_then(|()| out.flush()) {
        Err(why) if why.kind() != io::ErrorKind::BrokenPipe => {
            Err(Error::input(format!("cannot write to standard output: {why}")))
        }
        _ => Ok(()),
    }
}

/// Writes a value to standard output as one JSON object in a line.
pub fn say_json(value: &impl serde::Serialize) -> Result<()> {
    say(serde_json::to_string(value).map_err(Error::check)?)
}

/// Writes one line to standard error; a lost line there is no reason to stop.
pub fn note(line: impl fmt::Display) {
    let _ = writeln!(io::stderr().lock(), "{line}");
}

/// The progress of long work, in a line on standard error that stays invisible unless that is a terminal.
pub struct Progress {
    what: &'static str,
    length: u64,
    begin: Instant,
    done: AtomicU64,
    /// Time of the last drawing since the begin \[ms\]; `None` if nobody sees the line.
    drawn_ms: Option<AtomicU64>,
}

/// Least time between two drawings \[ms\].
const DRAWING_MS: u64 = 100;

impl Progress {
    /// Begins work of `length` steps.
    #[must_use]
    pub fn new(length: u64, what: &'static str) -> Self {
        let drawn_ms = io::stderr().is_terminal().then(AtomicU64::default);
        Self { what, length, begin: Instant::now(), done: AtomicU64::new(0), drawn_ms }
    }

    /// Progress that nobody sees.
    #[must_use]
    pub fn unseen() -> Self {
        Self { what: "", length: 0, begin: Instant::now(), done: AtomicU64::new(0), drawn_ms: None }
    }

    /// Counts one step.
    pub fn step(&self) {
        self.draw(self.done.fetch_add(1, Ordering::Relaxed) + 1);
    }

    /// Sets the number of steps that are done.
    pub fn set_done(&self, done: u64) {
        self.done.store(done, Ordering::Relaxed);
        self.draw(done);
    }

    /// The number of steps that are done.
    #[must_use]
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }

    /// Draws the line, unless it was drawn a short time ago.
    fn draw(&self, done: u64) {
        let Some(drawn_ms) = &self.drawn_ms else { return };
        let seconds = self.begin.elapsed().as_secs_f64();
        let now_ms = (1e3 * seconds) as u64;
        if now_ms < drawn_ms.load(Ordering::Relaxed) + DRAWING_MS {
            return;
        }
        drawn_ms.store(now_ms, Ordering::Relaxed);
        let left_s = seconds * self.length.saturating_sub(done) as f64 / done.max(1) as f64;
        let (what, length) = (self.what, self.length);
        let _ = write!(io::stderr().lock(), "\r{what} {done}/{length}, {left_s:.0} s left\x1b[K");
    }
}

/// Clears the line.
impl Drop for Progress {
    fn drop(&mut self) {
        if self.drawn_ms.is_some() {
            let _ = write!(io::stderr().lock(), "\r\x1b[K");
        }
    }
}
