//! Bodies that relax: exact in time, as quadratic elements do, with an account that closes, the same bits everywhere.
//!
//! - `time`: branches against the analytic series, with few sweeps and under a ball.
//! - `account`: the energy that a hand puts in, and what it gets back.
//! - `rest`: nothing changes any more after a press and after a release.
#![allow(clippy::unwrap_used)]

mod account;
mod rest;
mod time;

use chaincell_host::bake::tissue::{Branch, DEVICE_HZ, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell};
use chaincell_host::engine::rest_m;
use chaincell_kernel::{
    Model, Network, Predict, ResetError, Settings, Tissue as Storage, ToolPart, Track, term_states,
};
use chaincell_tests::bodies::{baked, model};

use crate::bench::Bench;

/// Ratios to the long-term modulus and times \[s\].
type Branches<'b> = &'b [(f64, f64)];

/// A body with these instantaneous numbers \[Pa\], elastic without branches.
fn image(spec: &str, young_pa: f64, poisson: f64, branches: Branches<'_>) -> ImageBytes {
    image_at(DEVICE_HZ, spec, (young_pa, poisson), branches)
}

/// The same for sessions of this many ticks a second; Young's modulus \[Pa\] and Poisson's ratio are instantaneous.
fn image_at(
    device_hz: u32,
    spec: &str,
    (young_pa, poisson): (f64, f64),
    branches: Branches<'_>,
) -> ImageBytes {
    let of_each = |&(ratio, time_s)| Branch { ratio, time_s };
    let relaxation = (!branches.is_empty()).then(|| Relaxation {
        branches: branches.iter().map(of_each).collect(),
        is_instant: true,
        device_hz,
    });
    let tissue = Tissue::new(PerCell::Uniform(young_pa), PerCell::Uniform(poisson));
    baked(
        spec,
        &BakeOptions { tissue: Some(Tissue { relaxation, ..tissue }), ..Default::default() },
    )
}

/// A body of links of this slack with these numbers, whose stiffness is the instantaneous one.
fn links(spec: &str, alpha: f64, branches: Branches<'_>) -> ImageBytes {
    let of_each = |&(ratio, time_s)| Branch { ratio, time_s };
    let link_relaxation = (!branches.is_empty()).then(|| Relaxation {
        branches: branches.iter().map(of_each).collect(),
        is_instant: true,
        device_hz: DEVICE_HZ,
    });
    let alpha = PerCell::Uniform(alpha);
    baked(spec, &BakeOptions { alpha, link_relaxation, ..Default::default() })
}

/// A block of shapes, of links, and of slack links that differ, with these branches.
fn blocks(branches: Branches<'_>) -> [(&'static str, ImageBytes); 3] {
    let spec = "box:5x5x4x0.005";
    let mut varied = Vec::new();
    for node in 0..5 * 5 * 4 {
        varied.push(10.0 + f64::from(node % 7));
    }
    let of_each = |&(ratio, time_s)| Branch { ratio, time_s };
    let options = BakeOptions {
        alpha: PerCell::Each(varied.iter().map(|of| 2e-3 * (of - 9.0)).collect()),
        stiffness_n_per_m: PerCell::Each(varied),
        link_relaxation: Some(Relaxation {
            branches: branches.iter().map(of_each).collect(),
            is_instant: false,
            device_hz: DEVICE_HZ,
        }),
        ..Default::default()
    };
    [
        ("shapes", image(spec, 15e3, 0.45, branches)),
        ("links", links(spec, 0.0, branches)),
        ("slack links", baked(spec, &options)),
    ]
}

fn network(image: &ImageBytes, sweeps: u16) -> Network<'_> {
    let model = model(image);
    let settings = Settings { sweeps, max_force_n: 1.0e3, ..Settings::for_model(&model) };
    Network::new(model, settings).unwrap()
}

/// Middle of the upper face \[m\].
fn middle_m(model: &Model<'_>) -> [f64; 3] {
    let places: Vec<_> = (0..model.cells()).map(|cell| rest_m(model, cell)).collect();
    let top = places.iter().map(|place| place[2]).fold(f64::MIN, f64::max);
    let [x, y] = [0, 1].map(|axis| {
        let each = places.iter().map(|place| place[axis]);
        0.5 * (each.clone().fold(f64::MAX, f64::min) + each.fold(f64::MIN, f64::max))
    });
    [x, y, top]
}

/// Nodes of the upper face within this distance of its middle \[m\].
fn upper(model: &Model<'_>, radius_m: f64) -> Vec<u32> {
    let [x, y, top] = middle_m(model);
    let is_near = |cell: &usize| {
        let place = rest_m(model, *cell);
        place[2] > top - 1e-4 && (place[0] - x).hypot(place[1] - y) < radius_m
    };
    let cells = (0..model.cells()).filter(is_near);
    cells.map(|cell| model.input_id()[cell]).collect()
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

/// The same bits with and without a vector unit, with sleep and without, restored in the middle; out of the band too.
#[test]
fn the_bits_are_the_same_by_every_way() {
    for (name, image) in &blocks(&[(1.0, 0.03), (0.5, 15.0)]) {
        same_bits(name, network(image, 2));
    }
}

fn same_bits(name: &str, network: Network<'_>) {
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
        assert!(others.iter().all(|other| other == first), "{name}, {tick}: {outputs:?}");
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
