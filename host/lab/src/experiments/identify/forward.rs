//! The forward problem: what a body of given parameters would have measured.
//!
//! Curves and fields are those of the engine itself: `track` to the equilibrium at every
//! displacement, `rkl2` through time. So what is identified is what a run with the model feels.

use std::collections::BTreeMap;

use chaincell_kernel::{Flags, Model, Settings, ToolPose};

use super::target::{Kind, Target};
use super::tool::Tool;
use super::{Bench, Parameters};
use crate::bodies::Variant;
use crate::reference::vectors::{dot, minus};
use chaincell_host::bake::{ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;

/// Sweeps between two looks at the force.
const SWEEPS: u16 = 16;
/// Ticks in a row that must be so.
const CALM_TICKS: usize = 2;
/// How held cells go from one equilibrium to the next: strides in mean link lengths.
const HELD: Pace = Pace { stride: 0.25, on_the_way: 4, at_most: 24, settled: 1e-6 };
/// How a probe does: strides in radii. Points that come into contact make its force jump at first,
/// and it has more rounding.
const PROBE: Pace = Pace { stride: 0.01, on_the_way: 1, at_most: 48, settled: 5e-4 };
/// How a blade does: strides in mean link lengths. It waits for the cells behind it to split.
const BLADE: Pace = Pace { stride: 0.05, on_the_way: 1, at_most: 24, settled: 2e-3 };
/// Time of the tick in which the tool makes its step, before which nothing relaxes
/// [dimensionless time].
const AT_ONCE: f32 = 1e-6;
/// Sweeps a tick in time: so many for every Euler-bound root, and at least.
const SWEEPS_PER_ROOT: f32 = 6.0;
const SWEEPS_MIN: f32 = 24.0;
/// Moves of the tool between two rows of a path that are apart.
const PATH_MOVES: f64 = 4.0;
/// Longest time a tick advances [dimensionless time].
const TICK_TIME_MAX: f64 = 50.0;

/// How a tool goes from one equilibrium to the next.
struct Pace {
    /// Longest move between two states.
    stride: f64,
    /// Ticks at a state on the way.
    on_the_way: usize,
    /// Most ticks at an equilibrium that is asked for.
    at_most: usize,
    /// A force or energy that changes by less than this fraction in a tick has settled.
    settled: f32,
}

/// Values at every number of every target.
pub type Predicted = Vec<Vec<f64>>;

/// Bakes the body with parameters.
pub fn image(bench: &Bench<'_>, parameters: &Parameters) -> Result<ImageBytes> {
    let whole = bench.groups.len() == 1 && bench.groups[0].nodes.len() == bench.mesh.nodes_m.len();
    let per_cell = |base: &[f64], of_group: &[f64]| {
        if let (true, [value]) = (whole, of_group) {
            return PerCell::Uniform(*value);
        }
        let mut values = base.to_vec();
        for (group, &value) in bench.groups.iter().zip(of_group) {
            for &node in &group.nodes {
                values[node as usize] = value;
            }
        }
        PerCell::Each(values)
    };
    let mut options = bench.options.clone();
    if let Some(tissue) = &mut options.tissue {
        tissue.young_pa = per_cell(&bench.base(&tissue.young_pa), &parameters.young_pa);
        tissue.stiffening.clone_from(&parameters.stiffening);
        if let Some(cuttable) = options.cuttable.as_mut().filter(|_| bench.wanted.toughness) {
            cuttable.toughness_j_per_m2 = PerCell::Uniform(parameters.toughness_j_per_m2);
        }
    } else {
        let stiffness = bench.base(&options.stiffness_n_per_m);
        options.stiffness_n_per_m = per_cell(&stiffness, &parameters.stiffness_n_per_m);
        options.alpha = per_cell(&bench.base(&options.alpha), &parameters.alpha);
    }
    bake(&bench.mesh_of(parameters), bench.fixed, &options)
}

/// What the targets would have measured on a body with these parameters. Pure: the same bits for
/// the same arguments. Cost: a bake, some hundred sweeps for each displacement, some ten for each
/// moment.
pub fn predict(bench: &Bench<'_>, parameters: &Parameters) -> Result<Predicted> {
    let image = image(bench, parameters)?;
    let model = Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
    let mut found = vec![Vec::new(); bench.targets.len()];
    for direction in directions(bench) {
        let along = |target: &Target| target.direction.unwrap_or(bench.direction) == direction;
        let targets = || bench.targets.iter().filter(|target| along(target));
        let line = Line { bench, direction, offset_m: parameters.offset_m };
        let equilibria = Equilibria::follow(line, targets(), &model)?;
        for (found, target) in found.iter_mut().zip(bench.targets).filter(|(_, of)| along(of)) {
            let (depths_m, first_m) = (&target.displacement_m, target.displacement_m[0]);
            let path = |start_m: f64, depth_m: &dyn Fn(usize) -> f64| {
                let rows = target.time_s.iter().enumerate().map(|(row, &t)| (t, depth_m(row)));
                follow_path(line, &model, parameters.time_constant_s, start_m, rows)
            };
            *found = match target.kind {
                Kind::Press => depths_m.iter().map(|&d| equilibria.force_n(d)).collect(),
                Kind::Field => equilibria.field(first_m, &target.nodes),
                Kind::Relaxation => path(first_m, &|_| first_m)?,
                Kind::Path => path(0.0, &|row| depths_m[row])?,
            };
        }
    }
    Ok(found)
}

/// The directions of all targets, each once.
fn directions(bench: &Bench<'_>) -> Vec<[f64; 3]> {
    let mut all: Vec<[f64; 3]> = Vec::new();
    for target in bench.targets {
        let direction = target.direction.unwrap_or(bench.direction);
        if !all.contains(&direction) {
            all.push(direction);
        }
    }
    all
}

/// A bench whose tool goes along a direction.
#[derive(Clone, Copy)]
struct Line<'a> {
    bench: &'a Bench<'a>,
    direction: [f64; 3],
    /// Displacement from where a probe meets the surface to its 0 \[m\].
    offset_m: f64,
}

