//! Ticks of organs of nodal shapes: 5 kPa, Poisson's ratio 0.45, `predict`, one sweep.
//!
//! Counted are the 300 ticks of a press by 10 mm, of held cells and under a ball of 12 mm, and the state hash
//! apart. Beside each tick stands the error of its force against 64 sweeps over that press and the 150 ms that
//! it is held: median, nine of ten ticks, and the largest, as shares of the largest force.
//!
//! After them come the same counts of a body that relaxes in two branches and is as stiff at once, and their ratio to
//! those of the elastic one.

use std::hint::black_box;
use std::path::{Path, PathBuf};

use chaincell_host::bake::tissue::{Branch, DEVICE_HZ, Relaxation, Tissue};
use chaincell_host::bake::{
    BakeOptions, ImageBytes, ORGAN_POISSON, ORGAN_SIZE, ORGAN_TICK_INSTRUCTIONS, ORGAN_YOUNG_PA,
    PerCell,
};
use chaincell_host::engine::convergence::MANY;
use chaincell_host::error::{Error, Result};
use chaincell_kernel::Model;
use chaincell_lab::experiments::report::scene::{Scene, Source};
use chaincell_lab::experiments::report::sweeps::{Task, body};

use crate::callgrind::instructions;

/// What is counted; the hash has no tool of its own.
const ROWS: [(&str, Option<Task>); 3] = [
    ("tick of shapes, held cells", Some(Task::HELD_PRESS)),
    ("tick of shapes, ball", Some(Task::BALL_PRESS)),
    ("state hash", None),
];
/// Ticks of the press, and hashes.
const TICKS: usize = 300;
const HASHES: usize = 64;
/// Branches of the body that relaxes: ratios to the long-term shear modulus and times \[s\].
const BRANCHES: [(f64, f64); 2] = [(1.0, 0.1), (1.0, 2.0)];
/// Organs that are counted.
const NODES: [usize; 2] = [ORGAN_SIZE, 5_783];

/// The run that valgrind counts: the tool takes hold, then come as many ticks or hashes as `length` says, all
/// or none.
pub fn counted_run(row: usize, length: usize, image: &Path) -> Result<()> {
    let (Some((_, task)), 0..=1) = (ROWS.get(row), length) else {
        return Err(Error::input("--shapes is 0 to 2 and --length 0 or 1"));
    };
    let image = ImageBytes::copy(&std::fs::read(image).map_err(Error::input)?);
    let model = Model::from_bytes(image.as_bytes()).map_err(Error::input)?;
    let mut engine = task.unwrap_or(Task::HELD_PRESS).engine(model, 1)?;
    let poses = task.unwrap_or(Task::HELD_PRESS).poses(&engine)?;
    let ticks = if task.is_some() { length * TICKS } else { 0 };
    for pose in &poses[..=ticks] {
        black_box(engine.tick(black_box(pose)));
    }
    let hashes = if task.is_some() { 0 } else { length * HASHES };
    for _ in 0..hashes {
        black_box(engine.state_hash());
    }
    Ok(())
}

/// The organ of [`body`] with [`BRANCHES`], of the same instantaneous moduli.
fn relaxing(nodes: usize) -> Result<Scene> {
    let branches = BRANCHES.map(|(ratio, time_s)| Branch { ratio, time_s }).to_vec();
    let relaxation = Some(Relaxation { branches, is_instant: true, device_hz: DEVICE_HZ });
    let tissue = Tissue::new(PerCell::Uniform(ORGAN_YOUNG_PA), PerCell::Uniform(ORGAN_POISSON));
    let tissue = Some(Tissue { relaxation, ..tissue });
    Source::organ(Some(nodes))?.bake(&BakeOptions { tissue, ..BakeOptions::default() })
}

/// Returns the instructions of a tick, or of a hash, on the body in each of these files.
fn counts<const FILES: usize>(row: usize, images: &[PathBuf; FILES]) -> Result<[f64; FILES]> {
    let times = if ROWS.get(row).is_some_and(|(_, task)| task.is_some()) { TICKS } else { HASHES };
    let mut counts = [0.0; FILES];
    for (count, image) in counts.iter_mut().zip(images) {
        let image = image.to_string_lossy();
        let run = |length| {
            instructions(&["--shapes", &row.to_string(), "--length", length, "--image", &image])
        };
        *count = (run("1")? - run("0")?) / times as f64;
    }
    Ok(counts)
}

/// Prints the rows of an organ, elastic and with branches. Returns the instructions of a tick under the ball with its
/// hash, of the elastic one.
pub fn count(nodes: usize) -> Result<f64> {
    // Both bodies as files for the counted runs.
    let scenes = [body(nodes, Some(ORGAN_POISSON))?, relaxing(nodes)?];
    let folder = tempfile::tempdir().map_err(Error::check)?;
    let images = ["elastic", "relaxing"].map(|name| folder.path().join(name));
    for (scene, image) in scenes.iter().zip(&images) {
        std::fs::write(image, scene.bytes()).map_err(Error::check)?;
    }
    // The table of the elastic one.
    let [elastic, _] = &scenes;
    println!("\norgan:{nodes} of nodal shapes, {} cells", elastic.model()?.cells());
    println!("{:<28} {:>12}   error of the force, % of its peak", "", "thousand");
    println!("{:<28} {:>12}   median, 9 of 10, largest", "", "instructions");
    let mut rows = [[0.0; 2]; ROWS.len()];
    for (row, (name, task)) in ROWS.into_iter().enumerate() {
        rows[row] = counts(row, &images)?;
        let error = match task {
            Some(task) => {
                let rows = task.rows(elastic, "", &[1], MANY)?;
                let percent = |share: f64| format!("{:.2}", 100.0 * share);
                let of = rows.first().map(|row| [row.median, row.p90, row.largest].map(percent));
                format!("   {}", of.unwrap_or_default().join(", "))
            }
            None => String::new(),
        };
        println!("{name:<28} {:>12.1}{error}", 1e-3 * rows[row][0]);
    }
    // That of the one with branches.
    println!("{:<28} {:>12}   ratio to the elastic body", "with two branches", "");
    for ((name, _), [of_elastic, of_relaxing]) in ROWS.into_iter().zip(rows) {
        let ratio = of_relaxing / of_elastic;
        println!("{name:<28} {:>12.1}   {ratio:.3}", 1e-3 * of_relaxing);
    }
    let [_, [ball, _], [hash, _]] = rows;
    Ok(ball + hash)
}

/// The rows of all organs. The tick of the default one has to keep its bound.
pub fn count_all() -> Result<()> {
    for nodes in NODES {
        let whole = count(nodes)?;
        if nodes == ORGAN_SIZE && whole > ORGAN_TICK_INSTRUCTIONS {
            return Err(Error::check(format!(
                "a tick of organ:{nodes} takes {whole:.0} instructions, more than the \
                 {ORGAN_TICK_INSTRUCTIONS} of the default body"
            )));
        }
    }
    Ok(())
}
