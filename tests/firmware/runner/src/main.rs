//! Builds firmware images of the kernel, runs them on emulated microcontrollers, compares their
//! bits with this machine's and holds them against their budgets.

mod board;
mod budget;
mod case;
mod checks;
mod emulate;
mod figures;
mod fit;
mod host;
mod image;
mod stand_by;
mod target;
mod tier;
mod trace;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};

use anyhow::{Context, Result, anyhow, bail, ensure};
use chaincell_kernel::Choice;
use chaincell_scenes::{TICKS, Tier};
use clap::Parser;

use budget::Budgets;
use case::{CASES, Case, FIT, Ready};
use figures::Figures;
use host::Answer;
use image::{Image, With, Workshop, allocators};
use target::{FOLDERS, TARGETS, Target};
use tier::tiers;
use trace::Traces;

/// Longest run of one image on this machine, also where it is busy with others \[s\].
const SECONDS: u32 = 1800;
const SECONDS_SLOW: u32 = 1800;

/// Run the kernel on emulated microcontrollers: the same bits as here, and what it costs.
#[derive(Debug, Parser)]
#[command(after_help = "Example:\n  tests/firmware/run --only m7-plane8_track,rv32 --json")]
struct Args {
    /// Print one JSON object a line, one for each image and scene
    #[arg(long)]
    json: bool,
    /// Images whose TARGET-SCENE-NUMBER contains one of these: m7, organ500, m3-plane8_euler, fixed; stand-by for the
    /// board that takes a session over a serial line
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// All 2,000 ticks of the scenes; CHAINCELL_SLOW=1 does the same
    #[arg(long)]
    slow: bool,
    /// Which organs fit 480,000 instructions on the Cortex-M7, with the error of their force
    #[arg(long)]
    fit: bool,
    /// Write budgets.toml anew from what is measured
    #[arg(long)]
    write_budgets: bool,
    /// Hold the image's source against the lints and do no more
    #[arg(long)]
    lint: bool,
    /// The program that bakes models
    #[arg(long, env = "CHAINCELL")]
    chaincell: PathBuf,
    /// The program that finds errors of the force, for --fit
    #[arg(long, env = "CHAINCELL_PRESS_ERROR")]
    press_error: Option<PathBuf>,
}

/// An image that is wanted, with the scene it plays.
struct Job {
    target: &'static Target,
    ready: Arc<Ready>,
    tier: Tier,
    kind: Kind,
}

/// What an image is for.
enum Kind {
    /// To be measured; with this machine's answer.
    Measured(Answer),
    /// To be tried, see [`checks`]; with what it plays.
    Checked(Arc<Traces>),
}

/// A job, done.
struct Built {
    job: Job,
    image: Image,
}

/// A job, and where it goes when it is done.
type Order = (Job, Sender<Result<Built>>);
/// Where a job comes from when it is done.
type Done = Receiver<Result<Built>>;

/// What a run works with.
struct Bench {
    args: Args,
    workshop: Workshop,
    models: PathBuf,
    ticks: u32,
    slow: bool,
}

fn main() -> ExitCode {
    match run(Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("firmware: {why:#}");
            ExitCode::FAILURE
        }
    }
}

