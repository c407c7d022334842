//! A tool that is pressed into a contact surface and drawn over it: error of the force against time
//! of a tick. The reference is the same body under the same tool with many more sweeps a tick.

use chaincell_kernel::{Flags, Model, Network, Settings, ToolPart, ToolPose, Unloading};
use nalgebra::Vector3;
use serde::Serialize;
use serde_json::json;

use super::pictures::{Point, figures};
use crate::experiments::page::table::{Table, csv, percent, us};
use crate::experiments::page::{Context, Numbers, Section};
use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
use chaincell_host::cli::session::press;
use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_host::session::timing::histogram::{Latencies, Summary};
use chaincell_host::words::counted;

/// Young's modulus and Poisson's ratio of the shapes: those of a liver.
const YOUNG_PA: f64 = 5000.0;
const POISSON: f64 = 0.45;
/// Sweeps a tick that are measured, and those of the reference.
const SWEEPS: [u16; 4] = [1, 2, 4, 8];
const REFERENCE_SWEEPS: u16 = 48;

/// What a body is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Material {
    Shapes,
    Links,
}

/// A body of the report, and which of the [`tasks`] it goes through.
struct Body {
    mesh: &'static str,
    material: Material,
    tasks: &'static [usize],
}

const BODIES: [Body; 3] = [
    Body { mesh: "organ:1000", material: Material::Shapes, tasks: &[0, 1, 2, 3, 4, 5, 6] },
    Body { mesh: "organ:1000", material: Material::Links, tasks: &[1, 2, 4] },
    Body { mesh: "organ", material: Material::Shapes, tasks: &[0, 1, 4] },
];
const QUICK: [Body; 2] = [
    Body { mesh: "organ:300", material: Material::Shapes, tasks: &[1, 5] },
    Body { mesh: "organ:300", material: Material::Links, tasks: &[1] },
];

/// What a tool does: pressed to a depth in so many ticks, then drawn aside while it holds.
#[derive(Clone)]
struct Task {
    name: &'static str,
    parts: Vec<ToolPart>,
    depth_m: f64,
    aside_m: f64,
    ticks: u64,
}

fn tasks() -> Vec<Task> {
    let task = |name, part, [depth_m, aside_m]: [f64; 2], ticks| {
        let parts = vec![part];
        Task { name, parts, depth_m, aside_m, ticks }
    };
    let (large, small) = (ToolPart::sphere(0.012), ToolPart::sphere(0.004));
    let rounded = ToolPart::rounded_box([0.006; 3], 0.004);
    vec![
        task("ball of 12 mm", large, [0.043, 0.0], 1000),
        task("ball of 12 mm", large, [0.010, 0.0], 1000),
        task("ball of 12 mm", large, [0.023, 0.0], 300),
        task("ball of 4 mm", small, [0.006, 0.0], 1000),
        task("ball of 12 mm", large, [0.006, 0.03], 1000),
        task("capsule", ToolPart::capsule(0.01, 0.006), [0.010, 0.0], 1000),
        task("rounded box", rounded, [0.008, 0.0], 1000),
    ]
}

/// A tool on a body with a number of sweeps a tick; errors are shares of the reference's largest
/// force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ToolRow {
    /// Generator of the body.
    pub body: &'static str,
    /// Its cells.
    pub cells: usize,
    /// Nodal shapes or links.
    pub material: &'static str,
    /// What the tool does.
    pub tool: String,
    /// Largest force of the reference \[N\].
    pub peak_n: f64,
    /// Sweeps a tick.
    pub sweeps: u16,
    /// A tick of the motion.
    pub tick_ns: Summary,
    /// Half of the ticks in contact are below.
    pub median: f64,
    /// Nine of ten are.
    pub p90: f64,
    /// Of all ticks.
    pub largest: f64,
    /// Ticks in which the guard discarded a pass.
    pub rolled_back: usize,
}

/// What a motion gave.
struct Played {
    forces_n: Vec<Vector3<f64>>,
    tick_ns: Summary,
    rolled_back: usize,
}

