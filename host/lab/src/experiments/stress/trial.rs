//! A body, a state to start from, and what a tool does to it: played under every variant, twice
//! and once more cell by cell, every tick looked at.

use chaincell_kernel::{Flags, Model, Network, Settings, TickOutput, ToolSample, Unloading};
use nalgebra::Vector3;

use super::body::Body;
use super::energy::of_positions;
use super::variant::Variant;
use super::watch::{Bounds, Check, Failure, Seen, Watch, Worst};
use chaincell_host::engine::{Contact, Engine};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;

/// Most cells that a probe touches at a time.
const CAPACITY: usize = 64;
/// A tool step without a limit \[m\].
const NO_LIMIT_M: f32 = 1e30;

/// What the tool touches.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Touch {
    /// It holds the body's contact nodes.
    Cells,
    /// A sphere \[m\].
    Probe(f32),
}

/// Where the tool is \[m\], and whether it touches.
pub type Pose = ([f32; 3], bool);

/// A cell's place in a state [mean link lengths from the centre].
pub type State = Box<dyn Fn(&Model<'_>, usize) -> [f32; 3]>;

/// What is done to a body.
pub struct Trial<'b> {
    /// What it is, within its case.
    pub label: String,
    /// The body.
    pub body: &'b Body,
    /// Where the cells start; at rest unless given.
    pub state: Option<State>,
    /// What the tool touches.
    pub touch: Touch,
    /// The tool's pose in a tick.
    pub script: Box<dyn Fn(u32) -> Pose>,
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
    /// Whether the other methods take part.
    pub compared: bool,
}

/// How a trial ended under a variant.
#[derive(Debug, Clone, PartialEq)]
pub enum Ended {
    /// The body has no hats.
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

/// Ends with [`Error::Interrupted`] where the user asked for it.
///
/// # Errors
/// That one.
pub fn stop_if_asked() -> Result<()> {
    if interrupt::asked() { Err(Error::Interrupted) } else { Ok(()) }
}

/// A sample of a pose.
#[must_use]
pub fn sample((position_m, touches): Pose) -> ToolSample {
    ToolSample { position_m: Vector3::from(position_m), engaged: u32::from(touches) }
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
            touch: Touch::Cells,
            script: Box::new(|_| ([0.0; 3], false)),
            ticks,
            leaps: false,
            unloading: Unloading::Off,
            sweeps: None,
            left_max: None,
            compared: true,
        }
    }

    /// From a state of all cells.
    #[must_use]
    pub fn from(self, state: impl Fn(&Model<'_>, usize) -> [f32; 3] + 'static) -> Self {
        Self { state: Some(Box::new(state)), ..self }
    }

    /// Under a tool.
    #[must_use]
    pub fn under(self, script: impl Fn(u32) -> Pose + 'static) -> Self {
        Self { script: Box::new(script), ..self }
    }

    /// The settings of a variant.
    #[must_use]
    pub fn settings(&self, model: &Model<'_>, variant: Variant) -> Settings {
        let settings = variant.scheme.settings(model, self.sweeps.unwrap_or(variant.sweeps()));
        let max_tool_step_m = if self.leaps { NO_LIMIT_M } else { settings.max_tool_step_m };
        Settings { max_tool_step_m, unloading: self.unloading, ..settings }
    }

    /// What the tool touches, in the model's cells.
    #[must_use]
    pub fn contact(&self, model: &Model<'_>) -> Contact {
        match self.touch {
            Touch::Cells => Contact::Cells(self.body.held(model)),
            Touch::Probe(radius_m) => Contact::Probe { radius_m, capacity: CAPACITY },
        }
    }

    /// Where the cells start.
    #[must_use]
    pub fn start(&self, model: &Model<'_>) -> Option<Vec<[f32; 3]>> {
        let state = self.state.as_ref()?;
        Some((0..model.cells()).map(|cell| state(model, cell)).collect())
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
        let settings = self.settings(&model, variant);
        let network = Network::new(model, settings).map_err(Error::check)?;
        let contact = self.contact(&model);
        match Engine::with_contact(network, variant.scheme, variant.numbers, contact) {
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
        let Some(model) = self.body.model(variant.hats)? else { return Ok(Ended::Absent) };
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
        let mut view = View::new(self, model, variant, one);
        for tick in 0..self.ticks {
            stop_if_asked()?;
            let pose = (self.script)(tick);
            let output = one.tick(&sample(pose));
            for other in [&mut *again, &mut *scalar] {
                let same = bits(&other.tick(&sample(pose))) == bits(&output)
                    && other.state_hash() == one.state_hash();
                view.watch.hold(Check::SameBits, same, || "another run differs".to_owned());
            }
            view.look(one, pose, &output);
        }
        Ok(view.ended(self, variant))
    }
}

/// What is kept from tick to tick to tell what acts.
struct View<'m> {
    model: Model<'m>,
    watch: Watch,
    resolution: f64,
    probe: bool,
    /// Weight of the links between held and other cells; of a cell at most, for a probe.
    weight: f64,
    last: Option<(Pose, Flags)>,
}

