//! The bodies that the mechanics of the paper are shown on, and a tool that presses them.

use chaincell_kernel::{Flags, Model, Settings, TickOutput, ToolPose, Unloading};
use nalgebra::Vector3;
use serde::Serialize;

use crate::bodies::Variant;
use crate::experiments::report::engine::{field, free_residual};
use crate::experiments::report::scene;
use crate::reference::Links;
use crate::reference::vectors::{dot, fields, norm, plus};
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::mesh::{self, Mesh, MeshOptions};

/// Sweeps between two looks at the residual.
const SWEEPS: u16 = 16;
/// Looks at most: what has not settled then is told by its residual.
const LOOKS_MAX: usize = 60;
/// Sweeps at most until a press counts as settled.
pub const SETTLE_SWEEPS: usize = LOOKS_MAX * SWEEPS as usize;
/// Largest residual of a free cell at which a press counts as settled [force on the tool].
const RESIDUAL: f64 = 1e-4;
/// The same where the tool feels next to nothing: a few roundings [mean link lengths]; the force
/// must then stay the same to this part from look to look.
const RESIDUAL_MIN: f64 = 2e-6;
const FORCE_STAYS: f64 = 1e-2;
/// A force that is none: a link so far outside its band [mean link lengths].
const NO_FORCE: f64 = 1e-5;
/// Centre of the paper's plane.
const CENTRE: u32 = 220;

/// A mesh with the place that is pressed.
pub struct Source {
    /// Name in tables and files.
    pub name: &'static str,
    /// What it is, in words.
    pub words: String,
    mesh: Mesh,
    contact: scene::Contact,
}

impl Source {
    /// The paper's plane, 21 x 21 cells 10 mm apart with 8 neighbours each, its border fixed; the
    /// centre is pressed across it.
    ///
    /// # Errors
    /// None for this plane.
    pub fn plane() -> Result<Self> {
        let options = MeshOptions { diagonals: true, ..MeshOptions::default() };
        let mesh = mesh::load("plane:21x21x0.01", &options)?;
        let words = "plane of 21 x 21 cells".to_owned();
        let contact = scene::Contact::Nodes(vec![CENTRE], scene::DOWN);
        Ok(Self { name: "plane", words, mesh, contact })
    }

    /// The generated organ, of 1,000 cells with `quick`; its part farthest from the fixed patch is
    /// pressed inwards.
    ///
    /// # Errors
    /// As the generator.
    pub fn organ(quick: bool) -> Result<Self> {
        let mesh = mesh::load(if quick { "organ:1000" } else { "organ" }, &MeshOptions::default())?;
        let words = format!("generated organ of {} cells", mesh.nodes_m.len());
        Ok(Self { name: "organ", words, mesh, contact: scene::Contact::Auto })
    }

    /// The body with its links' bands.
    ///
    /// # Errors
    /// As [`bake`].
    pub fn with_alpha(&self, alpha: f64) -> Result<Body> {
        let options = BakeOptions { alpha: PerCell::Uniform(alpha), ..BakeOptions::default() };
        let image = bake(&self.mesh, &self.mesh.default_fixed, &options)?;
        let model = parse(&image)?;
        let (contacts, direction) = self.contact.of(&model)?;
        Ok(Body { name: self.name, image, contacts, direction })
    }
}

/// A baked body with its contact.
pub struct Body {
    /// Name in tables and files.
    pub name: &'static str,
    image: ImageBytes,
    /// Cells that the tool holds, ascending.
    pub contacts: Vec<u16>,
    /// Unit vector along which they are pressed.
    pub direction: [f64; 3],
}

/// What the tool feels at a depth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Felt {
    /// Displacement of the contact cells \[m\].
    pub depth_m: f64,
    /// Force that the press takes, along its direction \[N\].
    pub force_n: f64,
    /// Energy of the links \[J\], summed in double precision.
    pub energy_j: f64,
    /// Largest residual of a free cell, over the force on the tool.
    pub residual: f64,
}