impl Body {
    fn image(&self) -> Result<ImageBytes> {
        let mesh = load(self.mesh, &MeshOptions::default())?;
        let shapes = Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(POISSON));
        let tissue = (self.material == Material::Shapes).then_some(shapes);
        let options = BakeOptions { tissue, ..BakeOptions::default() };
        bake(&mesh, &mesh.default_fixed, &options)
    }

    /// A task with each number of sweeps beside its reference of `reference` sweeps.
    fn rows(&self, image: &ImageBytes, task: &Task, reference: u16) -> Result<Vec<ToolRow>> {
        let model = Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
        let poses = task.poses(&task.engine(model, 1)?)?;
        let exact = task.play(model, &poses, reference)?;
        let peak_n = exact.forces_n.iter().map(|force| force.norm()).fold(0.0, f64::max);
        let row = |sweeps| {
            let played = task.play(model, &poses, sweeps)?;
            let [median, p90, largest] = errors(&played.forces_n, &exact.forces_n, peak_n)?;
            Ok(ToolRow {
                body: self.mesh,
                cells: model.cells(),
                material: if model.is_nodal() { "nodal shapes" } else { "links" },
                tool: task.words(),
                peak_n,
                sweeps,
                tick_ns: played.tick_ns,
                median,
                p90,
                largest,
                rolled_back: played.rolled_back,
            })
        };
        SWEEPS.into_iter().map(row).collect()
    }
}

/// Median, ninth decile and largest error of the ticks in which a force acts.
fn errors(forces_n: &[Vector3<f64>], exact: &[Vector3<f64>], peak_n: f64) -> Result<[f64; 3]> {
    let pairs = forces_n.iter().zip(exact);
    let pairs = pairs.filter(|(force, exact)| force.norm() + exact.norm() > 0.0);
    let mut errors: Vec<f64> =
        pairs.map(|(force, exact)| (force - exact).norm() / peak_n).collect();
    errors.sort_by(f64::total_cmp);
    let Some(&largest) = errors.last() else {
        return Err(Error::input("the tool touches nothing: press deeper"));
    };
    let at = |share: usize| errors[errors.len() * share / 10];
    Ok([at(5), at(9), largest])
}

impl Task {
    fn words(&self) -> String {
        let aside = match self.aside_m {
            0.0 => String::new(),
            aside_m => format!(", drawn by {:.0} mm", 1e3 * aside_m),
        };
        let (depth_mm, seconds) = (1e3 * self.depth_m, 1e-3 * self.ticks as f64);
        format!("{}, {depth_mm:.0} mm deep in {seconds} s{aside}", self.name)
    }

    fn engine<'m>(&self, model: Model<'m>, sweeps: u16) -> Result<Engine<'m>> {
        let (unloading, max_tool_step_m) = (Unloading::Off, 1.0);
        let settings =
            Settings { sweeps, unloading, max_tool_step_m, ..Settings::for_model(&model) };
        let network = Network::new(model, settings).map_err(Error::check)?;
        let contact = Contact::Tools { tools: vec![self.parts.clone()], friction: 0.0 };
        Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact)
    }

    /// The built-in press, the poses of its hold moved aside, steadily, and back with the retreat.
    fn poses(&self, engine: &Engine<'_>) -> Result<Vec<Pose>> {
        let mut poses = press(engine, Some(self.depth_m), self.ticks)?;
        let at = |pose: &Pose| Vector3::from(pose.position_m).cast::<f64>();
        let inward = match (poses.first(), poses.get(poses.len() / 2)) {
            (Some(first), Some(middle)) => (at(middle) - at(first)).normalize(),
            _ => return Ok(poses),
        };
        let aside = inward.cross(&Vector3::ith(inward.iamin(), 1.0)).normalize();
        let count = poses.len() as f64;
        for (tick, pose) in poses.iter_mut().enumerate() {
            // The hold is from 0.4 of the ticks to 0.75.
            let share = ((tick as f64 / count - 0.4) / 0.35).clamp(0.0, 1.0);
            pose.position_m = (at(pose) + self.aside_m * share * aside).cast::<f32>().into();
        }
        Ok(poses)
    }

    fn play(&self, model: Model<'_>, poses: &[Pose], sweeps: u16) -> Result<Played> {
        let mut engine = self.engine(model, sweeps)?;
        let (mut forces_n, mut times, mut rolled_back) = (Vec::new(), Latencies::new()?, 0);
        for pose in poses {
            interrupt::check()?;
            let sample = ToolPose::from(*pose);
            let output = times.time(|| engine.tick(&sample));
            rolled_back += usize::from(output.flags.contains(Flags::ROLLED_BACK));
            forces_n.push(output.force_n.map(f64::from));
        }
        Ok(Played { forces_n, tick_ns: times.summary(), rolled_back })
    }
}

