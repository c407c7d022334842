//! Snapshots: a tissue or a stage that goes on from one gives the bits of that which was saved.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::{Band, Branch, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::stage::{Device, Stage, StageSettings};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{
    Budget, Choice, Drive, Model, NOT_TURNED, Network, TickOutput, ToolPart, ToolPose, Unloading,
};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_tests::graph::sample;

/// Ticks that a restored tissue is compared for.
const AFTER: usize = 1000;

/// Links that differ, with slack where there is an alpha.
fn links(alpha: f64, coarse_functions: bool) -> ImageBytes {
    let options = BakeOptions {
        alpha: PerCell::Uniform(alpha),
        stiffness_n_per_m: PerCell::Each((0..48).map(|i| 10.0 + f64::from(i % 7)).collect()),
        coarse_basis: if coarse_functions { BasisSpacing::Links(2.0) } else { BasisSpacing::None },
        ..BakeOptions::default()
    };
    Shape::generated("box:4x4x3x0.01").unwrap().bake(&options).unwrap()
}

/// Nodal shapes with a contact surface, that stiffen.
fn shapes() -> ImageBytes {
    let stiffening = vec![Band::new(0.05, 12_000.0)];
    let tissue = Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45));
    let options = BakeOptions {
        tissue: Some(Tissue { stiffening, ..tissue }),
        coarse_basis: BasisSpacing::Links(2.0),
        ..BakeOptions::default()
    };
    Shape::generated("box:4x4x3x0.01").unwrap().bake(&options).unwrap()
}

/// A tissue to be saved.
struct Case<'a> {
    image: &'a ImageBytes,
    scheme: Scheme,
    numbers: Arithmetic,
    contact: Contact,
    unloading: Unloading,
    drive: Drive,
}

impl<'a> Case<'a> {
    fn new(image: &'a ImageBytes, scheme: Scheme, contact: Contact) -> Self {
        let (numbers, unloading) = (Arithmetic::F32, Unloading::Release);
        Self { image, scheme, numbers, contact, unloading, drive: Drive::Position }
    }

    fn engine(&self) -> Engine<'a> {
        let model = Model::from_bytes(self.image.as_bytes()).unwrap();
        let mut settings = self.scheme.settings(&model, 2);
        (settings.unloading, settings.drive) = (self.unloading, self.drive);
        let network = Network::new(model, settings).unwrap();
        Engine::with_contact(network, self.scheme, self.numbers, self.contact.clone()).unwrap()
    }

    /// Samples of a press that wavers, lets go, rests, comes back, and has bad ones.
    fn sample(&self, tick: usize) -> ToolPose {
        let model = Model::from_bytes(self.image.as_bytes()).unwrap();
        let (unit_m, [x, y, z]) = (model.unit_m(), model.centre_m());
        let (cycle, phase) = (tick / 400, (tick % 400) as f32);
        let is_held = matches!(self.contact, Contact::Cells(_));
        let top = if is_held { z } else { z + 2.3 * unit_m };
        let depth = unit_m * (phase.min(250.0) * 0.006 + 0.2 * (phase * 0.1).sin());
        let place = [x + 0.3 * unit_m * cycle as f32, y, top - depth];
        let engaged = u32::from(tick % 400 < 300) + 7 * u32::from(tick % 97 == 3);
        sample(place, engaged)
    }

    /// Some ticks are late, some end early.
    fn tick(&self, engine: &mut Engine<'_>, tick: usize) -> (TickOutput, u64) {
        let sweeps = [None, None, Some(1), None, Some(0)][tick % 5];
        (engine.tick_by(&[self.sample(tick)], Budget::again(sweeps)), engine.state_hash())
    }

    /// Saves after a number of ticks, and continues in another tissue.
    fn holds(&self, ticks: usize) {
        let (mut first, mut second) = (self.engine(), self.engine());
        (0..ticks).for_each(|tick| {
            self.tick(&mut first, tick);
        });
        // Memory that another life has left behind.
        (0..37).for_each(|tick| {
            self.tick(&mut second, tick);
        });
        let bytes = first.save().unwrap();
        assert_eq!(first.save().unwrap(), bytes, "saving changes nothing");
        second.restore(&bytes).unwrap();
        assert_eq!(second.save().unwrap(), bytes, "{:?}: {ticks}", self.scheme);
        let mut touched = 0;
        for tick in ticks..ticks + AFTER {
            let [one, two] = [&mut first, &mut second].map(|of| self.tick(of, tick));
            assert_eq!(one, two, "{:?}, {:?}: tick {tick}", self.scheme, self.contact);
            touched += usize::from(one.0.contacts > 0);
        }
        assert!(touched > AFTER / 4, "{:?}: {touched}", self.contact);
    }
}

