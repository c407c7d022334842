//! What a sweep buys: error of the force at few sweeps a tick beside the time of the tick, for held
//! cells and for a ball on a contact surface that is pressed, slides and trembles. The reference is the
//! same body under the same motion with [`MANY`] sweeps a tick.

use chaincell_kernel::{Flags, Model, ToolPose};
use nalgebra::Vector3;
use serde::Serialize;
use serde_json::json;

use super::motions::Motion;
use super::pictures::{Point, figures};
use super::scene::{Scene, Source};
use crate::bodies::Variant;
use crate::experiments::page::table::{Table, csv, percent, us};
use crate::experiments::page::{Context, Numbers, Section};
use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ORGAN_YOUNG_PA, PerCell};
use chaincell_host::cli::session::press;
use chaincell_host::engine::contact::automatic;
use chaincell_host::engine::convergence::{Errors, MANY};
use chaincell_host::engine::place::place;
use chaincell_host::engine::{Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::session::timing::histogram::{Latencies, Summary};
use chaincell_host::words::counted;

/// Poisson's ratios of the bodies of nodal shapes; none for links.
const MATERIALS: [Option<f64>; 4] = [Some(0.3), Some(0.45), Some(0.49), None];
const QUICK_MATERIALS: [Option<f64>; 2] = [Some(0.45), None];
/// Sweeps a tick that are measured.
const SWEEPS: [u16; 3] = [1, 2, 4];
/// Radius of the ball \[m\].
const RADIUS_M: f32 = 0.012;
/// Cells of the organ, unless given.
const CELLS: usize = 1000;
const QUICK_CELLS: usize = 300;

/// What a tool does to a body.
#[derive(Debug, Clone, Copy)]
pub struct Task {
    /// Whether it holds cells; otherwise it is a ball.
    holds: bool,
    path: Path,
}

#[derive(Debug, Clone, Copy)]
enum Path {
    /// A motion from the place where the tool touches.
    Motion(Motion),
    /// The built-in press, with its retreat; of its default depth without one.
    ThereAndBack { depth_m: Option<f64>, ticks: u64 },
}

const SLOW: Path = Path::Motion(Motion::Press { from_mm: 0.0, to_mm: 10.0, press_s: 0.3 });
const TASKS: [Task; 5] = [
    Task::HELD_PRESS,
    Task::BALL_PRESS,
    Task {
        holds: false,
        path: Path::Motion(Motion::Press { from_mm: -20.0, to_mm: 23.0, press_s: 0.15 }),
    },
    Task { holds: false, path: Path::Motion(Motion::Slide) },
    Task { holds: false, path: Path::ThereAndBack { depth_m: Some(0.043), ticks: 1000 } },
];
/// How many of them the quick form has.
const QUICK_TASKS: usize = 2;

/// A body under a tool with a number of sweeps a tick; errors are shares of the reference's largest force.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SweepRow {
    /// Its cells.
    pub cells: usize,
    /// Nodal shapes with their Poisson's ratio, or links.
    pub material: String,
    /// What the tool does.
    pub tool: String,
    /// Largest force of the reference \[N\].
    pub peak_n: f64,
    /// Sweeps a tick.
    pub sweeps: u16,
    /// Half of the ticks in which a force acts are within.
    pub median: f64,
    /// Nine of ten are.
    pub p90: f64,
    /// All are.
    pub largest: f64,
    /// Ticks in which the guard discarded a pass.
    pub rolled_back: usize,
    /// A tick of the motion.
    pub tick_ns: Summary,
    /// Its median over the time of a pass in the same run.
    pub passes: f64,
}

/// Forces and times of a motion.
struct Played {
    forces_n: Vec<Vector3<f64>>,
    tick_ns: Summary,
    rolled_back: usize,
}

/// What tables call this material.
pub(super) fn words(material: Option<f64>) -> String {
    material.map_or_else(|| "links".to_owned(), |poisson| format!("shapes, nu {poisson}"))
}

/// The generated organ of about so many `cells`: nodal shapes of this Poisson's ratio, or links.
///
/// # Errors
/// As the generator.
pub fn body(cells: usize, material: Option<f64>) -> Result<Scene> {
    let of = PerCell::Uniform;
    let tissue = material.map(|poisson| Tissue::new(of(ORGAN_YOUNG_PA), of(poisson)));
    Source::organ(Some(cells))?.bake(&BakeOptions { tissue, ..BakeOptions::default() })
}

