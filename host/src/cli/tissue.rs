//! Arguments that say how a model is run, shared by `run`, `serve`, `cosim` and `latency`.

#![allow(
    rustdoc::broken_intra_doc_links,
    reason = "help texts, which name units as [N] and are printed as they stand"
)]

use chaincell_kernel::stage::StageSettings;
use chaincell_kernel::{Choice, Drive, Model, Network, Settings};
use serde::{Deserialize, Serialize};

use super::choice::parser;
use super::settings::{SettingArgs, SettingReport};
use super::tool::{self, ToolSpec};
use crate::choice;
use crate::engine::contact::contact_cells;
use crate::engine::staged::Staged;
use crate::engine::threads::{ThreadCount, Threads};
use crate::engine::{Arithmetic, Contact, Engine, Scheme};
use crate::error::{Error, Result};
use crate::words::counted;

/// Length of a tick [s].
const TICK_S: f32 = 1e-3;

/// Contact, dynamics and limits.
#[derive(Debug, Clone, Serialize, Deserialize, clap::Args)]
#[serde(deny_unknown_fields)]
pub struct TissueArgs {
    /// Cells that the tool holds while engaged: cells:SELECTOR (see `bake --help`), input ids, or
    /// auto: the free surface cell farthest from the fixed ones with its surface neighbours. On a
    /// model baked with --cells the ids are those of nodes, and a cell is held if half of its group
    /// or more is named. The tool's displacement counts from where it engages. probe:RADIUS is short
    /// for --tool sphere:RADIUS
    #[arg(long, default_value = "auto", value_name = "CONTACT")]
    pub contact: String,
    /// A tool by its parts, on a model with a contact surface (`bake`); up to eight times, the first is
    /// tool 0. PART[+PART...], at most eight, each sphere:R, capsule:HALF_LENGTH,R (along
    /// z), box:HX,HY,HZ,R (half edges of the core inside the rounding), half-space[:R] (all below
    /// z = 0) or, last, blade:LENGTH (an edge along x that cuts towards -z a body baked with
    /// --cuttable) or scissors:LENGTH[,OFFSET[,MOUTH]] (blades along -z that open in the y direction by
    /// the pose's opening), then @X,Y,Z, its place in the tool's frame, and /X,Y,Z,W, its turn, a unit
    /// quaternion [m]
    #[arg(long, value_name = "PART[+PART...]", conflicts_with = "contact")]
    pub tool: Vec<ToolSpec>,
    /// Coefficient of friction between tools and the tissue [default: 0]
    #[arg(long, value_name = "MU", allow_negative_numbers = true)]
    pub friction: Option<f32>,
    /// Scheme: track follows the equilibrium; predict does so in fewer sweeps where the tool holds
    /// cells or moves on a surface; euler is the paper's own, for relaxation in time;
    /// rkl2 the same trajectory beyond euler's bound [default: predict where the tool holds
    /// cells of a model without slack, or there are tools; else track]
    #[serde(with = "choice::optional")]
    #[arg(long, value_parser = parser::<Scheme>())]
    scheme: Option<Scheme>,
    /// Numbers that cells and links are computed in
    #[serde(with = "choice")]
    #[arg(long, value_parser = parser::<Arithmetic>(), default_value = Arithmetic::default().name(),
        value_name = "TYPE")]
    pub precision: Arithmetic,
    #[command(flatten)]
    settings: SettingArgs,
    /// Time constant of the body's relaxation [s]: a tick of 1 ms advances 1 ms / S of
    /// dimensionless time, with euler or rkl2
    #[arg(long, value_name = "S", allow_negative_numbers = true, conflicts_with = "step")]
    pub time_constant_s: Option<f32>,
    /// Threads that share the sweeps of a body of 4,096 cells of shapes or 16,384 of links or more, under
    /// track and predict, each on a processor of its own, at most 4 for shapes; auto leaves one
    /// processor free. The bits do not depend on it
    #[arg(long, default_value_t = ThreadCount::Of(1), value_name = "N|auto", allow_negative_numbers = true)]
    pub threads: ThreadCount,
    /// Largest torque of a --tool; a larger one is shortened and flagged [N m] [default: no limit]
    #[arg(long, value_name = "T", allow_negative_numbers = true, requires = "tool")]
    pub max_torque_n_m: Option<f32>,
}

/// Why a scheme takes no time.
const STATIC: &str = "this scheme answers the static question; take --scheme euler or rkl2";

/// Every parameter in force, for summaries.
#[derive(Debug, Clone, Serialize)]
pub struct TissueReport {
    #[serde(serialize_with = "choice::serialize")]
    scheme: Scheme,
    #[serde(serialize_with = "choice::serialize")]
    precision: Arithmetic,
    #[serde(flatten)]
    settings: SettingReport,
    step_bound: f32,
    time_constant_s: Option<f32>,
    network_time_per_tick: Option<f32>,
    max_torque_n_m: Option<f32>,
    tools: Vec<String>,
    contact_nodes: Vec<u32>,
    friction: Option<f32>,
    alpha: f32,
    alpha_varies: bool,
    stiffness_n_per_m: f32,
    stiffness_varies: bool,
    k_m: f32,
    r_x: f32,
    capacitance: f32,
    energy_max_j: f32,
    mean_link_m: f32,
    model_checksum: String,
}

