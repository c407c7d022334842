//! The controller's side: sends poses on an absolute 1 kHz schedule and times the answers as they arrive.
//!
//! It stands on the client's [`Exchange`], with the schedule, the deliberate faults and the accounting on
//! top. [`chaincell_client::Client`] numbers its own poses, sends each once, and refuses one that is no
//! number; here some are late, sent twice or out of order on purpose, and each is timed separately.

use serde::{Deserialize, Serialize};

use chaincell_client::{Exchange, Kind, Options};
use chaincell_kernel::{Flags, ToolPose};

use crate::engine::flag_ticks::FlagTicks;
use crate::engine::motion::Pose;
use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::ipc;
use crate::session::ipc::complain::complain;
use crate::session::ipc::services::Domain;
use crate::session::ipc::tools::{TickForce, ToolForces};
use crate::session::loops::inject::{Faults, Injected, Plan, Sending};
use crate::session::loops::link::{message, tick_force};
use crate::session::loops::outstanding::Outstanding;
use crate::session::loops::playlist::Playlist;
use crate::session::loops::realtime::{self, Role};
use crate::session::loops::wait::Wait;
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS, now_ns, span_ns};
use crate::session::timing::histogram::{Latencies, Summary};
use crate::session::timing::spans::Spans;

/// An answer is due this long after the scheduled send \[ns\].
const DEADLINE_NS: u64 = MILLISECOND_NS;
/// Longest wait for outstanding answers after the last pose \[ns\].
const LINGER_NS: u64 = 2 * SECOND_NS;
/// Time before the first pose \[ns\].
const START_NS: u64 = 2 * MILLISECOND_NS;

/// Options of controlling a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlOptions {
    /// Name of the scene, `None` for the unnamed one.
    pub scene: Option<String>,
    /// Configuration of the files of iceoryx2.
    pub domain: Domain,
    /// Way of waiting for answers.
    pub wait: Wait,
    /// Longest wait for a server before the first pose \[s\].
    pub wait_for_server_s: f64,
    /// Number of times that the poses are played; the ticks continue to count.
    pub repeats: u64,
    /// True if the report has histograms.
    pub histogram: bool,
    /// True to ask for real-time privileges.
    pub realtime: bool,
    /// True to end when the process that started this one has ended.
    pub ends_with_parent: bool,
    /// Silence of the server after which the force at the device falls to 0, 0 for never \[ms\].
    pub watchdog_ms: u32,
    /// Time in which it falls, and rises when answers resume; 0 for at once \[ms\].
    pub ramp_ms: u32,
    /// Deliberate faults, and the seed from which they are drawn.
    pub faults: Option<(Faults, u64)>,
}

impl Default for ControlOptions {
    fn default() -> Self {
        Self {
            scene: None,
            domain: Domain::default(),
            wait: Wait::default(),
            wait_for_server_s: 10.0,
            repeats: 1,
            histogram: false,
            realtime: true,
            ends_with_parent: false,
            watchdog_ms: 20,
            ramp_ms: 20,
            faults: None,
        }
    }
}

/// Report of a controller's run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ControlReport {
    /// Poses sent; one that was sent twice counts once.
    pub ticks_sent: u64,
    /// Poses whose answer arrived.
    pub ticks_answered: u64,
    /// Poses sent without an answer, except those sent after a later one on purpose.
    pub ticks_unanswered: u64,
    /// Answers that arrived more than 1 ms after the scheduled send.
    pub missed_deadlines: u64,
    /// Of these, the ones whose pose was itself sent more than 1 ms late: the machine delayed this process.
    pub missed_sent_late: u64,
    /// Of the others, the ones whose tick took more than 1 ms.
    pub missed_in_step: u64,
    /// Number of answers in which each flag was set.
    pub flag_ticks: FlagTicks,
    /// Messages of the tissue's watchdog after poses stopped: one per millisecond while the force falls.
    pub stale_answers: u64,
    /// Answers to poses that were not sent, or that already had an answer.
    pub foreign_answers: u64,
    /// Poses that shared memory did not accept; they count as sent.
    pub sends_failed: u64,
    /// Number of times that no message of the server came for the watchdog's time.
    pub silences: u64,
    /// Largest change of the force at the device from one shown value to the next \[N\].
    pub largest_force_step_n: f32,
    /// Deliberate faults.
    pub injected: Option<Injected>,
    /// Time from the send of a pose to the arrival of its answer \[ns\].
    pub round_trip_ns: Summary,
    /// Time from the scheduled to the actual send \[ns\].
    pub send_late_ns: Summary,
    /// Hash in the last answer that had one: 16 lower-case hexadecimal digits, or empty.
    pub state_hash: String,
    /// True if the user asked to stop before the last pose.
    pub interrupted: bool,
    /// Privileges that were refused, with the reasons.
    pub refused: Vec<String>,
    /// Histograms, if they were requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub histogram: Option<ControlSpans>,
}