fn run(args: Args) -> Result<()> {
    let workspace = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    let workspace = workspace.parent().context("no workspace")?.to_owned();
    let slow = args.slow || std::env::var("CHAINCELL_SLOW").is_ok_and(|value| value == "1");
    let [few, all] = TICKS;
    let ticks = if slow { all } else { few };
    let path = workspace.join("budgets.toml");
    let mut budgets = Budgets::read(&path)
        .or_else(|why| if args.write_budgets { Ok(Budgets::default()) } else { Err(why) })?;
    let models = workspace.join("target/models");
    let bench = Bench { workshop: Workshop::new(workspace)?, models, ticks, slow, args };
    bench.say(&format!("images by {}, {ticks} ticks", bench.workshop.compiler));
    let foreign = !bench.args.write_budgets && budgets.compiler() != bench.workshop.compiler;
    if foreign {
        bench.say(&format!("SKIPPED budgets: they are for {}", budgets.compiler()));
    }
    if bench.args.fit {
        return bench.fit();
    }
    if bench.args.lint {
        return bench.lint();
    }
    bench.say(&Figures::head());
    let (mut broken, mut images) = (vec![], 0);
    bench.each(|figures| {
        images += 1;
        bench.show(&figures)?;
        if bench.args.write_budgets {
            budgets.take(&figures, &bench.workshop.compiler);
            return Ok(());
        }
        if foreign {
            return Ok(());
        }
        let verdict = budgets.check(&figures);
        for loose in verdict.loose {
            bench.say(&format!("  can be tightened: {loose}"));
        }
        broken.extend(verdict.broken);
        Ok(())
    })?;
    let all = bench.args.only.is_empty();
    let stands_by = all || bench.args.only.iter().any(|part| stand_by::NAME.contains(&**part));
    ensure!(stands_by || images > 0, "--only {}: no such image", bench.args.only.join(","));
    if stands_by {
        bench.stand_by()?;
    }
    if all {
        bench.canaries()?;
    }
    if bench.args.write_budgets {
        budgets.write(&path)?;
        bench.say(&format!("written: {}", path.display()));
    }
    ensure!(broken.is_empty(), "over budget:\n  {}", broken.join("\n  "));
    let held = if foreign { "budgets skipped" } else { "within their budgets" };
    bench.say(&format!("ok: {images} images, the bits of this machine, {held}"));
    Ok(())
}

impl Bench {
    /// For people: with `--json` on the other channel.
    fn say(&self, text: &str) {
        if self.args.json {
            eprintln!("{text}");
        } else {
            println!("{text}");
        }
    }

    /// A line of the table, and with `--json` the object.
    fn show(&self, figures: &Figures) -> Result<()> {
        if self.args.json {
            println!("{}", serde_json::to_string(figures)?);
        }
        self.say(&figures.line());
        Ok(())
    }

    /// Measures all images that are wanted, in their order. Cargo builds one image at a time in a
    /// folder: each folder has a thread that builds the next ones while one runs.
    fn each(&self, mut take: impl FnMut(Figures) -> Result<()>) -> Result<()> {
        std::thread::scope(|scope| {
            let builders = FOLDERS.map(|_| {
                let (to, orders) = channel();
                scope.spawn(move || self.build_all(orders));
                to
            });
            let (to, done) = channel();
            scope.spawn(move || {
                if let Err(why) = self.order_all(&builders, &to) {
                    // Nobody listens any more where an earlier image has failed.
                    let _ = to.send(Err(why));
                }
            });
            for built in done {
                let Built { job, image } = built?.recv()??;
                match job.kind {
                    Kind::Measured(host) => take(self.emulate(&job, &image, host)?)?,
                    Kind::Checked(_) => self.check(&job, &image)?,
                }
            }
            Ok(())
        })
    }