impl Line<'_> {
    /// The tool at a displacement.
    fn sample(&self, depth_m: f64) -> ToolPose {
        self.bench.tool.sample(self.direction, depth_m + self.offset_m)
    }
}

/// Displacements at which an equilibrium is asked for, ascending, those of fields marked.
fn displacements<'a>(targets: impl Iterator<Item = &'a Target>) -> Vec<(f64, bool)> {
    let mut wanted: BTreeMap<u64, bool> = BTreeMap::new();
    for target in targets {
        // The bits of positive numbers ascend as they do.
        let bits = target.displacement_m.iter().map(|d| d.abs().to_bits());
        match target.kind {
            Kind::Press => bits.for_each(|bits| {
                wanted.entry(bits).or_default();
            }),
            Kind::Field => wanted.extend(bits.map(|bits| (bits, true))),
            Kind::Relaxation | Kind::Path => {}
        }
    }
    wanted.into_iter().map(|(bits, field)| (f64::from_bits(bits), field)).collect()
}

/// Equilibria of a growing press.
struct Equilibria {
    /// Force along the direction by the bits of the displacement \[N\].
    force_n: BTreeMap<u64, f64>,
    /// Displacements by input node, for fields \[m\].
    fields: BTreeMap<u64, BTreeMap<u32, [f64; 3]>>,
}

impl Equilibria {
    fn follow<'a>(
        line: Line<'_>,
        targets: impl Iterator<Item = &'a Target>,
        model: &Model<'_>,
    ) -> Result<Self> {
        let mut found = Self { force_n: BTreeMap::new(), fields: BTreeMap::new() };
        let wanted = displacements(targets);
        if wanted.is_empty() {
            return Ok(found);
        }
        let mut press = Press::new(line, *model, Scheme::Track, SWEEPS)?;
        let mut at_m = -line.offset_m;
        for (depth_m, field) in wanted {
            let stride_m = match line.bench.tool {
                Tool::Held(_) => HELD.stride * f64::from(model.unit_m()),
                Tool::Probe { radius_m, .. } => PROBE.stride * radius_m,
                Tool::Blade(..) => BLADE.stride * f64::from(model.unit_m()),
            };
            let strides = ((depth_m - at_m) / stride_m).ceil().max(1.0);
            for stride in 1..=strides as usize {
                let part = stride as f64 / strides;
                let force_n = press.settle(at_m + part * (depth_m - at_m), part == 1.0)?;
                found.force_n.insert(depth_m.to_bits(), force_n);
            }
            at_m = depth_m;
            if field {
                found.fields.insert(depth_m.to_bits(), press.field());
            }
        }
        Ok(found)
    }

    fn force_n(&self, displacement_m: f64) -> f64 {
        self.force_n.get(&displacement_m.abs().to_bits()).copied().unwrap_or(f64::NAN)
    }

    fn field(&self, displacement_m: f64, nodes: &[u32]) -> Vec<f64> {
        let field = self.fields.get(&displacement_m.to_bits());
        let of = |node| field.and_then(|field| field.get(node)).copied().unwrap_or([f64::NAN; 3]);
        nodes.iter().flat_map(of).collect()
    }
}

/// The tool on a body.
struct Press<'a, 'm> {
    line: Line<'a>,
    engine: Engine<'m>,
}

impl<'a, 'm> Press<'a, 'm> {
    /// In contact, at rest.
    fn new(line: Line<'a>, model: Model<'m>, scheme: Scheme, sweeps: u16) -> Result<Self> {
        let contact = line.bench.tool.contact();
        let variant = Variant::plain(scheme, Arithmetic::F32);
        let mut engine = variant.unlimited(model, contact, sweeps, |settings| Settings {
            tick_time: AT_ONCE,
            ..settings
        })?;
        engine.tick(&line.sample(-line.offset_m));
        Ok(Self { line, engine })
    }

