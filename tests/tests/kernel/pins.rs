//! Pins: regions of the surface that are held to the world, set and released while tools press and pull.
#![allow(clippy::unwrap_used)]

use std::sync::LazyLock;

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{Budget, Network, PinError, Settings, ToolPart, ToolPose};
use chaincell_lab::monitor::Monitor;
use chaincell_tests::bodies::{baked, model, nodal, under};
use nalgebra::Vector3;

use crate::bench::Bench;

/// Height of the top of the block \[m\].
const TOP_M: f32 = 0.04;
/// Radius of the ball that presses and pulls \[m\].
const BALL_M: f32 = 0.008;
const RIGID: f32 = f32::INFINITY;

/// Blocks on a fixed ground, 40 mm high and 48 mm wide, with edges of about 8 mm.
static BLOCKS: LazyLock<[(&str, ImageBytes); 2]> = LazyLock::new(|| {
    let coarse_basis = BasisSpacing::Links(2.5);
    let links = BakeOptions { coarse_basis, ..BakeOptions::default() };
    [("shapes", nodal("box:7x7x6x0.008", 5000.0)), ("links", baked("box:7x7x6x0.008", &links))]
});

fn engine(image: &ImageBytes, way: (Scheme, u16)) -> Engine<'_> {
    let contact = Contact::sphere(BALL_M, 0.0);
    under(image, contact, way, 1.0e3).unwrap()
}

fn ball(x_m: f32, depth_m: f32) -> ToolPose {
    ToolPose::at([x_m, 0.0, TOP_M + BALL_M - depth_m].into(), 1)
}

fn away() -> ToolPose {
    ToolPose { engaged: 0, ..ball(0.0, -0.02) }
}

/// Numbers between 0 and 1, the same in every run.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }
}

#[test]
fn a_pin_bears_what_a_tool_presses_on_it() {
    for (body, image) in BLOCKS.iter() {
        for (stiffness, most_m) in [(RIGID, 2.0e-4), (100.0, 1.0e-3)] {
            let mut engine = engine(image, (Scheme::Predict, 8));
            let free_m = press(&mut engine, None);
            engine.reset().unwrap();
            let pin = engine.pin_at([0.012, 0.0, TOP_M], 0.006, stiffness).unwrap();
            let held_m = press(&mut engine, Some(pin));
            let output = engine.pin_output(pin).unwrap();
            let force_n = output.force_n.norm();
            println!("{body} {stiffness}: free {free_m}, held {held_m}, {output:?}");
            assert!(force_n > 0.01 && output.samples > 3, "{body}: {output:?}");
            assert!(held_m < most_m && held_m < 0.7 * free_m, "{body}: {held_m} of {free_m}");
            let by_spring_n = output.stiffness_n_per_m * held_m;
            // The mean of the samples is no more than their stretch.
            assert!(by_spring_n < 1.1 * force_n, "{body}: {by_spring_n} {output:?}");
        }
    }
}

/// Presses 6 mm deep and stays. Returns how far the pinned place, or that of a pin set and at once released, moves
/// \[m\].
fn press(engine: &mut Engine<'_>, pin: Option<u16>) -> f32 {
    let soft = pin.unwrap_or_else(|| engine.pin_at([0.012, 0.0, TOP_M], 0.006, 1.0e-6).unwrap());
    for step in 0..200_u16 {
        engine.tick_by(&[ball(0.0, 1.0e-4 * f32::from(step.min(60)))], Budget::All);
    }
    Vector3::from(engine.pin_output(soft).unwrap().given_m).norm()
}

