//! Faces that a cut opens, under tools: a tool touches the sides of a wound, and a cut that lies closed leaves the
//! force of a press as it was.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue as Material;
use chaincell_host::bake::{BakeOptions, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::mesh::{Mesh, MeshOptions, load};
use chaincell_kernel::{Network, Settings, ToolPart};
use chaincell_tests::bodies::model;

use crate::bench::Bench;
use crate::cutting::{centre, cut, faces};

/// A block of tissue on a fixed ground, 24 mm high.
const BLOCK: &str = "box:9x7x5x0.006";
const TOP_M: f32 = 0.024;

fn mesh() -> Mesh {
    load(BLOCK, &MeshOptions::default()).unwrap()
}

fn image(mesh: &Mesh, spare_share: f64) -> ImageBytes {
    let options = BakeOptions {
        tissue: Some(Material::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.4))),
        cuttable: Some(Cuttable { spare_share, ..Cuttable::default() }),
        ..BakeOptions::default()
    };
    bake(mesh, &mesh.default_fixed, &options).unwrap()
}

fn network(image: &ImageBytes) -> Network<'_> {
    let model = model(image);
    let settings = Settings { sweeps: 4, ..Settings::for_model(&model) };
    Network::new(model, settings).unwrap()
}

/// A whole body under spheres of these radii \[m\].
fn under<'a>(network: Network<'a>, radii_m: &[f32], friction: f32) -> Bench<'a> {
    let tools: Vec<[ToolPart; 1]> =
        radii_m.iter().map(|&radius_m| [ToolPart::sphere(radius_m)]).collect();
    let tools: Vec<&[ToolPart]> = tools.iter().map(|tool| &tool[..]).collect();
    Bench::under(network, &tools, friction)
}

/// Number of opened faces that a tool touches; each has an area and names the cell that a copy was made from, and
/// forces make the tool's.
fn bare_touched(body: &mut Bench<'_>, tool: u8) -> usize {
    let network = body.network;
    let surface = network.model().triangles().len();
    let cells = network.model().body_cells();
    let (mut count, mut sum_n, mut origins) = (0, [0.0; 3], Vec::new());
    body.view().contact_forces(&network, |contact| {
        if contact.tool == tool {
            count += usize::from(contact.triangle as usize >= surface);
            assert!(contact.area_m2 > 0.0);
            let copy = usize::from(contact.cell).checked_sub(cells);
            origins.push((copy, contact.cell, contact.origin));
            let force_n = contact.normal_n.iter().zip(contact.tangential_n);
            sum_n.iter_mut().zip(force_n).for_each(|(sum, (a, b)): (&mut f32, _)| *sum += a + b);
        }
    });
    for (copy, cell, origin) in origins {
        let known = copy.map_or(Some(cell), |copy| body.view().origin_of_copy(&network, copy));
        assert_eq!(Some(origin), known, "{cell}");
    }
    let force_n = body.tool(tool.into()).force_n;
    let off_n = (sum_n[0] - force_n.x).hypot(sum_n[1] - force_n.y).hypot(sum_n[2] - force_n.z);
    assert!(off_n <= 1e-3 * force_n.norm(), "{sum_n:?} {force_n:?}");
    count
}

fn open(body: &mut Bench<'_>, faces: &[(usize, usize)]) {
    faces.iter().for_each(|face| assert_eq!(body.open(*face), Ok(true)));
}

/// Opens a cut, lowers a sphere and waits. Returns its force, and the number of opened faces that it touches.
fn pressed(body: &mut Bench<'_>, (x_m, radius_m, depth_m): (f32, f32, f32)) -> (f32, usize) {
    let mut force_n = 0.0;
    for tick in 0..760_u16 {
        let share = (f32::from(tick) - 60.0) / 300.0;
        let depth_m = depth_m * share.min(1.0);
        force_n = body.tick_all(&[[x_m, 0.0005, TOP_M + radius_m - depth_m]]).force_n.z;
    }
    (force_n, bare_touched(body, 0))
}

