//! Over time: sleep, rest, bad samples and late ticks.

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::{Flags, Model};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::Monitor;
use chaincell_tests::graph::{holds, kinds, sample};

/// A body that the guard had judged stiff, and that slept, moves on as one that lay awake.
#[test]
fn what_is_learnt_of_a_body_outlasts_its_sleep() {
    let shape = Shape::generated("box:2x2x2x0.02").unwrap().holding(&[7]);
    let mut discarded = 0;
    let coarse_basis = BasisSpacing::Links(1.0);
    for options in kinds(&BakeOptions { coarse_basis, ..BakeOptions::default() }) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        for variant in Variant::plain_of(&model) {
            let contact = || Contact::Cells(shape.cells(&model));
            let mut engines = [(); 2]
                .map(|()| variant.engine(model, contact(), variant.sweeps(), |of| of).unwrap());
            engines[0].forbid_sleep();
            for tick in 0..4000_u16 {
                // Moves with a jump, and a long rest after each.
                let (at, engaged) = (tick % 400, u32::from(tick % 400 < 40));
                let z = if at < 2 { 0.0 } else { 0.002 * f32::from(1 + tick / 400) };
                let [awake, asleep] =
                    engines.each_mut().map(|engine| engine.tick(&sample([0.0, 0.0, z], engaged)));
                discarded += u32::from(awake.flags.contains(Flags::ROLLED_BACK));
                assert_eq!(awake, asleep, "{variant}, tick {tick}");
            }
        }
    }
    assert!(discarded > 0);
}

/// Each way to compute a body of links and one of shapes.
fn each(shape: &Shape, of: impl Fn(&ImageBytes, Variant)) {
    for options in kinds(&BakeOptions::default()) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        Variant::plain_of(&model).into_iter().for_each(|variant| of(&image, variant));
    }
}

/// 20,000 ticks at rest on the generated organ, without a band, with bad samples and good ones: the hash
/// stays.
// REQ-ENE-07
#[test]
fn ten_thousand_ticks_of_rest() {
    each(&Shape::generated("organ:300").unwrap(), |image, variant| {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let cells = Contact::Cells(Vec::new());
        let mut engine = variant.engine(model, cells, variant.sweeps(), |of| of).unwrap();
        let mut monitor = Monitor::new(&engine, variant.numbers);
        monitor.rests(&mut engine);
        let before = engine.state_hash();
        for tick in 0..20_000_u16 {
            let sample = if tick % 2 == 0 { sample([f32::NAN; 3], 7) } else { sample([0.0; 3], 0) };
            // The energy in double precision of every hundredth tick is enough.
            if tick % 100 < 2 {
                monitor.tick(&mut engine, &[sample], None);
            } else {
                engine.tick(&sample);
            }
        }
        assert_eq!(engine.state_hash(), before, "{variant}");
        holds(&monitor).unwrap();
    });
}

/// Bad samples: the force of the last good one for ten ticks, then 0 and cells as they are, then back.
// REQ-SMP-01, REQ-SMP-02
#[test]
fn bad_samples_end_in_the_safe_state() {
    let shape = Shape::generated("box:5x5x5x0.01").unwrap().holding(&[124]);
    each(&shape, |image, variant| {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let contact = Contact::Cells(shape.cells(&model));
        let Ok(mut engine) = variant.engine(model, contact, variant.sweeps(), |of| of) else {
            assert_eq!(variant.numbers, Arithmetic::Fixed, "{variant}");
            return;
        };
        let mut monitor = Monitor::new(&engine, variant.numbers);
        let mut tick = |sample| monitor.tick(&mut engine, &[sample], None);
        tick(sample([0.0; 3], 1));
        let good = sample([0.0, 0.0, -0.004], 1);
        tick(good);
        for bad in [sample([f32::NAN, 0.0, 0.0], 1), sample([0.0; 3], 2)] {
            for at in 1..=30 {
                let output = tick(bad);
                assert_eq!(output.force_n.z > 0.0, at <= 10, "{variant}, {at}: {output:?}");
            }
            let output = tick(good);
            assert!(output.force_n.z > 0.0 && output.flags.0 == 0, "{variant}: {output:?}");
        }
        holds(&monitor).unwrap();
    });
}

/// The tool's way in late ticks counts as in any other: none of it is lost, and none made twice.
// REQ-TCK-06
#[test]
fn a_tick_after_late_ones_is_where_the_tool_is() {
    let shape = Shape::generated("box:7x6x4x0.008").unwrap();
    for options in kinds(&BakeOptions::default()) {
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let held = model.surface().iter().copied().rfind(|&cell| !model.is_fixed(cell)).unwrap();
        let variant = Variant::plain(Scheme::Track, Arithmetic::F32);
        let engine =
            || variant.engine(model, Contact::Cells(vec![held]), 4, |settings| settings).unwrap();
        let [mut late, mut all] = [engine(), engine()];
        let mut monitor = Monitor::new(&late, variant.numbers);
        let mut forces = [0.0; 2];
        for tick in 0..200_u16 {
            let pose = sample([0.0, 0.0, -8e-5 * f32::from(tick.min(60))], 1);
            let sweeps = if (31..60).contains(&tick) { Some(0) } else { None };
            forces = [monitor.tick(&mut late, &[pose], sweeps), all.tick(&pose)]
                .map(|output| output.force_n.norm());
            if tick == 30 || tick == 59 {
                assert!((forces[0] == forces[1]) == (tick == 30), "{forces:?}");
            }
        }
        holds(&monitor).unwrap();
        assert!(forces[1] > 0.01 && (forces[0] / forces[1] - 1.0).abs() < 1e-3, "{forces:?}");
        let place = |engine: &mut Engine<'_>| engine.positions_m()[usize::from(held)];
        assert_eq!(place(&mut late), place(&mut all));
    }
}
