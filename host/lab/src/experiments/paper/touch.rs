//! The body of Fig. 6 as nodal shapes under the same probe, which meets the triangles of its surface.

use chaincell_kernel::{Model, Settings, ToolPose, Unloading};
use serde_json::{Value, json};

use super::press::{Pressed, Probe, pressed};
use crate::bodies::Variant;
use crate::charts::plot::{Axis, Chart, Style};
use crate::experiments::report::scene::Scene;
use crate::reference::vectors::{dot, minus, norm};
use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, ProbeContact, bake};
use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::{Arithmetic, Contact, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::mesh::Mesh;

/// The tissue.
pub const YOUNG_PA: f64 = 5000.0;
pub const POISSON: f64 = 0.45;
/// Depths at which the settled force is found.
const DEPTHS: usize = 10;
/// Sweeps between two looks at the force, looks at most, and the change of a force that is settled.
const SWEEPS: u16 = 16;
const LOOKS_MAX: usize = 60;
const SETTLED: f64 = 1e-5;

/// The force at a depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Felt {
    /// How far the probe has come since its first touch \[m\].
    pub depth_m: f64,
    /// Force on it as it passed \[N\].
    pub force_n: f64,
    /// Force once the body is at rest there \[N\].
    pub settled_n: f64,
}

impl Felt {
    /// How far the force is off the settled one, a part of it.
    #[must_use]
    pub fn error(&self) -> f64 {
        (self.force_n - self.settled_n).abs() / self.settled_n.max(1e-12)
    }
}

/// The body under the probe.
pub struct Touched {
    /// The press tick by tick.
    pub pressed: Pressed,
    /// The way in, depth by depth.
    pub felt: Vec<Felt>,
    /// Every tick of the way in: depth \[mm\] and force \[N\].
    curve: Vec<[f64; 2]>,
}

impl Touched {
    /// Presses the body of a scene.
    ///
    /// # Errors
    /// As the bake and the engine; the user's wish to stop.
    pub fn new(scene: &Scene, mesh: &Mesh, probe: &Probe) -> Result<Self> {
        let links = scene.model()?;
        let id = |cell: &u16| links.input_id().get(usize::from(*cell)).copied();
        let mut fixed: Vec<u32> = links.fixed().iter().filter_map(id).collect();
        fixed.sort_unstable();
        let tissue = Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(POISSON));
        let probe_contact = ProbeContact::Surface;
        let options = BakeOptions { tissue: Some(tissue), probe_contact, ..BakeOptions::default() };
        let image = bake(mesh, &fixed, &options)?;
        let pressed = pressed(parse(&image)?, variant(), probe)?;
        let [_, touch] = probe.centres_m();
        let depth = |pose: &Pose| {
            let way = minus(pose.position_m.map(f64::from), touch);
            dot(way, scene.direction)
        };
        let depths: Vec<f64> = probe.poses.iter().map(depth).collect();
        let most = depths.iter().copied().fold(0.0, f64::max);
        let first = |part: f64| depths.iter().position(|&depth| depth >= part * most);
        let end = first(0.999).unwrap_or(0);
        let shares = (1..=DEPTHS).map(|at| 0.999 * at as f64 / DEPTHS as f64);
        let ticks: Vec<usize> = shares.filter_map(first).collect();
        let settled_n = settled(parse(&image)?, probe, &ticks)?;
        let felt = ticks.iter().zip(settled_n).map(|(&tick, settled_n)| Felt {
            depth_m: depths[tick],
            force_n: pressed.force_n[tick],
            settled_n,
        });
        let felt = felt.collect();
        let way_in = depths.iter().zip(&pressed.force_n).take(end + 1);
        let way_in = way_in.filter(|(depth, _)| **depth >= 0.0);
        let curve = way_in.map(|(depth_m, force_n)| [1e3 * depth_m, *force_n]).collect();
        Ok(Self { pressed, felt, curve })
    }

    /// Largest error of the force and that in the median, parts of the settled force.
    #[must_use]
    pub fn errors(&self) -> [f64; 2] {
        let mut errors: Vec<f64> = self.felt.iter().map(Felt::error).collect();
        errors.sort_unstable_by(f64::total_cmp);
        let median = errors.get(errors.len() / 2).copied().unwrap_or_default();
        [errors.last().copied().unwrap_or_default(), median]
    }

    /// Force over displacement.
    #[must_use]
    pub fn chart(&self) -> Chart {
        let settled: Vec<[f64; 2]> =
            self.felt.iter().map(|felt| [1e3 * felt.depth_m, felt.settled_n]).collect();
        let [most, median] = self.errors().map(|error| 100.0 * error);
        let label = format!("as it passes, off by {median:.2} % (median), {most:.2} % (most)");
        let (x, y) = (Axis::linear("displacement [mm]"), Axis::linear("force [N]"));
        Chart::new("Force on the probe of nodal shapes", x, y)
            .series(&label, Style::Line, &self.curve)
            .series("at rest", Style::Markers, &settled)
    }

    /// The rows behind the chart.
    #[must_use]
    pub fn csv(&self) -> String {
        let mut csv = String::from("depth_m,force_n,settled_n\n");
        for Felt { depth_m, force_n, settled_n } in &self.felt {
            csv += &format!("{depth_m:?},{force_n:?},{settled_n:?}\n");
        }
        csv
    }

    /// Its figures.
    #[must_use]
    pub fn json(&self) -> Value {
        let [most, median] = self.errors();
        json!({
            "young_pa": YOUNG_PA,
            "poisson": POISSON,
            "force_max_n": self.pressed.force_n.iter().copied().fold(0.0, f64::max),
            "force_error_max": most,
            "force_error_median": median,
        })
    }
}

fn variant() -> Variant {
    Variant { coarse: true, ..Variant::plain(Scheme::Predict, Arithmetic::F32) }
}

fn parse(image: &ImageBytes) -> Result<Model<'_>> {
    Model::from_bytes(image.as_bytes()).map_err(Error::check)
}

/// The force at the poses of some ticks, held until it stays \[N\].
fn settled(model: Model<'_>, probe: &Probe, ticks: &[usize]) -> Result<Vec<f64>> {
    let contact = Contact::Probe { radius_m: probe.radius_m as f32, capacity: 1 };
    let mut engine = variant().engine(model, contact, SWEEPS, |settings| Settings {
        unloading: Unloading::Off,
        ..settings
    })?;
    let mut forces = Vec::new();
    for pose in ticks.iter().filter_map(|&tick| probe.poses.get(tick)) {
        let mut force = f64::INFINITY;
        for _ in 0..LOOKS_MAX {
            interrupt::check()?;
            let before = force;
            let output = engine.tick(&ToolPose::from(*pose));
            force = norm(output.force_n.map(f64::from).into());
            if (force - before).abs() <= SETTLED * force {
                break;
            }
        }
        forces.push(force);
    }
    Ok(forces)
}
