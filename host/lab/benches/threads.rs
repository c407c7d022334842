//! Instructions of a tick of nodal shapes that several threads share, by thread, by callgrind:
//!
//! ```sh
//! cargo bench -p chaincell-lab --bench threads [-- --nodes N --threads T | --quick]
//! ```
//!
//! The body is the generated organ of 16,500 nodes (5 kPa, Poisson's ratio 0.45) under `predict` with one sweep
//! a tick. A tool goes deeper by a tenth of a millimetre a tick: held cells, or a ball of 12 mm. The rows are
//! the instructions of a tick in each of four threads, the ticking one first; the parts of the body are dealt
//! out in turn. The state after these ticks is that of one thread, to the last bit. With held cells the
//! largest share of a thread may be [`SHARE_INSTRUCTIONS`].
//!
//! `--quick`, which `cargo test` in the place of `cargo bench` takes by itself, counts on a small organ.

use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::{Command, ExitCode};
use std::sync::{Mutex, PoisonError};

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ORGAN_POISSON, ORGAN_YOUNG_PA, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_kernel::{Job, Model, ToolPose, Workers};
use chaincell_lab::bodies::Variant;
use chaincell_lab::cli::exit_code;
use chaincell_lab::experiments::report::scene::{Scene, Source};
use nalgebra::Vector3;
use rayon_core::{ThreadPool, ThreadPoolBuilder};

/// Nodes of the organ, and of that of the quick form: several parts.
const NODES: usize = 16_500;
const QUICK_NODES: usize = 4_300;
/// Threads that share a tick.
const THREADS: usize = 4;
/// Instructions that a tick may take in a thread, with AVX2.
const SHARE_INSTRUCTIONS: f64 = 3.5e6;
/// Ticks of the press, and those counted after it.
const PRESS_TICKS: u16 = 100;
const COUNTED_TICKS: u16 = 8;
/// Way of the tool a tick, and radius of the ball \[m\].
const WAY_M: f64 = 1e-4;
const RADIUS_M: f32 = 0.012;
/// Tools by their number.
const TOOLS: [&str; 2] = ["held cells", "ball of 12 mm"];

/// Threads that sleep between the loops, each with the same parts in every loop.
struct Dealt {
    helpers: Option<ThreadPool>,
    threads: usize,
}

impl Dealt {
    fn new(threads: usize) -> Result<Self> {
        let pool = |helpers| ThreadPoolBuilder::new().num_threads(helpers).build();
        let helpers = (threads > 1).then(|| pool(threads - 1)).transpose();
        Ok(Self { helpers: helpers.map_err(Error::check)?, threads })
    }
}

impl Workers for Dealt {
    fn run(&self, jobs: &mut [Job<'_>]) {
        let Some(helpers) = &self.helpers else { return };
        let jobs: Vec<Mutex<&mut Job<'_>>> = jobs.iter_mut().map(Mutex::new).collect();
        let work = |thread: usize| {
            for job in jobs.iter().skip(thread).step_by(self.threads) {
                job.lock().unwrap_or_else(PoisonError::into_inner)();
            }
        };
        helpers.in_place_scope(|scope| {
            scope.spawn_broadcast(|_, helper| work(helper.index() + 1));
            work(0);
        });
    }
}

/// The organ of so many nodes.
fn organ(nodes: usize) -> Result<Scene> {
    let tissue = Tissue::new(PerCell::Uniform(ORGAN_YOUNG_PA), PerCell::Uniform(ORGAN_POISSON));
    let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
    Source::organ(Some(nodes))?.bake(&options)
}

/// A press of an image that lies in a file, for a run of this program that valgrind counts.
struct Press {
    tool: usize,
    contacts: Vec<u16>,
    direction: [f64; 3],
}

impl Press {
    fn to_arguments(&self) -> [String; 3] {
        let contacts: Vec<String> = self.contacts.iter().map(u16::to_string).collect();
        let direction = self.direction.map(|x| x.to_string());
        [self.tool.to_string(), contacts.join(","), direction.join(",")]
    }

    fn of_arguments(arguments: &[String]) -> Option<Self> {
        let [tool, contacts, direction] = arguments else { return None };
        let direction: Vec<f64> = direction.split(',').filter_map(|x| x.parse().ok()).collect();
        Some(Self {
            tool: tool.parse().ok()?,
            contacts: contacts.split(',').filter_map(|cell| cell.parse().ok()).collect(),
            direction: direction.try_into().ok()?,
        })
    }

    /// The engine after `ticks` ticks that this number of threads shared.
    fn run<'m>(&self, model: Model<'m>, threads: usize, ticks: u16) -> Result<Engine<'m>> {
        let (contact, away_m) = match self.tool {
            0 => (Contact::Cells(self.contacts.clone()), 0.0),
            _ => (Contact::sphere(RADIUS_M, 0.0), f64::from(RADIUS_M)),
        };
        let variant = Variant::plain(Scheme::Predict, Arithmetic::F32);
        let mut engine = variant.unlimited(model, contact, 1, |settings| settings)?;
        engine.share(Some(Box::new(Dealt::new(threads)?)));
        let touched = usize::from(self.contacts.first().copied().unwrap_or_default());
        let start_m = model.rest_position(touched).map(|x| x * model.unit_m());
        for tick in 0..ticks {
            let way_m = WAY_M * f64::from(tick) - away_m;
            let at =
                |x: usize| model.centre_m()[x] + start_m[x] + (way_m * self.direction[x]) as f32;
            let pose = ToolPose::at(Vector3::from([0, 1, 2].map(at)), 1);
            black_box(engine.tick(black_box(&pose)));
        }
        Ok(engine)
    }
}

