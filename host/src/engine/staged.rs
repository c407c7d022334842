//! A tissue behind an output stage: the device's samples in, the device's forces out.

use chaincell_kernel::stage::{Stage, StageSettings};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{ContactForce, Drive, Flags, TOOLS_MAX, TickOutput, ToolPose, ToolSample};
use nalgebra::Vector3;

use crate::engine::Engine;
use crate::engine::snapshot::Saved;
use crate::engine::tissue::{Node, Refusal, Sweeps, TissueEngine};
use crate::engine::tools::{Felt, Poses};
use crate::error::{Error, Result};

/// An engine with the stage between it and the device, or without one.
///
/// Every sample is one tick of both, so what comes out is a function of the samples alone. A
/// silence is no tick of either: what is published meanwhile is the loop's own.
pub struct Staged<'m> {
    engine: Engine<'m>,
    stage: Option<Stage>,
    /// Largest torque of a tool \[N m\].
    max_torque_n_m: f32,
    /// Which tools were engaged in the last good poses.
    engaged: [bool; TOOLS_MAX],
    /// The last answer, of the first tool.
    last: TickOutput,
}

impl<'m> Staged<'m> {
    /// An engine behind a stage of these settings, or as it is.
    ///
    /// # Errors
    /// A setting out of range; a stage for several tools.
    pub fn new(engine: Engine<'m>, settings: Option<StageSettings>) -> Result<Self> {
        let goes_by_position =
            settings.is_some_and(|of| of.coupling.is_some() || of.passivity.is_some());
        if goes_by_position && engine.network().settings().drive == Drive::Current {
            return Err(Error::input(
                "`drive` current: coupling and passivity control are for a tool that prescribes \
                 positions; pass `coupling` none `passivity` none",
            ));
        }
        if settings.is_some() && engine.contact().tools() > 1 {
            return Err(Error::input(
                "`tool`: the output stage (`device`, `coupling`, `passivity` and what belongs to \
                 them) is for the force of one tool; leave its options out, or choose one `tool`",
            ));
        }
        let stage = settings.map(Stage::new).transpose();
        let stage = stage.map_err(|why| Error::input(format!("output stage: {why}")))?;
        let (max_torque_n_m, engaged, last) = (f32::INFINITY, [false; TOOLS_MAX], TickOutput::NONE);
        Ok(Self { engine, stage, max_torque_n_m, engaged, last })
    }

    /// Torques of tools are shortened to this from here on \[N m\]. It changes no bit of the tissue.
    pub fn limit_torque(&mut self, max_torque_n_m: f32) {
        self.max_torque_n_m = max_torque_n_m;
    }

    /// The tissue.
    #[must_use]
    pub fn engine(&self) -> &Engine<'m> {
        &self.engine
    }

    /// The tissue, for what reads its nodes.
    pub fn engine_mut(&mut self) -> &mut Engine<'m> {
        &mut self.engine
    }

    /// The tick that made so many sweeps once: 0 for one that was late, `None` for one with the
    /// settings' count.
    pub fn tick_again(&mut self, device: &ToolSample, sweeps: Option<u16>) -> TickOutput {
        self.tick_by(device, Sweeps::Counted(sweeps))
    }

    /// Goes on from what an engine of the same options had saved.
    ///
    /// # Errors
    /// What does not fit; nothing has changed then.
    pub fn restore(&mut self, saved: &Saved) -> Result<()> {
        let mut stage = self.stage;
        match &mut stage {
            Some(stage) => stage.restore(&saved.stage).map_err(Error::input)?,
            None if saved.stage.is_empty() => {}
            None => return Err(Error::input("the snapshot has an output stage, here is none")),
        }
        let before = *self.engine.network().settings();
        self.engine.choose(saved.settings)?;
        if let Err(why) = self.engine.restore(&saved.tissue) {
            self.engine.choose(before)?;
            return Err(why);
        }
        self.stage = stage;
        self.engaged = std::array::from_fn(|tool| saved.engaged >> tool & 1 == 1);
        self.last = TickOutput::NONE;
        Ok(())
    }

    /// The stage's settings, `None` without one.
    #[must_use]
    pub fn settings(&self) -> Option<&StageSettings> {
        self.stage.as_ref().map(Stage::settings)
    }
}