/// Over a closed cut a press meets no side of it, and its force is within 8 % of that on the whole body.
#[test]
fn a_closed_cut_leaves_the_force_of_a_press() {
    let mesh = mesh();
    let image = image(&mesh, 1.0);
    let network = network(&image);
    for (radius_m, depth_m) in [(0.004, 0.002), (0.008, 0.002), (0.008, 0.004), (0.012, 0.004)] {
        let [(whole_n, _), (cut_n, touched)] = [false, true].map(|is_cut| {
            let mut body = under(network, &[radius_m], 0.0);
            if is_cut {
                open(&mut body, &cut(&mesh, 0.005));
            }
            pressed(&mut body, (0.0, radius_m, depth_m))
        });
        println!("{radius_m} {depth_m}: {whole_n} N, {cut_n} N over the cut");
        assert!((cut_n / whole_n - 1.0).abs() < 0.08, "{radius_m} {depth_m}: {whole_n} {cut_n}");
        assert_eq!(touched, 0, "{radius_m} {depth_m}");
    }
    // A sphere that sinks in between the lips meets them: else it would hang on nothing.
    let mut body = under(network, &[0.008], 0.0);
    open(&mut body, &cut(&mesh, 0.005));
    let (force_n, touched) = pressed(&mut body, (0.0, 0.008, 0.006));
    assert!(force_n > 0.1 && touched > 4, "{force_n} {touched}");
}

/// Two spheres that hold the lips, `apart_m` from where they took hold, and the probe.
fn places(apart_m: f32, probe_m: [f32; 3]) -> [[f32; 3]; 3] {
    let held = |x_m: f32| [x_m, 0.0005, TOP_M + 0.003];
    [held(-0.016 - apart_m), held(0.016 + apart_m), probe_m]
}

/// A body of which two spheres grip the top on both sides of a cut that goes down to 8 mm.
fn gripped<'a>(network: Network<'a>, mesh: &Mesh, friction: f32) -> Bench<'a> {
    let mut body = under(network, &[0.005, 0.005, 0.004], friction);
    open(&mut body, &cut(mesh, 0.008));
    for tick in 0..200_u16 {
        let mut places = places(0.0, AWAY_M);
        for place in places.iter_mut().take(2) {
            place[2] += 0.004 * (1.0 - f32::from(tick) / 100.0).max(0.0);
        }
        body.tick_all(&places);
    }
    for tool in [0, 1] {
        assert!(body.view().grip(&network, tool) > 0);
    }
    body
}

/// The probe above the body.
const AWAY_M: [f32; 3] = [0.0005, 0.0005, TOP_M + 0.02];

/// Two tools pull a wound open. A probe meets its ground from above, and each of its sides from within, with forces
/// against its motion; what it meets are opened faces.
#[test]
fn a_probe_meets_ground_and_sides_of_a_wound() {
    let mesh = mesh();
    let image = image(&mesh, 1.0);
    let mut body = gripped(network(&image), &mesh, 0.0);
    for tick in 0..600_u16 {
        body.tick_all(&places(0.010 * (f32::from(tick) / 400.0).min(1.0), AWAY_M));
    }
    let mut at = |x_m: f32, z_m: f32| {
        let mut output = body.tool(2);
        for _ in 0..300 {
            body.tick_all(&places(0.010, [x_m, 0.0005, z_m]));
            output = body.tool(2);
        }
        ([output.force_n.x, output.force_n.z], output.contacts as usize, bare_touched(&mut body, 2))
    };
    let ([_, above_n], _, _) = at(0.0005, 0.030);
    assert_eq!(above_n, 0.0);
    let ([_, between_n], ..) = at(0.0005, 0.021);
    let ([_, ground_n], contacts, bare) = at(0.0005, 0.016);
    println!("{between_n} N between the sides, {ground_n} N on the ground");
    assert!(ground_n > 0.05 && ground_n > 5.0 * between_n.max(0.0), "{between_n} {ground_n}");
    assert!(bare > 3 && bare == contacts, "{bare} {contacts}");
    let ([middle_n, _], ..) = at(0.0005, 0.021);
    let ([right_n, _], ..) = at(0.0055, 0.021);
    let ([left_n, _], _, bare) = at(-0.0045, 0.021);
    println!("{left_n} N on the left, {middle_n} N in the middle, {right_n} N on the right");
    assert!(right_n < -0.02 && left_n > 0.02 && bare > 0, "{left_n} {middle_n} {right_n}");
}

