//! A tissue with an output stage: the device's samples in, the device's forces out.

use chaincell_client::stress::NodeStress;
use chaincell_client::surface::{SurfaceHeader, SurfaceRow};
use chaincell_kernel::stage::{Stage, StageSettings};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{
    Budget, ContactForce, Drive, Flags, Model, TOOLS_MAX, TickOutput, ToolPose,
};
use nalgebra::Vector3;

use crate::bake::tissue::DEVICE_HZ;
use crate::engine::Engine;
use crate::engine::cut::report::CutReport;
use crate::engine::snapshot::Saved;
use crate::engine::tissue::{Node, Refusal, TissueEngine};
use crate::engine::tools::{Felt, Poses};
use crate::error::{Error, Result};

/// Rounding of a rate in single precision, as a share of it.
const RATE_ROUNDING: f64 = 1.0e-6;

/// An engine with a stage between it and the device, one for each of several tools, or without a stage.
///
/// Several stages have the same settings, but each has its own ledger, ramp and limits: a force withheld at
/// one tool does not affect the others.
///
/// Every sample is one tick of both, so the output is a function of the samples alone. A silence is no tick
/// of either: the loop decides what is published meanwhile.
pub struct Staged<'m> {
    engine: Engine<'m>,
    stages: Vec<Stage>,
    /// Largest torque of a tool \[N m\].
    max_torque_n_m: f32,
    /// Tools that were engaged in the last good poses.
    engaged: [bool; TOOLS_MAX],
    /// The last output of each tool; without stages only that of the first.
    last: [TickOutput; TOOLS_MAX],
    /// True for each tool, and for held cells in the first place, whose answered force is not the tissue's in the
    /// last tick: its stage was on a ramp, or coupling, control, clamp or slew limit changed the force.
    is_shaped: [bool; TOOLS_MAX],
    /// Poses that the tissue got in the last tick.
    passed: Poses,
}

impl<'m> Staged<'m> {
    /// An engine with stages of these settings, or without a stage; a tick is then a millisecond.
    ///
    /// # Errors
    /// A setting out of range, ticks for which the model's branches of relaxation were not baked.
    pub fn new(engine: Engine<'m>, settings: Option<StageSettings>) -> Result<Self> {
        let goes_by_position =
            settings.is_some_and(|of| of.coupling.is_some() || of.passivity.is_some());
        if goes_by_position && engine.network().settings().drive == Drive::Current {
            return Err(Error::input(
                "`drive` current: coupling and passivity control are for a tool that prescribes \
                 positions; pass `coupling` none `passivity` none",
            ));
        }
        check_tick(engine.network().model(), settings)?;
        let mut stages = Vec::new();
        if let Some(settings) = settings {
            let stage = Stage::new(settings);
            let stage = stage.map_err(|why| Error::input(format!("output stage: {why}")))?;
            stages.resize(engine.contact().tools().max(1), stage);
        }
        let max_torque_n_m = f32::INFINITY;
        let [engaged, is_shaped] = [[false; TOOLS_MAX]; 2];
        let (last, passed) = ([TickOutput::NONE; TOOLS_MAX], Poses::NONE);
        Ok(Self { engine, stages, max_torque_n_m, engaged, last, is_shaped, passed })
    }

    /// Limits the torques of tools from now on \[N m\]. It changes no bit of the tissue.
    pub fn limit_torque(&mut self, max_torque_n_m: f32) {
        self.max_torque_n_m = max_torque_n_m;
    }

    /// The tissue.
    #[must_use]
    pub fn engine(&self) -> &Engine<'m> {
        &self.engine
    }

    /// The tissue, for callers that read its nodes.
    pub fn engine_mut(&mut self) -> &mut Engine<'m> {
        &mut self.engine
    }

    /// Restores the state that an engine of the same options has saved.
    ///
    /// # Errors
    /// A snapshot that does not fit; nothing has changed then.
    pub fn restore(&mut self, saved: &Saved) -> Result<()> {
        // Restore copies of the stages first, then settings and tissue.
        let mut stages = self.stages.clone();
        let bytes = stages.iter().map(Stage::snapshot_bytes).sum::<usize>();
        if bytes != saved.stage.len() {
            return Err(Error::input("the snapshot has other output stages"));
        }
        let each = saved.stage.chunks_exact((bytes / stages.len().max(1)).max(1));
        for (stage, bytes) in stages.iter_mut().zip(each) {
            stage.restore(bytes).map_err(Error::input)?;
        }
        let before = *self.engine.network().settings();
        self.engine.choose(saved.settings)?;
        if let Err(why) = self.engine.restore(&saved.tissue) {
            self.engine.choose(before)?;
            return Err(why);
        }
        // Take over the stages only when everything fits.
        self.stages = stages;
        self.engaged = saved.engaged;
        (self.last, self.is_shaped) = ([TickOutput::NONE; TOOLS_MAX], [false; TOOLS_MAX]);
        Ok(())
    }

    /// Poses that the tissue got in the last tick: those of the device after the stages.
    #[must_use]
    pub fn passed(&self) -> &Poses {
        &self.passed
    }

    /// The stage's settings; `None` without a stage.
    #[must_use]
    pub fn settings(&self) -> Option<&StageSettings> {
        self.stages.first().map(Stage::settings)
    }
}