/// Every body under every motion of its list.
pub fn section(context: &Context) -> Result<Section> {
    // Every body under the motions of its list.
    let (tasks, mut rows) = (tasks(), Vec::new());
    for body in if context.quick { &QUICK[..] } else { &BODIES } {
        let image = body.image()?;
        for task in body.tasks.iter().filter_map(|&at| tasks.get(at)) {
            // The quick form takes a third of the time at the same speed.
            let task = match context.quick {
                true => {
                    Task { depth_m: 0.3 * task.depth_m, ticks: 3 * task.ticks / 10, ..task.clone() }
                }
                false => task.clone(),
            };
            rows.extend(body.rows(&image, &task, REFERENCE_SWEEPS)?);
        }
    }
    // A chart for each motion.
    let shown = rows.iter().map(|row| Point {
        motion: &row.tool,
        line: format!("{}, {} cells", row.material, row.cells),
        tick_ns: row.tick_ns.p50,
        error: row.p90,
    });
    let measure = "nine of ten ticks within this";
    let figures = figures("tools", measure, &shown.collect::<Vec<_>>())?;
    let caption = "Tools on a surface: time of a tick and error of the force".to_owned();
    Ok(Section {
        key: "tools",
        title: "A tool that moves".to_owned(),
        text: vec![text()],
        figures,
        tables: vec![(caption, table(&rows))],
        numbers: vec![Numbers { name: "tools".to_owned(), csv: csv(&rows) }],
        json: json!(rows),
        ..Section::default()
    })
}

fn text() -> String {
    format!(
        "Tools on a contact surface under `predict` at 1 kHz, by the built-in press: approach, press, \
         hold with a hand's tremor, retreat. Nodal shapes of {:.0} kPa and a Poisson's ratio of \
         {POISSON}, links as the bake makes them. The reference is the same tool on the same body with \
         {} a tick; errors are in percent of its peak, over the ticks in which a force acts.",
        1e-3 * YOUNG_PA,
        counted(REFERENCE_SWEEPS, "sweep")
    )
}

fn table(rows: &[ToolRow]) -> Table {
    Table::of(rows)
        .column("body", |row| format!("{}, {}", row.body, counted(row.cells, "cell")))
        .column("of", |row| row.material)
        .column("tool", |row| &row.tool)
        .column("peak [N]", |row| format!("{:.3}", row.peak_n))
        .column("sweeps a tick", |row| row.sweeps)
        .column("median tick [us]", |row| us(row.tick_ns.p50))
        .column("force, median error [%]", |row| percent(row.median))
        .column("90 % within [%]", |row| percent(row.p90))
        .column("largest [%]", |row| percent(row.largest))
        .column("ticks with a discarded pass", |row| row.rolled_back)
        .table()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a budget leaves under load: one sweep a tick, under a tool that moves.
    #[test]
    fn one_sweep_holds_the_force_of_a_moving_tool() {
        let body = Body { mesh: "organ:600", material: Material::Shapes, tasks: &[] };
        let image = body.image().unwrap();
        let deep = tasks().swap_remove(0);
        let shallow = Task { depth_m: 0.02, ticks: 500, ..deep.clone() };
        for task in [deep, shallow] {
            let rows = body.rows(&image, &task, 24).unwrap();
            let (one, two) = (&rows[0], &rows[1]);
            assert!(one.median < 0.02 && one.p90 < 0.10, "{one:?}");
            assert!(two.median < 0.005 && two.p90 < 0.03, "{two:?}");
        }
    }
}