/// Stiff and soft pins at random places and ticks, released over random ticks, under a ball that presses, grips and
/// jumps far away with what it grips.
// REQ-CON-13
#[test]
fn no_pin_makes_energy() {
    for (body, image) in BLOCKS.iter() {
        for (seed, way) in [(Scheme::Predict, 1), (Scheme::Predict, 4), (Scheme::Track, 1)]
            .into_iter()
            .flat_map(|way| (1..=3_u8).map(move |seed| (seed, way)))
        {
            let mut engine = engine(image, way);
            let mut monitor = Monitor::new(&engine, Arithmetic::F32);
            monitor.rests(&mut engine);
            let mut dice = Dice(seed.into());
            let (mut most_n, mut set, mut place) = (0.0_f32, 0, [0.0, 0.0]);
            for tick in 0..1500_u16 {
                let at = [0.04 * dice.roll() - 0.02, 0.04 * dice.roll() - 0.02, TOP_M];
                let (chance, other) = (dice.roll(), dice.roll());
                let radius_m = 0.003 + 0.012 * dice.roll();
                if chance < 0.02 {
                    let stiffness = if other < 0.6 { RIGID } else { 1.0e4 * other.powi(8) };
                    set +=
                        u32::from(monitor.pin_at(&mut engine, (at, radius_m), stiffness).is_ok());
                } else if chance < 0.04 {
                    set += u32::from(engine.pin_held(0, RIGID).is_ok());
                } else if chance < 0.07 {
                    monitor.grip(&mut engine, 0);
                } else if chance < 0.09 {
                    engine.let_go(0, 1 + (20.0 * other) as u16);
                } else if chance < 0.13
                    && let Some(&pin) = engine.pins().first()
                {
                    engine.unpin(pin, 1 + (30.0 * other) as u16).unwrap();
                }
                if dice.roll() < 0.05 {
                    place = [0.03 * dice.roll() - 0.015, 0.06 * dice.roll() - 0.04];
                }
                let sweeps = (dice.roll() < 0.05).then_some(0);
                let pose = if dice.roll() < 0.02 { away() } else { ball(place[0], place[1]) };
                let pose = if tick < 5 { away() } else { pose };
                monitor.tick(&mut engine, &[pose], sweeps);
                for pin in engine.pins() {
                    most_n = most_n.max(engine.pin_output(pin).unwrap().force_n.norm());
                }
            }
            println!("{body} {way:?}: {set} pins, most {most_n} N, {:?}", monitor.worst());
            assert!(set > 20 && most_n > 0.1, "{body}: {set} {most_n}");
            assert!(
                monitor.failures().is_empty(),
                "{body} {way:?} {seed}: {:?}",
                monitor.failures()
            );
        }
    }
}

// REQ-CON-13
#[test]
fn a_pin_passes_a_pull_on_and_ends_it_without_a_jump() {
    for (body, image) in BLOCKS.iter() {
        let mut engine = engine(image, (Scheme::Predict, 8));
        let force_n = |engine: &mut Engine<'_>| engine.tool_output(0).force_n;
        for step in 0..=60_u8 {
            engine.tick_by(&[ball(0.0, 5.0e-5 * f32::from(step))], Budget::All);
        }
        assert!(engine.grip(0) > 4);
        for step in 0..=300_u16 {
            engine.tick_by(&[ball(0.0, 0.003 - 5.0e-5 * f32::from(step.min(120)))], Budget::All);
        }
        // The ball stands still and pulls. A pin takes no force, and changes none.
        let pulled = force_n(&mut engine);
        assert!(pulled.z < -0.01, "{body}: {pulled}");
        let pin = engine.pin_held(0, RIGID).unwrap();
        let output = engine.pin_output(pin).unwrap();
        assert_eq!((output.force_n.norm(), output.energy_j), (0.0, 0.0), "{body}");
        for _ in 0..20 {
            engine.tick_by(&[ball(0.0, -0.003)], Budget::All);
            let off = (force_n(&mut engine) - pulled).norm();
            assert!(off < 0.02 * pulled.norm(), "{body}: {off} {pulled}");
        }
        // Let go: the pull passes to the pin along the ramp.
        engine.let_go(0, 50);
        let mut last = [pulled, engine.pin_output(pin).unwrap().force_n];
        let mut largest = 0.0_f32;
        for _ in 0..60 {
            engine.tick_by(&[ball(0.0, -0.003)], Budget::All);
            let now = [force_n(&mut engine), engine.pin_output(pin).unwrap().force_n];
            largest = largest.max((now[0] - last[0]).norm()).max((now[1] - last[1]).norm());
            last = now;
        }
        println!("{body}: pulled {pulled}, largest step {largest}, {last:?}");
        assert!(largest < 0.1 * pulled.norm(), "{body}: {largest} {pulled}");
        let [of_tool, of_pin] = last;
        assert!(of_tool.norm() < 1e-3 * pulled.norm(), "{body}: {last:?} {pulled}");
        // Rigid pins on links are softer, so the tissue draws back a little.
        let gives = if *body == "links" { 0.5 } else { 0.1 };
        assert!((of_pin.z / pulled.z - 1.0).abs() < gives, "{body}: {last:?} {pulled}");
        // Without a tool it still holds; released, it ends as softly.
        engine.tick_by(&[away()], Budget::All);
        engine.unpin(pin, 50).unwrap();
        let mut largest = 0.0_f32;
        while let Some(output) = engine.pin_output(pin) {
            largest = largest.max((output.force_n - last[1]).norm());
            last[1] = output.force_n;
            engine.tick_by(&[away()], Budget::All);
        }
        println!("{body}: largest step {largest} of the release");
        assert!(largest < 0.1 * pulled.norm() && last[1].norm() < 0.1 * pulled.norm(), "{body}");
    }
}

