//! A body of links under cuts at random, and asleep beside one; the latter of tissue that stiffens too.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{
    Budget, Dynamics, Flags, Network, Predict, Settings, ToolPose, Track, Unloading,
};
use chaincell_tests::bodies::model;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::bench::Bench;
use crate::cut_bar::{bar, end, move_inner_nodes};
use crate::cutting::{centre, faces, network, stiffening};

const EDGE_M: f64 = 0.006;

/// A box whose inner nodes are moved.
fn mesh(seed: u64) -> Mesh {
    let mut mesh = load("box:7x6x5x0.006", &MeshOptions::default()).unwrap();
    move_inner_nodes(&mut mesh, EDGE_M, seed);
    mesh
}

fn image(mesh: &Mesh, alpha: f64, coarse_basis: BasisSpacing, is_cuttable: bool) -> ImageBytes {
    let cuttable = Cuttable { spare_share: 0.8, ..Cuttable::default() };
    let options = BakeOptions {
        alpha: PerCell::Uniform(alpha),
        cuttable: is_cuttable.then_some(cuttable),
        coarse_basis,
        ..BakeOptions::default()
    };
    bake(mesh, &mesh.default_fixed, &options).unwrap()
}

/// Nodes of the side that a tool holds.
fn side(mesh: &Mesh) -> Vec<u32> {
    let nodes = (0..).zip(&mesh.nodes_m);
    let far = mesh.nodes_m.iter().map(|place| place[0]).fold(f64::MIN, f64::max);
    let is_there = |place: &[f64; 3]| place[0] > far - 1e-6 && place[2] > 1.5 * EDGE_M;
    nodes.filter(|(_, place)| is_there(place)).map(|(node, _)| node).collect()
}

/// The way of the tool: it pulls, presses and shears.
fn way(tick: usize) -> [f32; 3] {
    let angle = 0.02 * tick as f32;
    [0.003 * angle.sin(), 0.002 * (1.7 * angle).sin(), 0.002 * (0.6 * angle).sin()]
}

/// The body as it is, in memory of its own.
fn copied<'a, D: Dynamics<Number = f32>>(
    body: &mut Bench<'_, D>,
    network: Network<'a>,
    held: &[u32],
) -> Bench<'a, D> {
    let before = body.network;
    let mut bytes = vec![0; body.view().snapshot_bytes(&before).unwrap()];
    body.view().save(&before, &mut bytes).unwrap();
    let mut other = Bench::holding(network, held);
    other.view().restore(&network, &bytes).unwrap();
    other
}

/// The energy of the links as they are, computed anew by a copy that lets go of the cells, is no more than the level.
fn check_level<D: Dynamics<Number = f32>>(body: &mut Bench<'_, D>, held: &[u32], level_j: f32) {
    let settings = Settings { unloading: Unloading::Release, ..*body.network.settings() };
    let network = Network::new(body.model(), settings).unwrap();
    let mut copy = copied(body, network, held);
    let output = copy.view().tick(&network, &[ToolPose::at([0.0; 3].into(), 0)], Budget::All);
    assert!(output.flags.contains(Flags::BAND_CLOSED), "{output:?}");
    assert!(output.energy_j <= 1.0001 * level_j + 1e-9, "{output:?} above {level_j} J");
}

/// Opens random faces in random order while a tool moves the body. Returns the number of copies, and of ticks that
/// discarded a pass.
fn opened_at_random<D: Dynamics<Number = f32>>(seed: u64, coarse: BasisSpacing) -> (u32, usize) {
    let (mesh, mut random) = (mesh(seed), Pcg64::seed_from_u64(seed));
    let (image, held, faces) = (image(&mesh, 0.0, coarse, true), side(&mesh), faces(&mesh));
    let settings = Settings { unloading: Unloading::Off, ..*network(&image, 3).settings() };
    let network = Network::new(model(&image), settings).unwrap();
    let mut body = Bench::<D>::holding(network, &held);
    let (mut again, mut scalar) = (Bench::<D>::holding(network, &held), None);
    let mut rolled_back = 0;
    for tick in 0..240 {
        let mut open = Vec::new();
        for _ in 0..if tick < 160 { 5 } else { 0 } {
            open.push(faces[random.next_u32() as usize % faces.len()][0]);
        }
        let output = opened(&mut body, &open, tick);
        rolled_back += usize::from(output.flags.contains(Flags::ROLLED_BACK));
        assert!(output.force_n.iter().all(|x| x.is_finite()) && body.is_finite(), "{tick}");
        if tick % 30 == 29 {
            check_level(&mut body, &held, output.energy_j);
        }
        // Replayed from the start, and by a copy without vector units on the way.
        opened(&mut again, &open, tick);
        if let Some(scalar) = &mut scalar {
            opened(scalar, &open, tick);
        }
        if tick == 80 {
            let mut copy = copied(&mut body, network, &held);
            copy.view().go_scalar();
            scalar = Some(copy);
        }
        assert_eq!(again.hash(), body.hash(), "{tick}");
    }
    assert_eq!(scalar.unwrap().hash(), body.hash());
    (body.cuts().copies, rolled_back)
}