impl Body {
    /// The model.
    ///
    /// # Errors
    /// None for a body that was baked here.
    pub fn model(&self) -> Result<Model<'_>> {
        parse(&self.image)
    }

    /// A force that is none: a link a few roundings outside its band \[N\].
    ///
    /// # Errors
    /// As [`Self::model`].
    pub fn no_force_n(&self) -> Result<f64> {
        Ok(NO_FORCE * f64::from(self.model()?.force_unit_n()))
    }

    /// A tool that follows equilibria, with `track`.
    ///
    /// # Errors
    /// As [`Variant::unlimited`].
    pub fn quasi_static(&self, unloading: Unloading) -> Result<Tool<'_>> {
        self.tool(Scheme::Track, SWEEPS, |settings| Settings { unloading, ..settings })
    }

    /// A tool on the paper's own dynamics: one Euler step of `step` [dimensionless time] a tick.
    ///
    /// # Errors
    /// As [`Variant::unlimited`].
    pub fn in_time(&self, step: f64) -> Result<Tool<'_>> {
        self.tool(Scheme::Euler, 1, |settings| Settings { step: step as f32, ..settings })
    }

    /// The contact cells with their positions at a depth, in internal units.
    ///
    /// # Errors
    /// As [`Self::model`].
    pub fn held(&self, depth_m: f64) -> Result<Vec<(usize, [f64; 3])>> {
        let model = self.model()?;
        let depth = depth_m / f64::from(model.unit_m());
        let at = |&cell: &u16| {
            let rest = model.rest_position(usize::from(cell)).map(f64::from);
            (usize::from(cell), plus(rest, depth, self.direction))
        };
        Ok(self.contacts.iter().map(at).collect())
    }

    /// The force that the press takes at positions, in double precision \[N\].
    ///
    /// # Errors
    /// As [`Self::model`].
    pub fn push_of(&self, links: &Links, at: &[[f64; 3]]) -> Result<f64> {
        let contacts: Vec<usize> = self.contacts.iter().map(|&cell| usize::from(cell)).collect();
        let force = links.force(at, &contacts);
        Ok(-dot(force, self.direction) * f64::from(self.model()?.force_unit_n()))
    }

    fn tool(
        &self,
        scheme: Scheme,
        sweeps: u16,
        change: impl FnOnce(Settings) -> Settings,
    ) -> Result<Tool<'_>> {
        let model = self.model()?;
        let contact = Contact::Cells(self.contacts.clone());
        let variant = Variant::plain(scheme, Arithmetic::F32);
        let mut tool = Tool {
            engine: variant.unlimited(model, contact, sweeps, change)?,
            closed: Links::of_model(&model).closed(),
            links: Links::of_model(&model),
            body: self,
        };
        tool.tick(0.0);
        Ok(tool)
    }
}

/// A tool that holds a body's contact cells.
pub struct Tool<'b> {
    engine: Engine<'b>,
    links: Links,
    closed: Links,
    body: &'b Body,
}

impl Tool<'_> {
    /// One tick at a depth.
    pub fn tick(&mut self, depth_m: f64) -> TickOutput {
        let position_m = Vector3::from(self.body.direction.map(|x| (depth_m * x) as f32));
        self.engine.tick(&ToolPose::at(position_m, 1))
    }

    /// The force that a press takes, of a tick's answer \[N\].
    #[must_use]
    pub fn push_n(&self, answer: &TickOutput) -> f64 {
        -dot(answer.force_n.map(f64::from).into(), self.body.direction)
    }

    /// One tick at a depth, and the force it takes \[N\].
    ///
    /// # Errors
    /// The user asked to stop; the body's energy bound stopped the tool.
    pub fn press(&mut self, depth_m: f64) -> Result<f64> {
        let answer = self.checked(depth_m)?;
        Ok(self.push_n(&answer))
    }

    fn checked(&mut self, depth_m: f64) -> Result<TickOutput> {
        let answer = self.tick(depth_m);
        interrupt::check()?;
        if answer.flags.contains(Flags::MOTION_CLAMPED) {
            Err(Error::check(format!(
                "{}: the tool was stopped before {depth_m} m",
                self.body.name
            )))
        } else {
            Ok(answer)
        }
    }

    /// Ticks at a depth until the body has settled, at most so many that it should have.
    ///
    /// # Errors
    /// As [`Self::press`].
    pub fn settle(&mut self, depth_m: f64) -> Result<Felt> {
        let mut felt = Felt { depth_m, force_n: 0.0, energy_j: 0.0, residual: 0.0 };
        for _ in 0..LOOKS_MAX {
            let answer = self.checked(depth_m)?;
            let closed = answer.flags.contains(Flags::BAND_CLOSED);
            let model = *self.engine.network().model();
            let (energy, residual) = self.residual(closed);
            let force = norm(answer.force_n.map(f64::from).into());
            let force = force / f64::from(model.force_unit_n());
            let before = felt.force_n;
            felt.force_n = self.push_n(&answer);
            let stays = (felt.force_n - before).abs() <= FORCE_STAYS * felt.force_n.abs()
                || force <= NO_FORCE;
            felt.energy_j = energy * f64::from(model.energy_unit_j());
            felt.residual = if force > 0.0 { residual / force } else { 0.0 };
            if (residual <= RESIDUAL_MIN && stays) || felt.residual <= RESIDUAL {
                break;
            }
        }
        Ok(felt)
    }

    /// Energy and largest residual of a free cell in internal units, with the bands as they are.
    fn residual(&mut self, closed: bool) -> (f64, f64) {
        let at = fields(self.links.rest(), 1.0, &field(&mut self.engine));
        let links = if closed { &self.closed } else { &self.links };
        free_residual(links, &at, &self.body.contacts)
    }
}

fn parse(image: &ImageBytes) -> Result<Model<'_>> {
    Model::from_bytes(image.as_bytes()).map_err(Error::check)
}
