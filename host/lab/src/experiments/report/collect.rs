//! The whole report: what is measured in which order, and what it gives.

use std::collections::BTreeMap;
use std::path::PathBuf;

use indicatif::ProgressBar;
use serde::Serialize;

use super::embedded;
use super::exact::{ExactPress, PRESS_TICKS};
use super::hand::{self, Hand, HandRow};
use super::model::{self, Measured};
use super::motions::Motion;
use super::press::{self, Errors, PressRow};
use super::scene::Scene;
use super::setting::Setting;
use super::settle::{Press, Settled};
use super::snaps::Snaps;
use super::specimen::{self, SpecimenRow};
use super::tools::{self, ToolRow};
use super::worst::{self, Sweep};
use crate::baseline::{MassSpring, PerCell, Xpbd};
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::session::timing::machine::Machine;
use chaincell_host::words::counted;

/// Half a millisecond: the budget of the figures under `track` \[ns\].
pub const BUDGET_NS: u64 = 500_000;
/// Most sweeps a tick that are tried for the budget.
const SWEEPS_MAX: u16 = 64;

/// What to measure.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Fewer scenes, sizes and rounds.
    pub quick: bool,
    /// Folder of the reference data with the real liver.
    pub reference: Option<PathBuf>,
}

/// `track` within the budget on the main body.
#[derive(Debug, Clone, Serialize)]
pub struct Track {
    /// Name of the body.
    pub scene: &'static str,
    /// Sweeps a tick: the most whose median tick is within half a millisecond.
    pub sweeps: u16,
    /// Median tick of the press \[ns\].
    pub tick_ns_p50: u64,
    /// Largest error of the field from tick 30 on, snaps left out.
    pub field_error_max: f64,
    /// Largest error of the force, likewise.
    pub force_error_max: f64,
    /// 20 ms after the press.
    pub field_error_after_20ms: f64,
    /// Likewise of the force.
    pub force_error_after_20ms: f64,
    /// Where the exact path jumps from one equilibrium to another.
    pub snaps: Snaps,
    /// Largest errors there.
    pub largest_in_snaps: Errors,
}

/// A scene with its exact path.
#[derive(Debug, Clone, Serialize)]
pub struct SceneFigures {
    /// Name.
    pub name: &'static str,
    /// Where the body comes from.
    pub source: String,
    /// Cells.
    pub cells: usize,
    /// Links.
    pub links: usize,
    /// Cells that the tool holds.
    pub contacts: usize,
    /// Depth of the press \[m\].
    pub depth_m: f64,
    /// Where the path jumps.
    pub snaps: Snaps,
    /// Largest residual of a reference [mean link lengths].
    pub reference_residual: f64,
    /// Moments of the path that were computed.
    pub moments: usize,
}

/// All figures; what an interrupted report did not reach is absent.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// Fewer scenes, sizes and rounds.
    pub quick: bool,
    /// Whether the user ended it early: sections are missing.
    pub interrupted: bool,
    /// How long the measurements took \[s\].
    pub seconds: f64,
    /// Whether reference data was at hand.
    pub reference: bool,
    /// The machine.
    pub machine: Machine,
    /// The worst-case sweep of the main body.
    pub sweep: Option<Sweep>,
    /// The press test with `track`: slab and block.
    pub press: BTreeMap<&'static str, Settled>,
    /// `track` within the budget.
    pub track: Option<Track>,
    /// Its errors during the press, by tick.
    #[serde(skip)]
    pub budget_path: Vec<(usize, Errors)>,
    /// Scenes of the presses.
    pub scenes: Vec<SceneFigures>,
    /// One row a scene, scheme and number of sweeps.
    pub rows: Vec<PressRow>,
    /// Held cells under a hand that moves.
    pub hand: Vec<HandRow>,
    /// Exact equilibria of models against finite elements, where reference data was at hand.
    #[serde(flatten)]
    pub model: Measured,
    /// A measured specimen beside the kernel, where its data was at hand.
    pub specimen: Vec<SpecimenRow>,
    /// Every way in which a tool acts on a body.
    pub tools: Vec<ToolRow>,
    /// Time to equilibrium, every method.
    pub settled: Vec<Settled>,
    /// Sources of the bodies of the press test, with cells that move.
    pub settled_sources: Vec<String>,
}