/// A tick after these faces were opened.
fn opened<D: Dynamics<Number = f32>>(
    body: &mut Bench<'_, D>,
    open: &[(usize, usize)],
    tick: usize,
) -> chaincell_kernel::TickOutput {
    for face in open {
        body.open(*face).unwrap();
    }
    body.tick(way(tick))
}

#[test]
fn faces_opened_at_random_keep_the_level_and_the_bits() {
    for seed in 1..=3 {
        for coarse in [BasisSpacing::None, BasisSpacing::Links(2.0)] {
            for (copies, rolled_back) in
                [opened_at_random::<Track>(seed, coarse), opened_at_random::<Predict>(seed, coarse)]
            {
                println!(
                    "{seed}, {coarse:?}: {copies} copies, {rolled_back} of 240 ticks rolled back"
                );
                assert!(copies > 80, "{copies}");
                // The bounds hold: without a coarse level hardly a sweep is discarded.
                assert!(coarse != BasisSpacing::None || rolled_back < 12, "{rolled_back}");
            }
        }
    }
}

/// A body that can be cut has the forces of a plain one, bit by bit, until it is cut.
#[test]
fn links_that_are_not_cut_have_the_bits_of_a_plain_body() {
    let mesh = mesh(1);
    let [plain, cuttable] =
        [false, true].map(|is_cuttable| image(&mesh, 0.02, BasisSpacing::Links(2.0), is_cuttable));
    let mut bodies =
        [&plain, &cuttable].map(|image| Bench::<Predict>::holding(network(image, 2), &side(&mesh)));
    for tick in 0..200 {
        let [plain, cuttable] = bodies.each_mut().map(|body| body.tick(way(tick)));
        assert_eq!(plain, cuttable, "{tick}");
    }
    let face = faces(&mesh)[faces(&mesh).len() / 2][0];
    assert_eq!(bodies[1].open(face), Ok(true));
    let [plain, cuttable] = bodies.each_mut().map(|body| body.tick(way(200)));
    assert_eq!((plain, bodies[1].cuts().copies), (cuttable, 0));
}

/// Sleep changes no bit while the sides of a cut are drawn apart, rest, and are pressed on each other.
#[test]
fn sleep_beside_a_cut_changes_no_bit() {
    sleeps(None);
}

/// Nor in tissue that stiffens.
#[test]
fn sleep_beside_a_cut_of_tissue_changes_no_bit() {
    let tissue = Tissue::new(PerCell::Uniform(2000.0), PerCell::Uniform(0.3));
    sleeps(Some(Tissue { stiffening: stiffening(), ..tissue }));
}

fn sleeps(tissue: Option<Tissue>) {
    let mesh = bar(8, 1);
    let options = BakeOptions {
        alpha: if tissue.is_some() { BakeOptions::default().alpha } else { PerCell::Uniform(0.02) },
        tissue,
        cuttable: Some(Cuttable { spare_share: 0.5, ..Cuttable::default() }),
        coarse_basis: BasisSpacing::None,
        ..BakeOptions::default()
    };
    let image = bake(&mesh, &end(&mesh, -0.02), &options).unwrap();
    let across = faces(&mesh).into_iter().filter(|[(one, _), (other, _)]| {
        (centre(&mesh, *one)[0] < 0.0002) != (centre(&mesh, *other)[0] < 0.0002)
    });
    let across: Vec<(usize, usize)> = across.map(|[one, _]| one).collect();
    let hashes = |is_sleepless: bool| {
        let network = network(&image, 4);
        let mut body = Bench::<Track>::holding(network, &end(&mesh, 0.02));
        if is_sleepless {
            body.view().forbid_sleep(network.model());
        }
        for face in &across {
            body.open(*face).unwrap();
        }
        // Drawn away along the cut and beyond it, at rest, and back until both sides press.
        let mut hashes = Vec::new();
        for tick in 0..900_u16 {
            let along = match tick {
                0..100 => 2.0e-5 * f32::from(tick),
                100..600 => 2.0e-3,
                _ => 2.0e-3 - 2.0e-5 * f32::from(tick - 600).min(250.0),
            };
            let output = body.tick([along, 0.0, 0.0]);
            hashes.push((body.hash(), output.force_n.map(f32::to_bits)));
        }
        let force_n = body.tick([-3.0e-3, 0.0, 0.0]).force_n;
        assert!(body.cuts().copies > 10 && force_n.norm() > 0.01, "{force_n:?}");
        hashes
    };
    assert!(hashes(false) == hashes(true));
}