/// The wound is pulled open and goes deeper while the probe drags on its side; returns hashes and forces.
fn dragged(body: &mut Bench<'_>, ticks: core::ops::Range<u16>) -> Vec<u64> {
    let mut bits = Vec::new();
    for tick in ticks {
        let share = (f32::from(tick) / 300.0).min(1.0);
        let probe_m =
            [0.0005 + 0.006 * share, 0.0005 + 0.002 * share, TOP_M + 0.008 - 0.012 * share];
        body.tick_all(&places(0.010 * share, probe_m));
        let model = *body.network.model();
        bits.push(body.view().state_hash(&model));
        let force_n = body.tool(2).force_n;
        bits.extend([force_n.x, force_n.y, force_n.z].map(|x| u64::from(x.to_bits())));
    }
    bits
}

/// A snapshot within a cut, with friction on opened faces and cells that wait: a tissue that is restored from it
/// goes on with the same bits.
#[test]
fn touched_faces_are_the_same_after_a_snapshot() {
    let mesh = mesh();
    let image = image(&mesh, 1.0);
    let network = network(&image);
    let mut body = gripped(network, &mesh, 0.4);
    dragged(&mut body, 0..300);
    assert!(bare_touched(&mut body, 2) > 0);
    let deeper: Vec<(usize, usize)> =
        cut(&mesh, 0.004).into_iter().filter(|face| !cut(&mesh, 0.008).contains(face)).collect();
    open(&mut body, &deeper);
    assert!(!deeper.is_empty() && body.view().cut_output(&network).waiting > 0);
    let mut bytes = vec![0; body.view().snapshot_bytes(&network).unwrap()];
    body.view().save(&network, &mut bytes).unwrap();
    let bits = dragged(&mut body, 300..420);
    assert!(bare_touched(&mut body, 2) > 0);
    let mut other = under(network, &[0.005, 0.005, 0.004], 0.4);
    open(&mut other, &cut(&mesh, 0.015));
    for _ in 0..20 {
        other.tick_all(&places(0.0, AWAY_M));
    }
    other.view().restore(&network, &bytes).unwrap();
    assert!(bits == dragged(&mut other, 300..420));
}

/// Where places for triangles are lacking, faces open all the same and are counted; a reset leaves none.
#[test]
fn faces_without_a_place_are_counted() {
    let mesh = mesh();
    let image = image(&mesh, 0.0);
    let network = network(&image);
    let mut body = under(network, &[0.008], 0.0);
    // Small cuts across the nodes along the middle: the faces at each in the plane of its x.
    let is_inner = |node: &[f64; 3]| {
        node[0].abs() < 0.019 && node[1].abs() < 1e-6 && (node[2] - 0.012).abs() < 1e-6
    };
    let nodes = (0_u32..).zip(&mesh.nodes_m).filter(|(_, node)| is_inner(node)).map(|(id, _)| id);
    let mut opened = 0;
    for node in nodes {
        let x = mesh.nodes_m[node as usize][0];
        for [(one, corner), (other, _)] in faces(&mesh) {
            let has_node = (0..4).any(|at| at != corner && mesh.tetrahedra[one][at] == node);
            if has_node && (centre(&mesh, one)[0] < x) != (centre(&mesh, other)[0] < x) {
                open(&mut body, &[(one, corner)]);
                opened += 1;
            }
        }
    }
    for _ in 0..20 {
        body.tick_all(&[AWAY_M]);
    }
    let cuts = body.view().cut_output(&network);
    assert_eq!((cuts.copies, cuts.opened_faces, cuts.refused), (7, opened, 0));
    // There are places for four faces for each of the eight spare cells.
    assert!(opened > 32, "{opened}");
    assert_eq!(cuts.untouched, opened - 32);
    body.view().reset(&network).unwrap();
    assert_eq!(body.view().cut_output(&network).untouched, 0);
}
