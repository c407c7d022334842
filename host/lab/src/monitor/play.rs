//! Plays steps on an engine and on its twins: a second one, one without vector unit and sleep, and of a large
//! body one with two threads. All bits agree, and every tick is checked.

use chaincell_kernel::{Budget, Flags, TickOutput, ToolPose};
use nalgebra::Vector3;

use super::{Check, Monitor};
use chaincell_host::engine::threads::ThreadCount;
use chaincell_host::engine::{Arithmetic, Engine};
use chaincell_host::error::Result;
use chaincell_host::interrupt;

/// What is done between two ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Act {
    /// A tool grips what it touches.
    Grip(usize),
    /// It lets go within this number of ticks.
    LetGo(usize, u16),
    /// Everything is reset to rest.
    Reset,
}

/// A tick and what comes before it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Step {
    /// What comes before it.
    pub act: Option<Act>,
    /// The poses; tools beyond them stay.
    pub poses: Vec<ToolPose>,
    /// Sweeps, 0 for a late tick, `None` for all of them.
    pub sweeps: Option<u16>,
}

impl Step {
    /// A tick of these tools.
    #[must_use]
    pub fn of(poses: &[ToolPose]) -> Self {
        Self { poses: poses.to_vec(), ..Self::default() }
    }

    /// A tick of one tool at a place \[m\].
    #[must_use]
    pub fn at(position_m: [f32; 3], engaged: u32) -> Self {
        Self::of(&[ToolPose::at(Vector3::from(position_m), engaged)])
    }
}

/// All bits of an answer and of the outputs of the tools.
fn bits(engine: &mut Engine<'_>, output: &TickOutput) -> (Vec<u32>, Flags, u16, u64) {
    let TickOutput { force_n, energy_j, work_j, stiffness_n_per_m, contacts, .. } = *output;
    let mut numbers: Vec<f32> = force_n.iter().copied().collect();
    numbers.extend([energy_j, work_j, stiffness_n_per_m, f32::from_bits(contacts)]);
    for tool in 0..engine.contact().tools() {
        let of_tool = engine.tool_output(tool);
        numbers.extend(of_tool.force_n.iter().chain(&of_tool.torque_n_m));
        numbers.extend([of_tool.work_j, f32::from_bits(of_tool.contacts)]);
    }
    let numbers = numbers.into_iter().map(f32::to_bits).collect();
    (numbers, output.flags, output.sweeps, engine.state_hash())
}

/// Plays steps on engines that `new` makes, from a state [mean link lengths from the centre] or from rest.
///
/// # Errors
/// Those of `new` and of the state; an interruption.
pub fn play<'m>(
    new: impl Fn() -> Result<Engine<'m>>,
    numbers: Arithmetic,
    state: Option<&[[f32; 3]]>,
    steps: impl IntoIterator<Item = Step>,
) -> Result<Monitor<'m>> {
    let (mut one, mut twins) = (new()?, vec![new()?, new()?]);
    plain(&mut twins);
    let model = *one.network().model();
    if model.thread_parts().count() > 1 {
        // A machine of one processor has no second thread.
        let (mut shared, threads) = (new()?, ThreadCount::Of(2).start(&model));
        let threads = threads.unwrap_or_default();
        shared.share(threads.map(|threads| Box::new(threads) as _));
        twins.push(shared);
    }
    let mut monitor = Monitor::new(&one, numbers);
    match state {
        None => monitor.rests(&mut one),
        Some(state) => {
            one.set_positions(state)?;
            twins.iter_mut().try_for_each(|twin| twin.set_positions(state))?;
        }
    }
    for step in steps {
        interrupt::check()?;
        if let Some(act) = step.act {
            carry_out(act, &mut monitor, &mut one, &mut twins)?;
        }
        let output = monitor.tick(&mut one, &step.poses, step.sweeps);
        let known = bits(&mut one, &output);
        for twin in &mut twins {
            let output = twin.tick_by(&step.poses, Budget::again(step.sweeps));
            let same = bits(twin, &output) == known;
            monitor.hold(Check::SameBits, same, || "another run differs".to_owned());
        }
    }
    Ok(monitor)
}

/// Turns the vector unit and sleep of the second twin off.
fn plain(twins: &mut [Engine<'_>]) {
    if let Some(engine) = twins.get_mut(1) {
        engine.go_scalar();
        engine.forbid_sleep();
    }
}

/// Does the same to all engines.
fn carry_out<'m>(
    act: Act,
    monitor: &mut Monitor<'m>,
    one: &mut Engine<'m>,
    twins: &mut [Engine<'m>],
) -> Result<()> {
    match act {
        Act::Grip(tool) => {
            let held = monitor.grip(one, tool);
            let same = twins.iter_mut().all(|twin| twin.grip(tool) == held);
            monitor.hold(Check::SameBits, same, || "another run grips otherwise".to_owned());
        }
        Act::LetGo(tool, ticks) => {
            one.let_go(tool, ticks);
            twins.iter_mut().for_each(|twin| twin.let_go(tool, ticks));
        }
        Act::Reset => {
            monitor.interfere();
            one.reset()?;
            monitor.rests(one);
            twins.iter_mut().try_for_each(Engine::reset)?;
            plain(twins);
        }
    }
    Ok(())
}