impl TissueEngine for Staged<'_> {
    fn tick(&mut self, device: &ToolSample) -> TickOutput {
        self.tick_by(device, Sweeps::ALL)
    }

    fn is_anytime(&self) -> bool {
        self.engine.is_anytime()
    }

    fn tick_by(&mut self, device: &ToolSample, sweeps: Sweeps<'_>) -> TickOutput {
        match &mut self.stage {
            None => self.engine.tick_by(device, sweeps),
            Some(stage) => {
                let tool = stage.sample(device);
                let output = self.engine.tick_by(&tool, sweeps);
                stage.output(&output)
            }
        }
    }

    fn tools(&self) -> usize {
        self.engine.contact().tools()
    }

    fn tick_tools(&mut self, poses: &Poses, sweeps: Sweeps<'_>) -> TickOutput {
        if poses.are_good() {
            for (engaged, pose) in self.engaged.iter_mut().zip(poses.each()) {
                *engaged = pose.engaged == 1;
            }
        }
        let output = match (&mut self.stage, poses.each()) {
            (Some(stage), [pose]) => {
                let tool = stage.sample(&poses.sample());
                let pose = ToolPose { position_m: tool.position_m, engaged: tool.engaged, ..*pose };
                stage.output(&self.engine.tick_tools_by(&[pose], sweeps))
            }
            _ => self.engine.tick_tools_by(poses.each(), sweeps),
        };
        self.last = output;
        if self.stage.is_none() && !self.feels(0) {
            // Others may hold on: a late tick would repeat the force.
            (self.last.force_n, self.last.contacts) = (Vector3::zeros(), 0);
        }
        self.last
    }

    fn felt(&mut self, tool: usize) -> Felt {
        if !self.feels(tool) && (tool > 0 || self.stage.is_none()) {
            return Felt::default();
        }
        let felt = self.engine.tool_output(tool);
        let max_force_n = self.engine.network().settings().max_force_n;
        let (force_n, is_clamped) = match tool {
            0 => (self.last.force_n, self.last.flags.contains(Flags::FORCE_CLAMPED)),
            // The kernel has shortened it to the limit, less what rounding may add.
            _ => (felt.force_n, felt.force_n.norm() >= max_force_n * (1.0 - 1e-5)),
        };
        let torque_n_m = if self.feels(tool) { felt.torque_nm } else { Vector3::zeros() };
        let (torque_n_m, is_short) = shortened(torque_n_m, self.max_torque_n_m);
        let mut flags = Flags::default();
        if is_clamped || is_short {
            flags.insert(Flags::FORCE_CLAMPED);
        }
        let contacts = if tool == 0 { self.last.contacts } else { felt.contacts };
        Felt { force_n: force_n.into(), torque_n_m: torque_n_m.into(), contacts, flags }
    }

    fn restart_ramp(&mut self) {
        if let Some(stage) = &mut self.stage {
            stage.restart_ramp();
        }
    }

    fn delayed(&mut self, ticks: u16) {
        if let Some(stage) = &mut self.stage {
            stage.delayed(ticks);
        }
    }

    fn state_hash(&mut self) -> u64 {
        self.engine.state_hash()
    }

    fn read_nodes(&mut self, to: &mut [Node]) {
        self.engine.read_nodes(to);
    }

    fn read_contacts(&mut self, each: &mut dyn FnMut(u32, &ContactForce)) {
        self.engine.read_contacts(each);
    }

    fn saved(&mut self) -> Option<Saved> {
        let bits = self.engaged.iter().rev().fold(0, |bits, &is| bits << 1 | u32::from(is));
        let settings = *self.engine.network().settings();
        let tissue = self.engine.save().ok()?;
        let mut stage = Vec::new();
        if let Some(of) = &self.stage {
            stage.resize(of.snapshot_bytes(), 0);
            of.save(&mut stage).ok()?;
        }
        Some(Saved { engaged: bits, settings, tissue, stage })
    }

    fn command(&mut self, command: &Command) -> std::result::Result<(), Refusal> {
        self.engine.obey(command)?;
        if *command == Command::Reset {
            (self.engaged, self.last) = ([false; TOOLS_MAX], TickOutput::NONE);
        }
        if let (Command::Reset, Some(stage)) = (command, &mut self.stage) {
            // Settings that made a stage once make it again.
            *stage = Stage::new(*stage.settings()).map_err(|_| Refusal::Reset)?;
        }
        Ok(())
    }
}

impl Staged<'_> {
    /// Whether a tool has a force of the tissue.
    fn feels(&self, tool: usize) -> bool {
        let is_engaged = self.engaged.get(tool).is_some_and(|engaged| *engaged);
        is_engaged && !self.last.flags.contains(Flags::SAFE_STATE)
    }
}

/// A torque within its limit, and whether that bit.
fn shortened(torque: Vector3<f32>, most: f32) -> (Vector3<f32>, bool) {
    let size = libm::sqrt(torque.iter().map(|&x| f64::from(x) * f64::from(x)).sum());
    if size <= f64::from(most) {
        return (torque, false);
    }
    // Rounding adds nothing to what is a little shorter.
    let share = f64::from(most) / size * (1.0 - 2.0 * f64::from(f32::EPSILON));
    (torque.map(|x| (f64::from(x) * share) as f32), true)
}

#[cfg(test)]
mod tests {
    use chaincell_kernel::stage::Device;
    use nalgebra::Vector3;

    use super::*;
    use crate::engine::fixture::{engine, plane};

    /// Pressed by 40 mm, 1 mm a tick.
    fn press(staged: &mut Staged<'_>) -> Vec<TickOutput> {
        let tick = |tick: u8| {
            let position_m = Vector3::new(0.0, 0.0, -1.0e-3 * f32::from(tick));
            staged.tick(&ToolSample { position_m, engaged: 1 })
        };
        (0..=40).map(tick).collect()
    }

    #[test]
    fn a_reset_is_one_of_the_stage_too() {
        let image = plane();
        let settings = StageSettings { ramp_ticks: 50, ..StageSettings::for_device(Device::Omega) };
        let begin = || Staged::new(engine(&image), Some(settings)).unwrap();
        let mut staged = begin();
        let first = press(&mut staged);
        assert!(first[40].force_n.norm() > 0.0 && first != press(&mut staged));
        staged.command(&Command::Reset).unwrap();
        assert_eq!(press(&mut staged), first);
        assert_eq!(press(&mut begin()), first);
    }

    #[test]
    fn what_the_device_gets_is_the_stages() {
        let image = plane();
        let mut plain = Staged::new(engine(&image), None).unwrap();
        let own = press(&mut plain);
        let largest_n = own[40].force_n.norm();
        let settings = StageSettings { max_force_n: 0.5 * largest_n, ..StageSettings::NONE };
        let mut staged = Staged::new(engine(&image), Some(settings)).unwrap();
        let shown = press(&mut staged);
        assert!(largest_n > 0.0 && shown.iter().all(|of| of.force_n.norm() <= 0.5 * largest_n));
        let tissue = |of: &TickOutput| (of.energy_j, of.work_j, of.contacts);
        assert!(shown.iter().map(tissue).eq(own.iter().map(tissue)));
        assert_eq!(staged.state_hash(), plain.state_hash());
    }
}