impl Task {
    /// Cells that a tool holds, pressed in by 10 mm in 300 ms, then held there.
    pub const HELD_PRESS: Self = Self { holds: true, path: SLOW };
    /// Cells that a tool holds by default, pressed as `cosim` does.
    pub const DEFAULT_PRESS: Self =
        Self { holds: true, path: Path::ThereAndBack { depth_m: None, ticks: 2000 } };
    /// The press of held cells by a ball that touches the surface at first.
    pub const BALL_PRESS: Self = Self { holds: false, path: SLOW };

    /// What it is, for tables.
    #[must_use]
    pub fn words(self) -> String {
        let tool = if self.holds { "held cells" } else { "ball" };
        match self.path {
            Path::Motion(motion) => format!("{tool}, {}", motion.words()),
            Path::ThereAndBack { depth_m, ticks } => {
                let depth = depth_m.map_or_else(
                    || "the default press".to_owned(),
                    |depth_m| format!("{:.0} mm", 1e3 * depth_m),
                );
                format!("{tool}, {depth} and back in {:.0} s", 1e-3 * ticks as f64)
            }
        }
    }

    /// The body at rest under the tool, with so many `sweeps` a tick.
    ///
    /// # Errors
    /// A body that the tool cannot hold or touch.
    pub fn engine(self, model: Model<'_>, sweeps: u16) -> Result<Engine<'_>> {
        let contact = match self.holds {
            true => Contact::Cells(automatic(&model)?),
            false => Contact::sphere(RADIUS_M, 0.0),
        };
        let variant = Variant::single(Scheme::Predict, true);
        variant.unlimited(model, contact, sweeps, |settings| settings)
    }

    /// The tool tick by tick.
    ///
    /// # Errors
    /// As the built-in press.
    pub fn poses(self, engine: &Engine<'_>) -> Result<Vec<ToolPose>> {
        match self.path {
            Path::ThereAndBack { depth_m, ticks } => {
                Ok(press(engine, depth_m, ticks)?.into_iter().map(ToolPose::from).collect())
            }
            Path::Motion(motion) => {
                let place = place(engine.network().model(), engine.contact(), None)?;
                let touch_m = Vector3::from(place.touch_m);
                let pose = |tick| {
                    let step_m = motion.sample(tick, place.direction).position_m.cast::<f64>();
                    ToolPose::at((touch_m + step_m).cast(), 1)
                };
                Ok((0..=motion.ticks()).map(pose).collect())
            }
        }
    }

    fn play(self, scene: &Scene, poses: &[ToolPose], sweeps: u16) -> Result<Played> {
        let mut engine = self.engine(scene.model()?, sweeps)?;
        let (mut forces_n, mut times, mut rolled_back) = (Vec::new(), Latencies::new()?, 0);
        for pose in poses {
            interrupt::check()?;
            let output = times.time(|| engine.tick(pose));
            rolled_back += usize::from(output.flags.contains(Flags::ROLLED_BACK));
            forces_n.push(output.force_n.map(f64::from));
        }
        Ok(Played { forces_n, tick_ns: times.summary(), rolled_back })
    }

    /// The task with each number of `sweeps`, against the same with `many`; `material` as in tables.
    ///
    /// # Errors
    /// As [`Self::engine`]; a tool that touches nothing.
    pub fn rows(
        self,
        scene: &Scene,
        material: &str,
        sweeps: &[u16],
        many: u16,
    ) -> Result<Vec<SweepRow>> {
        let poses = self.poses(&self.engine(scene.model()?, 1)?)?;
        let exact = self.play(scene, &poses, many)?;
        let peak_n = exact.forces_n.iter().map(|force| force.norm()).fold(0.0, f64::max);
        let mut rows = Vec::new();
        for &sweeps in sweeps {
            let Played { forces_n, tick_ns, rolled_back } = self.play(scene, &poses, sweeps)?;
            let [median, p90, largest] = errors(&forces_n, &exact.forces_n, peak_n)?;
            // A pass is what each sweep more takes.
            let more = f64::from(many - sweeps);
            let pass_ns = (exact.tick_ns.p50 as f64 - tick_ns.p50 as f64) / more;
            let passes = tick_ns.p50 as f64 / pass_ns.max(1.0);
            let (cells, material) = (scene.model()?.cells(), material.to_owned());
            let tool = self.words();
            rows.push(SweepRow {
                cells,
                material,
                tool,
                peak_n,
                sweeps,
                median,
                p90,
                largest,
                rolled_back,
                tick_ns,
                passes,
            });
        }
        Ok(rows)
    }
}

/// Median, ninth decile and largest error of the ticks in which a force acts.
fn errors(forces_n: &[Vector3<f64>], exact: &[Vector3<f64>], peak_n: f64) -> Result<[f64; 3]> {
    let pairs = forces_n.iter().zip(exact);
    let pairs = pairs.filter(|(force, exact)| force.norm() + exact.norm() > 0.0);
    let errors = Errors::of(pairs.map(|(force, exact)| (force - exact).norm() / peak_n))
        .ok_or_else(|| Error::input("the tool touches nothing: press deeper"))?;
    Ok([50, 90, 100].map(|percent| errors.within(percent)))
}

/// Every body under every motion.
pub(crate) fn section(context: &Context) -> Result<Section> {
    let (materials, tasks, cells) = match context.quick {
        true => (&QUICK_MATERIALS[..], &TASKS[..QUICK_TASKS], QUICK_CELLS),
        false => (&MATERIALS[..], &TASKS[..], CELLS),
    };
    let mut rows = Vec::new();
    for &material in materials {
        let scene = body(context.cells.unwrap_or(cells), material)?;
        for task in tasks {
            rows.extend(task.rows(&scene, &words(material), &SWEEPS, MANY)?);
        }
    }
    // A chart for each motion.
    let shown = rows.iter().map(|row| Point {
        motion: &row.tool,
        line: row.material.clone(),
        tick_ns: row.tick_ns.p50,
        error: row.p90,
    });
    let measure = "nine of ten ticks within this";
    let figures = figures("sweeps", measure, &shown.collect::<Vec<_>>())?;
    let caption =
        "Error of the force in % of its peak: median, 90 % of the ticks, largest".to_owned();
    Ok(Section {
        key: "sweeps",
        title: "What a sweep buys".to_owned(),
        text: vec![text(&rows)],
        figures,
        tables: vec![(caption, table(&rows))],
        numbers: vec![Numbers { name: "sweeps".to_owned(), csv: csv(&rows) }],
        json: json!(rows),
        ..Section::default()
    })
}

fn text(rows: &[SweepRow]) -> String {
    format!(
        "Cells that a tool holds, and a ball of {:.0} mm on the contact surface, under `predict` at 1 kHz, \
         on a generated organ of {}: nodal shapes of {:.0} kPa, and links as the bake makes them. The \
         reference is the same motion with {} a tick; errors are shares of its largest force, over the ticks \
         in which a force acts. A pass is what each sweep more takes: the ratio of tick and pass depends \
         less on the machine than their times. {}",
        1e3 * RADIUS_M,
        counted(rows.first().map_or(0, |row| row.cells), "cell"),
        1e-3 * ORGAN_YOUNG_PA,
        counted(MANY, "sweep"),
        Motion::SLIDES
    )
}

/// A line for each motion of a body.
fn table(rows: &[SweepRow]) -> Table {
    let error = |row: &SweepRow| {
        format!("{}, {}, {}", percent(row.median), percent(row.p90), percent(row.largest))
    };
    let motions: Vec<&[SweepRow]> = rows.chunks(SWEEPS.len()).collect();
    let first = |of: &[SweepRow]| of.first().cloned();
    let mut columns = Table::of(motions.iter())
        .column("of", |of| first(of).map_or_else(String::new, |row| row.material))
        .column("tool", |of| first(of).map_or_else(String::new, |row| row.tool))
        .column("peak [N]", |of| {
            first(of).map_or(String::new(), |row| format!("{:.3}", row.peak_n))
        });
    for (at, sweeps) in SWEEPS.into_iter().enumerate() {
        columns = columns
            .column(&counted(sweeps, "sweep"), |of| of.get(at).map_or_else(String::new, error));
    }
    columns
        .column("tick of one sweep [us]", |of| {
            first(of).map_or_else(String::new, |row| us(row.tick_ns.p50))
        })
        .column("in passes", |of| {
            first(of).map_or_else(String::new, |row| format!("{:.1}", row.passes))
        })
        .table()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sweep holds the force of a moving tool, and two are nearer to many: the errors are those of forces
    /// and not of a motion against itself.
    #[test]
    fn a_second_sweep_buys_a_smaller_error() {
        let scene = body(600, Some(0.45)).unwrap();
        for task in [TASKS[1], TASKS[2]] {
            let rows = task.rows(&scene, "shapes", &[1, 2], 24).unwrap();
            let (one, two) = (&rows[0], &rows[1]);
            assert!(1e-4 < one.median && one.median < 0.02 && one.p90 < 0.10, "{one:?}");
            assert!(0.0 < two.median && two.median < 0.005 && two.p90 < 0.03, "{two:?}");
            assert!(one.median < one.p90 && one.p90 < one.largest && one.peak_n > 0.1, "{one:?}");
            assert!(two.p90 < one.p90, "{one:?} {two:?}");
        }
    }
}
