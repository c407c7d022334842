//! A body, a state to start from, and what a tool does to it: played under every variant, twice
//! and once more cell by cell, every tick looked at.

use chaincell_kernel::{Budget, Flags, Model, Settings, TickOutput, ToolPose, Unloading};
use nalgebra::Vector3;

use crate::bodies::{Body, Variant};
use crate::monitor::{Check, Failure, Monitor, Worst};
use chaincell_host::engine::{Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;

/// A tool step without a limit \[m\].
const NO_LIMIT_M: f32 = 1e30;

/// Where the tool is \[m\], and whether it touches.
pub type Pose = ([f32; 3], bool);

/// Positions of all cells of a model [mean link lengths from the centre].
pub type Positions = Box<dyn Fn(&Model<'_>) -> Vec<[f32; 3]>>;

/// What is done to a body.
pub struct Trial<'b> {
    /// What it is, within its case.
    pub label: String,
    /// The body.
    pub body: &'b Body,
    /// Where the cells start; at rest unless given.
    pub state: Option<Positions>,
    /// The tool's pose in a tick.
    pub script: Box<dyn Fn(u32) -> Pose>,
    /// Sweeps of a tick, 0 for a late one, `None` for all of them.
    pub sweeps_made: fn(u32) -> Option<u16>,
    /// Ticks.
    pub ticks: u32,
    /// Whether the tool may go any way in one tick.
    pub leaps: bool,
    /// When the bands close.
    pub unloading: Unloading,
    /// Link passes a tick; as the scheme's unless given.
    pub sweeps: Option<u16>,
    /// Largest part of the largest energy that `track` may leave at the end.
    pub left_max: Option<f64>,
}

/// How a trial ended under a variant.
#[derive(Debug, Clone, PartialEq)]
pub enum Ended {
    /// The body has no coarse functions.
    Absent,
    /// The kernel does not take the body in these numbers, with its reason.
    Refused(String),
    /// All ticks were played.
    Played {
        /// How close they came to the bounds.
        worst: Worst,
        /// Checks that failed.
        failures: Vec<Failure>,
    },
}

/// A sample of a pose.
#[must_use]
pub fn sample((position_m, touches): Pose) -> ToolPose {
    ToolPose::at(Vector3::from(position_m), u32::from(touches))
}

/// All bits of an answer.
fn bits(output: &TickOutput) -> ([u32; 4], u32, Flags) {
    let [x, y, z]: [f32; 3] = output.force_n.into();
    ([x, y, z, output.energy_j].map(f32::to_bits), output.contacts, output.flags)
}

impl<'b> Trial<'b> {
    /// A body at rest under a tool that stays away.
    #[must_use]
    pub fn new(label: impl Into<String>, body: &'b Body, ticks: u32) -> Self {
        Self {
            label: label.into(),
            body,
            state: None,
            script: Box::new(|_| ([0.0; 3], false)),
            sweeps_made: |_| None,
            ticks,
            leaps: false,
            unloading: Unloading::Off,
            sweeps: None,
            left_max: None,
        }
    }

    /// From a state of all cells.
    #[must_use]
    pub fn from(self, state: impl Fn(&Model<'_>) -> Vec<[f32; 3]> + 'static) -> Self {
        Self { state: Some(Box::new(state)), ..self }
    }

    /// Under a tool.
    #[must_use]
    pub fn under(self, script: impl Fn(u32) -> Pose + 'static) -> Self {
        Self { script: Box::new(script), ..self }
    }

    /// Where the cells start.
    #[must_use]
    pub fn start(&self, model: &Model<'_>) -> Option<Vec<[f32; 3]>> {
        self.state.as_ref().map(|state| state(model))
    }

    /// An engine at rest, or why the kernel does not take the body in these numbers.
    ///
    /// # Errors
    /// What the engine refuses other than the body.
    pub fn engine<'m>(
        &self,
        model: Model<'m>,
        variant: Variant,
    ) -> Result<std::result::Result<Engine<'m>, String>> {
        let sweeps = self.sweeps.unwrap_or(variant.sweeps());
        let contact = Contact::Cells(self.body.held(&model));
        let engine = variant.engine(model, contact, sweeps, |settings| Settings {
            max_tool_step_m: if self.leaps { NO_LIMIT_M } else { settings.max_tool_step_m },
            unloading: self.unloading,
            ..settings
        });
        match engine {
            Ok(engine) => Ok(Ok(engine)),
            Err(Error::Input(why)) => Ok(Err(why)),
            Err(why) => Err(why),
        }
    }

    /// Plays all ticks under a variant.
    ///
    /// # Errors
    /// [`Error::Interrupted`]; what the engine refuses other than the body.
    pub fn play(&self, variant: Variant) -> Result<Ended> {
        let Some(model) = self.body.model(variant.coarse)? else { return Ok(Ended::Absent) };
        let mut engines = Vec::new();
        for _ in 0..3 {
            match self.engine(model, variant)? {
                Ok(engine) => engines.push(engine),
                Err(why) => return Ok(Ended::Refused(why)),
            }
        }
        if let Some(positions) = self.start(&model) {
            engines.iter_mut().try_for_each(|engine| engine.set_positions(&positions))?;
        }
        let [one, again, scalar] = &mut engines[..] else { return Ok(Ended::Absent) };
        scalar.go_scalar();
        let mut monitor = Monitor::new(one, variant.scheme, variant.numbers);
        for tick in 0..self.ticks {
            interrupt::check()?;
            let sample = sample((self.script)(tick));
            let sweeps = (self.sweeps_made)(tick);
            let output = monitor.tick_again(one, &sample, sweeps);
            for other in [&mut *again, &mut *scalar] {
                let same = bits(&other.tick_by(&[sample], Budget::again(sweeps))) == bits(&output)
                    && other.state_hash() == one.state_hash();
                monitor.hold(Check::SameBits, same, || "another run differs".to_owned());
            }
        }
        let left = monitor.worst().left();
        let most = self.left_max.filter(|_| variant.scheme == Scheme::Track);
        monitor.hold(Check::Return, most.is_none_or(|most| left <= most), || {
            format!("{left:e} of the energy left, {:e} expected", most.unwrap_or_default())
        });
        Ok(Ended::Played { worst: *monitor.worst(), failures: monitor.failures().to_vec() })
    }
}
