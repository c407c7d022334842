//! The press test under other methods and engines, same links, one thread, one process:
//!
//! ```sh
//! cargo bench -p chaincell-lab --features baselines --bench baselines [-- [--quick] [--json]]
//! ```
//!
//! `--quick`, which `cargo test` in the place of `cargo bench` takes by itself, presses small boxes
//! for fewer steps: the same engines and checks in some seconds, without a time worth reading.
//!
//! Jolt's build script takes a checked prebuilt library from the net; without one it needs CMake
//! 3.20 and a C++ compiler, and some minutes.
//!
//! One cell of a slab and of a block goes down by a tenth of the height in one step and stays;
//! counted are steps and time until the displacement field stays within 5 % (L2 over the cells)
//! and the force on the pressed cell within 1 % of the engine's own converged values. Steps are
//! counted with the one that moves the cell; a step of chaincell is a sweep.
//!
//! Mass-spring dynamics and position-based dynamics are plain loops of this crate
//! ([`chaincell_lab::baseline`]). They, Jolt and rapier give no force on a prescribed particle: theirs
//! is the sum of its link forces, extension times stiffness, at the positions they give. Settings and their reasons stand
//! with the engines. The column `off` says how far an engine's converged field is from
//! chaincell's, the minimum of the links' energy: elasticity that an engine drops shows there.

mod jolt;
mod ours;
mod plain;
mod rapier;
mod scene;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use chaincell_host::error::{Error, Result};
use chaincell_lab::baseline::{Baseline, MassSpring, Xpbd};
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::report::scene::{Scene, Source};
use chaincell_lab::reference::vectors::distance;
use serde::Serialize;

use nalgebra::Vector3;
use scene::Pressed;

/// Field and force count as settled within these parts of the converged values.
const FIELD: f64 = 0.05;
const FORCE: f64 = 0.01;
/// A run whose field still moves by more than this part in its last quarter has not converged.
const DRIFT: f64 = 0.01;
/// An engine whose field is farther than this part from chaincell's was not pressed as it was.
const OFF: f64 = 0.75;

/// How much is done.
#[derive(Clone, Copy)]
struct Effort {
    /// Nodes along the axes of small boxes in the place of slab and block.
    boxes: Option<[[usize; 3]; 2]>,
    /// Steps that are enough to converge.
    ours: usize,
    plain: usize,
    jolt: usize,
    rapier: usize,
    /// A press is timed so often: the median is told.
    repeats: usize,
}

const FULL: Effort =
    Effort { boxes: None, ours: 4000, plain: 6000, jolt: 1500, rapier: 400, repeats: 9 };
const QUICK: Effort = Effort {
    boxes: Some([[15, 12, 4], [9, 8, 7]]),
    ours: 200,
    plain: 1000,
    jolt: 200,
    rapier: 100,
    repeats: 1,
};
/// Spacing of the nodes of a small box \[m\].
const SPACING_M: f64 = 0.005;

/// A body under one engine, at rest until pressed.
pub trait Engine {
    /// The step in which the cell goes down.
    fn press(&mut self) -> Result<()>;
    /// One step.
    fn step(&mut self) -> Result<()>;
    /// Positions in the model's order \[m\].
    fn positions_m(&mut self, out: &mut Vec<[f64; 3]>) -> Result<()>;
    /// Force on the pressed cell, in any unit, where the engine gives it.
    fn force(&mut self) -> Option<Vector3<f64>> {
        None
    }
}

/// One row of the table.
#[derive(Debug, Clone, Serialize)]
struct Row {
    scene: &'static str,
    engine: &'static str,
    cells: usize,
    links: usize,
    /// Median.
    step_ms: f64,
    /// Until the field is settled.
    field_steps: usize,
    field_ms: f64,
    /// Until field and force are.
    steps: usize,
    ms: f64,
    /// `ms` over chaincell's.
    ratio: f64,
    /// Change of the field over the last quarter of the run, of its norm.
    drift: f64,
    /// Distance of the converged field from chaincell's, of that one's norm.
    off: f64,
}