/// Ticks in a second for which the branches of relaxation of a model were baked \[Hz\]; `None` of an elastic one.
#[must_use]
pub fn baked_hz(model: &Model<'_>) -> Option<f64> {
    model.branches().next().map(|branch| 1.0 / f64::from(branch.tick_s))
}

/// Checks that the branches of relaxation of a model were baked for the ticks of a session.
///
/// # Errors
/// Another rate, with both.
pub fn check_tick(model: &Model<'_>, settings: Option<StageSettings>) -> Result<()> {
    let Some(baked_hz) = baked_hz(model) else { return Ok(()) };
    let hz = settings.map_or(f64::from(DEVICE_HZ), |stage| 1.0 / f64::from(stage.tick_s));
    if (baked_hz - hz).abs() <= RATE_ROUNDING * hz {
        return Ok(());
    }
    let [baked_hz, hz] = [baked_hz, hz].map(f64::round);
    Err(Error::input(format!(
        "`device_hz`: the session has {hz} ticks a second, and the model's branches of relaxation were baked for \
         {baked_hz}; take `run` or `serve` with `device_hz` {baked_hz}, or bake it with `device_hz` {hz}"
    )))
}

impl TissueEngine for Staged<'_> {
    fn is_anytime(&self) -> bool {
        self.engine.is_anytime()
    }

    fn least_sweeps(&self) -> u16 {
        self.engine.least_sweeps()
    }

    fn tick_by(&mut self, poses: &[ToolPose], budget: Budget<'_>) -> TickOutput {
        self.limit_force();
        match (self.tools(), self.stages.is_empty()) {
            (0, _) => self.tick_one(poses, budget),
            (tools, true) => self.tick_plain(&Poses::of_tools(tools, poses), budget),
            (tools, false) => self.tick_staged(&Poses::of_tools(tools, poses), budget),
        }
    }

    fn tools(&self) -> usize {
        self.engine.contact().tools()
    }

    fn felt(&mut self, tool: usize) -> Felt {
        let stage = self.stages.get(tool);
        if !self.feels(tool) && stage.is_none() {
            return Felt::default();
        }
        // Force, contacts and flags: of the stage, or of the tissue without one.
        let felt = self.engine.tool_output(tool);
        let own = if stage.is_some() { tool } else { 0 };
        let last = self.last.get(own).copied().unwrap_or(TickOutput::NONE);
        let mut flags = Flags(last.flags.0 & (Flags::FORCE_CLAMPED.0 | Flags::FORCE_WITHHELD.0));
        let (mut force_n, mut contacts) = (last.force_n, last.contacts);
        if stage.is_none() && tool > 0 {
            (force_n, contacts, flags) = (felt.force_n, felt.contacts, self.clamped(felt.force_n));
        }
        // Torque: on the stage's ramp, and within its limit.
        let share = stage.map_or(1.0, Stage::share);
        if self.engine.waits(tool) {
            flags.insert(Flags::STARTS_INSIDE);
        }
        let torque_n_m = if self.feels(tool) { felt.torque_n_m * share } else { Vector3::zeros() };
        let (torque_n_m, is_short) = shortened(torque_n_m, self.max_torque_n_m);
        if is_short {
            flags.insert(Flags::FORCE_CLAMPED);
        }
        let (force_n, torque_n_m) = (force_n.into(), torque_n_m.into());
        let [force_error_n, torque_error_n_m] =
            [self.force_error_n(tool), self.torque_error_n_m(tool)];
        Felt { force_n, torque_n_m, contacts, flags, force_error_n, torque_error_n_m }
    }

    fn places_m(&mut self, tool: usize) -> Option<[[f32; 3]; 2]> {
        let asked_m = self.passed.each().get(tool)?.position_m;
        let proxy = self.engine.proxy_pose(tool).filter(|proxy| proxy.share > 0.0)?;
        Some([asked_m.into(), proxy.position_m])
    }

    fn force_error_n(&mut self, tool: usize) -> Option<f32> {
        let is_shaped = self.is_shaped.get(tool).is_some_and(|is_shaped| *is_shaped);
        // The kernel knows the release of held cells, but in a late tick not that of one of several tools.
        let is_known = (self.engine.contact().tools() == 0 || self.feels(tool)) && !is_shaped;
        self.engine.force_error_n(tool).filter(|_| is_known)
    }

    fn torque_error_n_m(&mut self, tool: usize) -> Option<f32> {
        // The stage changes a torque by its ramp alone.
        let is_whole = self.stages.get(tool).is_none_or(|stage| stage.share() == 1.0);
        let is_known = is_whole && self.feels(tool);
        self.engine.torque_error_n_m(tool).filter(|_| is_known)
    }

    fn has_stage(&self) -> bool {
        !self.stages.is_empty()
    }

    fn skipped(&mut self, ticks: u16) {
        self.stages.iter_mut().for_each(|stage| stage.skipped(ticks));
    }

    fn restart_ramp(&mut self) {
        self.stages.iter_mut().for_each(Stage::restart_ramp);
    }

    fn delayed(&mut self, ticks: u16) {
        self.stages.iter_mut().for_each(|stage| stage.delayed(ticks));
    }

    fn model_checksum(&self) -> u32 {
        self.engine.network().model().checksum()
    }

    fn cut(&mut self) -> Option<CutReport> {
        self.engine.cut()
    }

    fn relaxed_j(&mut self) -> Option<f32> {
        self.engine.relaxed_j()
    }

    fn state_hash(&mut self) -> u64 {
        self.engine.state_hash()
    }

    fn read_nodes(&mut self, to: &mut [Node]) {
        self.engine.read_nodes(to);
    }

    fn read_stresses(&mut self, first: usize, to: &mut [NodeStress], means_pa: &mut [f32]) -> bool {
        self.engine.read_stresses(first, to, means_pa)
    }

    fn add_copies(
        &mut self,
        first: usize,
        most: usize,
        to: &mut [NodeStress],
        means_pa: &mut [f32],
    ) -> usize {
        self.engine.add_copies(first, most, to, means_pa)
    }

    fn read_surface(&mut self, to: &mut [SurfaceRow]) -> SurfaceHeader {
        self.engine.read_surface(to)
    }

    fn read_contacts(&mut self, each: &mut dyn FnMut(u32, &ContactForce)) {
        self.engine.read_contacts(each);
    }

    fn newest_pin(&mut self) -> Option<u16> {
        self.engine.newest_pin()
    }

    fn saved(&mut self) -> Option<Saved> {
        let settings = *self.engine.network().settings();
        let tissue = self.engine.save().ok()?;
        let mut stage = Vec::new();
        for of in &self.stages {
            let before = stage.len();
            stage.resize(before + of.snapshot_bytes(), 0);
            of.save(&mut stage[before..]).ok()?;
        }
        Some(Saved { engaged: self.engaged, settings, tissue, stage })
    }

    fn command(&mut self, command: &Command) -> std::result::Result<(), Refusal> {
        self.engine.obey(command)?;
        if *command == Command::Reset {
            (self.engaged, self.last) = ([false; TOOLS_MAX], [TickOutput::NONE; TOOLS_MAX]);
            self.is_shaped = [false; TOOLS_MAX];
            for stage in &mut self.stages {
                // Valid settings stay valid.
                *stage = Stage::new(*stage.settings()).map_err(|_| Refusal::Reset)?;
            }
        }
        Ok(())
    }
}