/// At rest, as the tool engages, in mid-press, behind a bad sample, released, asleep.
const TICKS: [usize; 6] = [0, 1, 140, 101, 305, 399];

fn held(image: &ImageBytes) -> Contact {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let free = (0..model.cells() as u16).rev().filter(|&cell| !model.is_fixed(cell));
    let mut cells: Vec<u16> = free.step_by(9).take(3).collect();
    cells.sort_unstable();
    Contact::Cells(cells)
}

// REQ-BIT-09
#[test]
fn every_scheme_goes_on_from_held_cells() {
    for image in [links(0.0, true), links(0.08, false), shapes()] {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        for Variant { scheme, .. } in Variant::singles_of(&model) {
            let case = Case::new(&image, scheme, held(&image));
            TICKS.into_iter().for_each(|ticks| case.holds(ticks));
        }
    }
}

// REQ-BIT-09
#[test]
fn every_number_type_goes_on() {
    let image = links(0.05, false);
    for scheme in [Scheme::Euler, Scheme::Track] {
        let numbers = Arithmetic::Fixed;
        let case = Case { numbers, ..Case::new(&image, scheme, held(&image)) };
        TICKS.into_iter().for_each(|ticks| case.holds(ticks));
    }
}

// REQ-BIT-09
#[test]
fn other_drives_and_bands_go_on() {
    for image in [links(0.1, false), shapes()] {
        for (unloading, drive) in
            [(Unloading::Retreat, Drive::Position), (Unloading::Off, Drive::Current)]
        {
            let case = Case { unloading, drive, ..Case::new(&image, Scheme::Track, held(&image)) };
            TICKS.into_iter().for_each(|ticks| case.holds(ticks));
        }
    }
}

// REQ-BIT-09
#[test]
fn spheres_go_on_over_links_and_shapes() {
    let (links, shapes) = (links(0.0, true), shapes());
    let probe = |image: &ImageBytes| {
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        Contact::sphere(1.2 * model.unit_m(), 0.0)
    };
    for image in [&links, &shapes] {
        for scheme in [Scheme::Track, Scheme::Predict] {
            let case = Case::new(image, scheme, probe(image));
            [140, 305].into_iter().for_each(|ticks| case.holds(ticks));
        }
    }
}

/// Two tools that rub, one of which grips.
// REQ-BIT-09
#[test]
fn tools_go_on_with_friction_and_grips() {
    let image = shapes();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let unit_m = model.unit_m();
    let tools = vec![
        vec![ToolPart::sphere(0.9 * unit_m)],
        vec![ToolPart::capsule(0.6 * unit_m, 0.8 * unit_m)],
    ];
    let contact = Contact::Tools { tools, friction: 0.3 };
    let case = Case::new(&image, Scheme::Predict, contact);
    let poses = |tick: usize| {
        let [x, y, z] = model.centre_m();
        let along = 0.004 * (tick as f32 % 300.0);
        let (sin, cos) = (0.001 * tick as f32).sin_cos();
        let high = z + 1.9 * unit_m;
        let pose = |position_m: [f32; 3], orientation| ToolPose {
            orientation,
            ..ToolPose::at(position_m.into(), u32::from(tick % 300 < 260))
        };
        [
            pose([x - unit_m, y, high - along * unit_m], NOT_TURNED),
            pose([x + along * unit_m, y + unit_m, high - 0.4 * unit_m], [0.0, sin, 0.0, cos]),
        ]
    };
    let mut touched = 0;
    for ticks in [3, 120, 170, 280] {
        let (mut first, mut second) = (case.engine(), case.engine());
        let go = |engine: &mut Engine<'_>, tick: usize| {
            if tick == 100 {
                let _ = engine.obey(&Command::Grip { tool: 0 });
            }
            if tick == 160 {
                let _ = engine.obey(&Command::LetGo { tool: 0, ticks: 40 });
            }
            let output = engine.tick_by(&poses(tick), Budget::All);
            let felt = [0, 1].map(|tool| engine.tool_output(tool));
            (output, felt, engine.contact_forces(), engine.state_hash())
        };
        (0..ticks).for_each(|tick| {
            go(&mut first, tick);
        });
        second.restore(&first.save().unwrap()).unwrap();
        for tick in ticks..ticks + AFTER {
            let one = go(&mut first, tick);
            assert_eq!(one, go(&mut second, tick), "{ticks}: {tick}");
            touched += one.2.len();
        }
    }
    assert!(touched > 10_000, "{touched}");
}

