//! Runs `serve` and `control` as child processes and collects their reports.

pub mod program;

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::loops::control::ControlReport;
use crate::session::loops::serve::ServeReport;
use crate::terminal::Progress;

/// Line that `serve` prints once its services exist.
const READY: &str = "ready";
/// Time between checks of the children.
const LOOK: Duration = Duration::from_millis(20);
/// Time in which children that got the terminal's Ctrl-C may write their results.
const OWN_END: Duration = Duration::from_millis(1500);
/// Time in which a child has to end after a termination signal.
const TERM_LIMIT: Duration = Duration::from_secs(5);
/// Time in which `serve` may end by itself after `control`.
const SERVE_END: Duration = Duration::from_secs(3);
/// Time that `control` has besides the motion, to find the server, wait for answers and report.
const CONTROL_END: Duration = Duration::from_secs(20);

/// The two child processes of a co-simulation. Set `ends_with_parent` on both sides, so that they end
/// even if this process is killed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CosimOptions {
    /// Executable of both sides.
    pub program: PathBuf,
    /// Arguments with which it serves the scene and prints a report as the last line.
    pub serve_args: Vec<OsString>,
    /// Arguments with which it controls the scene and prints a report as the last line.
    pub control_args: Vec<OsString>,
    /// Length of the motion \[ms\].
    pub motion_ms: u64,
    /// Longest wait for `ready` \[s\].
    pub ready_s: u64,
}

/// Reports of both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct CosimReports {
    /// The tissue's side.
    pub serve: ServeReport,
    /// The controller's side.
    pub control: ControlReport,
    /// True if the user asked to stop; the reports then cover the run up to that moment.
    pub interrupted: bool,
}

/// The two child processes while they run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Underway {
    /// Time since the start of the controller.
    pub elapsed: Duration,
    /// Process id of the tissue's side.
    pub serve_pid: u32,
    /// Process id of the controller's side.
    pub control_pid: u32,
}

/// Runs both sides to their end, and calls `watch` about fifty times per second during the motion. No child
/// outlives this call, even if it fails.
pub fn cosim(options: &CosimOptions, mut watch: impl FnMut(Underway)) -> Result<CosimReports> {
    // Start both sides, the server first.
    let mut serve = Side::start("serve", &options.program, &options.serve_args)?;
    serve.wait_for_ready(Duration::from_secs(options.ready_s))?;
    let mut control = Side::start("control", &options.program, &options.control_args)?;
    // Follow the motion until the controller ends, is overdue, or a side fails.
    let motion = Duration::from_millis(options.motion_ms);
    let progress = Progress::new(options.motion_ms, "cosim");
    let start = Instant::now();
    while control.try_wait()?.is_none()
        && start.elapsed() < motion + CONTROL_END
        && !interrupt::asked()
    {
        if serve.try_wait()?.is_some_and(|status| !status.success()) {
            break;
        }
        let done_ms = u64::try_from(start.elapsed().as_millis()).unwrap_or(u64::MAX);
        progress.set_done(done_ms.min(options.motion_ms));
        let (serve_pid, control_pid) = (serve.child.id(), control.child.id());
        watch(Underway { elapsed: start.elapsed(), serve_pid, control_pid });
        std::thread::sleep(LOOK);
    }
    drop(progress);
    // End both sides and collect their reports.
    let own_end = if interrupt::asked() { OWN_END } else { Duration::ZERO };
    let control_report = control.end(own_end)?;
    let serve_report = serve.end(SERVE_END)?;
    Ok(CosimReports {
        serve: serve_report,
        control: control_report,
        interrupted: interrupt::asked(),
    })
}

/// A child process; dropping this kills it.
struct Side {
    name: &'static str,
    child: Child,
    lines: Receiver<String>,
    last_line: String,
}

impl Side {
    fn start(name: &'static str, program: &Path, args: &[OsString]) -> Result<Self> {
        let start_error = |why| Error::check(format!("cannot start chaincell {name}: {why}"));
        let mut child = Command::new(program)
            .args(args)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(start_error)?;
        let (sender, lines) = mpsc::channel();
        if let Some(stdout) = child.stdout.take() {
            // The thread ends with the child, whose end closes the pipe.
            std::thread::spawn(move || {
                for line in BufReader::new(stdout).lines().map_while(std::result::Result::ok) {
                    if sender.send(line).is_err() {
                        return;
                    }
                }
            });
        }
        Ok(Self { name, child, lines, last_line: String::new() })
    }

    fn wait_for_ready(&mut self, at_most: Duration) -> Result<()> {
        let start = Instant::now();
        while start.elapsed() < at_most {
            interrupt::check()?;
            match self.lines.recv_timeout(LOOK) {
                Ok(line) if line == READY => return Ok(()),
                Ok(_) | Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    let status = self.wait(TERM_LIMIT)?;
                    return Err(self.failed(status));
                }
            }
        }
        Err(Error::check(format!(
            "chaincell {} was not ready after {} s; look for its message above",
            self.name,
            at_most.as_secs()
        )))
    }

    /// Gives the child the time `by_itself` to end, then ends it, and returns its report.
    fn end<Report: DeserializeOwned>(&mut self, by_itself: Duration) -> Result<Report> {
        let status = self.wait(by_itself)?;
        let lines = self.lines.iter().filter(|line| !line.is_empty());
        if let Some(line) = lines.last() {
            self.last_line = line;
        }
        serde_json::from_str(&self.last_line).map_err(|_| self.failed(status))
    }

    fn wait(&mut self, by_itself: Duration) -> Result<ExitStatus> {
        if let Some(status) = self.wait_for(by_itself)? {
            return Ok(status);
        }
        if let Some(pid) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw) {
            // A child that has just ended needs no signal.
            let _ = kill_process(pid, Signal::TERM);
        }
        if let Some(status) = self.wait_for(TERM_LIMIT)? {
            return Ok(status);
        }
        let ended = self.child.kill().and_then(|()| self.child.wait());
        ended.map_err(|why| self.lost(&why))
    }

    fn wait_for(&mut self, at_most: Duration) -> Result<Option<ExitStatus>> {
        let start = Instant::now();
        loop {
            let status = self.try_wait()?;
            if status.is_some() || start.elapsed() >= at_most {
                return Ok(status);
            }
            std::thread::sleep(LOOK.min(at_most));
        }
    }

    fn try_wait(&mut self) -> Result<Option<ExitStatus>> {
        let status = self.child.try_wait();
        status.map_err(|why| self.lost(&why))
    }

    fn lost(&self, why: &std::io::Error) -> Error {
        Error::check(format!("cannot wait for chaincell {}: {why}", self.name))
    }

    /// Error for a child that ended without a report; it has written the reason to standard error.
    fn failed(&self, status: ExitStatus) -> Error {
        let text = format!(
            "chaincell {} ended without a report ({status}); its message stands above",
            self.name
        );
        match status.code() {
            Some(2) => Error::input(text),
            Some(130) if interrupt::asked() => Error::Interrupted,
            _ => Error::check(text),
        }
    }
}

impl Drop for Side {
    fn drop(&mut self) {
        // Both fail only for a child that has ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
