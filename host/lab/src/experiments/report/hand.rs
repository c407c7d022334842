//! A hand that holds cells and moves: error of the force against time of a tick, for every scheme
//! of a list, against the force of the energy's minimum followed tick by tick in double precision.

use chaincell_kernel::{Choice, ToolPose};
use serde::Serialize;
use serde_json::json;

use super::motions::Motion;
use super::pictures::{Point, figures};
use super::scene::{RELEASED, Scene, Source};
use super::snaps::{Snaps, Spread};
use crate::bodies::Variant;
use crate::experiments::page::table::{Table, csv, percent, us};
use crate::experiments::page::{Context, Numbers, Section};
use crate::reference::vectors::{minus, norm, plus};
use crate::reference::{Links, minimum};
use crate::states::State;
use chaincell_host::engine::Scheme;
use chaincell_host::error::{Error, Result};
use chaincell_host::interrupt;
use chaincell_host::session::timing::histogram::{Latencies, Summary};
use chaincell_host::words::counted;

/// Sweeps a tick that are measured.
pub const SWEEPS: [u16; 4] = [1, 2, 4, 8];
/// Part of the largest force below which an error is relative to that part.
const FLOOR: f64 = 0.02;
/// Largest residual of a free cell at a reference [mean link lengths].
const RESIDUAL: f64 = 1e-8;

/// Straight in, two depths: the deeper one goes through the liver's snap.
const FAST: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 15.0 };
const FAST_DEEP: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 24.0 };
/// The large organ up to the tick before its first snap.
const SHALLOW: Motion = Motion::Straight { speed_mm_per_s: 80.0, depth_mm: 6.9 };
/// Cells of the large organ, and of the only one of the quick form.
const LARGE_CELLS: usize = 16_500;
const QUICK_CELLS: usize = 300;
/// Times that a sweep is measured.
const ROUNDS: usize = 301;
const QUICK_ROUNDS: usize = 15;

/// The schemes that are compared, with and without the coarse level that the bake gives by size.
const COMPARED: [Variant; 4] = [
    Variant::single(Scheme::Track, true),
    Variant::single(Scheme::Predict, true),
    Variant::single(Scheme::Predict, false),
    Variant::single(Scheme::Track, false),
];

/// A body under a motion, a scheme and a number of sweeps.
#[derive(Debug, Clone, Serialize)]
pub struct HandRow {
    /// Where the body comes from.
    pub body: String,
    /// Its cells.
    pub cells: usize,
    /// Its links.
    pub links: usize,
    /// The motion.
    pub motion: String,
    /// The scheme.
    pub scheme: String,
    /// Sweeps a tick.
    pub sweeps: u16,
    /// A tick of the motion.
    pub tick_ns: Summary,
    /// The median tick over a sweep of the links alone of the report's main body.
    pub link_sweeps: f64,
    /// Errors of the force.
    pub force: Spread,
    /// Snaps of the reference.
    pub snaps: Snaps,
}

/// The forces that a motion should give \[N\], by tick.
pub struct Reference {
    forces_n: Vec<[f64; 3]>,
    /// Their snaps.
    pub snaps: Snaps,
}

impl Reference {
    fn new(forces_n: Vec<[f64; 3]>) -> Self {
        Self { snaps: Snaps::of(&forces_n), forces_n }
    }

    /// Follows the minimum under the held cells of a scene, tick by tick.
    pub fn follow(scene: &Scene, motion: Motion) -> Result<Self> {
        let model = scene.model()?;
        let links = Links::of_model(&model);
        let contacts: Vec<usize> = scene.contacts.iter().map(|&cell| cell.into()).collect();
        let (per_m, force_unit_n) =
            (1.0 / f64::from(model.unit_m()), f64::from(model.force_unit_n()));
        let mut at = links.rest().to_vec();
        let mut forces_n = Vec::with_capacity(motion.ticks() + 1);
        for tick in 0..=motion.ticks() {
            let way_m = motion.sample(tick, scene.direction).position_m.map(f64::from);
            let place = |&cell: &usize| (cell, plus(links.rest()[cell], per_m, way_m.into()));
            let held: Vec<(usize, [f64; 3])> = contacts.iter().map(place).collect();
            let found = minimum(&links, &held, &at, RESIDUAL);
            if found.residual_max > 10.0 * RESIDUAL {
                return Err(Error::check(format!(
                    "{}: the reference of tick {tick} has a residual of {:e} mean link lengths",
                    scene.source, found.residual_max
                )));
            }
            let force = links.force(&found.positions, &contacts);
            forces_n.push(force.map(|x| force_unit_n * x));
            at = found.positions;
            interrupt::check()?;
        }
        Ok(Self::new(forces_n))
    }