/// Loaded, asleep, then woken by other bands.
// REQ-BIT-09
#[test]
fn a_sleeping_press_goes_on_when_it_is_woken() {
    let image = shapes();
    let radius_m = 0.012;
    let case = Case::new(&image, Scheme::Track, Contact::sphere(radius_m, 0.0));
    let (mut first, mut second) = (case.engine(), case.engine());
    let sample = case.sample(120);
    (0..120).for_each(|tick| {
        case.tick(&mut first, tick);
    });
    (0..600).for_each(|_| {
        first.tick(&sample);
    });
    second.restore(&first.save().unwrap()).unwrap();
    for tick in 0..AFTER {
        if tick == 20 {
            first.obey(&Command::Sweeps(3)).unwrap();
            second.obey(&Command::Sweeps(3)).unwrap();
        }
        let [one, two] = [&mut first, &mut second].map(|of| (of.tick(&sample), of.state_hash()));
        assert_eq!(one, two, "{tick}");
    }
}

// REQ-BIT-09
#[test]
fn a_stage_goes_on_to_the_same_forces() {
    for device in Device::ALL {
        let mut first = Stage::new(StageSettings::for_device(*device)).unwrap();
        let mut second = first;
        let tick = |stage: &mut Stage, tick: usize| {
            let depth_m = 1.0e-5 * (tick % 300) as f32;
            if tick % 41 == 7 {
                return stage.missed();
            }
            if tick.is_multiple_of(5) {
                stage.delayed((tick % 4) as u16);
            }
            let tool = stage.sample(&sample([0.0, 0.0, -depth_m], 1));
            let force_n = [0.0, 0.0, -900.0 * tool.position_m.z].into();
            stage.output(&TickOutput { force_n, stiffness_n_per_m: 900.0, ..TickOutput::NONE })
        };
        (0..170).for_each(|at| {
            tick(&mut first, at);
        });
        (0..11).for_each(|at| {
            tick(&mut second, 3 * at);
        });
        let mut bytes = vec![0; first.snapshot_bytes()];
        assert_eq!(first.save(&mut bytes), Ok(bytes.len()));
        second.restore(&bytes).unwrap();
        for at in 170..170 + AFTER {
            assert_eq!(tick(&mut first, at), tick(&mut second, at), "{device:?}: {at}");
        }
        assert_eq!(first, second);
    }
}

/// A tissue in mid-press and its snapshot.
fn pressed<'a>(case: &Case<'a>) -> (Engine<'a>, Vec<u8>) {
    let mut engine = case.engine();
    (0..140).for_each(|tick| {
        case.tick(&mut engine, tick);
    });
    let bytes = engine.save().unwrap();
    (engine, bytes)
}

/// What a tissue says of these bytes, which changes nothing in it.
fn refusal(engine: &mut Engine<'_>, bytes: &[u8]) -> String {
    let before = engine.save().unwrap();
    let why = engine.restore(bytes).unwrap_err().to_string();
    assert_eq!(engine.save().unwrap(), before, "{why}");
    why
}

// REQ-BIT-10
#[test]
fn damaged_snapshots_are_refused_and_change_nothing() {
    for image in [links(0.0, true), shapes()] {
        let case = Case::new(&image, Scheme::Track, held(&image));
        let (_, bytes) = pressed(&case);
        let mut engine = case.engine();
        for at in (0..bytes.len()).step_by(bytes.len() / 100).chain(0..32) {
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (at % 8);
            refusal(&mut engine, &flipped);
            refusal(&mut engine, &bytes[..at]);
        }
        let mut longer = bytes.clone();
        longer.extend([0; 4]);
        assert!(refusal(&mut engine, &longer).contains("not whole"));
        let none = b"no snapshot at all, but long enough";
        assert!(refusal(&mut engine, none).contains("not a snapshot"));
    }
}

/// Sets the checksum of a snapshot.
pub fn check(snapshot: &mut [u8]) {
    let digest = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
    let mut sum = digest.digest();
    sum.update(&snapshot[..24]);
    sum.update(&snapshot[28..]);
    let sum = sum.finalize().to_le_bytes();
    snapshot[24..28].copy_from_slice(&sum);
}

