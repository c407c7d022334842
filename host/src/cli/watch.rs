//! Looking at what a running `serve` sends to viewers, until it ends.

use serde::{Deserialize, Serialize};

use super::shared::PrintArgs;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::ipc;
use crate::session::ipc::services::{Domain, SceneServices};
use crate::session::ipc::viewed::{Reader, Viewed};
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS, now_ns, sleep_until_ns, span_ns};

/// Span between looks for a message \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;
/// Span between lines \[ns\].
const LINE_NS: u64 = SECOND_NS;
/// A server sends what viewers read this long after it has begun to take poses, or not at all \[ns\].
const START_NS: u64 = SECOND_NS;
/// Longest wait for the first message of a server \[ns\].
const FIRST_NS: u64 = 5 * SECOND_NS;

/// How long to wait for a server.
#[derive(Debug, Clone, Copy, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct ServerWait {
    /// Longest wait for a server [s]
    #[arg(long, default_value_t = 10.0, value_name = "S", allow_negative_numbers = true)]
    pub wait_for_server_s: f64,
}

/// Which messages are looked at.
#[derive(Debug, clap::Args)]
pub struct WatchArgs {
    /// Name of the scene that `serve` was started with
    #[arg(long, value_name = "NAME")]
    pub scene: Option<String>,
    /// End after the first message
    #[arg(long)]
    pub once: bool,
    #[command(flatten)]
    pub server: ServerWait,
    #[command(flatten)]
    pub print: PrintArgs,
}

impl WatchArgs {
    /// Opens the scene.
    ///
    /// # Errors
    /// A time that cannot be waited, a scene that cannot be opened.
    pub fn open(&self) -> Result<SceneServices> {
        self.server.check()?;
        ipc::open(self.scene.as_deref(), &Domain::default())
    }
}

impl ServerWait {
    /// A time that can be waited, before anything is opened.
    ///
    /// # Errors
    /// None that can be.
    pub fn check(&self) -> Result<()> {
        if self.wait_for_server_s.is_finite() && self.wait_for_server_s >= 0.0 {
            return Ok(());
        }
        let Self { wait_for_server_s } = self;
        Err(Error::input(format!("--wait-for-server-s {wait_for_server_s}: must be 0 or more")))
    }

    /// Waits until a server sends; whether one does. One that serves the scene and does not send is none
    /// that is starting.
    ///
    /// # Errors
    /// Ctrl-C.
    pub fn wait<T: Viewed>(&self, scene: &SceneServices, reader: &Reader<T>) -> Result<bool> {
        let at_most_ns = span_ns("`wait_for_server_s`", self.wait_for_server_s)?;
        let end_ns = now_ns().saturating_add(at_most_ns);
        let mut started_ns = None;
        while !reader.is_served() {
            interrupt::check()?;
            let now_ns = now_ns();
            let is_started = scene.is_served();
            let since_ns = *started_ns.get_or_insert(now_ns);
            started_ns = is_started.then_some(since_ns);
            if now_ns >= end_ns || (is_started && now_ns - since_ns >= START_NS) {
                return Ok(false);
            }
            sleep_until_ns(now_ns + LOOK_NS);
        }
        Ok(true)
    }
}

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
                // A line is printed now and then only.
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
