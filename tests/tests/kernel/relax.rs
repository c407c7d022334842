//! Bodies that relax: exact in time, as quadratic elements do, with an account that closes, the same bits everywhere.
#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;

use chaincell_host::bake::tissue::{Branch, DEVICE_HZ, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell};
use chaincell_host::engine::rest_m;
use chaincell_kernel::{
    Budget, Dynamics, Model, Network, Predict, ResetError, Settings, Tissue as Storage, ToolPart,
    ToolPose, Track, term_states,
};
use chaincell_tests::bodies::{baked, model};

use crate::bench::Bench;

/// Ratios to the long-term modulus and times \[s\].
type Branches<'b> = &'b [(f64, f64)];

/// A body with these instantaneous numbers \[Pa\], elastic without branches.
fn image(spec: &str, young_pa: f64, poisson: f64, branches: Branches<'_>) -> ImageBytes {
    let of_each = |&(ratio, time_s)| Branch { ratio, time_s };
    let relaxation = (!branches.is_empty()).then(|| Relaxation {
        branches: branches.iter().map(of_each).collect(),
        is_instant: true,
        device_hz: DEVICE_HZ,
    });
    let tissue = Tissue::new(PerCell::Uniform(young_pa), PerCell::Uniform(poisson));
    baked(
        spec,
        &BakeOptions { tissue: Some(Tissue { relaxation, ..tissue }), ..Default::default() },
    )
}

fn network(image: &ImageBytes, sweeps: u16) -> Network<'_> {
    let model = model(image);
    let settings = Settings { sweeps, max_force_n: 1.0e3, ..Settings::for_model(&model) };
    Network::new(model, settings).unwrap()
}

/// Nodes of the upper face within this distance of its middle \[m\].
fn upper(model: &Model<'_>, radius_m: f64) -> Vec<u32> {
    let places: Vec<_> = (0..model.cells()).map(|cell| rest_m(model, cell)).collect();
    let top = places.iter().map(|place| place[2]).fold(f64::MIN, f64::max);
    let middle = [0, 1].map(|axis| {
        let each = places.iter().map(|place| place[axis]);
        0.5 * (each.clone().fold(f64::MAX, f64::min) + each.fold(f64::MIN, f64::max))
    });
    let is_near = |place: &[f64; 3]| {
        place[2] > top - 1e-4 && (place[0] - middle[0]).hypot(place[1] - middle[1]) < radius_m
    };
    let cells = (0..places.len()).filter(|&cell| is_near(&places[cell]));
    cells.map(|cell| model.input_id()[cell]).collect()
}

/// Motions of a hand, 0 before its time begins.
#[derive(Debug, Clone, Copy)]
enum Motion {
    /// In one tick.
    Step,
    /// In 0.1 s.
    Ramp,
    /// At this frequency.
    Sine(f64),
}

impl Motion {
    fn at(self, time_s: f64) -> f64 {
        match self {
            Self::Step => (time_s / 1e-3).clamp(0.0, 1.0),
            Self::Ramp => (time_s / 0.1).clamp(0.0, 1.0),
            Self::Sine(hz) => (TAU * hz * time_s).sin(),
        }
    }

    /// The integral of exp(-(t - s) / tau) over the motion.
    fn remembered(self, tau_s: f64, time_s: f64) -> f64 {
        let ramp = |length_s: f64| {
            let done_s = time_s.min(length_s);
            let at = |s: f64| (-(time_s - s) / tau_s).exp();
            tau_s / length_s * (at(done_s) - at(0.0))
        };
        match self {
            Self::Step => ramp(1e-3),
            Self::Ramp => ramp(0.1),
            Self::Sine(hz) => {
                let (w, fade) = (TAU * hz, (-time_s / tau_s).exp());
                let (sin, cos) = (w * time_s).sin_cos();
                w * tau_s / (1.0 + (w * tau_s).powi(2)) * (cos + w * tau_s * sin - fade)
            }
        }
    }
}

