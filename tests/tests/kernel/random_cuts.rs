//! A generated organ under a blade that cuts across random planes at random speeds, is lifted, drawn back and rests:
//! the state stays finite, the energy and the work of cutting within what the blade gave, a replay and a restored
//! session come to the same bits, and tools still touch the body. Each cut has its seed. A thousand of them:
//!
//! ```text
//! CHAINCELL_CUTS=1000 cargo test --release -p chaincell-tests --test kernel random_cuts_ -- --nocapture
//! ```
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue as Material;
use chaincell_host::bake::{BakeOptions, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{
    Budget, Dynamics, Flags, Network, Predict, Settings, TickOutput, ToolPart, ToolPose, Track,
    Unloading,
};
use chaincell_tests::bodies::model;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::bench::Bench;
use crate::cutting::stiffening;

const CUTS: u64 = 20;
/// Further cuts of every run: the blade engages inside the tissue, or moves fast with one sweep a tick, so that the
/// energy exceeds the work of the published forces.
const ALSO: [u64; 4] = [52, 194, 370, 472];
/// Cuts of a body of links, and of one that stiffens.
const CUTS_OF_OTHERS: u64 = 8;
/// Ticks of a cut.
const TICKS: usize = 700;
/// Energy that a cut takes for each area \[J/m^2\].
const TOUGHNESS_J_PER_M2: f64 = 20.0;
/// Radius of the ball \[m\].
const BALL_M: f32 = 0.01;
/// Ticks between two looks at the whole state.
const LOOK: usize = 50;

fn image(tissue: Option<Material>) -> ImageBytes {
    let mesh = load("organ:1000", &MeshOptions::default()).unwrap();
    let cuttable = Cuttable {
        spare_share: 1.0,
        toughness_j_per_m2: PerCell::Uniform(TOUGHNESS_J_PER_M2),
        ..Cuttable::default()
    };
    let options = BakeOptions { tissue, cuttable: Some(cuttable), ..BakeOptions::default() };
    bake(&mesh, &mesh.default_fixed, &options).unwrap()
}

/// Random numbers of a case.
struct Draw(Pcg64);

impl Draw {
    /// A number from 0 to 1.
    fn share(&mut self) -> f32 {
        self.0.next_u32() as f32 / u32::MAX as f32
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.share()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.0.next_u64() % count as u64) as usize
    }

    fn direction(&mut self) -> Vector3<f32> {
        loop {
            let way = Vector3::from_fn(|_, _| self.between(-1.0, 1.0));
            if (0.01..1.0).contains(&way.norm_squared()) {
                return way.normalize();
            }
        }
    }
}

/// Where a node of the mesh lies at rest \[m\].
fn rest_m(network: &Network<'_>, cell: usize) -> Vector3<f32> {
    let model = network.model();
    Vector3::from(model.rest_position(cell)) * model.unit_m() + Vector3::from(model.centre_m())
}

/// What the blade does for some ticks.
#[derive(Clone, Copy)]
enum Act {
    /// It cuts on at this way in a tick.
    Cut(f32),
    /// It is drawn out, engaged or not.
    Back(bool),
    /// It stands still where it is, engaged or not, so that the body may sleep.
    Rest(bool),
}

