//! A tissue behind an output stage: the device's samples in, the device's forces out.

use chaincell_kernel::stage::{Stage, StageSettings};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{ContactForce, Drive, TickOutput, ToolSample};

use crate::engine::Engine;
use crate::engine::tissue::{Node, Refusal, Sweeps, TissueEngine};
use crate::error::{Error, Result};

/// An engine with the stage between it and the device, or without one.
///
/// Every sample is one tick of both, so what comes out is a function of the samples alone. A
/// silence is no tick of either: what is published meanwhile is the loop's own.
pub struct Staged<'m> {
    engine: Engine<'m>,
    stage: Option<Stage>,
}

impl<'m> Staged<'m> {
    /// An engine behind a stage of these settings, or as it is.
    ///
    /// # Errors
    /// A setting out of range.
    pub fn new(engine: Engine<'m>, settings: Option<StageSettings>) -> Result<Self> {
        let goes_by_position =
            settings.is_some_and(|of| of.coupling.is_some() || of.passivity.is_some());
        if goes_by_position && engine.network().settings().drive == Drive::Current {
            return Err(Error::input(
                "`drive` current: coupling and passivity control are for a tool that prescribes \
                 positions; pass `coupling` none `passivity` none",
            ));
        }
        let stage = settings.map(Stage::new).transpose();
        let stage = stage.map_err(|why| Error::input(format!("output stage: {why}")))?;
        Ok(Self { engine, stage })
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

    fn restart_ramp(&mut self) {
        if let Some(stage) = &mut self.stage {
            stage.restart_ramp();
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

    fn command(&mut self, command: &Command) -> std::result::Result<(), Refusal> {
        self.engine.obey(command)?;
        if let (Command::Reset, Some(stage)) = (command, &mut self.stage) {
            // Settings that made a stage once make it again.
            *stage = Stage::new(*stage.settings()).map_err(|_| Refusal::Reset)?;
        }
        Ok(())
    }
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