impl<'m> View<'m> {
    fn new(trial: &Trial<'_>, model: Model<'m>, variant: Variant, engine: &mut Engine<'m>) -> Self {
        let resolution = variant.resolution();
        let start_j = of_positions(&model, &engine.positions_m(), false, resolution).0;
        let probe = matches!(trial.touch, Touch::Probe(_));
        let weight = if probe {
            (0..model.cells()).map(|cell| f64::from(model.cell_weight(cell))).fold(0.0, f64::max)
        } else {
            outer_weight(&model, engine.contacts())
        };
        let unit_j = f64::from(model.energy_unit_j());
        let mut energy_max_j = f64::from(model.energy_max()) * unit_j;
        if trial.unloading != Unloading::Off {
            // Bands that close load their own slack.
            let slack = (0..model.links()).map(|link| {
                let slack = f64::from(model.link_alpha(link) * model.rest_lengths()[link]);
                f64::from(model.link_weight(link)) * slack * slack
            });
            let root = energy_max_j.sqrt() + 0.5 * (slack.sum::<f64>() * unit_j).sqrt();
            energy_max_j = root * root;
        }
        let saturation = f64::from(model.saturation());
        let bounds = Bounds { saturation, energy_max_j, certificate: variant.certificate() };
        let watch = Watch::new(bounds, start_j);
        Self { model, watch, resolution, probe, weight, last: None }
    }

    /// Looks at the tick that gave `output`.
    fn look(&mut self, engine: &mut Engine<'_>, pose: Pose, output: &TickOutput) {
        let positions_m = engine.positions_m();
        let closed = output.flags.contains(Flags::BAND_CLOSED);
        let (energy_j, allowance_j) =
            of_positions(&self.model, &positions_m, closed, self.resolution);
        let unit_m = f64::from(self.model.unit_m());
        let centre = self.model.centre_m();
        let inside =
            |p: &[f64; 3]| std::array::from_fn(|axis| (p[axis] - f64::from(centre[axis])) / unit_m);
        let positions: Vec<[f64; 3]> = positions_m.iter().map(inside).collect();
        let weight =
            if self.probe { self.weight * f64::from(output.contacts) } else { self.weight };
        let unit_j = f64::from(self.model.energy_unit_j());
        let bound = (weight * (energy_j + allowance_j) / unit_j).sqrt();
        let force_n: [f32; 3] = output.force_n.into();
        self.watch.look(&Seen {
            level_j: output.energy_j.into(),
            energy_j,
            allowance_j,
            acts: self.acts(pose, output.flags),
            force_n: force_n.map(f64::from),
            force_bound_n: f64::from(self.model.force_unit_n()) * bound,
            positions: &positions,
        });
        self.last = Some((pose, output.flags));
    }

    /// Whether anything acted from outside in this tick. Taking hold and letting go do not.
    fn acts(&self, (position_m, touches): Pose, flags: Flags) -> bool {
        let Some(((from_m, touched), before)) = self.last else { return false };
        let has = |flag| flags.contains(flag) || before.contains(flag);
        let moves = position_m != from_m || has(Flags::MOTION_CLAMPED) || has(Flags::BAD_SAMPLE);
        let unloads = flags.contains(Flags::BAND_CLOSED) != before.contains(Flags::BAND_CLOSED);
        // The sphere also pushes cells that come to it.
        unloads || (touches && (self.probe || (touched && moves)))
    }

    fn ended(mut self, trial: &Trial<'_>, variant: Variant) -> Ended {
        let left = self.watch.worst.left();
        let returns =
            trial.left_max.filter(|_| variant.scheme == chaincell_host::engine::Scheme::Track);
        if let Some(max) = returns.filter(|&max| left > max) {
            self.watch
                .fail(Check::Return, || format!("{left:e} of the energy left, {max:e} expected"));
        }
        Ended::Played { worst: self.watch.worst, failures: self.watch.failures }
    }
}

/// Weight of the links between the cells `held` (ascending) and others.
fn outer_weight(model: &Model<'_>, held: &[u16]) -> f64 {
    let is_held = |cell: usize| held.binary_search(&(cell as u16)).is_ok();
    let outer = held.iter().flat_map(|&cell| model.neighbours(cell.into()));
    outer
        .filter(|&(_, other)| !is_held(other))
        .map(|(link, _)| f64::from(model.link_weight(link)))
        .sum()
}