/// A tissue goes on from a snapshot with its pins; one without pins has no words of them.
#[test]
fn a_snapshot_has_the_pins() {
    let image = &BLOCKS[0].1;
    let mut one = engine(image, (Scheme::Predict, 2));
    for step in 0..40_u8 {
        one.tick_by(&[ball(0.0, 1.0e-4 * f32::from(step))], Budget::All);
    }
    let before = one.save().unwrap();
    let pin = one.pin_at([0.012, 0.0, TOP_M], 0.006, RIGID).unwrap();
    let other = one.pin_held(0, 50.0).unwrap();
    one.unpin(other, 30).unwrap();
    let samples = one.pin_output(pin).unwrap().samples + one.pin_output(other).unwrap().samples;
    let after = one.save().unwrap();
    // Three words, and fourteen for each sample; the body is the same.
    assert_eq!(after.len() - before.len(), 4 * (3 + 14 * samples as usize));
    let mut two = engine(image, (Scheme::Predict, 2));
    two.restore(&after).unwrap();
    assert_eq!(two.pins(), [pin, other]);
    for step in 40..100_u8 {
        let at = ball(0.0, 1.0e-4 * f32::from(step.min(60)));
        assert_eq!(one.tick_by(&[at], Budget::All), two.tick_by(&[at], Budget::All));
        assert_eq!(one.state_hash(), two.state_hash(), "{step}");
        assert_eq!(one.pin_output(pin), two.pin_output(pin));
    }
    // Without pins again.
    two.restore(&before).unwrap();
    assert_eq!((two.pins(), two.save().unwrap()), (vec![], before));
}

/// The energy of body and pins stays within what the blade gave, while cells split under the pinned triangles.
// REQ-CON-13
#[test]
fn pins_stay_on_their_sides_of_a_cut() {
    let mesh = load("box:16x10x5x0.004", &MeshOptions::default()).unwrap();
    let tissue = Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3)));
    let cuttable = Some(Cuttable {
        spare_share: 0.5,
        toughness_j_per_m2: PerCell::Uniform(4.0),
        ..Cuttable::default()
    });
    let options = BakeOptions { tissue, cuttable, ..BakeOptions::default() };
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    let model = model(&image);
    let settings = Settings { sweeps: 3, ..Settings::for_model(&model) };
    let network = Network::new(model, settings).unwrap();
    let mut bench: Bench<'_> = Bench::under(network, &[&[ToolPart::edge(0.032)]], 0.0);
    let pins = [[-0.01, 0.004, 0.016], [0.0, 0.0003, 0.016], [0.015, -0.003, 0.016]]
        .map(|point_m| bench.view().pin_at(&network, point_m, 0.005, RIGID).unwrap());
    let (mut given_j, mut most_n) = (0.0, 0.0_f32);
    for tick in 0..700_u16 {
        let at = [0.0007, 0.0003, 0.017 - 2.0e-5 * f32::from(tick)];
        let mut view = bench.view();
        let output = view.tick(&network, &[ToolPose::at(at.into(), 1)], Budget::All);
        given_j += f64::from(view.given_j(&network));
        let energy_j = f64::from(output.energy_j);
        assert!(energy_j <= 1.001 * given_j, "{tick}: {energy_j} J of {given_j} J");
        for pin in pins {
            let of_pin = view.pin_output(&network, pin).unwrap();
            most_n = most_n.max(of_pin.force_n.norm());
            let given_m = Vector3::from(of_pin.given_m).norm();
            assert!(given_m < 5.0e-4, "{tick}: pin {pin} gives {given_m} m");
        }
    }
    let cuts = bench.view().cut_output(&network);
    println!("{cuts:?}, {given_j} J, {most_n} N");
    assert!(cuts.copies > 20 && most_n > 0.01, "{cuts:?} {most_n}");
    // Away, the level only falls; released, the pins are gone.
    let mut last_j = f32::MAX;
    for pin in pins {
        bench.view().unpin(pin, 20).unwrap();
    }
    for _ in 0..100 {
        let pose = ToolPose { engaged: 0, ..ToolPose::at([0.0, 0.0, 0.05].into(), 0) };
        let output = bench.view().tick(&network, &[pose], Budget::All);
        assert!(output.energy_j <= last_j * 1.00001, "{output:?} after {last_j} J");
        last_j = output.energy_j;
    }
    assert_eq!(bench.view().pins().count(), 0);
}

