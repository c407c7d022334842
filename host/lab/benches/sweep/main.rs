//! Instructions of a sweep with every link outside its band, by callgrind:
//!
//! ```sh
//! cargo bench -p chaincell-lab --bench sweep [-- --quick]
//! ```
//!
//! The body is the reference liver, or the generated organ without CHAINCELL_REFERENCE. A tick of nine
//! sweeps less one of a single sweep is eight sweeps and nothing else; the instructions do not depend
//! on the machine's pace. After them come those of a late tick, the tool moving deeper by a tenth of a
//! millimetre, and its share of a sweep with vectors. Last come whole ticks of bodies of nodal shapes
//! ([`shapes`]). All loops are run first: their results are finite, and the same with and without the vector
//! unit.
//!
//! `--quick`, which `cargo test` in the place of `cargo bench` takes by itself, counts on a small organ, and
//! `--nodes N` the ticks of shapes alone on an organ of that size. Every count runs the product's own build,
//! which finds the vector unit at run time.

mod callgrind;
mod shapes;

use std::hint::black_box;
use std::path::Path;
use std::process::ExitCode;

use callgrind::instructions;
use chaincell_host::engine::{Arithmetic, Contact, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_kernel::{Budget, Model, ToolPose};
use chaincell_lab::bodies::Variant;
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::report::scene::{RELEASED, Scene, Source};
use chaincell_lab::states::State;
use nalgebra::Vector3;

/// Sweeps of the long and of the short counted tick.
const SWEEPS: [u16; 2] = [9, 1];
/// Cells of the quick form: enough for a coarse level.
const QUICK_CELLS: usize = 500;
/// Ticks of a counted run.
const COUNTED_TICKS: u32 = 4;
/// What the tool of a late tick is, and under which scheme.
const LATE: [(&str, Scheme); 3] = [
    ("late tick, held cells", Scheme::Track),
    ("late tick, probe", Scheme::Track),
    ("late tick, predict", Scheme::Predict),
];
/// Late ticks of the long and of the short counted run, and ticks of the press before them.
const LATE_TICKS: [u16; 2] = [64, 0];
const PRESS_TICKS: u16 = 100;
/// Way of the tool a tick, and radius of the probe \[m\].
const WAY_M: f64 = 1e-4;
const RADIUS_M: f32 = 0.012;
/// The loops by their number.
const LOOPS: [&str; 3] = ["track, vector unit", "track, scalar", "track with a coarse level"];

fn scene(quick: bool) -> Result<Scene> {
    let source = match std::env::var_os("CHAINCELL_REFERENCE") {
        _ if quick => Source::organ(Some(QUICK_CELLS))?,
        Some(folder) => Source::liver(Path::new(&folder))?,
        None => {
            eprintln!(
                "SKIPPED the liver: CHAINCELL_REFERENCE is not set; the generated organ instead"
            );
            Source::organ(None)?
        }
    };
    source.with_alpha(0.0)
}

/// The run that valgrind counts: ticks of a loop, long or short ones. Positions at its end.
fn counted_run(scene: &Scene, number: usize, length: usize) -> Result<Vec<[f64; 3]>> {
    let (true, Some(&sweeps)) = (number < LOOPS.len(), SWEEPS.get(length)) else {
        return Err(Error::input("--loop is 0 to 2 and --length 0 or 1"));
    };
    let model = scene.model()?;
    let positions = State::Stretched.positions(&model, 0);
    let variant = Variant::single(Scheme::Track, number == 2);
    let mut engine = scene.engine(variant, sweeps, |settings| settings)?;
    if number == 1 {
        engine.go_scalar();
    }
    for _ in 0..COUNTED_TICKS {
        engine.set_positions(&positions)?;
        black_box(engine.tick(black_box(&RELEASED)));
    }
    Ok(engine.positions())
}

/// What the loops compute is finite, and the same bits with and without the vector unit.
fn check(scene: &Scene) -> Result<()> {
    for length in 0..SWEEPS.len() {
        let run = |number| counted_run(scene, number, length);
        let ends = [run(0)?, run(1)?, run(2)?];
        let is_finite = |end: &[[f64; 3]]| end.as_flattened().iter().all(|x| x.is_finite());
        if let Some((name, _)) = LOOPS.iter().zip(&ends).find(|(_, end)| !is_finite(end)) {
            return Err(Error::check(format!("{name}: positions that are not finite")));
        }
        if ends[0] != ends[1] {
            return Err(Error::check("track: other bits without the vector unit"));
        }
    }
    Ok(())
}

/// The tool's pose `way_m` below the place of the first cell that is pressed.
fn pose(scene: &Scene, model: &Model<'_>, way_m: f64) -> ToolPose {
    let (unit_m, centre_m) = (f64::from(model.unit_m()), model.centre_m().map(f64::from));
    let touched = scene.contacts.first().copied().unwrap_or_default();
    let rest = model.rest_position(usize::from(touched)).map(f64::from);
    let at = |x| (centre_m[x] + unit_m * rest[x] + way_m * scene.direction[x]) as f32;
    ToolPose::at(Vector3::from([0, 1, 2].map(at)), 1)
}

/// The run that valgrind counts: late ticks behind a press, many or none.
fn late_run(scene: &Scene, number: usize, length: usize) -> Result<()> {
    let (true, Some(&ticks)) = (number < LATE.len(), LATE_TICKS.get(length)) else {
        return Err(Error::input("--late is 0 to 2 and --length 0 or 1"));
    };
    let model = scene.model()?;
    let (contact, away_m) = match number {
        0 | 2 => (Contact::Cells(scene.contacts.clone()), 0.0),
        _ => (Contact::sphere(RADIUS_M, 0.0), f64::from(RADIUS_M)),
    };
    let sample = |tick: u16| pose(scene, &model, WAY_M * f64::from(tick) - away_m);
    let (name, scheme) = LATE[number];
    let variant = Variant::plain(scheme, Arithmetic::F32);
    let mut engine = variant.unlimited(model, contact, 4, |settings| settings)?;
    let contacts = (0..PRESS_TICKS).map(|tick| engine.tick(&sample(tick)).contacts).last();
    eprintln!("{name}: {} cells", contacts.unwrap_or(0));
    for tick in PRESS_TICKS..PRESS_TICKS + ticks {
        black_box(engine.tick_by(&[*black_box(&sample(tick))], Budget::again(Some(0))));
    }
    Ok(())
}

/// The table of instructions; `form` is the argument that names this run's body.
fn count(model: &Model<'_>, form: &str) -> Result<()> {
    println!("{:<28} {:>16} {:>12}", "loop", "instructions", "a half-link");
    let mut sweeps = vec![];
    for (number, name) in LOOPS.into_iter().enumerate() {
        let number = number.to_string();
        let long = instructions(&[form, "--loop", &number, "--length", "0"])?;
        let short = instructions(&[form, "--loop", &number, "--length", "1"])?;
        if long <= short {
            return Err(Error::check(format!("{name}: eight more sweeps took no instructions")));
        }
        let sweep = (long - short) / f64::from(COUNTED_TICKS * u32::from(SWEEPS[0] - SWEEPS[1]));
        println!("{name:<28} {sweep:>16.0} {:>12.1}", sweep / (2 * model.links()) as f64);
        sweeps.push(sweep);
    }
    for (number, (name, _)) in LATE.into_iter().enumerate() {
        let number = number.to_string();
        let long = instructions(&[form, "--late", &number, "--length", "0"])?;
        let short = instructions(&[form, "--late", &number, "--length", "1"])?;
        let tick = (long - short) / f64::from(LATE_TICKS[0]);
        println!("{name:<28} {tick:>16.0}   1/{:.0} of a sweep", sweeps[0] / tick);
    }
    Ok(())
}

fn run() -> Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name)?;
        arguments.get(at + 1)
    };
    let number = |name: &str| value(name)?.parse::<usize>().ok();
    let has = |name: &str| arguments.iter().any(|argument| argument == name);
    let quick = has("--quick") || !has("--bench");
    // A run that valgrind counts.
    if let (Some(row), Some(length), Some(image)) =
        (number("--shapes"), number("--length"), value("--image"))
    {
        return shapes::counted_run(row, length, Path::new(image));
    }
    if let Some(nodes) = number("--nodes") {
        return shapes::count(nodes).map(drop);
    }
    let scene = scene(quick)?;
    let model = scene.model()?;
    if let (Some(loop_number), Some(length)) = (number("--loop"), number("--length")) {
        return counted_run(&scene, loop_number, length).map(drop);
    }
    if let (Some(tool), Some(length)) = (number("--late"), number("--length")) {
        return late_run(&scene, tool, length);
    }
    // The tables.
    check(&scene)?;
    println!("{}: {} cells, {} links", scene.name, model.cells(), model.links());
    if let Err(why) = callgrind::is_there() {
        eprintln!("SKIPPED the count of instructions: valgrind: {why}");
        return Ok(());
    }
    count(&model, if quick { "--quick" } else { "--bench" })?;
    if quick { shapes::count(QUICK_CELLS).map(drop) } else { shapes::count_all() }
}

fn main() -> ExitCode {
    exit_code(run())
}