/// Measures everything into `report`; an error leaves what was measured so far there.
///
/// # Errors
/// Reference data that cannot be read, or the user's wish to stop.
pub fn collect(options: &Options, report: &mut Report, bar: &ProgressBar) -> Result<()> {
    report.quick = options.quick;
    report.reference = options.reference.is_some();
    report.machine = Machine::read();
    let main = main_body(options)?;
    let rounds = if options.quick { 51 } else { 301 };
    let swept = worst::sweep(&main, rounds)?;
    report.sweep = Some(swept);
    step(bar)?;
    settle(options, report, bar)?;
    presses(options, &main, report, bar)?;
    let small = options.quick.then(|| Scene::organ_of(1000)).transpose()?;
    report.hand = hands(options, &main, swept.mixed.simd_ns, || step(bar))?;
    if let Some(folder) = &options.reference {
        report.model = model::run(folder, options.quick, || step(bar))?;
        report.specimen = specimen::run(folder)?;
        step(bar)?;
    }
    report.tools = tools::run(small.as_ref().unwrap_or(&main), || step(bar))?;
    Ok(())
}

/// Straight in, two depths of the main body: the deeper one goes through the liver's snap.
const FAST: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 15.0 };
const FAST_DEEP: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 24.0 };
/// Straight in, as the table of microcontrollers has it.
const SLOW: Motion = embedded::MOTION;
/// The large organ up to the tick before its first snap.
const SHALLOW: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 6.9 };
/// Cells of the large organ, and of the one that stands for the main body in the quick form.
const LARGE_CELLS: usize = 16_500;
const QUICK_CELLS: usize = 300;

/// Motions of the main body and of the large organ.
fn motions(options: &Options) -> [&'static [Motion]; 2] {
    match options.quick {
        true => [&[FAST, Motion::Circles], &[]],
        false => [&[FAST_DEEP, FAST, SLOW, Motion::Circles], &[FAST, SHALLOW]],
    }
}

fn hand_rounds(options: &Options) -> usize {
    if options.quick { 15 } else { 101 }
}

/// The main body, whose sweep takes `main_ns`, and the large organ; the quick form has a small organ
/// in the place of both. `after` is called behind each piece of work.
fn hands(
    options: &Options,
    main: &Scene,
    main_ns: u64,
    mut after: impl FnMut() -> Result<()>,
) -> Result<Vec<HandRow>> {
    let other = Scene::organ_of(if options.quick { QUICK_CELLS } else { LARGE_CELLS })?;
    let other_ns = worst::sweep(&other, hand_rounds(options))?.mixed.simd_ns;
    let other = (&other, other_ns);
    let bodies = if options.quick { vec![other] } else { vec![(main, main_ns), other] };
    let mut rows = Vec::new();
    for ((scene, own_ns), motions) in bodies.into_iter().zip(motions(options)) {
        let hand = Hand { scene, motions, sweeps: &hand::SWEEPS, own_ns, main_ns };
        rows.extend(hand.run(&mut after)?);
    }
    Ok(rows)
}

/// Pieces of work, for the progress bar.
#[must_use]
pub fn pieces(options: &Options) -> u64 {
    let settle = if options.quick { 2 } else { 2 * methods() };
    let rows = scenes(options) * sweeps(options).len() * Setting::all(true).len();
    let paths = scenes(options) * PRESS_TICKS;
    let hands = motions(options).map(|of_body| Hand::pieces(of_body, &hand::SWEEPS));
    let hands: usize = hands.iter().sum();
    let models = options.reference.as_ref().map_or(0, |_| model::pieces(options.quick) + 1);
    (2 + settle + rows + paths + hands + models + 3) as u64
}

fn methods() -> usize {
    Setting::all(true).len() + 3
}

fn scenes(options: &Options) -> usize {
    match (options.quick, &options.reference) {
        (true, _) => 2,
        (false, None) => 4,
        (false, Some(_)) => 5,
    }
}

/// One piece done; whether the user asked to stop.
fn step(bar: &ProgressBar) -> Result<()> {
    steps(bar, 1)
}

/// So many pieces done; likewise.
fn steps(bar: &ProgressBar, pieces: u64) -> Result<()> {
    bar.inc(pieces);
    interrupt::check()
}

/// The real liver, or the organ where it is not at hand.
fn main_body(options: &Options) -> Result<Scene> {
    match &options.reference {
        Some(folder) => Scene::liver(folder, false),
        None => Scene::organ(),
    }
}