/// Instructions of each thread of this program with the given arguments, by callgrind.
fn instructions(arguments: &[String]) -> Result<Vec<f64>> {
    let folder = tempfile::tempdir().map_err(Error::check)?;
    let program = std::env::current_exe().map_err(Error::check)?;
    let to = folder.path().join("thread");
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--separate-threads=yes"])
        .arg(format!("--callgrind-out-file={}", to.display()))
        .arg(program)
        .args(arguments)
        .output()
        .map_err(|why| Error::input(format!("the count needs valgrind: {why}")))?;
    let count = |thread: usize| {
        let text = fs::read_to_string(format!("{}-{thread:02}", to.display())).ok()?;
        text.lines().find_map(|line| line.strip_prefix("totals: ")?.trim().parse().ok())
    };
    let counts: Vec<f64> = (1..).map_while(count).collect();
    if !output.status.success() || counts.is_empty() {
        let text = String::from_utf8_lossy(&output.stderr);
        return Err(Error::check(format!("valgrind gave no count:\n{text}")));
    }
    Ok(counts)
}

/// Prints the instructions of a tick in each thread. Returns the largest.
fn count(image: &Path, press: &Press, threads: usize) -> Result<f64> {
    let run = |ticks: u16| {
        let (image, numbers) =
            (image.display().to_string(), [threads.to_string(), ticks.to_string()]);
        let press = press.to_arguments();
        let arguments = ["--counted".to_owned(), image].into_iter().chain(numbers).chain(press);
        instructions(&arguments.collect::<Vec<_>>())
    };
    let (long, short) = (run(PRESS_TICKS + COUNTED_TICKS)?, run(PRESS_TICKS)?);
    let share = |(long, short)| (long - short) / f64::from(COUNTED_TICKS);
    let shares: Vec<f64> = long.into_iter().zip(short).map(share).collect();
    if shares.len() != threads {
        return Err(Error::check(format!("{} threads in place of {threads}", shares.len())));
    }
    let text: String = shares.iter().map(|share| format!(" {share:>11.0}")).collect();
    println!("{:<16}{text}", TOOLS[press.tool]);
    Ok(shares.into_iter().fold(0.0, f64::max))
}

/// Checks that threads change no bit, then counts.
fn measure(nodes: usize, threads: usize, is_counted: bool) -> Result<()> {
    let scene = organ(nodes)?;
    let model = scene.model()?;
    println!("{}: {} cells of nodal shapes, {threads} threads", scene.name, model.cells());
    let folder = tempfile::tempdir().map_err(Error::check)?;
    let image = folder.path().join("organ.chaincell");
    fs::write(&image, scene.bytes()).map_err(Error::check)?;
    for (tool, name) in TOOLS.iter().enumerate() {
        let press = Press { tool, contacts: scene.contacts.clone(), direction: scene.direction };
        let hash =
            |threads| -> Result<u64> { Ok(press.run(model, threads, PRESS_TICKS)?.state_hash()) };
        if hash(1)? != hash(threads)? {
            return Err(Error::check(format!("{name}: other bits with threads")));
        }
        if !is_counted {
            continue;
        }
        let largest = count(&image, &press, threads)?;
        if tool == 0 && nodes == NODES && threads == THREADS && largest > SHARE_INSTRUCTIONS {
            return Err(Error::check(format!(
                "{name}: a thread takes {largest:.0} instructions a tick, more than {SHARE_INSTRUCTIONS}"
            )));
        }
    }
    Ok(())
}

fn run() -> Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, first, image, threads, ticks, press @ ..] = arguments.as_slice()
        && first == "--counted"
    {
        let bytes = fs::read(image).map_err(Error::check)?;
        let image = chaincell_host::bake::ImageBytes::copy(&bytes);
        let model = Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
        let numbers = (threads.parse(), ticks.parse(), Press::of_arguments(press));
        let (Ok(threads), Ok(ticks), Some(press)) = numbers else {
            return Err(Error::input("--counted: arguments that this program did not make"));
        };
        return press.run(model, threads, ticks).map(drop);
    }
    let number = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name)?;
        arguments.get(at + 1)?.parse::<usize>().ok()
    };
    let has = |name: &str| arguments.iter().any(|argument| argument == name);
    let is_quick = has("--quick") || !has("--bench");
    let nodes = number("--nodes").unwrap_or(if is_quick { QUICK_NODES } else { NODES });
    let is_counted = match Command::new("valgrind").arg("--version").output() {
        Ok(_) => true,
        Err(why) => {
            eprintln!("SKIPPED the count of instructions: valgrind: {why}");
            false
        }
    };
    measure(nodes, number("--threads").unwrap_or(THREADS), is_counted)
}

fn main() -> ExitCode {
    exit_code(run())
}