    /// Errors of forces by tick, told apart by the snaps.
    fn spread(&self, forces_n: &[[f64; 3]]) -> Spread {
        let largest = self.forces_n.iter().map(|force| norm(*force)).fold(0.0, f64::max);
        let each = forces_n
            .iter()
            .zip(&self.forces_n)
            .map(|(now, exact)| norm(minus(*now, *exact)) / norm(*exact).max(FLOOR * largest));
        self.snaps.spread(&each.enumerate().collect::<Vec<_>>())
    }
}

/// What a scheme gave: times of the ticks and errors of the force.
pub fn play(
    scene: &Scene,
    reference: &Reference,
    motion: Motion,
    variant: Variant,
    sweeps: u16,
) -> Result<(Summary, Spread)> {
    let mut engine = scene.engine(variant, sweeps, |settings| settings)?;
    let mut times = Latencies::new()?;
    let mut tick = |sample: &ToolPose| times.time(|| engine.tick(sample)).force_n;
    let forces_n: Vec<[f64; 3]> = (0..=motion.ticks())
        .map(|at| tick(&motion.sample(at, scene.direction)).map(f64::from).into())
        .collect();
    Ok((times.summary(), reference.spread(&forces_n)))
}

/// Every scheme and number of sweeps under a motion of a body; `main_ns` is the time of a sweep over
/// the links of the report's main body.
pub fn run(scene: &Scene, motion: Motion, sweeps: &[u16], main_ns: u64) -> Result<Vec<HandRow>> {
    let model = scene.model()?;
    let reference = Reference::follow(scene, motion)?;
    let mut rows = Vec::new();
    for variant in COMPARED {
        for &sweeps in sweeps {
            interrupt::check()?;
            let (tick_ns, force) = play(scene, &reference, motion, variant, sweeps)?;
            rows.push(HandRow {
                body: scene.source.clone(),
                cells: model.cells(),
                links: model.links(),
                motion: motion.words(),
                scheme: words(variant),
                sweeps,
                link_sweeps: tick_ns.p50 as f64 / main_ns.max(1) as f64,
                tick_ns,
                force,
                snaps: reference.snaps.clone(),
            });
        }
    }
    Ok(rows)
}

/// Median time of a sweep over the links alone, every link outside its band \[ns\].
fn link_sweep_ns(scene: &Scene, rounds: usize) -> Result<u64> {
    let mut engine = scene.engine(Variant::single(Scheme::Track, false), 1, |settings| settings)?;
    let positions = State::Stretched.positions(&scene.model()?, 0);
    let mut times = Latencies::new()?;
    for _ in 0..rounds {
        engine.set_positions(&positions)?;
        // The first sweep takes no momentum along; the second is one of many.
        engine.tick(&RELEASED);
        times.time(|| engine.tick(&RELEASED));
    }
    Ok(times.summary().p50)
}

/// A scheme as tables have it.
fn words(variant: Variant) -> String {
    let without = if variant.coarse { "" } else { " without a coarse level" };
    format!("{}{without}", variant.scheme.name())
}

