//! A large organ pressed at 80 mm/s by cells that a tool holds, under `predict`, by one thread and by
//! two: the time of a tick over that of a bare link sweep, and the error of the force.
//!
//! ```sh
//! CHAINCELL_REFERENCE=DIR cargo bench -p chaincell-lab --bench large
//! ```
//!
//! The tool holds the cells that `--contact auto` chooses, and goes 6 mm along -z.
//!
//! The bare sweep is that of the reference liver with every link outside its band, without a coarse
//! level, or of the generated organ without CHAINCELL_REFERENCE. All times are medians of the same
//! run, taken in turns. The error is the largest from tick 30 on, against `track` with sixty sweeps a
//! tick, over the largest force; no tick is left out. The last column tells how far from a snap the
//! press stays.
//!
//! `--quick`, which `cargo test` takes by itself, presses a smaller organ for a few ticks.

use std::path::Path;
use std::process::ExitCode;
use std::time::Instant;

use chaincell_host::engine::Scheme;
use chaincell_host::engine::contact::contact_cells;
use chaincell_host::engine::threads::ThreadCount;
use chaincell_host::error::{Error, Result};
use chaincell_kernel::ToolPose;
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::report::press::engine;
use chaincell_lab::experiments::report::scene::Scene;
use chaincell_lab::experiments::report::setting::Setting;
use chaincell_lab::states::State;
use nalgebra::Vector3;

/// Way of the tool a tick \[m\].
const WAY_M: f64 = 8e-5;
/// Sweeps of the reference.
const SETTLED: u16 = 60;
/// Ticks that are left out: the tool engages.
const ENGAGING: usize = 30;
const FREE: ToolPose = ToolPose::at(Vector3::new(0.0, 0.0, 0.0), 0);

/// How much is done.
struct Extent {
    cells: usize,
    /// Ticks of the press; it goes on until this many less [`HELD_TICKS`].
    ticks: usize,
    /// Times that everything is measured.
    rounds: usize,
}

const FULL: Extent = Extent { cells: 60_000, ticks: 95, rounds: 5 };
const QUICK: Extent = Extent { cells: 16_800, ticks: 50, rounds: 1 };
/// Ticks in which the tool stands still at the end.
const HELD_TICKS: usize = 20;

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_unstable_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Median time of a bare link sweep \[s\].
fn bare_sweep(scene: &Scene) -> Result<f64> {
    let mut engine = engine(scene, Setting { coarse: false, ..Setting::TRACK }, 1)?;
    let positions = State::Stretched.positions(&scene.model()?, 0);
    let times = (0..200).map(|_| {
        engine.set_positions(&positions)?;
        engine.tick(&FREE);
        let begin = Instant::now();
        engine.tick(&FREE);
        Ok(begin.elapsed().as_secs_f64())
    });
    Ok(median(times.collect::<Result<_>>()?))
}

/// A press: the forces \[N\], and the median time of its ticks that count \[s\].
fn press(
    scene: &Scene,
    scheme: Scheme,
    sweeps: u16,
    threads: usize,
    ticks: usize,
) -> Result<(Vec<[f64; 3]>, f64)> {
    let mut engine = engine(scene, Setting { scheme, coarse: true }, sweeps)?;
    engine.share(ThreadCount::Of(threads).start(scene.model()?.cells())?);
    let (mut forces, mut times) = (Vec::new(), Vec::new());
    for tick in 0..ticks {
        let way_m = WAY_M * tick.min(ticks - HELD_TICKS) as f64;
        let position_m = Vector3::from(scene.direction.map(|x| (way_m * x) as f32));
        let begin = Instant::now();
        let output = engine.tick(&ToolPose::at(position_m, 1));
        times.push(begin.elapsed().as_secs_f64());
        forces.push(output.force_n.cast::<f64>().into());
    }
    Ok((forces, median(times.split_off(ENGAGING.min(times.len())))))
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vector3::from(a) - Vector3::from(b)).norm()
}

fn run() -> Result<()> {
    let has = |name: &str| std::env::args().any(|argument| argument == name);
    let Extent { cells, ticks, rounds } =
        if has("--quick") || !has("--bench") { QUICK } else { FULL };
    let liver = match std::env::var_os("CHAINCELL_REFERENCE").filter(|folder| !folder.is_empty()) {
        Some(folder) => Scene::liver(Path::new(&folder), true)?,
        None => {
            eprintln!(
                "SKIPPED the liver: CHAINCELL_REFERENCE is not set; the generated organ instead"
            );
            Scene::organ()?
        }
    };
    let mut organ = Scene::organ_of(cells)?;
    (organ.contacts, organ.direction) = (contact_cells("auto", &organ.model()?)?, [0.0, 0.0, -1.0]);
    let (settled, _) = press(&organ, Scheme::Track, SETTLED, 1, ticks)?;
    let most_n = settled.iter().fold(0.0, |most: f64, &force| most.max(distance(force, [0.0; 3])));
    let steps = settled[ENGAGING..].windows(2).map(|pair| distance(pair[0], pair[1]));
    let step = steps.fold(0.0, f64::max) / most_n;
    let threads: &[usize] = if let Err(why) = ThreadCount::Of(2).start(organ.model()?.cells()) {
        eprintln!("SKIPPED two threads: {why}");
        &[1]
    } else {
        &[1, 2]
    };
    let settings: Vec<(u16, usize)> =
        threads.iter().flat_map(|&threads| [(1, threads), (2, threads)]).collect();
    let (mut bare, mut times) = (Vec::new(), vec![Vec::new(); settings.len()]);
    let mut errors = vec![0.0; settings.len()];
    for _ in 0..rounds {
        bare.push(bare_sweep(&liver)?);
        for (at, &(sweeps, threads)) in settings.iter().enumerate() {
            let (forces, time) = press(&organ, Scheme::Predict, sweeps, threads, ticks)?;
            times[at].push(time);
            let off = forces.iter().zip(&settled).skip(ENGAGING).map(|(a, b)| distance(*a, *b));
            errors[at] = off.fold(0.0, f64::max) / most_n;
        }
    }
    let bare = median(bare);
    println!(
        "{}: {} cells; a bare link sweep of the {}: {:.1} us",
        organ.name,
        organ.model()?.cells(),
        liver.name,
        1e6 * bare
    );
    println!(
        "{:>6} {:>7} {:>12} {:>16} {:>20} {:>26}",
        "sweeps",
        "threads",
        "tick [us]",
        "in bare sweeps",
        "largest error [%]",
        "largest step a tick [%]"
    );
    for ((&(sweeps, threads), times), error) in settings.iter().zip(times).zip(errors) {
        let time = median(times);
        if !(time > 0.0 && bare > 0.0 && most_n > 0.0) {
            return Err(Error::check("nothing was measured"));
        }
        println!(
            "{sweeps:>6} {threads:>7} {:>12.1} {:>16.2} {:>20.2} {:>26.2}",
            1e6 * time,
            time / bare,
            100.0 * error,
            100.0 * step
        );
    }
    Ok(())
}

fn main() -> ExitCode {
    exit_code(run())
}