/// A fresh body of an engine.
type Make<'a> = &'a dyn Fn() -> Result<Box<dyn Engine + 'a>>;

/// Presses twice: for the converged values after `steps`, then against them.
fn run(
    scene: &Pressed<'_>,
    engine: &'static str,
    steps: usize,
    repeats: usize,
    make: Make<'_>,
) -> Result<(Row, Vec<[f64; 3]>)> {
    let (converged_m, converged, late_m) = converge(scene, steps, make)?;
    let size = distance(&converged_m, &scene.rest_m);
    let drift = distance(&late_m, &converged_m) / size;
    let mut body = make()?;
    let (mut times_ms, mut now) = (Vec::with_capacity(steps), Vec::new());
    // The last step after which the field, and the force, was outside.
    let mut outside = [0, 0];
    for step in 1..=steps {
        let begin = Instant::now();
        if step == 1 { body.press() } else { body.step() }?;
        times_ms.push(begin.elapsed().as_secs_f64() * 1e3);
        body.positions_m(&mut now)?;
        let field = distance(&now, &converged_m) / size;
        let force = (force(&mut *body, scene, &now) - converged).norm() / converged.norm();
        // A number that is none is outside too.
        if field.is_nan() || field > FIELD {
            outside[0] = step;
        }
        if force.is_nan() || force > FORCE {
            outside[1] = step;
        }
    }
    let [field_steps, force_steps] = outside.map(|step| step + 1);
    let settled = field_steps.max(force_steps);
    if settled > steps || drift.is_nan() || drift > DRIFT {
        return Err(Error::check(format!("{engine}, {}: not converged in {steps}", scene.name)));
    }
    drop(body);
    let [field_ms, ms] = time_ms(make, [field_steps, settled], repeats)?;
    times_ms.sort_by(f64::total_cmp);
    let row = Row {
        scene: scene.name,
        engine,
        cells: scene.rest_m.len(),
        links: scene.links.len(),
        step_ms: times_ms[steps / 2],
        field_steps,
        field_ms,
        steps: settled,
        ms,
        ratio: 1.0,
        drift,
        off: 0.0,
    };
    Ok((row, converged_m))
}

/// Median time of the first `steps` steps, for either number of them \[ms\].
fn time_ms(make: Make<'_>, steps: [usize; 2], repeats: usize) -> Result<[f64; 2]> {
    let mut times = [const { Vec::new() }; 2];
    for _ in 0..repeats {
        for (times, steps) in times.iter_mut().zip(steps) {
            let mut body = make()?;
            let begin = Instant::now();
            body.press()?;
            for _ in 1..steps {
                body.step()?;
            }
            times.push(begin.elapsed().as_secs_f64() * 1e3);
        }
    }
    Ok(times.map(|mut times: Vec<f64>| {
        times.sort_by(f64::total_cmp);
        times[repeats / 2]
    }))
}

/// Positions and force after all steps, and the positions after three quarters of them.
#[allow(clippy::type_complexity, reason = "used once, named above")]
fn converge(
    scene: &Pressed<'_>,
    steps: usize,
    make: Make<'_>,
) -> Result<(Vec<[f64; 3]>, Vector3<f64>, Vec<[f64; 3]>)> {
    let (mut body, mut now, mut late_m) = (make()?, Vec::new(), Vec::new());
    for step in 1..=steps {
        if step == 1 { body.press() } else { body.step() }?;
        if step == steps * 3 / 4 {
            body.positions_m(&mut late_m)?;
        }
    }
    body.positions_m(&mut now)?;
    let force = force(&mut *body, scene, &now);
    Ok((now, force, late_m))
}

fn force(body: &mut dyn Engine, scene: &Pressed<'_>, positions_m: &[[f64; 3]]) -> Vector3<f64> {
    body.force().unwrap_or_else(|| scene.link_force_m(positions_m))
}