    /// Orders all images that are wanted from their folders' builders, until nobody takes them.
    fn order_all(&self, builders: &[Sender<Order>], to: &Sender<Result<Done>>) -> Result<()> {
        for case in CASES {
            // Cores that play the case, and number types that they compute in.
            let all = TARGETS
                .iter()
                .flat_map(|target| tiers(target, &case).iter().map(move |&tier| (target, tier)));
            let wanted: Vec<(&'static Target, Tier)> =
                all.filter(|(target, tier)| self.wants(target, &case, *tier)).collect();
            if wanted.is_empty() {
                continue;
            }
            let ready = Arc::new(self.prepare(case)?);
            // What this machine makes of the scene, once for all cores.
            let is_checked = |&(target, tier): &_| checks::wanted(target, &ready, tier);
            let mut made = vec![];
            for &tier in Tier::ALL {
                let mut images = wanted.iter().filter(|(_, other)| *other == tier).peekable();
                if images.peek().is_some() {
                    let traces = match images.any(is_checked) {
                        true => Some(Arc::new(self.record(&ready, tier)?)),
                        false => None,
                    };
                    made.push((tier, host::play(&ready, tier)?, traces));
                }
            }
            // An image to be measured, and after it the one to be tried.
            for (target, tier) in wanted {
                let played = made.iter().find(|(other, ..)| *other == tier);
                let (_, answer, traces) = played.context("not played on this machine")?;
                let traces = traces.as_ref().filter(|_| is_checked(&(target, tier)));
                let tried = traces.map(|traces| Kind::Checked(Arc::clone(traces)));
                for kind in [Some(Kind::Measured(*answer)), tried].into_iter().flatten() {
                    let job = Job { target, ready: Arc::clone(&ready), tier, kind };
                    let (built, done) = channel();
                    let builder = &builders[target.folder];
                    if to.send(Ok(done)).is_err() || builder.send((job, built)).is_err() {
                        return Ok(());
                    }
                }
            }
        }
        Ok(())
    }

    /// Builds images of one folder, until no more are ordered or nobody waits for one.
    fn build_all(&self, orders: Receiver<Order>) {
        for (job, to) in orders {
            let with = match &job.kind {
                Kind::Measured(_) => None,
                Kind::Checked(traces) => Some(With { feature: "checks", traces: Some(traces) }),
            };
            let image = self.build(job.target, &job.ready, job.tier, with);
            if to.send(image.map(|image| Built { job, image })).is_err() {
                return;
            }
        }
    }

    fn wants(&self, target: &Target, case: &Case, tier: Tier) -> bool {
        let name = format!("{}-{}-{}", target.name, case.name, tier.name());
        let named = |part: &String| name.contains(&**part);
        let plays = target.fpu || !case.needs_fpu;
        let asked = target.name == "m7" || self.slow || !case.of_size;
        plays && (self.args.only.is_empty() && asked || self.args.only.iter().any(named))
    }

    fn prepare(&self, case: Case) -> Result<Ready> {
        case::prepare(case, &self.args.chaincell, &self.models, self.ticks)
    }

    fn build(
        &self,
        target: &Target,
        ready: &Ready,
        tier: Tier,
        with: Option<With<'_>>,
    ) -> Result<Image> {
        self.workshop.build(target, ready, tier, with)?.map_err(|said| {
            let panics = said.contains("a_panic_is_left_in_the_image");
            let why = if panics { "the kernel or the image can panic" } else { "the build fails" };
            anyhow!("{} {}: {why}:\n{said}", target.name, ready.case.name)
        })
    }

    fn record(&self, ready: &Ready, tier: Tier) -> Result<Traces> {
        trace::record(ready, tier, &self.args.chaincell, &self.models)
    }

    fn emulate(&self, job: &Job, image: &Image, host: Answer) -> Result<Figures> {
        let Job { target, ready, tier, .. } = job;
        let said = emulate::run(target, image, self.seconds())?;
        Figures::new(target, ready, *tier, image, &said, host)
    }

    fn seconds(&self) -> u32 {
        if self.slow { SECONDS_SLOW } else { SECONDS }
    }

    /// Traces both ways, hard states and samples.
    fn check(&self, job: &Job, image: &Image) -> Result<()> {
        let Job { target, ready, tier, .. } = job;
        let name = format!("{}-{}-{}", target.name, ready.case.name, tier.name());
        let said = emulate::run(target, image, self.seconds())?;
        let stem = self.workshop.folder(target).join(&name);
        checks::hold(ready, *tier, &said, &self.args.chaincell, &stem).context(name.clone())?;
        self.say(&format!("  checked: {name}: traces both ways, hard states and samples"));
        Ok(())
    }

    /// A board that takes a session over a serial line.
    fn stand_by(&self) -> Result<()> {
        let session = stand_by::Session::record(&self.args.chaincell, &self.models)?;
        let image = self.workshop.build_stand_by(&TARGETS[0], session.model())?;
        for line in session.prove(&TARGETS[0], &image)? {
            self.say(&format!("  {}: {line}", stand_by::NAME));
        }
        Ok(())
    }

    /// Sees the gates fail: on an image that can panic, on one that links `alloc`, and on a program
    /// that has an allocator.
    fn canaries(&self) -> Result<()> {
        let ready = self.prepare(CASES[0])?;
        for (feature, refusal) in [
            // REQ-TCK-02
            ("canary-panic", "a_panic_is_left_in_the_image"),
            // REQ-TCK-01
            ("canary-alloc", "no global memory allocator found"),
        ] {
            let with = With { feature, traces: None };
            match self.workshop.build(&TARGETS[0], &ready, Tier::F32, Some(with))? {
                Ok(_) => bail!("the image with {feature} links"),
                Err(said) => ensure!(said.contains(refusal), "{feature}:\n{said}"),
            }
        }
        // This program has an allocator: the look for one must find it here.
        let own = std::env::current_exe()?;
        ensure!(!allocators(&own)?.is_empty(), "{}: no allocator is seen", own.display());
        self.say("gates: a panic and a heap do not link, an allocator is seen");
        Ok(())
    }

    fn lint(&self) -> Result<()> {
        let ready = self.prepare(CASES[0])?;
        let traces = self.record(&ready, Tier::F32)?;
        // Arm and RISC-V have files of their own; all else is the same source.
        for target in TARGETS.iter().filter(|target| ["m7", "rv32"].contains(&target.name)) {
            if !self.workshop.lint(target, &ready, &traces)? {
                self.say("SKIPPED lints of the images: the packages bring no clippy");
                return Ok(());
            }
        }
        self.workshop.lint_stand_by(&TARGETS[0], &ready.model_path)?;
        Ok(())
    }

    /// Measures organs of some sizes and says which of them fit with their force.
    fn fit(&self) -> Result<()> {
        let program = self.args.press_error.as_deref();
        let program =
            program.context("--fit needs --press-error, which tests/firmware/run gives")?;
        self.say(&fit::Row::head());
        let mut rows = vec![];
        for (scheme, sizes, spacings) in FIT {
            for spacing in spacings {
                for &cells in sizes {
                    rows.extend(self.fit_rows(program, scheme, cells, spacing)?);
                }
            }
        }
        self.say(&fit::headline(&rows));
        Ok(())
    }

    /// The organ of a size under a scheme, at some numbers of sweeps.
    fn fit_rows(
        &self,
        program: &Path,
        scheme: &'static str,
        cells: u32,
        spacing: &str,
    ) -> Result<Vec<fit::Row>> {
        let errors = fit::errors(program, scheme, cells, spacing)?;
        let figures = self.organ(case::fit(scheme, cells, spacing))?;
        let mut rows = vec![];
        for errors in errors {
            let (own, its) = (
                (figures.cells, figures.coarse_functions),
                (errors.cells, errors.coarse_functions),
            );
            ensure!(own == its, "organ:{cells}: cells and coarse functions {own:?} and {its:?}");
            // The worst of some ticks in a row: it holds what a moving tool costs.
            let tick = figures.instructions_per_tick_worst;
            let sweep = figures.instructions_per_sweep_worst;
            let row = fit::Row::new(figures.links, tick, sweep, &errors);
            if self.args.json {
                println!("{}", serde_json::to_string(&row)?);
            }
            self.say(&row.line());
            rows.push(row);
        }
        Ok(rows)
    }

    /// Figures of an organ on the Cortex-M7.
    fn organ(&self, case: Case) -> Result<Figures> {
        let ready = self.prepare(case)?;
        let (target, host) = (&TARGETS[0], host::play(&ready, Tier::F32)?);
        let image = self.build(target, &ready, Tier::F32, None)?;
        let (ready, tier, kind) = (Arc::new(ready), Tier::F32, Kind::Measured(host));
        self.emulate(&Job { target, ready, tier, kind }, &image, host)
    }
}
