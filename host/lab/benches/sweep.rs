//! A sweep at its worst, every link outside its band, beside the plain loop over the cells:
//!
//! ```sh
//! cargo bench -p chaincell-lab --bench sweep [-- --json]
//! cargo bench -p chaincell-lab --bench sweep -- --count      # instructions, under valgrind
//! ```
//!
//! The body is the reference liver, or the generated organ without CHAINCELL_REFERENCE. A tick of
//! nine sweeps less one of a single sweep is eight sweeps and nothing else; the loops take turns,
//! so that a slow spell of the machine meets all of them. Both states have every link out of its
//! band: stretched, and shaken, where what a branch decides cannot be foreseen. Counted are the
//! instructions of the stretched one; they do not depend on the machine's pace.

use std::hint::black_box;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::time::Instant;

use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_kernel::{Model, Network, Settings, ToolSample};
use chaincell_lab::baseline::{Baseline, PerCell};
use chaincell_lab::experiments::report::scene::Scene;
use chaincell_lab::experiments::report::setting::Setting;
use nalgebra::Vector3;
use serde::Serialize;

/// Sweeps of the long and of the short tick.
const SWEEPS: [u16; 2] = [9, 1];
const ROUNDS: usize = 400;
/// Stretch of the body that makes every link too long.
const STRETCH: f32 = 1.5;
/// Largest offset of a coordinate in the shaken body [mean link lengths].
const SHAKE: f32 = 0.5;
/// Ticks of a counted run.
const COUNTED_TICKS: u32 = 4;
const FREE: ToolSample = ToolSample { position_m: Vector3::new(0.0, 0.0, 0.0), engaged: 0 };

/// A loop over the links under test.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Loop {
    Vector,
    Scalar,
    /// With the coarse level that the bake gives the body.
    Hats,
    PerCell,
}

/// A state with every link out of its band (alpha 0).
#[derive(Clone, Copy)]
enum State {
    /// Every link too long: what a loop with branches foresees.
    Stretched,
    /// Too long and too short links in no order: what it cannot foresee.
    Shaken,
}

const STATES: [(State, &str); 2] = [(State::Stretched, "stretched"), (State::Shaken, "shaken")];

const LOOPS: [(Loop, &str); 4] = [
    (Loop::Vector, "track, vector unit"),
    (Loop::Scalar, "track, scalar"),
    (Loop::Hats, "track with hats"),
    (Loop::PerCell, "plain loop over the cells"),
];

#[derive(Serialize)]
struct Row {
    cells: usize,
    links: usize,
    name: &'static str,
    state: &'static str,
    sweep_ns_p50: f64,
    sweep_ns_p99: f64,
    half_link_ns: f64,
    /// Time of the plain loop over this one's.
    times_faster: f64,
}

fn scene() -> Result<Scene> {
    let Some(folder) = std::env::var_os("CHAINCELL_REFERENCE") else {
        eprintln!("SKIPPED the liver: CHAINCELL_REFERENCE is not set; the generated organ instead");
        return Scene::organ(0.0);
    };
    Scene::liver(Path::new(&folder), 0.0, true)
}

