//! A body with a contact surface, a state to start from, and what tools do to it: played under every
//! variant, twice and once more cell by cell, every tick looked at.

use chaincell_kernel::{Flags, Model, Settings, TickOutput, ToolPart, ToolPose, Unloading};

use super::trial::{Ended, Positions};
use crate::bodies::{Body, Variant};
use crate::monitor::{Check, ToolMonitor};
use chaincell_host::engine::{Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_kernel::Budget;

/// A tool step without a limit \[m\].
const NO_LIMIT_M: f32 = 1e30;

/// What is done between two ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Act {
    /// A tool grips what it touches.
    Grip(usize),
    /// It lets go within so many ticks.
    LetGo(usize, u16),
}

/// What the tools do in a tick.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Step {
    /// What comes before it.
    pub act: Option<Act>,
    /// The poses; tools beyond them stay.
    pub poses: Vec<ToolPose>,
}

/// What is done to a body.
pub struct ToolTrial<'b> {
    /// What it is, within its case.
    pub label: String,
    /// The body, of nodal shapes with a contact surface.
    pub body: &'b Body,
    /// Where the cells start; at rest unless given.
    pub state: Option<Positions>,
    /// Parts of the tools.
    pub tools: Vec<Vec<ToolPart>>,
    /// Their friction.
    pub friction: f32,
    /// What they do in a tick.
    pub script: Box<dyn Fn(u32) -> Step>,
    /// Sweeps of a tick, 0 for a late one, `None` for all of them.
    pub sweeps_made: fn(u32) -> Option<u16>,
    /// Ticks.
    pub ticks: u32,
    /// Largest part of the largest energy that `track` may leave at the end.
    pub left_max: Option<f64>,
}

/// All bits of an answer and of what the tools feel.
fn bits(engine: &mut Engine<'_>, output: &TickOutput, tools: usize) -> (Vec<u32>, Flags, u64) {
    let mut numbers: Vec<f32> = output.force_n.iter().copied().collect();
    numbers.extend([output.energy_j, output.work_j, f32::from_bits(output.contacts)]);
    for tool in 0..tools {
        let of_tool = engine.tool_output(tool);
        numbers.extend(of_tool.force_n.iter().chain(&of_tool.torque_n_m));
        numbers.extend([of_tool.work_j, f32::from_bits(of_tool.contacts)]);
    }
    (numbers.into_iter().map(f32::to_bits).collect(), output.flags, engine.state_hash())
}

impl<'b> ToolTrial<'b> {
    /// A body at rest under tools without friction.
    #[must_use]
    pub fn new(
        label: impl Into<String>,
        body: &'b Body,
        tools: &[&[ToolPart]],
        ticks: u32,
        script: impl Fn(u32) -> Step + 'static,
    ) -> Self {
        Self {
            label: label.into(),
            body,
            state: None,
            tools: tools.iter().map(|parts| parts.to_vec()).collect(),
            friction: 0.0,
            script: Box::new(script),
            sweeps_made: |_| None,
            ticks,
            left_max: None,
        }
    }

    fn engine<'m>(&self, model: Model<'m>, variant: Variant) -> Result<Engine<'m>> {
        let contact = Contact::Tools { tools: self.tools.clone(), friction: self.friction };
        variant.engine(model, contact, variant.sweeps(), |settings| Settings {
            max_tool_step_m: NO_LIMIT_M,
            unloading: Unloading::Off,
            ..settings
        })
    }

    /// Plays all ticks under a variant. Gives the ticks too in which the energy of contact was not
    /// compared with the level, see [`ToolMonitor::missing`].
    ///
    /// # Errors
    /// [`Error::Interrupted`]; what the engine refuses other than body and tools.
    pub fn play(&self, variant: Variant) -> Result<(Ended, u64)> {
        let Some(model) = self.body.model(variant.coarse)? else { return Ok((Ended::Absent, 0)) };
        let mut engines = Vec::new();
        for _ in 0..3 {
            match self.engine(model, variant) {
                Ok(engine) => engines.push(engine),
                Err(Error::Input(why)) => return Ok((Ended::Refused(why), 0)),
                Err(why) => return Err(why),
            }
        }
        if let Some(state) = &self.state {
            let positions = state(&model);
            engines.iter_mut().try_for_each(|engine| engine.set_positions(&positions))?;
        }
        let [one, again, scalar] = &mut engines[..] else { return Ok((Ended::Absent, 0)) };
        scalar.go_scalar();
        let Some(mut monitor) = ToolMonitor::new(one, &self.tools, self.friction) else {
            return Ok((Ended::Refused("the body has no contact surface".to_owned()), 0));
        };
        for tick in 0..self.ticks {
            interrupt::check()?;
            let (step, sweeps) = ((self.script)(tick), (self.sweeps_made)(tick));
            act(step.act, &mut monitor, one, &mut [again, scalar]);
            let output = monitor.tick(one, &step.poses, sweeps);
            let own = bits(one, &output, self.tools.len());
            for other in [&mut *again, &mut *scalar] {
                let output = other.tick_by(&step.poses, Budget::again(sweeps));
                let same = bits(other, &output, self.tools.len()) == own;
                monitor.hold(Check::SameBits, same, || "another run differs".to_owned());
            }
        }
        let left = monitor.worst().left();
        let most = self.left_max.filter(|_| variant.scheme == Scheme::Track);
        monitor.hold(Check::Return, most.is_none_or(|most| left <= most), || {
            format!("{left:e} of the energy left, {:e} expected", most.unwrap_or_default())
        });
        let (worst, failures) = (*monitor.worst(), monitor.failures().to_vec());
        Ok((Ended::Played { worst, failures }, monitor.missing()))
    }
}

/// What is done before a tick, to all engines alike.
fn act<'m>(
    act: Option<Act>,
    monitor: &mut ToolMonitor<'m>,
    one: &mut Engine<'m>,
    others: &mut [&mut Engine<'m>],
) {
    match act {
        None => {}
        Some(Act::Grip(tool)) => {
            let held = monitor.grip(one, tool);
            for other in others {
                let same = other.grip(tool) == held;
                monitor.hold(Check::SameBits, same, || "another run grips otherwise".to_owned());
            }
        }
        Some(Act::LetGo(tool, ticks)) => {
            one.let_go(tool, ticks);
            others.iter_mut().for_each(|other| other.let_go(tool, ticks));
        }
    }
}
