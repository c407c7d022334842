//! The running kernel under the presses of a body: what a tick costs, and how far its answer is from
//! its own equilibrium and from finite elements.

use std::time::Instant;

use serde::Serialize;

use super::body::{Body, Press, YOUNG_PA};
use super::equilibria::Found;
use super::{Model, against};
use crate::reference::nodal::{BAND_FROM, Volume};
use chaincell_host::bake::tissue::{Tissue, VolumeLaw};
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::Mesh;
use chaincell_kernel::{self as kernel, Choice, Network, Settings, ToolPose, Unloading};

/// How fast the tool presses, without a stop \[m/s\].
pub const SPEED_M_PER_S: f64 = 0.05;
/// Period of a tick \[s\].
const TICK_S: f64 = 0.001;
/// Ticks that the tool rests behind the deepest press.
const HELD_TICKS: u32 = 20;
/// Sweeps a tick.
const SWEEPS: [u16; 4] = [1, 2, 4, 8];
/// Sweeps of the bare passes that times are compared with.
const BARE_SWEEPS: u16 = 8;

/// A depth of a press that goes on, at so many sweeps a tick.
#[derive(Debug, Clone, Serialize)]
pub struct RunningRow {
    /// Name of the mesh.
    pub body: &'static str,
    /// Poisson's ratio in percent.
    pub poisson_percent: u8,
    /// The model.
    pub model: &'static str,
    /// Its scheme.
    pub scheme: &'static str,
    /// Sweeps a tick.
    pub sweeps: u16,
    /// Depth that the tool goes through.
    pub depth_mm: f64,
    /// Error of the field against the model's own equilibrium there.
    pub field_own: f64,
    /// Force over that of the model's own equilibrium.
    pub force_own: f64,
    /// Error of the field against quadratic elements.
    pub field: f64,
    /// Force over that of the elements.
    pub force: f64,
    /// Error of the field against the model's own equilibrium 20 ms after the deepest press.
    pub field_held: f64,
    /// Force over that of the model's own equilibrium then.
    pub force_held: f64,
    /// Ticks of the press that were rolled back, share.
    pub rolled_back: f64,
    /// Median time of a tick of the press.
    pub tick_us: f64,
    /// The same in sweeps over the links of this body without a coarse level, measured beside it.
    pub tick_bare_sweeps: f64,
}

/// The body baked by the host, its links with the mean modulus of the data.
fn baked(body: &Body, model: Model, coarse_basis: BasisSpacing) -> Result<ImageBytes> {
    let links = body.links();
    let mesh = Mesh {
        nodes_m: body.rest_m.clone(),
        links: links.keys().copied().collect(),
        tetrahedra: body.tetrahedra.clone(),
        ..Mesh::default()
    };
    let of = PerCell::Uniform;
    let options = match model {
        Model::Nodal(volume, band) => {
            let law = match volume {
                Volume::Det1 => VolumeLaw::Det1,
                Volume::Trace => VolumeLaw::Trace,
            };
            let stretch_min = band.then_some(BAND_FROM);
            let tissue = Tissue::new(of(YOUNG_PA), of(body.case.poisson()));
            let tissue = Tissue { law, stretch_min, ..tissue };
            BakeOptions { tissue: Some(tissue), ..BakeOptions::default() }
        }
        _ => BakeOptions {
            stiffness_n_per_m: of(body.even_stiffness_n_per_m()),
            ..BakeOptions::default()
        },
    };
    bake(&mesh, &body.fixed, &BakeOptions { coarse_basis, ..options })
}

/// A body under way.
struct Player<'a> {
    body: &'a Body,
    engine: Engine<'a>,
    /// Node of each cell.
    node: Vec<u32>,
    ticks: u32,
    rolled_back: u32,
    times_us: Vec<f64>,
}

impl<'a> Player<'a> {
    fn new(body: &'a Body, image: &'a ImageBytes, scheme: Scheme, sweeps: u16) -> Result<Self> {
        let model = kernel::Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
        let settings = Settings {
            max_tool_step_m: 1e3 * model.unit_m(),
            unloading: Unloading::Off,
            ..scheme.settings(&model, sweeps)
        };
        let network = Network::new(model, settings).map_err(Error::check)?;
        let mut held: Vec<u16> =
            body.pressed.iter().filter_map(|&node| model.cell_of_input(node as u32)).collect();
        held.sort_unstable();
        let mut engine = Engine::new(network, scheme, &held)?;
        engine.tick(&ToolPose::at([0.0; 3].into(), 1));
        let node = model.input_id().to_vec();
        Ok(Self { body, engine, node, ticks: 0, rolled_back: 0, times_us: Vec::new() })
    }

