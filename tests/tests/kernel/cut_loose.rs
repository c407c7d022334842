//! Pieces that a cut takes off: left, frozen where they are, or gone.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue as Material;
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{Budget, Loose, Predict, ToolPart, ToolPose};

use super::bench::Bench;
use super::cutting::{centre, faces, network};

/// Radius of the sphere, and the height of the block's top \[m\].
const RADIUS_M: f32 = 0.006;
const TOP_M: f32 = 0.018;
/// Most a sphere may feel of the piece where it is gone \[N\].
const NOTHING_N: f32 = 1e-6;

fn block() -> Mesh {
    load("box:7x5x4x0.006", &MeshOptions::default()).unwrap()
}

/// A block on a fixed ground.
fn image(mesh: &Mesh, loose: Loose) -> ImageBytes {
    let cuttable = Some(Cuttable { spare_share: 1.0, loose, ..Cuttable::default() });
    let tissue = Some(Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3)));
    let coarse_basis = BasisSpacing::Links(2.0);
    let options = BakeOptions { tissue, cuttable, coarse_basis, ..BakeOptions::default() };
    bake(mesh, &mesh.default_fixed, &options).unwrap()
}

/// The faces between tetrahedra whose middles lie above a height and those below it.
fn across(mesh: &Mesh, height_m: f64) -> Vec<(usize, usize)> {
    let is_above = |side: (usize, usize)| centre(mesh, side.0)[2] > height_m;
    let parted = faces(mesh).into_iter().filter(|[one, other]| is_above(*one) != is_above(*other));
    parted.map(|[one, _]| one).collect()
}

/// Opens the faces, and lets all cells split.
fn part(body: &mut Bench<'_, Predict>, open: &[(usize, usize)], place_m: [f32; 3]) {
    for face in open {
        body.open(*face).unwrap();
    }
    (0..60).for_each(|_| _ = body.tick(place_m));
    let cuts = body.cuts();
    assert!(cuts.waiting == 0 && cuts.refused == 0 && cuts.copies > 20, "{cuts:?}");
}

/// A sphere above the block.
fn above(height_m: f32) -> [f32; 3] {
    [0.001, 0.001, height_m + RADIUS_M]
}

/// Presses a sphere on the block, of which the upper third is cut off, down to a height. Returns the forces along z and
/// the positions of the piece's cells before and after.
fn pressed(loose: Loose, to_m: f32) -> (Vec<f32>, [Vec<[f32; 3]>; 2]) {
    let mesh = block();
    let image = image(&mesh, loose);
    let sphere = [ToolPart::sphere(RADIUS_M)];
    let mut body = Bench::<Predict>::under(network(&image, 4), &[&sphere], 0.3);
    part(&mut body, &across(&mesh, 0.012), above(0.02));
    let tops = |body: &Bench<'_, Predict>| {
        let model = body.model();
        let cells = (0..model.body_cells()).filter(|&cell| {
            model.rest_position(cell)[2] * model.unit_m() + model.centre_m()[2] > 0.017
        });
        cells.map(|cell| body.state[cell].xyz()).collect::<Vec<_>>()
    };
    let before = tops(&body);
    let way_m = 0.02 - to_m;
    let forces_n = (0..400).map(|tick| {
        let output = body.tick(above(0.02 - way_m * tick as f32 / 400.0));
        assert!(output.energy_j.is_finite() && body.is_finite());
        body.tool(0).force_n[2]
    });
    let forces_n = forces_n.collect();
    let after = tops(&body);
    (forces_n, [before, after])
}

#[test]
fn a_frozen_piece_stays_and_is_felt() {
    let (left_n, [before, after]) = pressed(Loose::Leave, TOP_M - 0.003);
    assert_ne!(before, after);
    let (frozen_n, [before, after]) = pressed(Loose::Freeze, TOP_M - 0.003);
    assert_eq!(before, after);
    let [left_n, frozen_n] = [left_n, frozen_n].map(|forces| forces[399]);
    assert!(left_n > 0.01 && frozen_n > 1.5 * left_n, "{left_n} {frozen_n}");
}

/// The sphere comes to the body under it as to one that was never higher.
#[test]
fn a_dropped_piece_is_not_felt() {
    let (gone_n, [before, after]) = pressed(Loose::Drop, 0.009);
    assert_eq!(before, after);
    // Above what is left of the body, whose top the faces of the cut make uneven.
    let free = gone_n.iter().zip(0..).take_while(|(force, _)| force.abs() < NOTHING_N);
    let height_m = 0.02 - 0.011 * free.count() as f32 / 400.0;
    assert!((0.0115..0.0155).contains(&height_m), "{height_m}");
    assert!(gone_n[399] > 0.01, "{}", gone_n[399]);
    let (felt_n, _) = pressed(Loose::Leave, 0.009);
    assert!(felt_n[150] > 0.01, "{}", felt_n[150]);
}

