//! Options of serving a scene, and the report.

use serde::{Deserialize, Serialize};

use super::{POSE_HZ, SweepBudget};
use crate::engine::course::ToolCourse;
use crate::engine::cut::report::CutReport;
use crate::engine::estimates::ForceEstimate;
use crate::engine::flag_ticks::FlagTicks;
use crate::engine::stress_limit::StressReport;
use crate::session::ipc::services::Domain;
use crate::session::loops::peers::PeerCost;
use crate::session::loops::wait::Wait;
use crate::session::timing::histogram::Summary;
use crate::session::timing::spans::Spans;

/// Options of serving a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct ServeOptions {
    /// Name of the scene, `None` for the unnamed one.
    pub scene: Option<String>,
    /// Configuration of the files of iceoryx2.
    pub domain: Domain,
    /// Way of waiting for poses.
    pub wait: Wait,
    /// Silence after which the published force falls to 0, 0 for never \[ms\].
    pub watchdog_ms: u32,
    /// Time in which it falls, and rises when poses resume; 0 for at once \[ms\].
    pub ramp_ms: u32,
    /// Largest slew of a ramp, infinite for none [N/s].
    pub max_slew_n_per_s: f32,
    /// Largest speed of a hand for a tissue without an output stage, infinite for any [m/s].
    pub max_speed_m_per_s: f32,
    /// Ticks between two state hashes; 0 for only one at the end of the run.
    pub hash_every: u64,
    /// Largest number of poses executed per second, 0 for no limit; see [`POSE_HZ`] \[Hz\].
    pub max_pose_hz: u32,
    /// Time limit for the sweeps of a tick, for a tissue whose ticks may end after any sweep.
    pub budget: SweepBudget,
    /// Share of the force at which its estimated error is small enough to end a tick.
    pub force_error: Option<f32>,
    /// A tick of the device, if the delay of the loop is measured \[ns\].
    pub delay_period_ns: Option<u64>,
    /// Fault on purpose: least duration of a sweep, 0 for none \[ns\].
    pub sweep_ns: u64,
    /// Ticks before that fault.
    pub sweep_after: u64,
    /// True if the report has a histogram.
    pub histogram: bool,
    /// Number of executed ticks after which the run ends.
    pub ticks: Option<u64>,
    /// Time after which the run ends \[s\].
    pub seconds: Option<f64>,
    /// True to request real-time privileges.
    pub realtime: bool,
    /// True to end when the parent process has ended.
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
            force_error: None,
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

/// Reason for the end of a run.
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

/// Statistics of the sweeps per tick of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct SweepCounts {
    /// 99 % of the ticks had at least this many.
    pub p1: u64,
    /// Median.
    pub p50: u64,
    /// Maximum.
    pub max: u64,
}

/// Report of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ServeReport {
    /// Poses that were executed and answered.
    pub ticks_executed: u64,
    /// Executed poses that newer ones had overtaken: without a sweep, answered with the force of an earlier
    /// tick.
    pub ticks_late: u64,
    /// Late poses that followed a silence or a gap.
    pub ticks_late_behind_gaps: u64,
    /// Poses that never arrived, by their tick numbers: lost, or overwritten in a full queue.
    pub poses_missing: u64,
    /// Number of overloads, in which the tissue could not keep up with the poses and the force fell to 0.
    pub overloads: u64,
    /// Sweeps of the ticks that were not late.
    pub sweeps: SweepCounts,
    /// Time limit for the sweeps of a tick: `auto`, `off`, or microseconds.
    pub budget_us: SweepBudget,
    /// Poses whose tick was not above the publisher's last one; not executed.
    pub poses_repeated: u64,
    /// Poses of a second publisher while the first was alive, and poses with a bad tick; not executed.
    pub poses_refused: u64,
    /// Poses above `--max-pose-hz`; not executed.
    pub poses_throttled: u64,
    /// Number of publishers from which poses were accepted.
    pub publishers: u64,
    /// Answers that shared memory did not accept.
    pub sends_failed: u64,
    /// Number of times that the watchdog lowered the force to 0.
    pub watchdog_fired: u64,
    /// Largest change of the published force from a message to the next one \[N\].
    pub largest_force_step_n: f32,
    /// Executed ticks in the recorder.
    pub ticks_recorded: u64,
    /// Executed ticks that did not fit the full recorder.
    pub ticks_unrecorded: u64,
    /// Number of ticks on which the tissue set each flag.
    pub flag_ticks: FlagTicks,
    /// Course of each tool; of held cells one entry.
    pub tool_courses: Vec<ToolCourse>,
    /// Estimated errors of the forces; `None` where none is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_error_estimate: Option<ForceEstimate>,
    /// The cut of a body that can be cut, since the last reset.
    #[serde(flatten)]
    pub cut: Option<CutReport>,
    /// Energy that a body with branches has relaxed since the last reset \[J\].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relaxed_j: Option<f32>,
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
    /// Messages of strain and stress sent to viewers.
    #[serde(default)]
    pub stresses_sent: u64,
    /// Time to compute and send one, in parts between ticks \[ns\].
    #[serde(default)]
    pub stress_ns: Summary,
    /// Surfaces of a body that can be cut sent to viewers.
    #[serde(default)]
    pub surfaces_sent: u64,
    /// Time to send one, between ticks \[ns\].
    #[serde(default)]
    pub surface_ns: Summary,
    /// The limit of the stress, where one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stress: Option<StressReport>,
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
    /// Reason for the end of the run.
    pub ended_by: Ending,
    /// Privileges that were refused, with the reason.
    pub refused: Vec<String>,
    /// Histogram of `step_ns`, if requested.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_histogram: Option<Spans>,
}