/// Every body under its motions.
pub fn section(context: &Context) -> Result<Section> {
    // Bodies with their motions.
    let bodies: Vec<(Source, &[Motion])> = if context.quick {
        vec![(Source::organ(Some(QUICK_CELLS))?, &[FAST, Motion::Circles])]
    } else {
        let main = match &context.reference {
            Some(folder) => Source::liver(folder)?,
            None => Source::organ(None)?,
        };
        let large = Source::organ(Some(LARGE_CELLS))?;
        let motions = &[FAST_DEEP, FAST, Motion::SLOW, Motion::Circles];
        vec![(main, motions), (large, &[FAST, SHALLOW])]
    };
    // Every scheme under every motion.
    let rounds = if context.quick { QUICK_ROUNDS } else { ROUNDS };
    let (mut rows, mut main_ns) = (Vec::new(), 0);
    for (source, motions) in bodies {
        let scene = source.with_alpha(0.0)?;
        if main_ns == 0 {
            main_ns = link_sweep_ns(&scene, rounds)?;
        }
        for &motion in motions {
            rows.extend(run(&scene, motion, &SWEEPS, main_ns)?);
        }
    }
    // The charts show the first body.
    let shown = rows.iter().filter(|row| row.body == rows[0].body).map(|row| Point {
        motion: &row.motion,
        line: row.scheme.clone(),
        tick_ns: row.tick_ns.p50,
        error: row.force.largest,
    });
    let figures = figures("hand", "largest", &shown.collect::<Vec<_>>())?;
    let caption = "Held cells: time of a tick and error of the force".to_owned();
    Ok(Section {
        key: "hand",
        title: "A hand that moves".to_owned(),
        text: text(main_ns),
        figures,
        tables: vec![(caption, table(&rows))],
        numbers: vec![Numbers { name: "hand".to_owned(), csv: csv(&rows) }],
        json: json!({ "link_sweep_ns": main_ns, "rows": rows }),
        ..Section::default()
    })
}

fn text(main_ns: u64) -> Vec<String> {
    let reference = format!(
        "Held cells, alpha 0, at 1 kHz. The reference is the force of the energy's minimum of the same \
         links under the same tool, followed tick by tick in f64 to a residual of {RESIDUAL:e} mean \
         link lengths; errors are relative to it, or to {} % of its largest value where it is smaller.",
        percent(FLOOR)
    );
    let sweep = format!(
        "A link sweep is one sweep of `track` without a coarse level over the first body with every \
         link outside its band, measured in the same run: {} us.",
        us(main_ns)
    );
    vec![reference, sweep, Snaps::rule(), Motion::description()]
}

fn table(rows: &[HandRow]) -> Table {
    Table::of(rows)
        .column("body", |row| format!("{}, {}", row.body, counted(row.cells, "cell")))
        .column("motion", |row| &row.motion)
        .column("scheme", |row| &row.scheme)
        .column("sweeps a tick", |row| row.sweeps)
        .column("median tick [us]", |row| us(row.tick_ns.p50))
        .column("in link sweeps", |row| format!("{:.1}", row.link_sweeps))
        .column("force, largest error [%]", |row| percent(row.force.largest))
        .column("median [%]", |row| percent(row.force.median))
        .column("largest in snaps [%]", |row| percent(row.force.in_snaps))
        .column("left out as snaps [%]", |row| row.snaps.share_words())
        .table()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::bake::{BakeOptions, BasisSpacing};

    #[test]
    fn more_sweeps_are_nearer() {
        let options = BakeOptions { coarse_basis: BasisSpacing::None, ..BakeOptions::default() };
        let scene = Source::organ(Some(200)).unwrap().bake(&options).unwrap();
        let motion = Motion::Straight { speed_mm_per_s: 50.0, depth_mm: 3.0 };
        let rows = run(&scene, motion, &[1, 32], 1).unwrap();
        assert_eq!(rows.len(), 2 * COMPARED.len());
        for of_scheme in rows.chunks(2) {
            let [few, many] = [0, 1].map(|at| of_scheme[at].force.largest);
            assert!(many < 0.01 && many < 0.2 * few, "{few} {many}");
        }
    }

    #[test]
    fn an_error_is_relative_to_the_force_and_not_to_next_to_nothing() {
        let reference = Reference::new(vec![[0.0, 0.0, 1.0]; 40]);
        let near = vec![[0.0, 0.1, 1.0]; 40];
        assert!((reference.spread(&near).largest - 0.1).abs() < 1e-12);
        let mut forces_n = vec![[0.0, 0.0, 1.0]; 40];
        forces_n[35] = [0.0; 3];
        let reference = Reference { snaps: Snaps::default(), ..Reference::new(forces_n.clone()) };
        forces_n[35] = [0.0, 0.0, 0.01];
        assert!((reference.spread(&forces_n).largest - 0.5).abs() < 1e-9);
    }
}