impl TissueArgs {
    /// Returns true if the cells to hold, or to press, are those that no option chose.
    pub fn is_place_default(&self) -> bool {
        self.contact == "auto" || self.contact.starts_with("probe:")
    }

    /// Returns true if it holds the cells that no option chose.
    pub fn holds_default(&self) -> bool {
        self.contact == "auto" && self.tool.is_empty()
    }

    /// The engine for a model.
    pub fn engine<'m>(&self, model: Model<'m>) -> Result<Engine<'m>> {
        let contact = self.contact(&model)?;
        let scheme = self.scheme(&model);
        let sweeps = self.given(&model).sweeps;
        let mut settings = self.settings.over(scheme.settings(&model, sweeps));
        self.set_times(scheme, &model, &mut settings)?;
        let limit_n = self.settings.real("max_force_n");
        if limit_n.is_some_and(|limit_n| !(limit_n > 0.0 && limit_n.is_finite())) {
            return Err(self.refusal("max_force_n", "must be above 0 and finite"));
        }
        let network = Network::new(model, settings).map_err(|why| {
            // The message begins with the name of the setting.
            let text = why.to_string();
            let (name, rule) = text.split_once(' ').unwrap_or_default();
            self.refusal(if name == "tick_time" { "step" } else { name }, rule)
        })?;
        let mut engine = Engine::with_contact(network, scheme, self.precision, contact)
            .map_err(|why| self.of_contact(why))?;
        let threads = self.threads(scheme, &model)?;
        engine.share(threads.map(|threads| Box::new(threads) as _));
        Ok(engine)
    }

    /// The settings that were given over a model's defaults.
    pub fn given(&self, model: &Model<'_>) -> Settings {
        self.settings.over(Settings::for_model(model))
    }

    fn refusal(&self, name: &str, rule: &str) -> Error {
        Error::input(format!("{}: {rule}", self.settings.shown(name)))
    }

    /// Names `--contact` in a refusal of the tool that `--contact probe:RADIUS` stands for.
    fn of_contact(&self, why: Error) -> Error {
        let given = format!("`contact` {}", self.contact);
        match why {
            Error::Input(text) if self.tool.is_empty() => {
                Error::Input(text.replace("`tool`", &given))
            }
            other => other,
        }
    }

    /// The engine for a model behind an output stage, or without one.
    ///
    /// # Errors
    /// As [`Self::engine`], a largest torque out of range, a stage for several tools.
    pub fn staged<'m>(&self, model: Model<'m>, stage: Option<StageSettings>) -> Result<Staged<'m>> {
        let mut staged = Staged::new(self.engine(model)?, stage)?;
        if let Some(most_n_m) = self.max_torque_n_m {
            if self.tool.is_empty() {
                return Err(Error::input(format!(
                    "--max-torque-n-m {most_n_m}: it is for tools by their parts; give --tool, or leave it \
                     out"
                )));
            }
            if !(most_n_m > 0.0 && most_n_m.is_finite()) {
                let why = format!("--max-torque-n-m {most_n_m}: must be above 0 and finite");
                return Err(Error::input(why));
            }
            staged.limit_torque(most_n_m);
        }
        Ok(staged)
    }

    /// The scheme that was asked for, or the one that suits the scene.
    fn scheme(&self, model: &Model<'_>) -> Scheme {
        let why_track = if self.given(model).drive == Drive::Current {
            Some("under a current")
        } else if model.has_slack() {
            Some("on a model with slack (--alpha of bake)")
        } else {
            None
        };
        match (self.scheme, why_track) {
            (None, None) if self.precision == Arithmetic::F32 => Scheme::Predict,
            (None, _) => Scheme::Track,
            (Some(Scheme::Predict), Some(why)) => {
                log::warn!("--scheme predict: {why} it is track, which needs less memory");
                Scheme::Predict
            }
            (Some(scheme), _) => scheme,
        }
    }

    /// The threads beside the ticking one.
    fn threads(&self, scheme: Scheme, model: &Model<'_>) -> Result<Option<Threads>> {
        let is_shared = matches!(scheme, Scheme::Track | Scheme::Predict);
        let precision = self.precision;
        match self.threads {
            ThreadCount::Auto if !is_shared || precision != Arithmetic::F32 => Ok(None),
            ThreadCount::Of(count @ 2..) if !is_shared || precision != Arithmetic::F32 => {
                Err(Error::input(format!(
                    "--threads {count}: threads share the sweeps of --scheme track and predict in \
                     --precision f32; leave it out"
                )))
            }
            count => count.start(model),
        }
    }

    /// Sets the step of a sweep, and the time of a tick for the schemes that go by it.
    fn set_times(&self, scheme: Scheme, model: &Model<'_>, settings: &mut Settings) -> Result<()> {
        let by_tick = scheme.goes_by_tick();
        let step = self.settings.real("step");
        // `--step` is the time of a tick for these schemes.
        if by_tick {
            settings.tick_time = step.unwrap_or(settings.tick_time);
            settings.step = Settings::for_model(model).step;
        } else if step.is_some() && scheme != Scheme::Euler {
            return Err(self.refusal("step", STATIC));
        }
        let Some(constant_s) = self.time_constant_s else { return Ok(()) };
        let refused =
            |why: String| Err(Error::input(format!("--time-constant-s {constant_s}: {why}")));
        let tick_time = TICK_S / constant_s;
        if !(constant_s > 0.0 && tick_time > 0.0 && tick_time.is_finite()) {
            return refused("must be above 0 and finite [s]".into());
        }
        settings.tick_time = tick_time;
        if by_tick {
            return Ok(());
        }
        if scheme != Scheme::Euler {
            return refused(STATIC.into());
        }
        // The sweeps share the time of the tick.
        let sweeps = f32::from(settings.sweeps.max(1));
        let bound = model.step_max();
        settings.step = tick_time / sweeps;
        if settings.step > bound {
            return refused(format!(
                "euler would step by {} a sweep, the model's proven bound is {bound}: at least \
                 {} s with {} a tick, or --scheme rkl2",
                settings.step,
                TICK_S / (bound * sweeps),
                counted(settings.sweeps, "sweep")
            ));
        }
        Ok(())
    }

    /// The contact of the tool.
    fn contact(&self, model: &Model<'_>) -> Result<Contact> {
        let tools = self.tools()?;
        if tools.is_empty() {
            if let Some(friction) = self.friction {
                return Err(Error::input(format!(
                    "--friction {friction}: cells that are held do not slide; give --contact \
                     probe:RADIUS or --tool, or leave it out"
                )));
            }
            return contact_cells(&self.contact, model).map(Contact::Cells);
        }
        if self.given(model).drive == Drive::Current {
            return Err(Error::input(
                "--drive current loads chosen cells, and a probe or a --tool has none: give --contact \
                 cells:SELECTOR, or leave --drive out",
            ));
        }
        tool::tools(&tools, self.friction, model)
    }

    /// The tools by their parts: those of `--tool`, or the sphere of `--contact probe:RADIUS`.
    fn tools(&self) -> Result<Vec<ToolSpec>> {
        let sphere = tool::probe(&self.contact)?.filter(|_| self.tool.is_empty());
        Ok(sphere.map_or_else(|| self.tool.clone(), |sphere| vec![sphere]))
    }

    /// The tools by their parts, none where cells are held.
    ///
    /// # Errors
    /// A radius that cannot be.
    pub fn tool_texts(&self) -> Result<Vec<String>> {
        Ok(self.tools()?.into_iter().map(|tool| tool.text).collect())
    }

    /// Every parameter in force.
    pub fn report(&self, engine: &Engine<'_>) -> TissueReport {
        let (model, settings) = (engine.network().model(), engine.network().settings());
        let mut contact_nodes: Vec<u32> =
            engine.contacts().iter().map(|&cell| model.input_id()[usize::from(cell)]).collect();
        contact_nodes.sort_unstable();
        let friction = match *engine.contact() {
            Contact::Cells(_) => None,
            Contact::Tools { friction, .. } => Some(friction),
        };
        // They were read once already.
        let tools = self.tool_texts().unwrap_or_default();
        // Network time, by sweep or by tick.
        let by_tick = engine.scheme().goes_by_tick();
        let euler = f32::from(settings.sweeps) * settings.step;
        TissueReport {
            scheme: engine.scheme(),
            precision: self.precision,
            settings: SettingReport(Settings {
                step: if by_tick { settings.tick_time } else { settings.step },
                ..*settings
            }),
            step_bound: model.step_max(),
            time_constant_s: self.time_constant_s,
            network_time_per_tick: match engine.scheme() {
                Scheme::Euler => Some(euler),
                _ => by_tick.then_some(settings.tick_time),
            },
            max_torque_n_m: self.max_torque_n_m,
            tools,
            contact_nodes,
            friction,
            alpha: model.alpha(),
            alpha_varies: model.alpha_varies(),
            stiffness_n_per_m: model.stiffness_n_per_m(),
            stiffness_varies: model.weight_varies(),
            k_m: model.saturation() * model.unit_m(),
            r_x: model.resistance(),
            capacitance: model.capacitance(),
            energy_max_j: model.energy_max() * model.energy_unit_j(),
            mean_link_m: model.unit_m(),
            model_checksum: format!("{:08x}", model.checksum()),
        }
    }
}

/// The contact that `--contact` names on a model.
///
/// # Errors
/// A selector or a radius that names nothing, a model without a contact surface.
pub fn contact(contact: &str, model: &Model<'_>) -> Result<Contact> {
    match tool::probe(contact)? {
        Some(sphere) => tool::tools(&[sphere], None, model),
        None => contact_cells(contact, model).map(Contact::Cells),
    }
}
