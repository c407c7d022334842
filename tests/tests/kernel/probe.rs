//! The probe as contact: on generated bodies, and on random graphs wherever the tool goes.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::{Flags, Model, Settings, TickOutput, ToolPose, Unloading};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::monitor::Monitor;
use chaincell_tests::graph::{body, holds, kinds, sample, shape};
use nalgebra::Vector3;
use proptest::prelude::*;

const BOX: &str = "box:9x9x6x0.01";
/// Height of the box's top \[m\].
const TOP_M: f32 = 0.05;
const RADIUS_M: f32 = 0.025;

/// The box, held at its bottom; a plane, held at its border; of links.
fn image(spec: &str, coarse_basis: BasisSpacing) -> ImageBytes {
    let options = BakeOptions { coarse_basis, ..BakeOptions::default() };
    Shape::generated(spec).unwrap().bake(&options).unwrap()
}

/// The box of both kinds.
fn boxes(coarse_basis: BasisSpacing) -> [ImageBytes; 2] {
    let options = BakeOptions { coarse_basis, ..BakeOptions::default() };
    kinds(&options).map(|options| Shape::generated(BOX).unwrap().bake(&options).unwrap())
}

fn engine_of(
    model: Model<'_>,
    variant: Variant,
    unloading: Unloading,
    capacity: usize,
) -> Option<Engine<'_>> {
    let contact = Contact::Probe { radius_m: RADIUS_M, capacity };
    let change = |settings| Settings { unloading, ..settings };
    variant.engine(model, contact, variant.sweeps(), change).ok()
}

