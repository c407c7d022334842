//! Writes and checks reports of the golden scenes, see `chaincell_scenes::report`, and traces.
//!
//! `golden emit` runs on any target with `std`, `golden check` on the workstation:
//! `golden emit all 2000 | golden check`.

use std::io::{Read, Write};
use std::process::ExitCode;

use chaincell_kernel::trace::header_bytes;
use chaincell_kernel::{Choice, Dynamics, TissueMut};
use chaincell_scenes::report::{self, Wish};
use chaincell_scenes::{Act, Run, SCENES, Scene, Stepper, Tier, stage};

const USAGE: &str = "usage:
  golden list
  golden emit SCENE|all [TICKS [CELLS_AFTER]] [--scalar] [--fault TICK CELL]
  golden check [FILE]          (standard input without FILE)
  golden check FILE --all TICKS   (every scene in every number type to that tick)
  golden trace SCENE TICKS FILE
CELLS_AFTER adds the state after that tick; --fault moves a cell's x by 2^-10 mean link lengths after a tick";

/// What `emit` does with a run.
#[derive(Clone, Copy)]
struct Emit {
    ticks: u32,
    scalar: bool,
    cells_after: Option<u32>,
    fault: Option<(u32, usize)>,
    tier: Tier,
}

impl Act for Emit {
    type Output = Result<String, String>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).map_err(|why| format!("{}: {why}", scene.name))?;
        if self.scalar {
            run.go_scalar();
        }
        if let Some((tick, cell)) = self.fault {
            run.fault(tick, cell);
        }
        let mut text = String::new();
        let wish = Wish { tier: self.tier, ticks: self.ticks, cells_after: self.cells_after };
        report::write(&mut text, &mut run, wish).map_err(|why| why.to_string())?;
        Ok(text)
    }
}

fn emit(mut args: impl Iterator<Item = String>) -> Result<(), String> {
    let which = args.next().ok_or(USAGE)?;
    let mut act =
        Emit { ticks: 2000, scalar: false, cells_after: None, fault: None, tier: Tier::F32 };
    let number = |text: Option<String>| text.and_then(|text| text.parse::<u32>().ok()).ok_or(USAGE);
    let mut numbers = Vec::new();
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--scalar" => act.scalar = true,
            "--fault" => {
                act.fault = Some((number(args.next())?, number(args.next())? as usize));
            }
            _ => numbers.push(number(Some(arg))?),
        }
    }
    match numbers[..] {
        [] => {}
        [ticks] => act.ticks = ticks,
        [ticks, after] => (act.ticks, act.cells_after) = (ticks, Some(after)),
        _ => return Err(USAGE.to_owned()),
    }
    let mut known = false;
    for &tier in Tier::ALL {
        act.tier = tier;
        for scene in SCENES.iter().filter(|scene| which == "all" || which == scene.name) {
            known = true;
            let Some(text) = stage(scene.name, tier, act) else { continue };
            let text = text?;
            let written = std::io::stdout().write_all(text.as_bytes());
            written.map_err(|why| format!("cannot write: {why}"))?;
        }
    }
    if known { Ok(()) } else { Err(format!("{which}: no such scene; see `golden list`")) }
}

/// The trace of a run, see `chaincell_kernel::trace`.
struct Trace(u32);

impl Act for Trace {
    type Output = Option<Vec<u8>>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).ok()?;
        let mut trace = vec![0; header_bytes(scene.held.len())];
        let (mut writer, _) = run.begin_trace(&mut trace)?;
        (0..self.0).for_each(|_| trace.extend(writer.record(&run.record())));
        Some(trace)
    }
}

fn trace(mut args: impl Iterator<Item = String>) -> Result<(), String> {
    let (Some(scene), Some(ticks), Some(file)) = (args.next(), args.next(), args.next()) else {
        return Err(USAGE.to_owned());
    };
    let ticks = ticks.parse().map_err(|_| USAGE)?;
    let trace = stage(&scene, Tier::F32, Trace(ticks)).flatten();
    let trace = trace.ok_or_else(|| format!("{scene}: no such scene; see `golden list`"))?;
    std::fs::write(&file, trace).map_err(|why| format!("cannot write {file}: {why}"))
}

/// Compares a report; with `all` it must play every scene in every number type to that tick.
fn check(file: Option<String>, all: Option<u64>) -> Result<(), String> {
    let mut text = String::new();
    match &file {
        Some(file) => std::fs::File::open(file).and_then(|mut file| file.read_to_string(&mut text)),
        None => std::io::stdin().read_to_string(&mut text),
    }
    .map_err(|why| format!("cannot read {}: {why}", file.as_deref().unwrap_or("input")))?;
    let ticks = report::check(&text).map_err(|why| why.to_string())?;
    let runs = SCENES.iter().map(|scene| scene.tiers.len() as u64).sum::<u64>();
    if all.is_some_and(|all| ticks != runs * all) {
        let expected = runs * all.unwrap_or_default();
        return Err(format!("the report plays {ticks} ticks, all scenes take {expected}"));
    }
    println!("{ticks} ticks agree");
    Ok(())
}

fn main() -> ExitCode {
    let mut args = std::env::args().skip(1);
    let done = match args.next().as_deref() {
        Some("list") => {
            SCENES.iter().for_each(|scene| println!("{}", scene.name));
            Ok(())
        }
        Some("emit") => emit(args),
        Some("trace") => trace(args),
        Some("check") => match [args.next(), args.next(), args.next()] {
            [file, None, None] => check(file, None),
            [file, Some(all), Some(ticks)] if all == "--all" && ticks.parse::<u64>().is_ok() => {
                check(file, ticks.parse().ok())
            }
            _ => Err(USAGE.to_owned()),
        },
        _ => Err(USAGE.to_owned()),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}