/// Words of any kind with the checksum right: refused, or harmless.
// REQ-BIT-10
#[test]
fn forged_snapshots_are_refused_or_harmless() {
    let wild = [f32::NAN.to_bits(), u32::MAX, f32::MAX.to_bits(), 3, 0, 0xff80_0000];
    for (image, step, least) in [(shapes(), 68, 20), (links(0.0, true), 44, 10)] {
        let radius_m = 0.012;
        let case = Case::new(&image, Scheme::Track, Contact::sphere(radius_m, 0.0));
        let (_, bytes) = pressed(&case);
        let (mut refused, mut taken) = (0, 0);
        for (count, at) in (32..bytes.len() - 4).step_by(step).enumerate() {
            let mut forged = bytes.clone();
            forged[at / 4 * 4..][..4].copy_from_slice(&wild[count % wild.len()].to_le_bytes());
            check(&mut forged);
            let mut engine = case.engine();
            if engine.restore(&forged).is_err() {
                refused += 1;
                continue;
            }
            taken += 1;
            for tick in 140..160 {
                let (output, _) = case.tick(&mut engine, tick);
                assert!(
                    output.force_n.iter().all(|x| x.is_finite()),
                    "word {}: {output:?}",
                    at / 4
                );
                assert!(
                    output.energy_j.is_finite() && output.work_j.is_finite(),
                    "word {}",
                    at / 4
                );
            }
        }
        assert!(refused > least && taken > least, "{refused}, {taken}");
    }
}

/// Links that relax, and links that can be cut: counts far beyond theirs and numbers far beyond those of a body.
fn lasting() -> [ImageBytes; 2] {
    let shape = Shape::generated("box:3x3x3x0.01").unwrap();
    let branches = vec![Branch { ratio: 2.0, time_s: 0.1 }];
    let relaxes = BakeOptions {
        link_relaxation: Some(Relaxation { branches, is_instant: false, device_hz: 1000 }),
        ..BakeOptions::default()
    };
    let cuttable = Some(Cuttable { spare_share: 1.0, ..Cuttable::default() });
    let parts = BakeOptions { cuttable, ..BakeOptions::default() };
    [relaxes, parts].map(|options| shape.bake(&options).unwrap())
}

// REQ-BIT-10
#[test]
fn forged_counts_are_refused_or_harmless() {
    for image in lasting() {
        let case = Case::new(&image, Scheme::Predict, Contact::sphere(0.012, 0.0));
        let case = Case { unloading: Unloading::Off, ..case };
        let (mut engine, bytes) = pressed(&case);
        let (mut refused, mut taken) = (0, 0);
        for at in (32..bytes.len()).step_by(4) {
            let word = u32::from_le_bytes(*bytes[at..].first_chunk().unwrap());
            // Counts are small; other words of the state are forged here and there.
            let is_count = (1..=64).contains(&word);
            if !is_count && at % 20 != 0 {
                continue;
            }
            for wild in [word.wrapping_add(1 << 15), u32::MAX, 1e30_f32.to_bits()] {
                let mut forged = bytes.clone();
                forged[at..at + 4].copy_from_slice(&wild.to_le_bytes());
                check(&mut forged);
                if engine.restore(&forged).is_err() {
                    refused += 1;
                    continue;
                }
                taken += 1;
                let (output, _) = case.tick(&mut engine, 140);
                let relaxed_j = engine.relaxed_j().unwrap_or_default();
                let is_finite = output.force_n.iter().chain([&relaxed_j]).all(|x| x.is_finite());
                assert!(is_finite, "word {}: {output:?}, {relaxed_j} J relaxed", at / 4);
            }
        }
        assert!(refused > 100 && taken > 100, "{refused}, {taken}");
    }
}

// REQ-BIT-10
#[test]
fn what_does_not_fit_is_told() {
    let (image, other) = (links(0.0, true), links(0.08, false));
    let case = Case::new(&image, Scheme::Track, held(&image));
    let (_, bytes) = pressed(&case);
    let scheme = Case::new(&image, Scheme::Predict, held(&image));
    assert!(refusal(&mut scheme.engine(), &bytes).contains("another scheme"));
    let numbers =
        Case { numbers: Arithmetic::Fixed, ..Case::new(&other, Scheme::Euler, held(&other)) };
    let single = Case::new(&other, Scheme::Euler, held(&other));
    assert!(refusal(&mut numbers.engine(), &pressed(&single).1).contains("number type"));
    let model = Case::new(&other, Scheme::Track, held(&other));
    assert!(refusal(&mut model.engine(), &bytes).contains("of the model"));
    let few = Contact::Cells(vec![40]);
    let narrow = Case::new(&image, Scheme::Track, few);
    assert!(refusal(&mut narrow.engine(), &bytes).contains("needs room for"));
}