/// An engine whose tool may go anywhere in a tick, engaged far above the body: whole from there on.
fn engaged_above(model: Model<'_>, scheme: Scheme, capacity: usize) -> Engine<'_> {
    let contact = Contact::Probe { radius_m: RADIUS_M, capacity };
    let variant = Variant::plain(scheme, Arithmetic::F32);
    let change =
        |settings| Settings { unloading: Unloading::Off, max_tool_step_m: 1.0, ..settings };
    let mut engine = variant.engine(model, contact, variant.sweeps(), change).unwrap();
    engine.tick(&sample([0.0, 0.0, 0.5], 1));
    engine
}

/// Bodies of both kinds with a coarse level under the schemes that have them, without under all that move them.
fn cases() -> Vec<(ImageBytes, Variant)> {
    let of = |coarse_functions: bool, variants: [Vec<Variant>; 2]| {
        let images =
            boxes(if coarse_functions { BasisSpacing::Links(2.5) } else { BasisSpacing::None });
        images.into_iter().zip(variants).flat_map(move |(image, variants)| {
            let those =
                variants.into_iter().filter(move |variant| variant.coarse == coarse_functions);
            those.map(move |variant| (image.clone(), variant))
        })
    };
    let variants = [Variant::all(), Variant::of_shapes()];
    of(true, variants.clone()).chain(of(false, variants)).collect()
}

/// The plain variants of each kind of body, with a coarse level in the image.
fn plain() -> Vec<(ImageBytes, Variant)> {
    let images = boxes(BasisSpacing::Links(2.5)).into_iter();
    let each = images.flat_map(|image| {
        let variants = Variant::plain_of(&Model::from_bytes(image.as_bytes()).unwrap());
        variants.into_iter().map(move |variant| (image.clone(), variant))
    });
    each.collect()
}

/// Down into the top of the box by a link and a half, aside by two links, then still.
fn centre_m(tick: u16) -> [f32; 3] {
    let share =
        |from: u16, ticks: u16| f32::from(tick.saturating_sub(from).min(ticks)) / f32::from(ticks);
    [0.0013 + 0.02 * share(300, 300), 0.0021, TOP_M + RADIUS_M - 0.015 * share(0, 300)]
}

/// Distance of every cell from the probe's surface \[m\], negative inside.
fn beyond_m(engine: &mut Engine<'_>, centre_m: [f32; 3]) -> Vec<f64> {
    let beyond = |at: [f64; 3]| {
        let squares = (0..3).map(|axis| (at[axis] - f64::from(centre_m[axis])).powi(2));
        squares.sum::<f64>().sqrt() - f64::from(RADIUS_M)
    };
    engine.positions_m().into_iter().map(beyond).collect()
}

/// Free surface cells for which something holds of their distance from the probe.
fn surface(model: &Model<'_>, beyond_m: &[f64], is: impl Fn(f64) -> bool) -> Vec<u16> {
    let of = model.surface().iter().copied();
    of.filter(|&cell| !model.is_fixed(cell) && is(beyond_m[usize::from(cell)])).collect()
}

/// Rounding of a distance \[m\].
const ROUNDING_M: f64 = 1e-7;

// REQ-CON-03
#[test]
fn cells_inside_end_on_the_sphere_and_fixed_ones_stay() {
    for (image, kind) in plain() {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let mut engine = engine_of(model, kind, Unloading::Off, 200).unwrap();
        let rest = engine.positions_m();
        let mut pushed = 0;
        for tick in 0..400 {
            let at = centre_m(tick);
            let before = beyond_m(&mut engine, at);
            let inside = surface(&model, &before, |beyond| beyond < -ROUNDING_M);
            let output = engine.tick(&sample(at, 1));
            // A rollback is the guard's own business.
            assert!([0, Flags::ROLLED_BACK.0].contains(&output.flags.0), "{kind:?} tick {tick}");
            let after = beyond_m(&mut engine, at);
            let on = surface(&model, &after, |beyond| beyond.abs() < ROUNDING_M);
            assert!(inside.iter().all(|cell| on.contains(cell)), "{kind:?} tick {tick}");
            assert!(on.len() >= output.contacts as usize, "{kind:?} tick {tick}");
            assert!(output.contacts as usize >= inside.len());
            pushed += inside.len();
        }
        assert!(pushed > 50, "{kind:?}: {pushed}");
        // Deep in a corner of the bottom, where all is fixed.
        let corner = rest[usize::from(model.fixed()[0])].map(|x| x as f32);
        for _ in 0..3 {
            engine.tick(&sample(corner, 0));
            engine.tick(&sample(corner, 1));
        }
        let now = engine.positions_m();
        assert!(
            model.fixed().iter().all(|&cell| now[usize::from(cell)] == rest[usize::from(cell)])
        );
    }
}

// REQ-CON-04
#[test]
fn over_the_capacity_the_lowest_cells_are_kept_and_it_is_said() {
    for image in boxes(BasisSpacing::None) {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        for (capacity, full) in [(3, true), (8, true), (200, false)] {
            let mut engine = engaged_above(model, Scheme::Track, capacity);
            let at = [0.0, 0.0, TOP_M + 0.005];
            let before = beyond_m(&mut engine, at);
            let inside = surface(&model, &before, |beyond| beyond < -ROUNDING_M);
            assert!(inside.len() > 8);
            let output = engine.tick(&sample(at, 1));
            assert_eq!(output.flags.contains(Flags::CONTACT_CAPACITY), full);
            let expected = &inside[..capacity.min(inside.len())];
            assert_eq!(output.contacts as usize, expected.len());
            let after = beyond_m(&mut engine, at);
            assert_eq!(surface(&model, &after, |beyond| beyond.abs() < ROUNDING_M), expected);
        }
    }
}

// REQ-CON-03
#[test]
fn a_cell_at_the_centre_leaves_along_its_normal() {
    let [links, shapes] = boxes(BasisSpacing::None);
    let plane = image("plane:9x9x0.01", BasisSpacing::None);
    for (image, top, scheme) in
        [(links, TOP_M, Scheme::Euler), (shapes, TOP_M, Scheme::Track), (plane, 0.0, Scheme::Euler)]
    {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        if top == 0.0 {
            // A plane has one side: all its cells, normal to it.
            assert_eq!(model.surface().len(), model.cells());
            assert!(model.normals().iter().all(|normal| *normal == [0.0, 0.0, 1.0]));
        }
        let mut engine = engaged_above(model, scheme, 200);
        let near = |at: [f64; 3]| at[0].abs() + at[1].abs() + (at[2] - f64::from(top)).abs() < 1e-6;
        let cell = engine.positions_m().into_iter().position(near).unwrap();
        engine.tick(&sample([0.0, 0.0, top], 1));
        let at = engine.positions_m()[cell];
        assert!(at[0].abs() + at[1].abs() < 1e-6, "{at:?}");
        assert!((at[2] - f64::from(top + RADIUS_M)).abs() < 1e-6, "{at:?}");
    }
}

/// The tool presses, slides and stands still.
// REQ-FOR-06
#[test]
fn contacts_and_force_do_not_chatter() {
    for (image, kind) in cases() {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let mut engine = engine_of(model, kind, Unloading::Off, 200).unwrap();
        let mut outputs: Vec<TickOutput> = Vec::new();
        let mut held = Vec::new();
        for tick in 0..1800 {
            outputs.push(engine.tick(&sample(centre_m(tick), 1)));
            if tick == 1400 {
                let beyond = beyond_m(&mut engine, centre_m(tick));
                let on = surface(&model, &beyond, |beyond| beyond.abs() < ROUNDING_M);
                let at = engine.positions_m();
                held = on.iter().map(|&cell| (cell, at[usize::from(cell)])).collect();
            }
        }
        let jumps: Vec<f32> =
            outputs.windows(2).map(|pair| (pair[1].force_n - pair[0].force_n).norm()).collect();
        let peak = outputs.iter().map(|output| output.force_n.norm()).fold(0.0, f32::max);
        let largest = |jumps: &[f32]| jumps.iter().copied().fold(0.0, f32::max);
        assert!(peak > 0.3, "{kind:?}: {peak} N");
        // A cell that is let go takes what held it sideways along.
        assert!(largest(&jumps) < 0.2 * peak, "{kind:?}: {}", largest(&jumps));
        let still = &outputs[1400..];
        let count = still[0].contacts;
        assert!(count > 5 && still.iter().all(|output| output.contacts == count), "{kind:?}");
        assert!(held.len() >= count as usize);
        let at = engine.positions_m();
        let kept = held.iter().filter(|(cell, before)| at[usize::from(*cell)] == *before);
        assert!(kept.count() >= count as usize, "{kind:?}: held cells move");
        // The coarse level of shapes spreads the rounding of their forces.
        let hum = if kind.coarse && model.is_nodal() { 2.5e-3 } else { 1e-3 };
        assert!(largest(&jumps[1400..]) < hum * peak, "{kind:?}: {}", largest(&jumps[1400..]));
    }
}

// REQ-FOR-02
#[test]
fn let_go_the_tool_feels_nothing() {
    for (image, kind) in plain() {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let mut engine = engine_of(model, kind, Unloading::Release, 200).unwrap();
        for tick in 0..300 {
            engine.tick(&sample(centre_m(tick), 1));
        }
        assert!(engine.tick(&sample(centre_m(300), 1)).force_n.norm() > 0.1, "{kind:?}");
        let pressed = engine.positions_m();
        for _ in 0..200 {
            let output = engine.tick(&sample(centre_m(300), 0));
            assert_eq!((output.force_n, output.contacts), (Vector3::zeros(), 0));
            assert!(output.flags.contains(Flags::BAND_CLOSED));
        }
        let after = engine.positions_m();
        assert_ne!(pressed, after);
        // Taking hold again is a new beginning, far off too.
        let output = engine.tick(&sample([9.0, 9.0, 9.0], 1));
        assert_eq!((output.force_n, output.contacts), (Vector3::zeros(), 0));
        assert!(!output.flags.contains(Flags::BAND_CLOSED));
    }
}

/// On the vector unit and without it, with sleep and without.
// REQ-BIT-02
#[test]
fn the_bits_are_the_same_however_they_are_computed() {
    for (image, kind) in cases() {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let mut engines = [(); 3].map(|()| engine_of(model, kind, Unloading::Retreat, 12).unwrap());
        engines[1].go_scalar();
        engines[2].forbid_sleep();
        let mut hashes = Vec::new();
        for tick in 0..400_u16 {
            let engaged = u32::from(tick % 370 < 330);
            let sample = ToolPose::at(centre_m(2 * tick).into(), engaged);
            let [one, scalar, sleepless] = engines.each_mut().map(|engine| {
                let TickOutput { force_n, energy_j, work_j, contacts, flags, .. } =
                    engine.tick(&sample);
                let force = force_n.data.0[0].map(f32::to_bits);
                (force, [energy_j, work_j].map(f32::to_bits), contacts, flags, engine.state_hash())
            });
            assert_eq!(one, scalar, "{kind:?} tick {tick}");
            assert_eq!(one, sleepless, "{kind:?} tick {tick}");
            hashes.push(one.4);
        }
        hashes.sort_unstable();
        hashes.dedup();
        assert!(hashes.len() > 200, "{kind:?}: {}", hashes.len());
    }
}

// REQ-CON-05
#[test]
fn a_probe_that_cannot_be_is_refused() {
    let line = [0.0, 0.01, 0.02].map(|x| [x, 0.0, 0.0]).to_vec();
    let line = shape(line, vec![[0, 1], [1, 2]], vec![0]).bake(&BakeOptions::default()).unwrap();
    let plane = image("plane:5x5x0.01", BasisSpacing::None);
    for (image, radius_m, part) in [
        (&line, 0.01, "no surface"),
        (&plane, 0.0, "above 0"),
        (&plane, f32::NAN, "above 0"),
        (&plane, 1e30, "at most"),
    ] {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let contact = Contact::Probe { radius_m, capacity: 4 };
        let variant = Variant::plain(Scheme::Track, Arithmetic::F32);
        let why = variant.engine(model, contact, 4, |of| of).err().unwrap().to_string();
        assert!(why.contains(part), "{why}");
    }
}

/// Where the tool goes, in metres, some of it far outside the body, and whether it touches.
fn moves() -> impl Strategy<Value = Vec<([f32; 3], bool)>> {
    let near = prop::array::uniform3(-0.1_f32..0.1);
    let far = prop::array::uniform3(-20.0_f32..20.0);
    let place = prop_oneof![6 => near, 1 => far];
    prop::collection::vec((place, prop::bool::weighted(0.8)), 1..40)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(500) })]

    /// Wherever the probe jumps to: no NaN, the energy of what is published is at most the
    /// certified level and the model's largest energy.
    // REQ-ENE-03
    #[test]
    fn the_certified_level_holds(
        (case, variant) in body(false, Variant::plain_ones()), moves in moves(),
        radius_m in 0.001_f32..0.15, capacity in 1_usize..40, teleports in any::<bool>(),
    ) {
        let image = case.with_surface().image();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let contact = Contact::Probe { radius_m, capacity };
        let change = |settings: Settings| Settings {
            unloading: Unloading::Off,
            max_tool_step_m: if teleports { 100.0 } else { settings.max_tool_step_m },
            ..settings
        };
        // Some bodies are beyond the range of fixed point.
        let Ok(mut engine) = case.engine_with(model, variant, contact, change) else {
            return Ok(());
        };
        let mut monitor = Monitor::new(&engine, variant.scheme, variant.numbers);
        let mut rest = engine.positions_m();
        for (position_m, engaged) in moves {
            let output = monitor.tick(&mut engine, &sample(position_m, u32::from(engaged)));
            prop_assert!(output.contacts as usize <= capacity && (engaged || output.contacts == 0));
            let now = engine.positions_m();
            for &cell in model.fixed() {
                let cell = usize::from(cell);
                prop_assert_eq!(now[cell], rest[cell]);
            }
            rest = now;
        }
        holds(&monitor)?;
    }
}