    /// One tick with the tool at a depth: force along the direction \[N\], energy \[J\], flags.
    fn tick(&mut self, depth_m: f64) -> (f32, f32, Flags) {
        let output = self.engine.tick(&self.line.sample(depth_m));
        let along = dot(output.force_n.map(f64::from).into(), self.line.direction);
        (-along as f32, output.energy_j, output.flags)
    }

    /// The force of a tick in which the tool reaches its depth \[N\].
    fn unclamped(&mut self, depth_m: f64) -> Result<f32> {
        let (force, _, flags) = self.tick(depth_m);
        if flags.contains(Flags::MOTION_CLAMPED) { Err(beyond(depth_m)) } else { Ok(force) }
    }

    /// Ticks until the force is that of the equilibrium \[N\]; on the way there a few suffice.
    fn settle(&mut self, depth_m: f64, to_the_end: bool) -> Result<f64> {
        let (mut last, mut calm, mut clamped) = (f32::NAN, 0, false);
        let mut last_energy = f32::NAN;
        let pace = match self.line.bench.tool {
            Tool::Held(_) => HELD,
            Tool::Probe { .. } => PROBE,
            Tool::Blade(..) => BLADE,
        };
        let most = if to_the_end { pace.at_most } else { pace.on_the_way };
        for _ in 0..most {
            interrupt::check()?;
            let (force, energy, flags) = self.tick(depth_m);
            clamped = flags.contains(Flags::MOTION_CLAMPED);
            let still = (force - last).abs() <= pace.settled * force.abs()
                && (last_energy - energy).abs() <= pace.settled * energy;
            // A probe or blade without a force may be about to touch.
            let touches = force != 0.0 || matches!(self.line.bench.tool, Tool::Held(_));
            calm = if still && touches && !clamped { calm + 1 } else { 0 };
            (last, last_energy) = (force, energy);
            if calm >= CALM_TICKS {
                break;
            }
        }
        if clamped && to_the_end { Err(beyond(depth_m)) } else { Ok(f64::from(last)) }
    }

    /// Displacements by input node \[m\].
    fn field(&mut self) -> BTreeMap<u32, [f64; 3]> {
        let positions = self.engine.positions_m();
        let nodes_m = &self.line.bench.mesh.nodes_m;
        let ids = self.engine.network().model().input_id();
        let moved = |(&id, at): (&u32, &[f64; 3])| (id, minus(*at, nodes_m[id as usize]));
        ids.iter().zip(&positions).map(moved).collect()
    }

    /// From the next tick on a tick advances by so much [dimensionless time].
    fn advance_by(&mut self, time: f64) -> Result<()> {
        let (model, settings) = (self.engine.network().model(), self.engine.network().settings());
        let roots = (time / f64::from(model.step_max())).sqrt() as f32;
        let sweeps = (SWEEPS_MIN + SWEEPS_PER_ROOT * roots) as u16;
        self.engine.choose(Settings { sweeps, tick_time: time as f32, ..*settings })
    }
}

/// Force along the direction at each time and displacement of a path, from rest at t = 0 on, when the
/// tool makes a step to `start_m` \[N\].
fn follow_path(
    line: Line<'_>,
    model: &Model<'_>,
    time_constant_s: f64,
    start_m: f64,
    path: impl Iterator<Item = (f64, f64)>,
) -> Result<Vec<f64>> {
    let mut press = Press::new(line, *model, Scheme::Rkl2, SWEEPS)?;
    let (mut at_s, mut at_m, mut force) = (0.0, 0.0, 0.0);
    let mut forces = Vec::new();
    if start_m != 0.0 {
        (at_m, force) = (start_m, press.unclamped(start_m)?);
    }
    for (t, depth_m) in path {
        let span = (t - at_s) / time_constant_s;
        let moves = if depth_m == at_m { 1.0 } else { PATH_MOVES };
        // A body that has come to rest stays there.
        let ticks = (span / TICK_TIME_MAX).ceil().clamp(moves, 200.0);
        if span > 0.0 {
            press.advance_by((span / ticks).min(TICK_TIME_MAX))?;
        }
        if span > 0.0 || depth_m != at_m {
            for tick in 1..=ticks as usize {
                interrupt::check()?;
                force = press.unclamped(at_m + (depth_m - at_m) * tick as f64 / ticks)?;
            }
        }
        (at_s, at_m) = (t, depth_m);
        forces.push(f64::from(force));
    }
    Ok(forces)
}

fn beyond(depth_m: f64) -> Error {
    Error::input(format!(
        "a displacement of {depth_m} m loads the body with more than --energy-max-j allows; check \
         the unit of the displacement, or raise it"
    ))
}
