//! A path played through a tissue, tick by tick.

use std::time::Instant;

use chaincell_kernel::{Budget, TickOutput, ToolPose};

use super::budget::timeless;
use crate::engine::flag_ticks::FlagTicks;
use crate::engine::motion::Pose;
use crate::engine::order::{TickOrder, TickPlace};
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::tools::Poses;
use crate::error::Result;
use crate::files::output::Answer;
use crate::files::path::Paths;
use crate::interrupt;
use crate::session::timing::histogram::Latencies;
use crate::terminal::Progress;

/// The result of a path that was played through an engine.
pub struct Played {
    /// One answer a tick that was executed.
    pub answers: Vec<Answer>,
    /// Number of ticks on which each flag was set.
    pub flag_ticks: FlagTicks,
    /// Time of each tick.
    pub step: Latencies,
    /// Poses whose tick was not above the last one, or was bad: not executed.
    pub poses_repeated: u64,
}

/// Plays sequences of poses, each from another controller, through a tissue as `serve` would,
/// calling `after` after each tick with the poses of all tools. A path of one tool moves the
/// first alone. A tick ends early where the estimated errors of the forces are within `share` of them, if one is
/// given. Ends early, with what it has, when the user asks to stop.
pub fn play(
    tissue: &mut Staged<'_>,
    paths: &Paths,
    share: Option<f32>,
    progress: Progress,
    mut after: impl FnMut(&Pose, &Poses, &TickOutput, &mut Staged<'_>) -> Result<()>,
) -> Result<Played> {
    let poses: usize = paths.poses.iter().map(Vec::len).sum();
    let mut played = Played {
        answers: Vec::with_capacity(poses),
        flag_ticks: FlagTicks::default(),
        step: Latencies::new()?,
        poses_repeated: 0,
    };
    'session: for (sequence, poses) in paths.poses.iter().enumerate() {
        let mut order = TickOrder::default();
        for (at, pose) in poses.iter().enumerate() {
            if interrupt::asked() {
                break 'session;
            }
            progress.step();
            if order.take(pose.tick) != TickPlace::Next {
                played.poses_repeated += 1;
                continue;
            }
            let first = [ToolPose::from(*pose)];
            let poses = match paths.each(sequence, at) {
                [] => &first,
                each => each,
            };
            let budget = timeless(pose.sweeps, share);
            let output = played.tick(tissue, pose.tick, poses, budget);
            after(pose, &Poses::of_tools(tissue.tools(), poses), &output, tissue)?;
        }
    }
    drop(progress);
    Ok(played)
}

impl Played {
    /// Mean number of sweeps in a tick.
    pub fn sweeps_mean(&self) -> f64 {
        let sweeps: u64 = self.answers.iter().map(|answer| u64::from(answer.output.sweeps)).sum();
        sweeps as f64 / self.answers.len().max(1) as f64
    }

    /// Returns true if the tool had a contact in some tick.
    pub fn has_touched(&self) -> bool {
        self.answers.iter().any(|answer| answer.output.contacts > 0)
    }

    /// One timed tick.
    fn tick(
        &mut self,
        tissue: &mut Staged<'_>,
        tick: u64,
        poses: &[ToolPose],
        budget: Budget<'_>,
    ) -> TickOutput {
        let start = Instant::now();
        let output = tissue.tick_by(poses, budget);
        let span = start.elapsed();
        self.step.record(u64::try_from(span.as_nanos()).unwrap_or(u64::MAX));
        self.flag_ticks.add(output.flags);
        let cut_area_m2 = tissue.engine_mut().cut_area_m2();
        let force_error_n = tissue.force_error_n(0);
        self.answers.push(Answer { tick, output, cut_area_m2, force_error_n });
        output
    }
}