/// All engines on one body, chaincell first.
fn measure(scene: &Scene, depth_m: f64, effort: Effort) -> Result<Vec<Row>> {
    let scene = &Pressed::new(scene, depth_m)?;
    let run = |name, steps, make: Make<'_>| run(scene, name, steps, effort.repeats, make);
    let (ours, ours_m) =
        run("chaincell track", effort.ours, &|| Ok(Box::new(ours::Ours::new(scene)?)))?;
    let jolt =
        |name, tuning| run(name, effort.jolt, &|| Ok(Box::new(jolt::Jolt::new(scene, tuning)?)));
    let baselines = [
        run(MassSpring::NAME, effort.plain, &|| {
            Ok(Box::new(plain::Plain::<MassSpring>::new(scene)))
        })?,
        run(Xpbd::NAME, effort.plain, &|| Ok(Box::new(plain::Plain::<Xpbd>::new(scene))))?,
        jolt("Jolt 5.6, XPBD edges, soonest", jolt::SOONEST)?,
        jolt("Jolt 5.6, XPBD edges, elastic", jolt::ELASTIC)?,
        run("rapier3d 0.36, edges", effort.rapier, &|| Ok(Box::new(rapier::Rapier::new(scene)?)))?,
    ];
    let size = distance(&ours_m, &scene.rest_m);
    let (ours_ms, mut rows) = (ours.ms, vec![ours]);
    rows.extend(baselines.into_iter().map(|(row, converged_m)| Row {
        ratio: row.ms / ours_ms,
        off: distance(&converged_m, &ours_m) / size,
        ..row
    }));
    let is_off = |row: &&Row| row.off.is_nan() || row.off > OFF;
    if let Some(Row { engine, scene, off, .. }) = rows.iter().find(is_off) {
        return Err(Error::check(format!("{engine}, {scene}: {off:.2} off the minimum")));
    }
    Ok(rows)
}

/// Slab and block, each with the depth of its press \[m\].
fn scenes(effort: Effort) -> Result<[(Source, f64); 2]> {
    if let Some([slab, block]) = effort.boxes {
        let small = |name, nodes| Source::press_of(name, nodes, SPACING_M);
        return Ok([small("slab", slab)?, small("block", block)?]);
    }
    if let Some(folder) = std::env::var_os("CHAINCELL_REFERENCE").map(PathBuf::from) {
        return Ok([Source::press("slab", &folder)?, Source::press("block", &folder)?]);
    }
    eprintln!("SKIPPED slab and block: CHAINCELL_REFERENCE is not set; boxes of like size");
    let slab = Source::press_of("slab", [45, 32, 4], 0.0037)?;
    Ok([slab, Source::press_of("block", [25, 21, 11], 0.005)?])
}

fn print(row: &Row) {
    println!(
        "{:<6} {:<30} {:>8.3} {:>7} {:>8.2} {:>7} {:>8.2} {:>7.1} {:>7.2} {:>6.0}",
        row.scene,
        row.engine,
        row.step_ms,
        row.field_steps,
        row.field_ms,
        row.steps,
        row.ms,
        row.ratio,
        100.0 * row.drift,
        100.0 * row.off
    );
}

fn run_all() -> Result<()> {
    let has = |name: &str| std::env::args().any(|argument| argument == name);
    let effort = if has("--quick") || !has("--bench") { QUICK } else { FULL };
    let mut rows = Vec::new();
    for (body, depth_m) in scenes(effort)? {
        rows.extend(measure(&body.with_alpha(0.0)?, depth_m, effort)?);
    }
    if has("--json") {
        println!("{}", serde_json::to_string_pretty(&rows).map_err(Error::check)?);
        return Ok(());
    }
    println!(
        "{:<6} {:<30} {:>8} {:>7} {:>8} {:>7} {:>8} {:>7} {:>7} {:>6}",
        "body", "engine", "ms/step", "field", "ms", "+force", "ms", "ratio", "drift %", "off %"
    );
    rows.iter().for_each(print);
    Ok(())
}

fn main() -> ExitCode {
    exit_code(run_all())
}