/// Histograms of a controller's run.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ControlSpans {
    /// Time from the send of a pose to the arrival of its answer.
    pub round_trip: Spans,
    /// Time from the scheduled to the actual send, by which this process woke up late.
    pub send_late: Spans,
}

/// A controller's run: its report, and the answers in order of arrival.
#[derive(Debug, Clone, PartialEq)]
pub struct ControlRun {
    /// The report.
    pub report: ControlReport,
    /// One answer for each answered pose; with several tools it has the force of tool 0 and the contacts of
    /// all. Empty if the poses are repeated, so that a run's memory does not depend on its length.
    pub forces: Vec<TickForce>,
}

/// Plays poses at 1 kHz, or with the given faults. A late pose is sent late, never skipped.
///
/// If the server ends, the schedule continues: poses without an answer are counted, and the answers of
/// the next server are accepted.
///
/// The ticks must ascend strictly. Waits for a server before the first pose and, for at most 2 s,
/// for outstanding answers after the last one. The memory depends on the number of poses, not on time.
pub fn control(poses: &[Pose], options: &ControlOptions) -> Result<ControlRun> {
    control_tools(poses, &[], options)
}

/// Like [`control`], for several tools: `tools` holds the poses of all tools in each tick of `poses`, tick
/// by tick. If it is empty, this is [`control`].
pub fn control_tools(
    poses: &[Pose],
    tools: &[ToolPose],
    options: &ControlOptions,
) -> Result<ControlRun> {
    let poses = Playlist::new(poses, options.repeats)?.with_tools(tools);
    if options.ends_with_parent {
        realtime::end_with_parent()?;
    }
    // Wait for the server.
    let scene = ipc::open(options.scene.as_deref(), &options.domain)?;
    let server_wait_ns = span_ns("`wait_for_server_s`", options.wait_for_server_s)?;
    let &ControlOptions { wait, watchdog_ms, ramp_ms, wait_for_server_s, .. } = options;
    let of_client = Options { wait, server_wait_ns, watchdog_ms, ramp_ms, ..Options::default() };
    let opened = Exchange::open(&scene, &of_client, interrupt::asked);
    let exchange = opened.map_err(|why| match why.kind() {
        Kind::NoServer => Error::input(format!(
            "no server on {} after {wait_for_server_s} s; start chaincell serve with the same \
             `scene`, or wait longer with `wait_for_server_s`",
            scene.label()
        )),
        _ => why.into(),
    })?;
    // Two programs on a scene confuse each other.
    if scene.has_other_pose_publisher() {
        log::warn!(
            "another program may publish poses on {}: the server executes those of one program",
            scene.label()
        );
    }
    let refused =
        if options.realtime { realtime::ask(Role::Control, options.wait) } else { Vec::new() };
    // Play the poses, then wait for the last answers.
    let mut run = Run::new(poses, exchange, options.faults)?;
    run.play();
    run.linger();
    Ok(run.finish(refused, options.histogram))
}

struct Run<'a> {
    poses: Playlist<'a>,
    plan: Plan,
    exchange: Exchange,
    start_ns: u64,
    outstanding: Outstanding,
    overtaken: u64,
    forces: Vec<TickForce>,
    round_trip: Latencies,
    send_late: Latencies,
    missed: u64,
    missed_sent_late: u64,
    missed_in_step: u64,
    flag_ticks: FlagTicks,
    stale: u64,
    foreign: u64,
    failed: u64,
    state_hash: u64,
    interrupted: bool,
}

impl<'a> Run<'a> {
    fn new(poses: Playlist<'a>, exchange: Exchange, faults: Option<(Faults, u64)>) -> Result<Self> {
        let kept = if poses.is_repeated() { 0 } else { poses.len() };
        let mut forces = Vec::new();
        // Writing every element now keeps page faults out of the loop.
        forces.resize(usize::try_from(kept).unwrap_or(0), TickForce::default());
        forces.clear();
        Ok(Self {
            poses,
            plan: Plan::new(poses.len(), faults),
            exchange,
            start_ns: now_ns() + START_NS,
            outstanding: Outstanding::new(),
            overtaken: 0,
            forces,
            round_trip: Latencies::new()?,
            send_late: Latencies::new()?,
            missed: 0,
            missed_sent_late: 0,
            missed_in_step: 0,
            flag_ticks: FlagTicks::default(),
            stale: 0,
            foreign: 0,
            failed: 0,
            state_hash: 0,
            interrupted: false,
        })
    }