/// Force of a cube without lateral stress, pressed by its upper face: late in every third tick, or never.
fn pressed_n(image: &ImageBytes, motion: Motion, ticks: usize, is_often_late: bool) -> Vec<f64> {
    let network = network(image, 12);
    let nodes = upper(network.model(), 1.0);
    let mut body = Bench::<Predict>::holding(network, &nodes);
    body.tick([0.0; 3]);
    let each = (1..=ticks).map(|tick| {
        let way_m = [0.0, 0.0, (-1e-3 * motion.at(1e-3 * tick as f64)) as f32];
        if is_often_late && tick % 3 == 2 {
            body.late(way_m);
            return f64::NAN;
        }
        f64::from(body.tick(way_m).force_n.z)
    });
    each.collect()
}

/// Largest error of the force in shares of the branch's largest force.
fn time_error(tau_s: f64, motion: Motion, is_often_late: bool) -> f64 {
    let ticks = ((5e3 * tau_s) as usize).clamp(300, 1500);
    let elastic = image("box:4x4x4x0.005", 15e3, 0.0, &[]);
    let relaxing = image("box:4x4x4x0.005", 15e3, 0.0, &[(1.0, tau_s)]);
    let stiff = pressed_n(&elastic, motion, ticks, is_often_late);
    let force = pressed_n(&relaxing, motion, ticks, is_often_late);
    let (mut error, mut largest) = (0.0_f64, 0.0_f64);
    for (tick, (stiff, force)) in stiff.iter().zip(&force).enumerate() {
        let time_s = 1e-3 * (tick + 1) as f64;
        let at = motion.at(time_s);
        if stiff.is_nan() || at.abs() < 0.05 {
            continue;
        }
        let branch = 0.5 * stiff / at * motion.remembered(tau_s, time_s);
        largest = largest.max(branch.abs());
        error = error.max((force - (0.5 * stiff + branch)).abs());
    }
    error / largest
}

const MOTIONS: [Motion; 5] =
    [Motion::Step, Motion::Ramp, Motion::Sine(1.0), Motion::Sine(3.0), Motion::Sine(10.0)];

/// Checks the largest error of branches of these times \[s\] under all motions, in shares of the branch's peak.
fn check_times(times_s: &[f64], is_often_late: bool, most: f64) {
    for &tau_s in times_s {
        for motion in MOTIONS {
            let error = time_error(tau_s, motion, is_often_late);
            println!("tau {tau_s} s, {motion:?}: {:.3} % of the branch's peak", 100.0 * error);
            assert!(error < most, "{tau_s} {motion:?}: {error}");
        }
    }
}

#[test]
fn branches_are_exact_in_time() {
    check_times(&[0.005, 0.02, 0.1, 2.0, 12.0], false, 2e-3);
}

#[test]
fn late_ticks_take_their_time() {
    check_times(&[0.005, 0.02], true, 5e-3);
}

/// A patch of 8.1 mm pressed 4 mm into a slab of 40 x 40 x 20 mm, beside quadratic elements with neo-Hookean branches
/// of one modulus each, 0.1 and 2 s: the error of time alone, as a share of the elastic body's.
#[test]
fn a_pressed_slab_relaxes_as_quadratic_elements_do() {
    let spec = "box:9x9x5x0.005";
    // Shear modulus 3 x 1,724 Pa, lambda 15,517 Pa; in the end 5,000 Pa and 0.45.
    let relaxing = image(spec, 14_224.1, 0.375, &[(1.0, 0.1), (1.0, 2.0)]);
    let elastic = image(spec, 5000.0, 0.45, &[]);
    let press = |image: &ImageBytes, ramp: usize, end: usize| {
        let network = network(image, 12);
        let nodes = upper(network.model(), 8.1e-3);
        assert_eq!(nodes.len(), 9);
        let mut body = Bench::<Predict>::holding(network, &nodes);
        let each = (0..=end).map(|tick| {
            body.tick([0.0, 0.0, -4e-3 * (tick as f32 / ramp as f32).min(1.0)]).force_n.z
        });
        each.last().unwrap()
    };
    let own = press(&elastic, 20, 200) / 0.4891;
    for (ramp, end, of_elements_n) in [
        (20, 20, 1.213),
        (50, 50, 1.173),
        (500, 500, 0.933),
        (5000, 5000, 0.666),
        (20, 8000, 0.500),
    ] {
        let ratio = press(&relaxing, ramp, end) / of_elements_n;
        println!("ramp {ramp} ms, at {end} ms: {ratio:.3} of the elements, elastic {own:.3}");
        assert!((ratio / own - 1.0).abs() < 0.025, "{ramp} {end}: {ratio} {own}");
    }
}