/// Time to equilibrium of the slab and the block.
fn settle(options: &Options, report: &mut Report, bar: &ProgressBar) -> Result<()> {
    for name in ["slab", "block"] {
        let (scene, depth_m) = Scene::press(name, options.reference.as_deref())?;
        let model = scene.model()?;
        let press = Press::new(&scene, depth_m, if options.quick { 11 } else { 51 })?;
        report.settled_sources.push(format!(
            "{name}: {}, {}, {}, one cell held by the tool, pressed by {:.2} mm; cells that move by \
             more than a hundredth of that: {}",
            scene.source,
            counted(model.cells(), "cell"),
            counted(model.links(), "link"),
            1e3 * depth_m,
            press.moved()
        ));
        for setting in scene.settings() {
            if setting.scheme.goes_by_tick() || options.quick && setting != Setting::TRACK {
                continue;
            }
            let settled = press.setting(setting)?;
            if setting == Setting::TRACK {
                report.press.insert(name, settled.clone());
            }
            report.settled.push(settled);
            step(bar)?;
        }
        if !options.quick {
            for baseline in
                [Press::baseline::<PerCell>, Press::baseline::<Xpbd>, Press::baseline::<MassSpring>]
            {
                report.settled.push(baseline(&press)?);
                step(bar)?;
            }
        }
    }
    Ok(())
}

fn sweeps(options: &Options) -> &'static [u16] {
    if options.quick { &[1, 4, 16] } else { &[1, 2, 4, 8, 16] }
}

/// Every scene with every scheme and number of sweeps.
fn presses(options: &Options, main: &Scene, report: &mut Report, bar: &ProgressBar) -> Result<()> {
    let mut others = vec![Scene::plane(true)?];
    if !options.quick {
        others.extend([Scene::plane(false)?, Scene::cuboid()?]);
        if options.reference.is_some() {
            others.push(Scene::organ()?);
        }
    }
    for (at, scene) in std::iter::once(main).chain(&others).enumerate() {
        let stride = match (options.quick, at) {
            (true, _) => 10,
            (false, 0) => 1,
            (false, _) => 5,
        };
        let exact = ExactPress::follow(scene, stride, |ticks| steps(bar, ticks))?;
        let model = scene.model()?;
        report.scenes.push(SceneFigures {
            name: scene.name,
            source: scene.source.clone(),
            cells: model.cells(),
            links: model.links(),
            contacts: scene.contacts.len(),
            depth_m: super::exact::DEPTH_LINKS * f64::from(model.unit_m()),
            snaps: exact.snaps.clone(),
            reference_residual: exact.residual_max,
            moments: exact.moments.len(),
        });
        if at == 0 {
            let (track, row) = track(scene, &exact)?;
            report.track = Some(track);
            report.budget_path.clone_from(&row.path);
            if !sweeps(options).contains(&row.sweeps) {
                report.rows.push(row);
            }
            step(bar)?;
        }
        for setting in scene.settings() {
            for &sweeps in sweeps(options) {
                report.rows.push(press::run(scene, &exact, setting, sweeps)?);
                step(bar)?;
            }
        }
    }
    Ok(())
}

/// `track` with as many sweeps as the budget allows.
fn track(scene: &Scene, exact: &ExactPress) -> Result<(Track, PressRow)> {
    let p50 = |sweeps: u16| Ok::<_, Error>(press::tick_times(scene, Setting::TRACK, sweeps)?.p50);
    let guess = u64::from(8_u16) * BUDGET_NS / p50(8)?.max(1);
    let mut sweeps = u16::try_from(guess).unwrap_or(SWEEPS_MAX).clamp(1, SWEEPS_MAX);
    while sweeps < SWEEPS_MAX && p50(sweeps + 1)? <= BUDGET_NS {
        sweeps += 1;
    }
    while sweeps > 1 && p50(sweeps)? > BUDGET_NS {
        sweeps -= 1;
    }
    let row = press::run(scene, exact, Setting::TRACK, sweeps)?;
    let track = Track {
        scene: scene.name,
        sweeps,
        tick_ns_p50: row.tick_ns.p50,
        field_error_max: row.largest.field,
        force_error_max: row.largest.force,
        field_error_after_20ms: row.after_20ms.field,
        force_error_after_20ms: row.after_20ms.force,
        snaps: exact.snaps.clone(),
        largest_in_snaps: row.largest_in_snaps,
    };
    Ok((track, row))
}