/// Pinned at rest a body stays at rest to the last bit; pinned and pulled it comes to rest, and with it its hash.
// REQ-CON-13
#[test]
fn a_pinned_body_rests() {
    for (body, image) in BLOCKS.iter() {
        let mut engine = engine(image, (Scheme::Predict, 8));
        let rest = engine.state_hash();
        let pin = engine.pin_at([0.0, 0.0, TOP_M], 0.006, RIGID).unwrap();
        let pinned = engine.state_hash();
        assert_ne!(pinned, rest, "{body}: the hash covers pins");
        for _ in 0..50 {
            let output = engine.tick_by(&[away()], Budget::All);
            assert_eq!((output.energy_j, engine.state_hash()), (0.0, pinned), "{body}");
        }
        engine.unpin(pin, 3).unwrap();
        for _ in 0..4 {
            engine.tick_by(&[away()], Budget::All);
        }
        assert_eq!((engine.state_hash(), engine.pins()), (rest, vec![]), "{body}");
    }
}

// REQ-CON-13
#[test]
fn pins_that_cannot_be_are_refused_by_name() {
    let mut engine = engine(&BLOCKS[0].1, (Scheme::Predict, 4));
    let top = [0.0, 0.0, TOP_M];
    let nan = f32::NAN;
    for (point, radius_m, stiffness) in [
        ([nan, 0.0, 0.0], 0.01, RIGID),
        (top, 0.0, RIGID),
        (top, RIGID, RIGID),
        (top, nan, RIGID),
        (top, 0.01, 0.0),
        (top, 0.01, -1.0),
        (top, 0.01, nan),
    ] {
        assert_eq!(engine.pin_at(point, radius_m, stiffness), Err(PinError::Value));
    }
    let Err(PinError::Reach { nearest_m }) = engine.pin_at([0.0, 0.0, 0.1], 0.01, RIGID) else {
        panic!("the surface ends 60 mm below");
    };
    assert!((nearest_m - 0.06).abs() < 1e-3, "{nearest_m}");
    // Distances whose squares are beyond f32 are within no radius.
    let far = engine.pin_at([1.0e30, 0.0, 0.0], 1.0e25, RIGID);
    assert!(matches!(far, Err(PinError::Reach { .. })), "{far:?}");
    assert_eq!(engine.pin_held(0, RIGID), Err(PinError::NothingHeld(0)));
    assert_eq!(engine.pin_held(7, RIGID), Err(PinError::NothingHeld(7)));
    assert_eq!(engine.unpin(0, 1), Err(PinError::Unknown(0)));
    // Room for 2,048 samples in all.
    let refused = (0..100).find_map(|_| engine.pin_at(top, 0.02, RIGID).err()).unwrap();
    assert!(matches!(refused, PinError::Room { capacity, .. } if capacity < 2048), "{refused:?}");
    let count = engine.pins().len() as u16;
    assert_eq!(engine.pins(), (0..count).collect::<Vec<_>>());
    // The lowest free number is taken again.
    engine.unpin(1, 1).unwrap();
    engine.tick_by(&[away()], Budget::All);
    assert_eq!(engine.pin_at(top, 0.004, RIGID), Ok(1));
    // Cells that a tool holds have no surface.
    let contact = Contact::Cells(vec![]);
    let mut held = under(&BLOCKS[0].1, contact, (Scheme::Predict, 4), 1.0).unwrap();
    assert_eq!(held.pin_at(top, 0.01, RIGID), Err(PinError::NoTools));
}