/// A hand that presses, shears and turns back, with jumps.
fn hand_m(tick: usize) -> [f32; 3] {
    let time = tick as f32;
    let jump = if (tick / 40).is_multiple_of(2) { 1e-3 } else { -1e-3 };
    [3e-3 * (0.02 * time).sin(), jump, -4e-3 * (0.013 * time).sin().abs()]
}

/// The hand's exact work is held, relaxed or taken by the sweeps; a still hand's energy falls; a closed motion pays.
fn account<D: Dynamics<Number = f32>>(sweeps: u16) {
    let image = image("box:5x5x4x0.005", 15e3, 0.45, &[(1.0, 0.03), (2.0, 0.4)]);
    let network = network(&image, sweeps);
    let nodes = upper(network.model(), 8e-3);
    let mut body = Bench::<D>::holding(network, &nodes);
    let (mut work_j, mut last_j, mut relaxed_j) = (0.0_f64, 0.0, 0.0);
    for tick in 0..900 {
        let is_late = tick % 7 == 3;
        let still = tick > 500;
        let place = if still { [0.0; 3] } else { hand_m(tick) };
        let output = if is_late { body.late(place) } else { body.tick(place) };
        work_j += f64::from(output.work_j);
        let energy_j = f64::from(output.energy_j);
        let now_j = f64::from(body.view().relaxed_j(&network));
        assert!(now_j >= relaxed_j - 1e-9, "{tick}: {now_j} after {relaxed_j}");
        // The sweeps only take.
        let lost_j = work_j - energy_j - now_j;
        assert!(lost_j >= -1e-6 * (work_j + energy_j), "{tick}: {work_j} {energy_j} {now_j}");
        if tick > 502 {
            assert!(energy_j <= last_j, "{tick}: {energy_j} after {last_j}");
        }
        (last_j, relaxed_j) = (energy_j, now_j);
    }
    assert!(
        work_j > 0.0 && relaxed_j > 0.01 * work_j && last_j < 0.05 * work_j,
        "{work_j} {last_j}"
    );
}

#[test]
fn the_account_of_energy_closes() {
    account::<Predict>(1);
    account::<Track>(1);
    account::<Predict>(4);
}

/// The same bits with and without a vector unit, with sleep and without, restored in the middle; out of the band too.
#[test]
fn the_bits_are_the_same_by_every_way() {
    let image = image("box:5x5x4x0.005", 15e3, 0.45, &[(1.0, 0.03), (0.5, 15.0)]);
    let network = network(&image, 2);
    let nodes = upper(network.model(), 8e-3);
    let new = || Bench::<Predict>::holding(network, &nodes);
    let (mut plain, mut scalar, mut sleepless, mut restored) = (new(), new(), new(), new());
    scalar.view().go_scalar();
    sleepless.view().forbid_sleep(network.model());
    for tick in 0..400 {
        let place = hand_m(tick).map(|x| 1.5 * x);
        let mut outputs = [&mut plain, &mut scalar, &mut sleepless, &mut restored].map(|body| {
            let output = if tick % 5 == 2 { body.late(place) } else { body.tick(place) };
            (output, body.hash())
        });
        let [first, others @ ..] = &mut outputs;
        assert!(others.iter().all(|other| other == first), "{tick}: {outputs:?}");
        if tick == 217 {
            let mut bytes = vec![0; plain.view().snapshot_bytes(&network).unwrap()];
            plain.view().save(&network, &mut bytes).unwrap();
            restored = new();
            restored.view().restore(&network, &bytes).unwrap();
            assert_eq!(restored.words, plain.words);
        }
    }
    // A reset forgets all strain, and so do positions that are set.
    let mut fresh = new();
    plain.view().reset(&network).unwrap();
    assert_eq!(plain.hash(), fresh.hash());
    let places: Vec<_> =
        (0..network.model().cells()).map(|c| network.model().rest_position(c)).collect();
    scalar.view().set_positions(&network, &places).unwrap();
    fresh.view().set_positions(&network, &places).unwrap();
    assert_eq!(scalar.hash(), fresh.hash());
}

