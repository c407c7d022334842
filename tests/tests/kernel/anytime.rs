//! Ticks that end after any sweep, and late ones without a sweep.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::bake::BakeOptions;
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::{Budget, Flags, Model, Unloading};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::Monitor;
use chaincell_tests::graph::{Case, body, case, holds, kinds, sample, singles};
use nalgebra::Vector3;
use proptest::prelude::*;

/// Bodies of both kinds under the schemes whose ticks may end after any sweep.
fn any_time() -> impl Strategy<Value = (Case, Variant)> {
    body(false, singles(&[Scheme::Track, Scheme::Predict]))
}

/// Where the tool goes in a tick \[m\], whether it holds on, and the sweeps.
type Tick = ([f32; 3], u32, Option<u16>);

fn ticks() -> impl Strategy<Value = Vec<Tick>> {
    let near = prop::array::uniform3(-0.05_f32..0.05);
    let far = prop::array::uniform3(-20.0_f32..20.0);
    let way = prop_oneof![6 => near, 1 => far];
    let sweeps = prop_oneof![3 => Just(Some(0)), 2 => (1_u16..6).prop_map(Some), 1 => Just(None)];
    prop::collection::vec((way, prop_oneof![4 => Just(1), 1 => Just(0)], sweeps), 1..40)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(1000) })]

    /// The level bounds the energy after every sweep and in every late tick, whatever the tool does
    /// meanwhile, and the same ticks give the same bits.
    // REQ-TCK-03, REQ-TCK-06
    #[test]
    fn the_certificate_holds_after_any_sweep((case, variant) in any_time(), ticks in ticks(),
                                             unloading in prop::sample::select(vec![Unloading::Off, Unloading::Release, Unloading::Retreat])) {
        let image = case.image();
        let mut engine = case.engine(&image, variant, unloading).unwrap();
        let mut again = case.engine(&image, variant, unloading).unwrap();
        let mut monitor = Monitor::new(&engine, variant.scheme, variant.numbers);
        let mut force_n = Vector3::zeros();
        for (way_m, engaged, sweeps) in ticks {
            let tool = sample(way_m, engaged);
            let output = monitor.tick_again(&mut engine, &tool, sweeps);
            let most = case.sweeps;
            let wanted = sweeps.map_or(most, |sweeps| sweeps.min(most));
            // Where the bands have just changed the level has to be found first.
            prop_assert!(output.sweeps == wanted || sweeps == Some(0) && output.sweeps == 1);
            let is_late = output.sweeps == 0;
            prop_assert_eq!(output.flags.contains(Flags::LATE), is_late);
            if is_late {
                let kept_n = if engaged == 1 { force_n } else { Vector3::zeros() };
                prop_assert_eq!(output.force_n, kept_n);
            }
            force_n = output.force_n;
            prop_assert_eq!(again.tick_by(&[tool], Budget::again(Some(output.sweeps))), output);
            prop_assert_eq!(again.state_hash(), engine.state_hash());
        }
        holds(&monitor)?;
    }

    /// Sweeps of a scheme that goes by time are not left out.
    // REQ-TCK-06
    #[test]
    fn other_schemes_make_every_sweep(case in case(false), scheme in prop::sample::select(vec![Scheme::Euler, Scheme::Rkl2])) {
        let image = case.image();
        let variant = Variant::plain(scheme, Arithmetic::F32);
        let mut engines = [0, 1].map(|_| case.engine(&image, variant, Unloading::Release).unwrap());
        prop_assert!(!engines[0].is_anytime());
        for tick in 0..20_u16 {
            let tool = sample([0.002 * f32::from(tick), 0.0, 0.0], 1);
            let [one, other] = &mut engines;
            prop_assert_eq!(one.tick_by(&[tool], Budget::again(Some(tick % 3))), other.tick(&tool));
        }
    }
}

/// The tool's way in late ticks counts as in any other: none of it is lost, and none made twice.
// REQ-TCK-06
#[test]
fn a_tick_behind_late_ones_is_where_the_tool_is() {
    let shape = Shape::generated("box:7x6x4x0.008").unwrap();
    for options in kinds(&BakeOptions::default()) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let held = model.surface().iter().copied().rfind(|&cell| !model.is_fixed(cell)).unwrap();
        let variant = Variant::plain(Scheme::Track, Arithmetic::F32);
        let engine =
            || variant.engine(model, Contact::Cells(vec![held]), 4, |settings| settings).unwrap();
        let [mut late, mut all] = [engine(), engine()];
        let way = |tick: u16| sample([0.0, 0.0, -8e-5 * f32::from(tick.min(60))], 1);
        let mut forces = [0.0; 2];
        for tick in 0..200 {
            let sweeps = if (31..60).contains(&tick) { Some(0) } else { None };
            forces = [late.tick_by(&[way(tick)], Budget::again(sweeps)), all.tick(&way(tick))]
                .map(|output| output.force_n.norm());
            if tick == 30 || tick == 59 {
                assert!((forces[0] == forces[1]) == (tick == 30), "{forces:?}");
            }
        }
        assert!(forces[1] > 0.01 && (forces[0] / forces[1] - 1.0).abs() < 1e-3, "{forces:?}");
        let place = |engine: &mut Engine<'_>| engine.positions_m()[usize::from(held)];
        assert_eq!(place(&mut late), place(&mut all));
    }
}