/// A tool that leaves faster than the tissue follows draws nothing after it: no force on
/// the tool, no energy that nobody put in, and no contact that stays.
// REQ-ENE-09
#[test]
fn a_tool_that_leaves_at_once_draws_no_cell_along() {
    for (image, kind) in plain() {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        for way_m in [0.003, 0.01, 0.4] {
            let mut engine = engine_of(model, kind, Unloading::Off, 200).unwrap();
            let mut last = engine.tick(&sample(centre_m(0), 1));
            for tick in 1..250 {
                last = engine.tick(&sample(centre_m(tick), 1));
            }
            assert!(last.contacts > 0 && last.force_n[2] > 0.05, "{kind:?}");
            let pressed_j = last.energy_j;
            let [x, y, z] = centre_m(250);
            for tick in 1..60_u16 {
                let at = [x, y, z + way_m * f32::from(tick)];
                let output = engine.tick(&sample(at, 1));
                let place = format!("{kind:?}, {way_m} m a tick, tick {tick}");
                assert!(output.force_n[2] >= -1e-3, "{place}: {}", output.force_n);
                assert!(output.energy_j <= pressed_j, "{place}: {output:?}, {pressed_j} J");
                last = output;
            }
            assert_eq!((last.contacts, last.force_n), (0, Vector3::zeros()), "{kind:?} {way_m}");
        }
    }
}
