//! A body, a state to start from, and what tools do to it: played under every variant, every tick looked at.

use chaincell_kernel::{Model, Settings, ToolPart, ToolPose, Unloading};

use crate::bodies::{Body, Variant};
use crate::monitor::{Check, Monitor, Step, play};
use chaincell_host::engine::{Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};

/// A tool step without a limit \[m\].
const NO_LIMIT_M: f32 = 1e30;

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
    /// The parts of tools and their friction, in place of the nodes that the body's tool holds.
    pub tools: Option<(Vec<Vec<ToolPart>>, f32)>,
    /// What happens in a tick.
    pub script: Box<dyn Fn(u32) -> Step + 'b>,
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

impl<'b> Trial<'b> {
    /// A body at rest under a tool that stays away.
    #[must_use]
    pub fn new(label: impl Into<String>, body: &'b Body, ticks: u32) -> Self {
        Self {
            label: label.into(),
            body,
            state: None,
            tools: None,
            script: Box::new(|_| Step::of(&[ToolPose::AWAY])),
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
    pub fn under(self, script: impl Fn(u32) -> Step + 'b) -> Self {
        Self { script: Box::new(script), ..self }
    }

    /// An engine at rest.
    ///
    /// # Errors
    /// [`Error::Input`] where the kernel does not take the body in these numbers.
    pub fn engine<'m>(&self, model: Model<'m>, variant: Variant) -> Result<Engine<'m>> {
        let contact = match &self.tools {
            None => Contact::Cells(self.body.held(&model)),
            Some((tools, friction)) => Contact::Tools { tools: tools.clone(), friction: *friction },
        };
        let sweeps = self.sweeps.unwrap_or(variant.sweeps());
        variant.engine(model, contact, sweeps, |settings| {
            let leaps = self.leaps || self.tools.is_some();
            let max_tool_step_m = if leaps { NO_LIMIT_M } else { settings.max_tool_step_m };
            Settings { max_tool_step_m, unloading: self.unloading, ..settings }
        })
    }

    /// Plays all ticks under a variant; `None` for a coarse level that the body does not have.
    ///
    /// # Errors
    /// [`Error::Input`] where the kernel does not take the body in these numbers;
    /// [`Error::Interrupted`].
    pub fn play(&self, variant: Variant) -> Result<Option<Monitor<'b>>> {
        let Some(model) = self.body.model(variant.coarse)? else { return Ok(None) };
        let state = self.state.as_ref().map(|state| state(&model));
        let steps = (0..self.ticks).map(&self.script);
        let new = || self.engine(model, variant);
        let mut monitor = play(new, variant.numbers, state.as_deref(), steps)?;
        let left = monitor.worst().left();
        let most = self.left_max.filter(|_| variant.scheme == Scheme::Track);
        monitor.hold(Check::Return, most.is_none_or(|most| left <= most), || {
            format!("{left:e} of the energy left, {:e} expected", most.unwrap_or_default())
        });
        Ok(Some(monitor))
    }
}

/// Whether the kernel refuses a body, and why, or another error.
///
/// # Errors
/// All but [`Error::Input`].
pub fn refusal<T>(result: Result<T>) -> Result<std::result::Result<T, String>> {
    match result {
        Ok(value) => Ok(Ok(value)),
        Err(Error::Input(why)) => Ok(Err(why)),
        Err(why) => Err(why),
    }
}