/// A cut across a random plane: the poses of the blade.
fn cut(network: &Network<'_>, draw: &mut Draw) -> Vec<ToolPose> {
    let cells = network.model().body_cells();
    // The blade goes along `way` through a node, its edge across it.
    let (target, way) = (rest_m(network, draw.below(cells)), draw.direction());
    let along = way.cross(&draw.direction()).normalize();
    let back = -way;
    let axes = Matrix3::from_columns(&[along, back.cross(&along), back]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let near = (0..cells).map(|cell| rest_m(network, cell) - target);
    let near = near.filter(|off| (off - way * off.dot(&way)).norm() < 0.02);
    let start = near.map(|off| off.dot(&way)).fold(0.0, f32::min) - 0.004;
    // Some ticks of each act; now and then a pose that jumps.
    let (mut place, mut poses) = (start, Vec::new());
    while poses.len() < TICKS {
        let act = match draw.below(8) {
            0 => Act::Back(draw.below(2) == 0),
            1 => Act::Rest(draw.below(2) == 0),
            2 => Act::Cut(draw.between(0.5e-3, 4.0e-3)),
            _ => Act::Cut(draw.between(2.0e-5, 3.0e-4)),
        };
        let ticks = match act {
            Act::Cut(step_m) if step_m > 4.0e-4 => 1 + draw.below(3),
            _ => 20 + draw.below(120),
        };
        for _ in 0..ticks {
            let engaged = match act {
                Act::Cut(_) => true,
                Act::Back(engaged) | Act::Rest(engaged) => engaged,
            };
            place = match act {
                Act::Cut(step_m) => place + step_m,
                Act::Back(_) => start.max(place - 1.0e-3),
                Act::Rest(_) => place,
            };
            // It saws by a millimetre.
            let saw = 1.0e-3 * (0.05 * poses.len() as f32).sin();
            let q = turn.quaternion().coords;
            poses.push(ToolPose {
                orientation: [q.x, q.y, q.z, q.w],
                ..ToolPose::at(target + way * place + along * saw, u32::from(engaged))
            });
        }
    }
    poses.truncate(TICKS);
    poses
}

/// A body under a blade and a ball.
fn under<'a, D: Dynamics<Number = f32>>(network: Network<'a>, half_m: f32) -> Bench<'a, D> {
    let tools: [&[ToolPart]; 2] = [&[ToolPart::edge(half_m)], &[ToolPart::sphere(BALL_M)]];
    Bench::under(network, &tools, 0.2)
}

/// A ball that is away, and does not touch.
fn away() -> ToolPose {
    ToolPose::at([1.0, 1.0, 1.0].into(), 0)
}

/// A tick of both tools.
fn tick<D: Dynamics<Number = f32>>(bench: &mut Bench<'_, D>, of: [ToolPose; 2]) -> TickOutput {
    let network = bench.network;
    bench.view().tick(&network, &of, Budget::All)
}

/// A fresh tissue that goes on from the state of another one.
fn restored<'a, D: Dynamics<Number = f32>>(
    bench: &mut Bench<'_, D>,
    network: Network<'a>,
    half_m: f32,
) -> Bench<'a, D> {
    let before = bench.network;
    let mut bytes = vec![0; bench.view().snapshot_bytes(&before).unwrap()];
    bench.view().save(&before, &mut bytes).unwrap();
    let mut other = under(network, half_m);
    other.view().restore(&network, &bytes).unwrap();
    other
}

/// The energy of a state is no more than its level: a copy whose tool is released with closing bands computes it
/// anew, and a pass lowers it. Its tick begins with the decay of the offsets, which adds up to a fiftieth.
fn check_level<D: Dynamics<Number = f32>>(bench: &mut Bench<'_, D>, half_m: f32, level_j: f32) {
    let settings = Settings { unloading: Unloading::Release, ..*bench.network.settings() };
    let network = Network::new(bench.model(), settings).unwrap();
    let mut copy = restored(bench, network, half_m);
    let output = tick(&mut copy, [away(), away()]);
    assert!(output.flags.contains(Flags::BAND_CLOSED), "{output:?}");
    assert!(output.energy_j <= 1.02 * level_j + 1e-9, "{output:?} above {level_j} J");
}

/// What a case has come to.
#[derive(Debug, Default)]
struct Found {
    faces: u32,
    copies: u32,
    refused: u32,
    rolled_back: usize,
    levels: usize,
}

/// A press of the ball at a random cell of the surface. Returns true if it had a contact.
fn is_met<D: Dynamics<Number = f32>>(
    bench: &mut Bench<'_, D>,
    draw: &mut Draw,
    lifted: ToolPose,
) -> bool {
    let model = bench.model();
    let cell = usize::from(model.triangles()[draw.below(model.triangles().len())][0]);
    let inward = -rest_m(&bench.network, cell).normalize();
    let touch = rest_m(&bench.network, cell) - inward * (BALL_M + 0.005);
    let mut contacts = 0;
    for at in 0..150 {
        let position_m = touch + inward * 1.0e-4 * at as f32;
        tick(bench, [lifted, ToolPose::at(position_m, 1)]);
        let felt = bench.tool(1);
        assert!(felt.force_n.iter().all(|x| x.is_finite()), "{at}: {felt:?}");
        contacts += felt.contacts;
    }
    tick(bench, [lifted, away()]);
    contacts > 0
}

