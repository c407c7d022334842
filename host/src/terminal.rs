//! Printing that survives a closed pipe, and progress bars that only a terminal sees.

use std::fmt;
use std::io::{self, IsTerminal, Write};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

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

/// A progress bar on standard error, invisible unless that is a terminal.
#[must_use]
pub fn progress(length: u64, what: &'static str) -> ProgressBar {
    let target = if io::stderr().is_terminal() {
        ProgressDrawTarget::stderr_with_hz(10)
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(length), target).with_prefix(what);
    match ProgressStyle::with_template("{prefix} {wide_bar} {pos}/{len} {eta}") {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