    /// On to a depth; the field and the force along the press there.
    fn press_to(&mut self, depth_m: f64) -> (Vec<[f64; 3]>, f64) {
        let last = (depth_m / (SPEED_M_PER_S * TICK_S)).round() as u32;
        self.play_to(last, last)
    }

    /// On to a tick, the tool at rest from tick `stop` on.
    fn play_to(&mut self, last: u32, stop: u32) -> (Vec<[f64; 3]>, f64) {
        let mut force_n = 0.0;
        while self.ticks < last {
            self.ticks += 1;
            let depth_m = f64::from(self.ticks.min(stop)) * SPEED_M_PER_S * TICK_S;
            let position_m = self.body.direction.map(|x| (depth_m * x) as f32).into();
            let begun = Instant::now();
            let output = self.engine.tick(&ToolPose::at(position_m, 1));
            self.times_us.push(1e6 * begun.elapsed().as_secs_f64());
            self.rolled_back += u32::from(output.flags.contains(kernel::Flags::ROLLED_BACK));
            let along = output.force_n.iter().zip(self.body.direction);
            force_n = -along.map(|(f, d)| f64::from(*f) * d).sum::<f64>();
        }
        let mut u = vec![[0.0; 3]; self.body.rest_m.len()];
        for (&node, at) in self.node.iter().zip(self.engine.positions_m()) {
            let rest = self.body.rest_m[node as usize];
            u[node as usize] = std::array::from_fn(|axis| at[axis] - rest[axis]);
        }
        (u, force_n)
    }

    fn median_us(&self) -> f64 {
        let mut times = self.times_us.clone();
        times.sort_by(f64::total_cmp);
        times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
    }
}

/// Time of a sweep over the links of a body without a coarse level \[us\].
fn bare_sweep_us(body: &Body) -> Result<f64> {
    let image = baked(body, Model::EvenLinks, BasisSpacing::None)?;
    let mut player = Player::new(body, &image, Scheme::Track, BARE_SWEEPS)?;
    let deepest = body.quadratic.iter().map(|press| press.depth_m).fold(0.0, f64::max);
    player.press_to(deepest);
    Ok(player.median_us() / f64::from(BARE_SWEEPS))
}

/// The presses of a body with a model, beside its equilibria `found`.
pub(super) fn play(
    body: &Body,
    weights: &[f64],
    model: Model,
    found: &[Found],
) -> Result<Vec<RunningRow>> {
    let bare_us = bare_sweep_us(body)?;
    let image = baked(body, model, BasisSpacing::BySize)?;
    let scheme = Scheme::Predict;
    let mut rows = Vec::new();
    for sweeps in SWEEPS {
        let mut player = Player::new(body, &image, scheme, sweeps)?;
        let mut of_sweeps = Vec::new();
        for (press, found) in body.quadratic.iter().zip(found) {
            let (u, force_n) = player.press_to(press.depth_m);
            of_sweeps.push(row(body, weights, model, press, found, (&u, force_n)));
        }
        let (rolled_back, tick_us) =
            (f64::from(player.rolled_back) / f64::from(player.ticks.max(1)), player.median_us());
        let (u, force_n) = player.play_to(player.ticks + HELD_TICKS, player.ticks);
        let held = found
            .last()
            .map(|found| (against(weights, &u, &found.displacement_m), force_n / found.force_n));
        let (field_held, force_held) = held.unwrap_or((f64::NAN, f64::NAN));
        rows.extend(of_sweeps.into_iter().map(|row| RunningRow {
            scheme: scheme.name(),
            sweeps,
            field_held,
            force_held,
            rolled_back,
            tick_us,
            tick_bare_sweeps: tick_us / bare_us,
            ..row
        }));
    }
    Ok(rows)
}

/// The errors at a depth; what belongs to the whole press is left open.
fn row(
    body: &Body,
    weights: &[f64],
    model: Model,
    press: &Press,
    found: &Found,
    (u, force_n): (&[[f64; 3]], f64),
) -> RunningRow {
    RunningRow {
        body: body.case.mesh,
        poisson_percent: body.case.poisson_percent,
        model: model.words(),
        scheme: "",
        sweeps: 0,
        depth_mm: 1e3 * press.depth_m,
        field_own: against(weights, u, &found.displacement_m),
        force_own: force_n / found.force_n,
        field: against(weights, u, &press.displacement_m),
        force: force_n / press.force_n,
        field_held: f64::NAN,
        force_held: f64::NAN,
        rolled_back: f64::NAN,
        tick_us: f64::NAN,
        tick_bare_sweeps: f64::NAN,
    }
}
