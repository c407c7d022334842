//! Latency of the machine itself: the same waits and the same loops, without a tissue.

use crate::engine::motion::Pose;
use crate::engine::tissue::NoTissue;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::ipc::names::unique_scene;
use crate::session::ipc::services::Domain;
use crate::session::loops::control::{ControlOptions, ControlReport, control};
use crate::session::loops::realtime::{self, Role};
use crate::session::loops::record::Recorder;
use crate::session::loops::serve::{ServeOptions, Server};
use crate::session::loops::wait::{Wait, Waiter};
use crate::session::timing::clock::{MILLISECOND_NS, PERIOD_NS, now_ns};
use crate::session::timing::histogram::{Latencies, Summary};

/// Longest wait of each side for the other \[s\].
const MEET_S: f64 = 5.0;

/// Latency of the machine itself in one wait mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Floor {
    /// Delay with which an empty 1 kHz loop wakes up \[ns\].
    pub wakeup_ns: Summary,
    /// The controller's run through `serve` and `control` without a tissue.
    pub run: ControlReport,
}

impl Floor {
    /// Returns the share of the answers that came more than 1 ms after the scheduled send.
    #[must_use]
    pub fn late_share(&self) -> f64 {
        self.run.missed_deadlines as f64 / self.run.ticks_answered.max(1) as f64
    }
}

/// Measures the latency, each part in `ticks` ticks of 1 ms.
pub fn measure(wait: Wait, realtime: bool, ticks: u64, domain: &Domain) -> Result<Floor> {
    let wakeup = in_thread(move || wakeup(wait, realtime, ticks))?;
    let run = without_tissue(wait, realtime, ticks, domain)?;
    Ok(Floor { wakeup_ns: wakeup.summary(), run })
}

/// Measures the delay with which the controller's wait reaches each tick of an empty 1 kHz loop.
fn wakeup(wait: Wait, realtime: bool, ticks: u64) -> Result<Latencies> {
    if realtime {
        realtime::ask(Role::Control, wait);
    }
    let mut late = Latencies::new()?;
    let waiter = Waiter::new(wait, PERIOD_NS);
    let start_ns = now_ns() + MILLISECOND_NS;
    for tick in 0..ticks {
        interrupt::check()?;
        let moment_ns = start_ns + tick * PERIOD_NS;
        waiter.until(moment_ns);
        late.record(now_ns() - moment_ns);
    }
    Ok(late)
}

/// Runs server and controller for `ticks` ticks of 1 ms without a tissue: two threads, each with its own
/// node, connected like two processes. The report has histograms.
///
/// # Errors
/// The user's request to stop; a failure of shared memory.
pub fn without_tissue(
    wait: Wait,
    realtime: bool,
    ticks: u64,
    domain: &Domain,
) -> Result<ControlReport> {
    // Set both sides up with the same scene.
    let scene = Some(unique_scene("floor"));
    let serve_options = ServeOptions {
        scene: scene.clone(),
        domain: domain.clone(),
        wait,
        hash_every: 0,
        ticks: Some(ticks),
        seconds: Some(2.0 * MEET_S + ticks as f64 / 1000.0),
        realtime,
        ..ServeOptions::default()
    };
    let control_options = ControlOptions {
        scene,
        domain: domain.clone(),
        wait,
        wait_for_server_s: MEET_S,
        realtime,
        repeats: ticks,
        histogram: true,
        ..ControlOptions::default()
    };
    // Run both to their end.
    let server = std::thread::spawn(move || {
        Server::open(&serve_options)?.run(&mut NoTissue, &mut Recorder::default())
    });
    let run = in_thread(move || control(&[Pose::default()], &control_options));
    join(server)?;
    let report = run?.report;
    if report.interrupted { Err(Error::Interrupted) } else { Ok(report) }
}

/// Runs `work` in a new thread, so that its privileges end with it.
fn in_thread<R: Send + 'static>(work: impl FnOnce() -> Result<R> + Send + 'static) -> Result<R> {
    join(std::thread::spawn(work))
}

fn join<R>(thread: std::thread::JoinHandle<Result<R>>) -> Result<R> {
    let ended = thread.join();
    ended.unwrap_or_else(|_| Err(Error::check("a measuring thread of the machine's floor failed")))
}