/// A cut, its replay with a restored half, and a press of the ball afterwards.
fn case<D: Dynamics<Number = f32>>(image: &ImageBytes, seed: u64) -> Found {
    let mut draw = Draw(Pcg64::seed_from_u64(seed));
    let model = model(image);
    let sweeps = 1 + draw.below(4) as u16;
    let unloading = Unloading::Off;
    let settings =
        Settings { sweeps, unloading, max_force_n: 100.0, ..Settings::for_model(&model) };
    let network = Network::new(model, settings).unwrap();
    let (half_m, poses) = (draw.between(0.005, 0.06), cut(&network, &mut draw));
    let (mut bench, mut found) = (under::<D>(network, half_m), Found::default());
    let mut given_j = 0.0;
    for (at, pose) in poses.iter().enumerate() {
        let output = tick(&mut bench, [*pose, away()]);
        given_j += f64::from(bench.given_j());
        found.rolled_back += usize::from(output.flags.contains(Flags::ROLLED_BACK));
        assert!(output.force_n.iter().all(|x| x.is_finite()), "{at}: {output:?}");
        let used_j = f64::from(output.energy_j) + f64::from(bench.cuts().work_j);
        assert!(used_j <= 1.0001 * given_j + 1e-8, "{at}: {used_j} of {given_j} J");
        if at % LOOK == 0 {
            assert!(bench.is_finite(), "{at}");
            if pose.engaged == 1 {
                check_level(&mut bench, half_m, output.energy_j);
                found.levels += 1;
            }
        }
    }
    let cuts = bench.cuts();
    (found.faces, found.copies, found.refused) = (cuts.opened_faces, cuts.copies, cuts.refused);
    // Replayed from the start, and restored on the way.
    let (mut again, change) = (under::<D>(network, half_m), draw.below(TICKS));
    for (at, pose) in poses.iter().enumerate() {
        if at == change {
            again = restored(&mut again, network, half_m);
        }
        tick(&mut again, [*pose, away()]);
    }
    assert_eq!((again.hash(), again.cuts()), (bench.hash(), cuts), "restored at {change}");
    // The ball still meets the body, at one of some places: at others it starts inside of it.
    let lifted = ToolPose { engaged: 0, ..poses[0] };
    let is_met = (0..8).any(|_| is_met(&mut bench, &mut draw, lifted));
    assert!(is_met && bench.is_finite(), "no contact");
    found
}

#[test]
fn random_cuts_leave_a_body_that_goes_on() {
    let tissue = Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.4));
    all(&image(Some(tissue)), CUTS, &ALSO);
}

#[test]
fn random_cuts_of_tissue_that_stiffens_leave_a_body_that_goes_on() {
    let tissue = Material::new(PerCell::Uniform(2000.0), PerCell::Uniform(0.4));
    let tissue = Material { stiffening: stiffening(), ..tissue };
    all(&image(Some(tissue)), CUTS_OF_OTHERS, &[]);
}

#[test]
fn random_cuts_of_links_leave_a_body_that_goes_on() {
    all(&image(None), CUTS_OF_OTHERS, &[]);
}

/// Runs these cuts, or as many as the environment asks for.
fn all(image: &ImageBytes, cuts: u64, also: &[u64]) {
    let asked = std::env::var("CHAINCELL_CUTS").ok().map(|count| count.parse().unwrap());
    let cuts = asked.unwrap_or(cuts);
    let also = also.iter().copied().filter(|&seed| seed >= cuts);
    let all = (0..cuts).chain(also).map(|seed| {
        println!("case {seed}");
        if seed % 2 == 0 { case::<Track>(image, seed) } else { case::<Predict>(image, seed) }
    });
    let all: Vec<Found> = all.collect();
    let sum = |of: fn(&Found) -> usize| all.iter().map(of).sum::<usize>();
    let faces = sum(|found| found.faces as usize);
    println!(
        "{} cuts: {faces} faces, {} copies, {} refused, {} of {} ticks discarded a pass, {} levels",
        all.len(),
        sum(|found| found.copies as usize),
        sum(|found| found.refused as usize),
        sum(|found| found.rolled_back),
        all.len() * TICKS,
        sum(|found| found.levels)
    );
    let cut = all.iter().filter(|found| found.copies > 0).count();
    assert!(cut > all.len() / 4, "{cut} of them split a cell");
}
