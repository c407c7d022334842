//! What a scene is served with, and what came of it.

use serde::{Deserialize, Serialize};

use super::{POSE_HZ, SweepBudget};
use crate::engine::flag_ticks::FlagTicks;
use crate::session::ipc::services::Domain;
use crate::session::loops::peers::PeerCost;
use crate::session::loops::wait::Wait;
use crate::session::timing::histogram::Summary;
use crate::session::timing::spans::Spans;

/// How to serve a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ServeOptions {
    /// Name of the scene, `None` for the unnamed one.
    pub scene: Option<String>,
    /// Where iceoryx2 keeps its files.
    pub domain: Domain,
    /// How to wait for poses.
    pub wait: Wait,
    /// Silence after which the published force falls to 0, 0 for never \[ms\].
    pub watchdog_ms: u32,
    /// Time in which it falls, and rises when poses come again; 0 for at once \[ms\].
    pub ramp_ms: u32,
    /// Largest slew of a ramp, infinite for none [N/s].
    pub max_slew_n_per_s: f32,
    /// Largest speed of a hand in front of a tissue without an output stage, infinite for any [m/s].
    pub max_speed_m_per_s: f32,
    /// A state hash every this many ticks; 0 leaves it to the end of the run.
    pub hash_every: u64,
    /// Most poses executed a second, 0 for any number; see [`POSE_HZ`] \[Hz\].
    pub max_pose_hz: u32,
    /// How long the sweeps of a tick may take, for a tissue whose ticks may end after any.
    pub budget: SweepBudget,
    /// A tick of the device, where the delay of the loop is measured \[ns\].
    pub delay_period_ns: Option<u64>,
    /// Fault on purpose: a sweep takes at least so long, 0 for none \[ns\].
    pub sweep_ns: u64,
    /// Ticks before that.
    pub sweep_after: u64,
    /// Whether the report has a histogram.
    pub histogram: bool,
    /// Ends after this many executed ticks.
    pub ticks: Option<u64>,
    /// Ends after this long \[s\].
    pub seconds: Option<f64>,
    /// Whether to ask for real-time privileges.
    pub realtime: bool,
    /// Whether to end when the process that started this one has ended.
    pub ends_with_parent: bool,
}

impl Default for ServeOptions {
    fn default() -> Self {
        Self {
            scene: None,
            domain: Domain::default(),
            wait: Wait::default(),
            watchdog_ms: 20,
            ramp_ms: 20,
            max_slew_n_per_s: f32::INFINITY,
            max_speed_m_per_s: f32::INFINITY,
            hash_every: 1,
            max_pose_hz: POSE_HZ,
            budget: SweepBudget::default(),
            delay_period_ns: None,
            sweep_ns: 0,
            sweep_after: 0,
            histogram: false,
            ticks: None,
            seconds: None,
            realtime: true,
            ends_with_parent: false,
        }
    }
}

/// Why a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Ending {
    /// All ticks were executed.
    Ticks,
    /// The time was up.
    Seconds,
    /// The user asked to stop.
    Interrupt,
}

/// Sweeps of the ticks of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SweepCounts {
    /// 99 % of the ticks had at least so many.
    pub p1: u64,
    /// Median.
    pub p50: u64,
    /// The most.
    pub max: u64,
}

/// What happened while serving.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ServeReport {
    /// Poses that were executed and answered.
    pub ticks_executed: u64,
    /// Of these, the ones that newer poses had overtaken: executed without a sweep, answered with
    /// the force of an earlier one.
    pub ticks_late: u64,
    /// Of those, the ones that came at once behind a silence or a gap.
    pub ticks_late_behind_gaps: u64,
    /// Poses that never came, by the numbers of their ticks: lost, or overwritten in a full queue.
    pub poses_missing: u64,
    /// Times that the tissue could not keep up with the poses, so that the force fell to 0.
    pub overloads: u64,
    /// Sweeps of the ticks that were not late.
    pub sweeps: SweepCounts,
    /// Time for the sweeps of a tick: `auto`, `off`, or microseconds.
    pub budget_us: SweepBudget,
    /// Poses whose tick was not above the publisher's last one: not executed.
    pub poses_repeated: u64,
    /// Poses of a second publisher while the first was alive, and poses with a bad tick: not
    /// executed.
    pub poses_refused: u64,
    /// Poses beyond `--max-pose-hz`: not executed.
    pub poses_throttled: u64,
    /// Publishers that poses were accepted from.
    pub publishers: u64,
    /// Answers that shared memory did not take.
    pub sends_failed: u64,
    /// Times the watchdog let the force fall to 0.
    pub watchdog_fired: u64,
    /// Largest change of the published force from a message to the next one \[N\].
    pub largest_force_step_n: f32,
    /// Executed ticks kept in the recorder.
    pub ticks_recorded: u64,
    /// Executed ticks that found the recorder full.
    pub ticks_unrecorded: u64,
    /// On how many ticks the tissue set each flag.
    pub flag_ticks: FlagTicks,
    /// Poses answered with force 0 while paused; they count as executed.
    pub ticks_paused: u64,
    /// Commands carried out.
    pub commands_done: u64,
    /// Commands refused.
    pub commands_refused: u64,
    /// States sent to viewers.
    pub states_sent: u64,
    /// Time to send a state, between ticks \[ns\].
    pub state_ns: Summary,
    /// Messages of contacts sent to viewers.
    pub contacts_sent: u64,
    /// Time to send one, between ticks \[ns\].
    pub contacts_ns: Summary,
    /// Time of a tick \[ns\].
    pub step_ns: Summary,
    /// Cost of peers that joined and left.
    pub peers: PeerCost,
    /// Hash of the final state, 16 lower-case hexadecimal digits.
    pub state_hash: String,
    /// Why the run ended.
    pub ended_by: Ending,
    /// Privileges that were refused, with the reason.
    pub refused: Vec<String>,
    /// Histogram of `step_ns`, where it was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_histogram: Option<Spans>,
}
