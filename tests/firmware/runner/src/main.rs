//! Builds firmware images of the kernel, runs them on emulated microcontrollers, compares their
//! bits with this machine's and holds them against their budgets.

mod budget;
mod case;
mod emulate;
mod figures;
mod fit;
mod host;
mod image;
mod target;

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::{Context, Result, anyhow, bail, ensure};
use chaincell_scenes::{TICKS, Tier};
use clap::Parser;

use budget::Budgets;
use case::{CASES, Case, FIT, Ready};
use figures::Figures;
use image::Workshop;
use target::{TARGETS, Target};

/// Longest run of one image on this machine \[s\].
const SECONDS: u32 = 120;
const SECONDS_SLOW: u32 = 1800;

/// Run the kernel on emulated microcontrollers: the same bits as here, and what it costs.
#[derive(Debug, Parser)]
#[command(after_help = "Example:\n  tests/firmware/run --only m7-plane8_track,rv32 --json")]
struct Args {
    /// Print one JSON object a line, one for each image and scene
    #[arg(long)]
    json: bool,
    /// Images whose TARGET-SCENE contains one of these: m7, organ500, m3-plane8_euler
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// All 2,000 ticks of the scenes; CHAINCELL_SLOW=1 does the same
    #[arg(long)]
    slow: bool,
    /// How many organ cells fit a millisecond on the Cortex-M7
    #[arg(long)]
    fit: bool,
    /// Write budgets.toml anew from what is measured
    #[arg(long)]
    write_budgets: bool,
    /// The program that bakes models
    #[arg(long, env = "CHAINCELL")]
    chaincell: PathBuf,
}

/// What a run works with.
struct Bench {
    args: Args,
    workshop: Workshop,
    models: PathBuf,
    ticks: u32,
    seconds: u32,
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
    let (ticks, seconds) = if slow { (all, SECONDS_SLOW) } else { (few, SECONDS) };
    let path = workspace.join("budgets.toml");
    let mut budgets = Budgets::read(&path).or_else(|why| {
        if args.write_budgets { Ok(Budgets::default()) } else { Err(why) }
    })?;
    let models = workspace.join("target/models");
    let bench = Bench { workshop: Workshop::new(workspace)?, models, ticks, seconds, args };
    bench.say(&format!("images by {}, {ticks} ticks", bench.workshop.compiler));
    if !bench.args.write_budgets && budgets.compiler() != bench.workshop.compiler {
        bench.say(&format!("budgets are for {}: held within 25 %", budgets.compiler()));
    }
    if bench.args.fit {
        return bench.fit();
    }
    let (mut broken, mut images) = (vec![], 0);
    bench.say(&Figures::head());
    for case in CASES {
        let wanted = |target: &&Target| bench.wants(target, &case);
        let targets: Vec<&Target> = TARGETS.iter().filter(wanted).collect();
        if targets.is_empty() {
            continue;
        }
        let ready = bench.prepare(case)?;
        let host = host::play(&ready, Tier::F32)?;
        for target in targets {
            let figures = bench.measure(target, &ready, host)?;
            images += 1;
            if bench.args.json {
                println!("{}", serde_json::to_string(&figures)?);
            }
            bench.say(&figures.line());
            if bench.args.write_budgets {
                budgets.take(&figures, &bench.workshop.compiler);
            } else {
                let verdict = budgets.check(&figures, &bench.workshop.compiler);
                for loose in verdict.loose {
                    bench.say(&format!("  can be tightened: {loose}"));
                }
                broken.extend(verdict.broken);
            }
        }
    }
    ensure!(images > 0, "--only {}: no such image", bench.args.only.join(","));
    if bench.args.only.is_empty() {
        bench.canaries()?;
    }
    if bench.args.write_budgets {
        budgets.write(&path)?;
        bench.say(&format!("written: {}", path.display()));
    }
    ensure!(broken.is_empty(), "over budget:\n  {}", broken.join("\n  "));
    bench.say(&format!("ok: {images} images, the bits of this machine, within their budgets"));
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

    fn wants(&self, target: &Target, case: &Case) -> bool {
        let name = format!("{}-{}", target.name, case.name);
        self.args.only.is_empty() || self.args.only.iter().any(|part| name.contains(&**part))
    }

    fn prepare(&self, case: Case) -> Result<Ready> {
        case::prepare(case, &self.args.chaincell, &self.models, self.ticks)
    }

    fn measure(&self, target: &Target, ready: &Ready, host: host::Answer) -> Result<Figures> {
        let image = self.workshop.build(target, ready, None)?.map_err(|said| {
            let panics = said.contains("a_panic_is_left_in_the_image");
            let why = if panics { "the kernel or the image can panic" } else { "the build fails" };
            anyhow!("{} {}: {why}:\n{said}", target.name, ready.case.name)
        })?;
        let said = emulate::run(target, &image, self.seconds)?;
        Figures::new(target, ready, Tier::F32, &image, &said, host)
    }

    /// Sees the gates fail: on an image that can panic, and on one that calls an allocator.
    fn canaries(&self) -> Result<()> {
        let ready = self.prepare(CASES[0])?;
        match self.workshop.build(&TARGETS[0], &ready, Some("canary-panic"))? {
            Ok(_) => bail!("an image that can panic links"),
            Err(said) => ensure!(said.contains("a_panic_is_left_in_the_image"), "{said}"),
        }
        match self.workshop.build(&TARGETS[0], &ready, Some("canary-alloc"))? {
            Ok(image) => ensure!(!image.allocators.is_empty(), "an allocator is not seen"),
            Err(said) => bail!("{said}"),
        }
        self.say("gates: a panic does not link, an allocator is seen");
        Ok(())
    }

    /// Measures the sizes and says how many cells fit.
    fn fit(&self) -> Result<()> {
        let mut sizes = vec![];
        for case in FIT {
            let ready = self.prepare(case)?;
            let figures = self.measure(&TARGETS[0], &ready, host::play(&ready, Tier::F32)?)?;
            let (tick, sweep) =
                (figures.instructions_one_sweep_tick_worst, figures.instructions_per_sweep_worst);
            let (cells, hats) = (figures.cells, figures.hats);
            self.say(&format!(
                "{} {cells} cells, {hats} hats: a tick of one sweep {tick}, a further sweep {sweep}",
                figures.target
            ));
            sizes.push(fit::Size { cells, tick, sweep });
        }
        for line in fit::lines(&sizes) {
            self.say(&line);
        }
        Ok(())
    }
}
