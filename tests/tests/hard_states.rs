//! From any state at all the certified level never rises by itself and bounds what is published:
//! inverted, flattened, coincident and exploded bodies, in every scheme.
//!
//! `CHAINCELL_SLOW=1 cargo test --release -p chaincell-tests --test hard_states` takes ten million
//! sweeps instead of a hundred thousand.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::BakeOptions;
use chaincell_host::engine::{Engine, Scheme};
use chaincell_kernel::Unloading;
use chaincell_tests::graph::{case, energy_j, sample};
use clap::ValueEnum;
use proptest::prelude::*;

/// Ticks of a case, of one to four sweeps each.
const TICKS: usize = 40;
/// Cases, some hundred sweeps each.
const CASES: u32 = 1_000;
const CASES_SLOW: u32 = 100_000;

/// How the rest shape is spoilt.
#[derive(Debug, Clone, Copy)]
enum Spoilt {
    Inverted,
    Flattened,
    Coincident,
    /// All but the first half of the cells coincide.
    HalfCoincident,
    /// Scattered over this many mean link lengths.
    Exploded(f32),
    Stretched,
}

fn spoilt() -> impl Strategy<Value = Spoilt> {
    prop_oneof![
        Just(Spoilt::Inverted),
        Just(Spoilt::Flattened),
        Just(Spoilt::Coincident),
        Just(Spoilt::HalfCoincident),
        (-6.0_f32..3.0).prop_map(|decades| Spoilt::Exploded(10.0_f32.powf(decades))),
        Just(Spoilt::Stretched),
    ]
}

/// The cells' positions in a spoilt state [mean link lengths].
fn positions(engine: &Engine<'_>, spoilt: Spoilt, seeds: &[f32]) -> Vec<[f32; 3]> {
    let model = engine.network().model();
    let seed = |at: usize| seeds[at % seeds.len()];
    let of = |cell: usize| {
        let rest = model.rest_position(cell);
        match spoilt {
            Spoilt::Inverted => rest.map(|x| -x),
            Spoilt::Flattened => [rest[0], rest[1], 0.0],
            Spoilt::Coincident => [0.0; 3],
            Spoilt::HalfCoincident if cell * 2 < model.cells() => rest,
            Spoilt::HalfCoincident => [0.5, -0.25, 0.0],
            Spoilt::Exploded(by) => [0, 1, 2].map(|axis| by * seed(7 * cell + 3 * axis + cell / 5)),
            Spoilt::Stretched => rest.map(|x| 1.5 * x),
        }
    };
    (0..model.cells()).map(of).collect()
}

fn cases() -> u32 {
    if std::env::var_os("CHAINCELL_SLOW").is_some() { CASES_SLOW } else { CASES }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases()) })]

    #[test]
    fn the_level_never_rises_and_bounds_the_energy(
        case in prop_oneof![3 => case(false), 1 => case(true)], spoilt in spoilt(),
        seeds in prop::collection::vec(-1.0_f32..1.0, 11),
        scheme in prop::sample::select(Scheme::value_variants()),
        wide in any::<bool>(), held in any::<bool>(),
    ) {
        // With a wide range the state stays linear, else exploded ones saturate.
        let saturation_m = wide.then_some(1e4);
        let image = case.image(BakeOptions { saturation_m, ..BakeOptions::default() });
        let mut engine = case.engine(&image, scheme, Unloading::Off);
        let state = positions(&engine, spoilt, &seeds);
        engine.set_positions(&state).unwrap();
        let (mut level, mut before) = (f64::INFINITY, f64::INFINITY);
        for tick in 0..TICKS {
            let output = engine.tick(&sample([0.0; 3], u32::from(held && tick < TICKS / 2)));
            let (energy, allowance) = energy_j(&mut engine);
            let certified = f64::from(output.energy_j);
            prop_assert!(energy.is_finite() && certified >= 0.0);
            if scheme == Scheme::Euler {
                // Its level is the energy of the last pass, one step behind.
                prop_assert!(energy <= before + allowance, "tick {tick}: {energy:e} after {before:e}");
            } else {
                prop_assert!(certified <= level, "tick {tick}: level {certified:e} after {level:e}");
                prop_assert!(
                    energy <= certified * (1.0 + 1e-6) + allowance,
                    "tick {tick}: {energy:e} above {certified:e}, {allowance:e}"
                );
            }
            (level, before) = (certified, energy);
        }
    }
}
