//! A tiny body kept moving for long: energy, centroid and hash.

use chaincell_kernel::{Model, ToolPose};

use crate::bodies::Body;
use crate::bodies::Variant;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::{Trial, refusal};
use crate::monitor::{Check, Monitor};
use crate::reference::vectors::{minus, norm};
use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::engine::{Arithmetic, Engine};
use chaincell_host::error::Result;
use chaincell_host::interrupt;

pub const CASES: &[Case] = &[Case {
    name: "drift",
    checks: "8 cells, the held one going round for 10^5 ticks (10^6, with --slow 10^8 in f32): after \
             every round hash as in a second run without vectors, energy at most the level, highest \
             level at most 1.001 of the first rounds', centroid within 0.05 links (floating, which \
             turns about the held cell: 1.5, 2); the same of nodal shapes",
    run: drift,
}];

/// Link passes a tick where the scheme is free to choose.
const SWEEPS: u16 = 2;
/// Ticks of a round.
const ROUND: u32 = 250;
/// Rounds that settle, and rounds that the later ones are held against.
const FIRST: std::ops::Range<u64> = 20..100;
/// Largest level of a round over that of the first rounds, and largest way of the centroid
/// [mean link lengths].
#[derive(Clone, Copy)]
struct Most {
    level: f64,
    centroid: f64,
}

/// For a body with fixed cells.
const FIXED: Most = Most { level: 1.001, centroid: 0.05 };
/// For a floating one, which a tool that goes round turns about the held cell.
const FLOATING: Most = Most { level: 1.5, centroid: 2.0 };
/// How far the tool goes [mean link lengths].
const REACH: f32 = 0.4;

fn drift(scale: Scale, found: &mut Findings) -> Result<()> {
    let ticks: u64 = match scale {
        Scale { slow: true, .. } => 100_000_000,
        Scale { quick: true, .. } => 100_000,
        _ => 1_000_000,
    };
    let shape = cuboid(2)?;
    let fixed = Body::new(shape.clone(), &BakeOptions::default())?;
    let floating = Body::new(shape.floating(), &BakeOptions::default())?;
    let tissue = Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45));
    let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
    let shapes = Body::new(cuboid(2)?, &options)?;
    for (label, body, most) in
        [("fixed", &fixed, FIXED), ("floating", &floating, FLOATING), ("shapes", &shapes, FIXED)]
    {
        for variant in Variant::of_body(body)? {
            let Some(model) = body.model(variant.coarse)? else { continue };
            let is_single = variant.numbers == Arithmetic::F32;
            // The longest drift is for the arithmetic that devices have.
            if scale.slow && !is_single {
                continue;
            }
            let sweeps = (!variant.scheme.goes_by_tick()).then_some(SWEEPS);
            let trial = Trial { sweeps, ..Trial::new(label, body, 0) };
            let [one, scalar] = [(); 2].map(|()| trial.engine(model, variant));
            match refusal(one.and_then(|one| Ok((one, scalar?))))? {
                Ok((one, mut scalar)) => {
                    scalar.go_scalar();
                    let place = format!("{label}, {variant}");
                    let watch = Rounds { found, place, model, variant, most };
                    watch.go(one, scalar, ticks / u64::from(ROUND))?;
                }
                Err(why) => found.refuse(why),
            }
        }
    }
    found.figure("ticks_each", ticks as f64);
    Ok(())
}

/// Looks at a body after every round.
struct Rounds<'f, 'm> {
    found: &'f mut Findings,
    place: String,
    model: Model<'m>,
    variant: Variant,
    most: Most,
}

impl Rounds<'_, '_> {
    fn go(mut self, mut one: Engine<'_>, mut scalar: Engine<'_>, rounds: u64) -> Result<()> {
        let unit_m = self.model.unit_m();
        let path: Vec<_> = (0..ROUND)
            .map(|tick| {
                let turn = f64::from(tick) / f64::from(ROUND) * std::f64::consts::TAU;
                let at = [libm::sin(turn), 0.5 * libm::sin(2.0 * turn), libm::cos(turn) - 1.0];
                ToolPose::at(at.map(|x| REACH * unit_m * x as f32).into(), 1)
            })
            .collect();
        let (mut level, mut centroid) = (0.0_f64, None);
        let mut worst = [0.0_f64; 2];
        let mut monitor = Monitor::new(&one, self.variant.numbers);
        for round in 0..rounds {
            interrupt::check()?;
            let mut highest_j = 0.0_f64;
            for (tick, at) in path.iter().enumerate() {
                let output = if tick + 1 < path.len() {
                    one.tick(at)
                } else {
                    // The last tick of a round is checked in full.
                    monitor.interfere();
                    monitor.tick(&mut one, &[*at], None)
                };
                highest_j = highest_j.max(f64::from(output.energy_j));
                scalar.tick(at);
            }
            let now = centre(&mut one).map(|x| x / f64::from(unit_m));
            self.hold(Check::SameBits, round, one.state_hash() == scalar.state_hash(), || {
                "the hash is another without vectors".to_owned()
            });
            if round < FIRST.start {
                continue;
            } else if FIRST.contains(&round) {
                level = level.max(highest_j);
            }
            let from = *centroid.get_or_insert(now);
            let way = norm(minus(now, from));
            let over = if level > 0.0 { highest_j / level } else { 0.0 };
            worst = [worst[0].max(over), worst[1].max(way)];
            if over > self.most.level || way > self.most.centroid {
                break;
            }
        }
        let [over, way] = worst;
        let Self { found, place, most, .. } = self;
        found.failed(&place, &monitor);
        found.hold(over <= most.level, place.clone(), Check::Drift, || {
            format!("level {over} of the first rounds'")
        });
        found.hold(way <= most.centroid, place, Check::Drift, || {
            format!("centroid {way} links off")
        });
        let which = if most.centroid < 1.0 { "fixed" } else { "floating" };
        found.figure(&format!("{which}_level_over_first"), over);
        found.figure(&format!("{which}_centroid_links"), way);
        Ok(())
    }

    fn hold(&mut self, check: Check, round: u64, holds: bool, what: impl FnOnce() -> String) {
        let place = format!("{}, round {round}", self.place);
        self.found.hold(holds, place, check, what);
    }
}

/// Mean position \[m\].
fn centre(engine: &mut Engine<'_>) -> [f64; 3] {
    let positions_m = engine.positions_m();
    let count = positions_m.len() as f64;
    std::array::from_fn(|axis| positions_m.iter().map(|p| p[axis]).sum::<f64>() / count)
}