impl Staged<'_> {
    /// Passes the tissue's force limit to the stages, which limits the coupling's force too; commands may
    /// change it.
    fn limit_force(&mut self) {
        let max_force_n = self.engine.network().settings().max_force_n;
        self.stages.iter_mut().for_each(|stage| stage.limit_force(max_force_n));
    }

    /// A tick of held cells, which go by the position of the first pose alone.
    fn tick_one(&mut self, poses: &[ToolPose], budget: Budget<'_>) -> TickOutput {
        let Some(first) = poses.first() else { return self.engine.tick_by(&[], budget) };
        let device = match first.is_good() {
            true => ToolPose::at(first.position_m, first.engaged.into()),
            false => *first,
        };
        let Some(stage) = self.stages.first_mut() else {
            self.passed = Poses::of(&[device]);
            return self.engine.tick_by(&[device], budget);
        };
        let tool = stage.sample(&device);
        self.passed = Poses::of(&[tool]);
        let output = self.engine.tick_by(&[tool], budget);
        let answer = stage.output(&output);
        self.is_shaped[0] = answer.force_n != output.force_n;
        answer
    }

    /// Notes which tools are engaged, where all poses are good.
    fn note_engaged(&mut self, poses: &Poses) {
        if poses.are_good() {
            for (engaged, pose) in self.engaged.iter_mut().zip(poses.each()) {
                *engaged = pose.engaged == 1;
            }
        }
    }

    /// A tick of tools without a stage.
    fn tick_plain(&mut self, poses: &Poses, budget: Budget<'_>) -> TickOutput {
        self.note_engaged(poses);
        self.passed = *poses;
        self.last[0] = self.engine.tick_by(poses.each(), budget);
        if !self.feels(0) {
            // Other tools may be engaged: a late tick would repeat the force.
            (self.last[0].force_n, self.last[0].contacts) = (Vector3::zeros(), 0);
        }
        self.last[0]
    }

    /// A tick with a stage for each tool. Returns the output for the first tool's device.
    fn tick_staged(&mut self, poses: &Poses, budget: Budget<'_>) -> TickOutput {
        self.note_engaged(poses);
        // Pass each pose through its stage, then tick the tissue.
        let are_good = poses.are_good();
        let mut behind = *poses;
        for (pose, stage) in behind.each_mut().iter_mut().zip(&mut self.stages) {
            let engaged = if are_good { pose.engaged } else { u16::MAX };
            *pose = stage.sample(&ToolPose { engaged, ..*pose });
        }
        self.passed = behind;
        let is_bad = !behind.are_good();
        let output = self.engine.tick_by(behind.each(), budget);
        // Pass the output of each tool through its stage.
        let tools = self.stages.len();
        for tool in 0..tools {
            // With one tool the tick's output is the tool's.
            let answer = if tools == 1 { output } else { self.answer_of(tool, &output) };
            let each = self.stages.get_mut(tool).zip(self.last.get_mut(tool));
            if let Some(((stage, last), is_shaped)) = each.zip(self.is_shaped.get_mut(tool)) {
                let is_bad_alone = behind.each().get(tool).is_some_and(|pose| !pose.is_good());
                // A bad sample of another tool has cost this one its output.
                *last =
                    if is_bad && !is_bad_alone { stage.missed() } else { stage.output(&answer) };
                *is_shaped = last.force_n != answer.force_n;
            }
        }
        let [first, ..] = self.last;
        // For any device output: these values are the tissue's, and a replay uses them.
        TickOutput { energy_j: output.energy_j, sweeps: output.sweeps, ..first }
    }

    /// Output of one of several tools, like that of a single tool.
    fn answer_of(&mut self, tool: usize, output: &TickOutput) -> TickOutput {
        let felt = self.engine.tool_output(tool);
        let mut flags = Flags(output.flags.0 & !Flags::FORCE_CLAMPED.0);
        flags.insert(self.clamped(felt.force_n));
        TickOutput {
            force_n: felt.force_n,
            work_j: felt.work_j,
            stiffness_n_per_m: felt.stiffness_n_per_m,
            contacts: felt.contacts,
            flags,
            ..*output
        }
    }

    /// The flag that the kernel has clamped a force to its limit, with a margin for rounding.
    fn clamped(&self, force_n: Vector3<f32>) -> Flags {
        let most = self.engine.network().settings().max_force_n * (1.0 - 1e-5);
        if force_n.norm() >= most { Flags::FORCE_CLAMPED } else { Flags::default() }
    }

    /// Returns true if a tool gets a force from the tissue.
    fn feels(&self, tool: usize) -> bool {
        let is_engaged = self.engaged.get(tool).is_some_and(|engaged| *engaged);
        let own = if self.stages.is_empty() { 0 } else { tool };
        let is_safe = self.last.get(own).is_none_or(|of| of.flags.contains(Flags::SAFE_STATE));
        is_engaged && !is_safe
    }
}

/// A torque within its limit; true if the limit shortened it.
fn shortened(torque: Vector3<f32>, most: f32) -> (Vector3<f32>, bool) {
    let size = libm::sqrt(torque.iter().map(|&x| f64::from(x) * f64::from(x)).sum());
    if size <= f64::from(most) {
        return (torque, false);
    }
    // A margin, so that rounding does not exceed the limit.
    let share = f64::from(most) / size * (1.0 - 2.0 * f64::from(f32::EPSILON));
    (torque.map(|x| (f64::from(x) * share) as f32), true)
}

#[cfg(test)]
mod tests;
