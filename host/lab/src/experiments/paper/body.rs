//! A tool that presses the bodies that the mechanics of the paper are shown on.

use chaincell_kernel::{Flags, Settings, TickOutput, ToolPose, Unloading};
use nalgebra::Vector3;
use serde::Serialize;

use crate::bodies::Variant;
use crate::experiments::report::scene::Scene;
use crate::reference::Links;
use crate::reference::vectors::{dot, fields, norm, plus};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;

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

impl Scene {
    /// A force that is none: a link a few roundings outside its band \[N\].
    pub fn no_force_n(&self) -> Result<f64> {
        Ok(NO_FORCE * f64::from(self.model()?.force_unit_n()))
    }

    /// A tool that follows equilibria, with `track`.
    pub fn quasi_static(&self, unloading: Unloading) -> Result<Tool<'_>> {
        self.tool(Scheme::Track, SWEEPS, |settings| Settings { unloading, ..settings })
    }

    /// A tool on the paper's own dynamics: one Euler step of `step` [dimensionless time] a tick.
    pub fn in_time(&self, step: f64) -> Result<Tool<'_>> {
        self.tool(Scheme::Euler, 1, |settings| Settings { step: step as f32, ..settings })
    }

    /// The contact cells with their positions at a depth, in internal units.
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
        let links = Links::of_model(&self.model()?);
        let engine = self.engine(Variant::single(scheme, true), sweeps, change)?;
        let mut tool = Tool { engine, closed: links.closed(), links, body: self };
        tool.tick(0.0);
        Ok(tool)
    }
}

/// A tool that holds a body's contact cells.
pub struct Tool<'b> {
    engine: Engine<'b>,
    links: Links,
    closed: Links,
    body: &'b Scene,
}

impl Tool<'_> {
    /// One tick at a depth.
    pub fn tick(&mut self, depth_m: f64) -> TickOutput {
        let position_m = Vector3::from(self.body.direction.map(|x| (depth_m * x) as f32));
        self.engine.tick(&ToolPose::at(position_m, 1))
    }

    /// The force that a press takes, of a tick's answer \[N\].
    pub fn push_n(&self, answer: &TickOutput) -> f64 {
        -dot(answer.force_n.map(f64::from).into(), self.body.direction)
    }

    /// One tick at a depth, and the force it takes \[N\].
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

    /// Energy of the links, and the largest residual of a cell that is neither fixed nor held by the
    /// tool, in internal units with the bands as they are.
    fn residual(&mut self, closed: bool) -> (f64, f64) {
        let at = fields(self.links.rest(), 1.0, &field(&mut self.engine));
        let links = if closed { &self.closed } else { &self.links };
        let mut residual = vec![[0.0; 3]; at.len()];
        let energy = links.residual(&at, &mut residual);
        for &cell in &self.body.contacts {
            residual[usize::from(cell)] = [0.0; 3];
        }
        let free = residual.iter().zip(links.fixed()).filter(|(_, fixed)| !**fixed);
        (energy, free.map(|(r, _)| norm(*r)).fold(0.0, f64::max))
    }
}

/// Displacements of all cells [mean link lengths].
fn field(engine: &mut Engine<'_>) -> Vec<[f64; 3]> {
    let positions_m = engine.positions_m();
    let model = engine.network().model();
    let (unit_m, centre_m) = (f64::from(model.unit_m()), model.centre_m().map(f64::from));
    let cells = positions_m.into_iter().enumerate();
    cells
        .map(|(cell, p)| {
            let rest = model.rest_position(cell).map(f64::from);
            std::array::from_fn(|x| (p[x] - centre_m[x]) / unit_m - rest[x])
        })
        .collect()
}