/// What a round runs: the engine with the long and with the short tick, or the plain loop.
enum Body<'m> {
    Ticks(Box<[Engine<'m>; 2]>),
    Plain(Box<PerCell>),
}

impl<'m> Body<'m> {
    fn new(scene: &'m Scene, kind: Loop) -> Result<Self> {
        let hats = kind == Loop::Hats;
        let model = scene.model_for(Setting { hats, ..Setting::TRACK })?;
        if kind == Loop::PerCell {
            return Ok(Self::Plain(Box::new(PerCell::new(&model))));
        }
        let engine = |sweeps: u16| {
            let settings = Settings { sweeps, ..Settings::for_model(&model) };
            let network = Network::new(model, settings).map_err(Error::check)?;
            let mut engine = Engine::new(network, Scheme::Track, &[])?;
            if kind == Loop::Scalar {
                engine.go_scalar();
            }
            Ok(engine)
        };
        Ok(Self::Ticks(Box::new([engine(SWEEPS[0])?, engine(SWEEPS[1])?])))
    }

    /// Time of a sweep from these positions \[ns\].
    fn sweep_ns(&mut self, positions: &[[f32; 3]]) -> Result<f64> {
        let sweeps = f64::from(SWEEPS[0] - SWEEPS[1]);
        match self {
            Self::Ticks(engines) => {
                let [long, short] = &mut **engines;
                let (long, short) = (tick_ns(long, positions)?, tick_ns(short, positions)?);
                Ok((long - short) / sweeps)
            }
            Self::Plain(body) => {
                body.set_positions(positions);
                body.step();
                let begin = Instant::now();
                for _ in SWEEPS[1]..SWEEPS[0] {
                    body.step();
                }
                black_box(body.positions());
                Ok(begin.elapsed().as_nanos() as f64 / sweeps)
            }
        }
    }
}

fn tick_ns(engine: &mut Engine<'_>, positions: &[[f32; 3]]) -> Result<f64> {
    engine.set_positions(positions)?;
    let begin = Instant::now();
    black_box(engine.tick(black_box(&FREE)));
    Ok(begin.elapsed().as_nanos() as f64)
}

fn positions(model: &Model<'_>, state: State) -> Vec<[f32; 3]> {
    let mut random = 1_u32;
    // Knuth's multiplicative generator: any noise will do.
    let mut noise = || {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        random as f32 / u32::MAX as f32 - 0.5
    };
    let mut place = |x: f32| match state {
        State::Stretched => STRETCH * x,
        State::Shaken => x + 2.0 * SHAKE * noise(),
    };
    (0..model.cells()).map(|cell| model.rest_position(cell).map(&mut place)).collect()
}

fn measure(scene: &Scene, (state, state_name): (State, &'static str)) -> Result<Vec<Row>> {
    let model = scene.model()?;
    let positions = positions(&model, state);
    let mut bodies = Vec::new();
    for (kind, _) in LOOPS {
        bodies.push((Body::new(scene, kind)?, Vec::with_capacity(ROUNDS)));
    }
    for _ in 0..ROUNDS {
        for (body, times) in &mut bodies {
            times.push(body.sweep_ns(&positions)?);
        }
    }
    let mut rows = Vec::new();
    for ((_, name), (_, mut times)) in LOOPS.into_iter().zip(bodies) {
        times.sort_by(f64::total_cmp);
        let sweep_ns_p50 = times[ROUNDS / 2];
        rows.push(Row {
            cells: model.cells(),
            links: model.links(),
            name,
            state: state_name,
            sweep_ns_p50,
            sweep_ns_p99: times[ROUNDS * 99 / 100],
            half_link_ns: sweep_ns_p50 / (2 * model.links()) as f64,
            times_faster: 1.0,
        });
    }
    let plain = rows.last().map_or(f64::NAN, |row| row.sweep_ns_p50);
    rows.iter_mut().for_each(|row| row.times_faster = plain / row.sweep_ns_p50);
    Ok(rows)
}

/// The run that valgrind counts: ticks of a loop, long or short ones.
fn counted_run(scene: &Scene, number: usize, length: usize) -> Result<()> {
    let (Some((kind, _)), Some(&sweeps)) = (LOOPS.get(number), SWEEPS.get(length)) else {
        return Err(Error::input("--loop is 0 to 3 and --length 0 or 1"));
    };
    let mut body = Body::new(scene, *kind)?;
    let positions = positions(&scene.model()?, State::Stretched);
    for _ in 0..COUNTED_TICKS {
        match &mut body {
            Body::Ticks(engines) => {
                tick_ns(&mut engines[length], &positions)?;
            }
            Body::Plain(body) => {
                body.set_positions(&positions);
                (0..sweeps).for_each(|_| body.step());
            }
        }
    }
    Ok(())
}

/// Instructions of this program with the given arguments, by callgrind.
fn instructions(arguments: &[&str]) -> Result<f64> {
    let program = std::env::current_exe().map_err(Error::check)?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args(arguments)
        .output()
        .map_err(|why| Error::input(format!("--count needs valgrind: {why}")))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let count = text.lines().find_map(|line| line.split_once("Collected :")?.1.trim().parse().ok());
    count.ok_or_else(|| Error::check(format!("valgrind gave no count:\n{text}")))
}

fn count(model: &Model<'_>) -> Result<()> {
    println!("{:<28} {:>16} {:>12}", "loop", "instructions", "a half-link");
    for (number, (_, name)) in LOOPS.into_iter().enumerate() {
        let number = number.to_string();
        let long = instructions(&["--loop", &number, "--length", "0"])?;
        let short = instructions(&["--loop", &number, "--length", "1"])?;
        let sweep = (long - short) / f64::from(COUNTED_TICKS * u32::from(SWEEPS[0] - SWEEPS[1]));
        println!("{name:<28} {sweep:>16.0} {:>12.1}", sweep / (2 * model.links()) as f64);
    }
    Ok(())
}

fn run() -> Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let number = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name)?;
        arguments.get(at + 1)?.parse::<usize>().ok()
    };
    let has = |name: &str| arguments.iter().any(|argument| argument == name);
    let scene = scene()?;
    let model = scene.model()?;
    if let (Some(loop_number), Some(length)) = (number("--loop"), number("--length")) {
        return counted_run(&scene, loop_number, length);
    }
    if !has("--json") {
        println!("{}: {} cells, {} links", scene.name, model.cells(), model.links());
    }
    if has("--count") {
        return count(&model);
    }
    let mut rows = Vec::new();
    for state in STATES {
        rows.extend(measure(&scene, state)?);
    }
    if has("--json") {
        println!("{}", serde_json::to_string_pretty(&rows).map_err(Error::check)?);
        return Ok(());
    }
    println!(
        "{:<28} {:<10} {:>9} {:>9} {:>14} {:>12}",
        "loop", "state", "p50 [us]", "p99 [us]", "half-link [ns]", "times faster"
    );
    for row in rows {
        println!(
            "{:<28} {:<10} {:>9.1} {:>9.1} {:>14.2} {:>12.2}",
            row.name,
            row.state,
            1e-3 * row.sweep_ns_p50,
            1e-3 * row.sweep_ns_p99,
            row.half_link_ns,
            row.times_faster
        );
    }
    Ok(())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::from(why.exit_code())
        }
    }
}
