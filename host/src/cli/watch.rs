//! Looking at what a running `serve` sends to viewers, until it ends.

use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::ipc::viewed::{Reader, Viewed};
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS, now_ns, sleep_until_ns};

/// Span between looks for a message \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;
/// Span between lines \[ns\].
const LINE_NS: u64 = SECOND_NS;
/// Longest wait for the first message of a server \[ns\].
const FIRST_NS: u64 = 5 * SECOND_NS;

/// When to end.
#[derive(Debug, Clone, Copy)]
pub struct Until {
    /// At this time \[ns\].
    pub end_ns: u64,
    /// After the first message.
    pub once: bool,
}

/// Gives each message to `take`, one a second to be told too; whether any came.
///
/// # Errors
/// No message for 5 s from a server; Ctrl-C; that of `take`.
pub fn watch<T: Viewed>(
    reader: &Reader<T>,
    until: Until,
    mut take: impl FnMut((T::Header, Vec<T>), bool) -> Result<()>,
) -> Result<bool> {
    let give_up_ns = now_ns() + FIRST_NS;
    let (mut line_ns, mut has_come) = (0, false);
    while now_ns() < until.end_ns {
        interrupt::check()?;
        // Looked at first: what a server sends right before its end is still taken.
        let served = reader.is_served();
        match reader.take()? {
            Some(message) => {
                let is_told = now_ns() >= line_ns;
                take(message, is_told)?;
                if is_told {
                    line_ns = now_ns() + LINE_NS;
                }
                has_come = true;
                if until.once {
                    return Ok(true);
                }
            }
            None if !served => return Ok(has_come),
            None if !has_come && now_ns() >= give_up_ns => {
                return Err(Error::check(format!(
                    "{} for 5 s: the server is busy, or was killed; restart chaincell serve",
                    T::NONE
                )));
            }
            None => sleep_until_ns(now_ns() + LOOK_NS),
        }
    }
    Ok(has_come)
}