/// In the rest shape a body remembers nothing, 15 (1 + G) tau after its release.
#[test]
fn a_released_body_forgets() {
    let image = image("box:5x5x4x0.005", 15e3, 0.45, &[(1.0, 0.02), (1.0, 0.1)]);
    let network = network(&image, 2);
    let nodes = upper(network.model(), 8e-3);
    let mut body = Bench::<Predict>::holding(network, &nodes);
    for tick in 0..300 {
        body.tick([0.0, 0.0, -1e-3 * (tick as f32 / 50.0).min(1.0)]);
    }
    let free = [ToolPose::at([0.0, 0.0, 0.0].into(), 0)];
    for _ in 0..6000 {
        body.view().tick(&network, &free, Budget::All);
    }
    // The clock and what has relaxed are left.
    let rows = &body.words[18..];
    assert!(rows.iter().all(|&word| word == 0), "{:?}", rows.iter().find(|&&word| word != 0));
    assert!(body.view().relaxed_j(&network) > 0.0);
}

/// A ball in a relaxing organ: its force falls to that of the long-term body, and the energy of a still hand too.
#[test]
fn a_ball_feels_the_tissue_relax() {
    let relaxing = image("organ:1000", 15e3, 0.4, &[(2.0, 0.05)]);
    let force = |image: &ImageBytes, sweeps: u16| {
        let network = network(image, sweeps);
        let cells = (0..network.model().cells()).map(|cell| rest_m(network.model(), cell));
        let top = cells.max_by(|a, b| a[2].total_cmp(&b[2])).unwrap();
        let ball = [ToolPart::sphere(0.012)];
        let mut body = Bench::<Predict>::under(network, &[&ball], 0.5);
        let mut forces = Vec::new();
        let mut last_j = f32::MAX;
        for tick in 0..900 {
            let depth_m = 0.012 * (tick as f64 / 80.0).min(1.0) - 0.001;
            let place = [top[0], top[1], top[2] + 0.012 - depth_m].map(|x| x as f32);
            let output = body.tick(place);
            if tick > 120 {
                // The tool gives way as the tissue does: a move that may raise the energy a little.
                let most_j = 1.0001 * last_j;
                assert!(output.energy_j <= most_j, "{tick}: {} after {last_j}", output.energy_j);
            }
            last_j = output.energy_j;
            forces.push(output.force_n.norm());
        }
        forces
    };
    // In the end mu is a third, lambda as it was: r = 3 x 4 = 12.
    let (mu, lambda) = (15e3 / 2.8 / 3.0, 15e3 / 2.8 * 4.0);
    let soft = image(
        "organ:1000",
        mu * (3.0 * lambda + 2.0 * mu) / (lambda + mu),
        lambda / (2.0 * (lambda + mu)),
        &[],
    );
    for sweeps in [1, 4] {
        let (mine, long) = (force(&relaxing, sweeps), force(&soft, sweeps));
        let (peak, end, expected) = (mine[80], mine[899], long[899]);
        println!(
            "{sweeps} sweeps: peak {peak:.4} N, end {end:.4} N, long-term body {expected:.4} N"
        );
        assert!(peak > 1.3 * end, "{peak} {end}");
        // The ball touches with the instantaneous stiffness, so it is less deep in the tissue's surface.
        assert!((0.98..1.1).contains(&(end / expected)), "{end} {expected}");
    }
}

#[test]
fn memory_that_is_too_small_is_refused() {
    let image = image("box:4x4x4x0.005", 15e3, 0.45, &[(1.0, 0.1)]);
    let network = network(&image, 1);
    let mut body = Storage::<64, Track, 16, { term_states(64) }>::new();
    let refused = body.reset(&network).unwrap_err();
    assert!(matches!(refused, ResetError::Memory { room: 0, .. }), "{refused}");
}