    fn play(&mut self) {
        while let Some(sending) = self.plan.next() {
            self.receive_until(self.start_ns + sending.due_ns, |_| interrupt::asked());
            if interrupt::asked() {
                self.interrupted = true;
                return;
            }
            self.send(&sending);
        }
    }

    fn scheduled_ns(&self, index: u64) -> u64 {
        self.start_ns + index * self.plan.period_ns()
    }

    fn send(&mut self, sending: &Sending) {
        let (send_ns, due_ns) = (now_ns(), self.start_ns + sending.due_ns);
        let pose = sending.pose(self.poses.pose(sending.index));
        let message = message(pose, send_ns, self.poses.tools(sending.index));
        if let Err(why) = self.exchange.send(message) {
            complain(&mut self.failed, "cannot send a pose", format_args!("{why}"));
        }
        self.send_late.record(send_ns.saturating_sub(due_ns));
        if !sending.again {
            self.outstanding.send(sending.index, send_ns);
            self.overtaken += u64::from(sending.overtaken);
        }
    }

    /// Returns the number of sent poses that the server should have answered and has not.
    fn unanswered(&self) -> u64 {
        let due = self.outstanding.sent() - self.overtaken;
        due.saturating_sub(self.outstanding.answered())
    }

    /// Receives answers until `moment_ns`, or until `done`.
    fn receive_until(&mut self, moment_ns: u64, done: impl Fn(&Self) -> bool) {
        while !done(self) {
            if let Some(forces) = self.exchange.receive() {
                self.on_answer(&forces, now_ns());
            } else if !self.exchange.pause(moment_ns) {
                return;
            }
        }
    }

    fn on_answer(&mut self, forces: &ToolForces, arrival_ns: u64) {
        // Show the force; a message of the watchdog answers no pose.
        if !self.exchange.show(forces, arrival_ns) {
            self.stale += 1;
            return;
        }
        let force = tick_force(forces);
        // Find the pose of the answer.
        let index = self.poses.index_of(force.tick);
        let answered = index.and_then(|index| Some((index, self.outstanding.answer(index)?)));
        let Some((index, sent_ns)) = answered else {
            self.foreign += 1;
            return;
        };
        // Time the round trip.
        let round_trip_ns = arrival_ns.saturating_sub(sent_ns);
        self.exchange.answered(arrival_ns, sent_ns, self.unanswered() > 0);
        self.round_trip.record(round_trip_ns);
        self.flag_ticks.add(Flags(force.flags));
        // Check the deadline, and note the cause of a miss.
        let due_ns = self.scheduled_ns(index) + DEADLINE_NS;
        if arrival_ns > due_ns {
            self.missed += 1;
            if sent_ns > due_ns {
                self.missed_sent_late += 1;
            } else if u64::from(force.step_ns) > DEADLINE_NS {
                self.missed_in_step += 1;
            }
        }
        // Keep the hash and the answer.
        if force.state_hash != 0 {
            self.state_hash = force.state_hash;
        }
        if !self.poses.is_repeated() {
            self.forces.push(force);
        }
    }

    fn linger(&mut self) {
        // After a request to stop, the wait is short for the user and the process that started this one.
        let linger_ns = if self.interrupted { LINGER_NS / 4 } else { LINGER_NS };
        let end_ns = now_ns() + linger_ns;
        self.receive_until(end_ns, |run| run.unanswered() == 0);
    }

    fn finish(self, refused: Vec<String>, histogram: bool) -> ControlRun {
        // The histograms allocate, so they are made here, after the loop.
        let histogram = histogram.then(|| ControlSpans {
            round_trip: self.round_trip.spans(),
            send_late: self.send_late.spans(),
        });
        ControlRun {
            report: ControlReport {
                ticks_sent: self.outstanding.sent(),
                ticks_answered: self.outstanding.answered(),
                ticks_unanswered: self.unanswered(),
                missed_deadlines: self.missed,
                missed_sent_late: self.missed_sent_late,
                missed_in_step: self.missed_in_step,
                flag_ticks: self.flag_ticks,
                stale_answers: self.stale,
                foreign_answers: self.foreign,
                sends_failed: self.failed,
                silences: self.exchange.silences(),
                largest_force_step_n: self.exchange.largest_step_n(),
                injected: self.plan.injected(),
                round_trip_ns: self.round_trip.summary(),
                send_late_ns: self.send_late.summary(),
                state_hash: match self.state_hash {
                    0 => String::new(),
                    hash => format!("{hash:016x}"),
                },
                interrupted: self.interrupted,
                refused,
                histogram,
            },
            forces: self.forces,
        }
    }
}