/// A piece that comes loose while it moves stays from the tick of its last split on.
#[test]
fn a_piece_stops_where_it_comes_loose() {
    let mesh = block();
    let image = image(&mesh, Loose::Freeze);
    let sphere = [ToolPart::sphere(RADIUS_M)];
    let mut body = Bench::<Predict>::under(network(&image, 2), &[&sphere], 0.3);
    let mut tick = 0..;
    let mut press = |body: &mut Bench<'_, Predict>| {
        let tick = tick.next().unwrap();
        body.tick(above(0.019 - 2e-5 * tick as f32));
    };
    (0..150).for_each(|_| press(&mut body));
    for face in across(&mesh, 0.012) {
        body.open(face).unwrap();
    }
    let model = body.model();
    let under = |cell: &usize| {
        let [x, y, z] = model.rest_position(*cell);
        z - x.abs() - y.abs()
    };
    let cells = 0..model.body_cells();
    let under = cells.max_by(|a, b| under(a).total_cmp(&under(b))).unwrap();
    // The piece moves until its last cell has split.
    let before = body.state[under].xyz();
    let (mut copies, mut there) = (0, before);
    for _ in 0..150 {
        press(&mut body);
        let cuts = body.cuts();
        if cuts.copies != copies {
            (copies, there) = (cuts.copies, body.state[under].xyz());
        }
    }
    assert!(copies > 20 && there != before, "{copies} {there:?}");
    assert_eq!(there, body.state[under].xyz());
}

/// A tool that holds cells of the piece carries it; it stays where the tool lets go of it.
#[test]
fn a_held_piece_follows_the_tool() {
    let mesh = block();
    let image = image(&mesh, Loose::Freeze);
    let top = |node: &[f64; 3]| node[2] > 0.017 && node[0].abs() < 0.007 && node[1].abs() < 0.007;
    let held: Vec<u32> =
        (0..).zip(&mesh.nodes_m).filter(|(_, node)| top(node)).map(|(id, _)| id).collect();
    let network = network(&image, 4);
    let mut body = Bench::<Predict>::holding(network, &held);
    part(&mut body, &across(&mesh, 0.012), [0.0; 3]);
    let model = body.model();
    let corner = (0..model.body_cells()).max_by(|&a, &b| {
        let sum = |cell| model.rest_position(cell).iter().sum::<f32>();
        sum(a).total_cmp(&sum(b))
    });
    let corner = corner.unwrap();
    let rest = model.rest_position(corner)[2];
    let height = |body: &Bench<'_, Predict>| (body.state[corner].xyz()[2] - rest) * model.unit_m();
    let mut force_n = 0.0;
    for tick in 0..=300 {
        force_n = body.tick([0.0, 0.0, 0.01 * tick.min(200) as f32 / 200.0]).force_n[2];
    }
    assert!((height(&body) - 0.01).abs() < 5e-4 && force_n.abs() < 0.01, "{force_n}");
    // The tool takes hold of the block's lower part.
    let low: Vec<u16> = (0..model.body_cells() as u16)
        .filter(|&cell| {
            let [x, _, z] = model.rest_position(usize::from(cell)).map(|x| x * model.unit_m());
            x > 0.017 && z + model.centre_m()[2] < 0.0065 && !model.is_fixed(cell)
        })
        .collect();
    let released = [ToolPose::at([0.0, 0.0, 0.01].into(), 0)];
    body.view().tick(&network, &released, Budget::All);
    body.view().choose_contacts(&network, &low).unwrap();
    body.tick([0.0; 3]);
    let before = height(&body);
    (0..50).for_each(|tick| _ = body.tick([1e-5 * tick as f32, 0.0, 0.0]));
    assert_eq!(before, height(&body));
}

#[test]
fn a_restored_body_goes_on_with_the_same_bits() {
    let mesh = block();
    let sphere = [ToolPart::sphere(RADIUS_M)];
    for loose in [Loose::Freeze, Loose::Drop] {
        let image = image(&mesh, loose);
        let network = network(&image, 3);
        let on = |body: &mut Bench<'_, Predict>, tick: u32| {
            body.tick(above(0.018 - 3e-5 * tick as f32));
            body.hash()
        };
        let open = across(&mesh, 0.012);
        for ticks in [1, 3, 40] {
            let mut body = Bench::<Predict>::under(network, &[&sphere], 0.3);
            on(&mut body, 0);
            open.iter().for_each(|face| _ = body.open(*face).unwrap());
            (0..ticks).for_each(|tick| _ = on(&mut body, tick));
            let mut bytes = vec![0; body.view().snapshot_bytes(&network).unwrap()];
            body.view().save(&network, &mut bytes).unwrap();
            let mut other = Bench::<Predict>::under(network, &[&sphere], 0.3);
            other.view().restore(&network, &bytes).unwrap();
            for tick in ticks..ticks + 200 {
                assert_eq!(on(&mut body, tick), on(&mut other, tick), "{loose:?} {ticks} {tick}");
            }
        }
    }
}
