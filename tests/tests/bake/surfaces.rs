//! Closed surfaces: what is filled, how near the tetrahedra come to it, and what is refused and where.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fmt::Write as _;
use std::path::Path;

use chaincell_host::error::Result;
use chaincell_host::mesh::{Filled, Filling, Mesh, MeshOptions, from_bytes};
use proptest::prelude::*;

/// Corners of triangles.
type Triangles = Vec<[[f64; 3]; 3]>;

/// A box from `low` to `high`, counter-clockwise from outside.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> Triangles {
    let at = |bits: usize| [0, 1, 2].map(|k| if bits >> k & 1 == 1 { high[k] } else { low[k] });
    let faces =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let cut = |[a, b, c, d]: [usize; 4]| [[a, b, c].map(at), [a, c, d].map(at)];
    faces.into_iter().flat_map(cut).collect()
}

/// A ball with this number of rings.
fn ball(middle: [f64; 3], radius: f64, rings: usize) -> Triangles {
    use std::f64::consts::{PI, TAU};
    let at = |i: usize, j: usize| {
        let (down, round) =
            (PI * i as f64 / rings as f64, TAU * (j % (2 * rings)) as f64 / (2 * rings) as f64);
        let across = if i.is_multiple_of(rings) { 0.0 } else { radius * down.sin() };
        [
            middle[0] + across * round.cos(),
            middle[1] + across * round.sin(),
            middle[2] + radius * down.cos(),
        ]
    };
    let mut all = Vec::new();
    for (i, j) in (0..rings).flat_map(|i| (0..2 * rings).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        if i + 1 < rings {
            all.push([a, b, c]);
        }
        if i > 0 {
            all.push([a, c, d]);
        }
    }
    all
}

fn turned(triangles: Triangles) -> Triangles {
    triangles.into_iter().map(|[a, b, c]| [a, c, b]).collect()
}

fn stl(triangles: &[[[f64; 3]; 3]]) -> Vec<u8> {
    let mut text = String::from("solid\n");
    for corners in triangles {
        text.push_str("facet normal 0 0 0\nouter loop\n");
        corners.iter().for_each(|[x, y, z]| writeln!(text, "vertex {x:?} {y:?} {z:?}").unwrap());
        text.push_str("endloop\nendfacet\n");
    }
    (text + "endsolid\n").into_bytes()
}

fn fill_with(bytes: &[u8], options: MeshOptions) -> Result<Mesh> {
    from_bytes("a.stl", bytes, &options)
}

fn fill(triangles: &[[[f64; 3]; 3]], size_m: f64) -> Result<Mesh> {
    fill_with(
        &stl(triangles),
        MeshOptions { filling: Some(Filling::even(size_m)), ..MeshOptions::default() },
    )
}

#[track_caller]
fn refused(triangles: &[[[f64; 3]; 3]], size_m: f64, parts: &[&str]) {
    let why = fill(triangles, size_m).unwrap_err().to_string();
    for part in parts.iter().chain(&["a.stl: "]) {
        assert!(why.contains(part), "`{part}` is missing: {why}");
    }
}

fn volume_m3(mesh: &Mesh) -> f64 {
    let of = |ids: &[u32; 4]| {
        let [a, b, c, d] = ids.map(|id| mesh.nodes_m[id as usize]);
        let [u, v, w] = [b, c, d].map(|p| [0, 1, 2].map(|k| p[k] - a[k]));
        (u[0] * (v[1] * w[2] - v[2] * w[1])
            + u[1] * (v[2] * w[0] - v[0] * w[2])
            + u[2] * (v[0] * w[1] - v[1] * w[0]))
            / 6.0
    };
    mesh.tetrahedra
        .iter()
        .map(|ids| {
            let volume = of(ids);
            assert!(volume > 0.0);
            volume
        })
        .sum()
}

fn figures(mesh: &Mesh) -> Filled {
    mesh.filled.clone().unwrap()
}

#[test]
fn a_box_keeps_its_edges_and_its_volume() {
    let mesh = fill(&cuboid([-0.02, -0.03, 0.0], [0.02, 0.03, 0.02]), 0.003).unwrap();
    let filled = figures(&mesh);
    let volume = volume_m3(&mesh);
    assert!((volume / 48e-6 - 1.0 - filled.volume_error).abs() < 1e-9);
    assert!((filled.volume_m3 / 48e-6 - 1.0).abs() < 1e-12);
    assert!(filled.volume_error.abs() < 0.002, "{filled:?}");
    assert!(filled.distance_m < 0.0015 && filled.roundness > 0.3, "{filled:?}");
    assert!(filled.dihedral_deg[0] > 15.0 && filled.dihedral_deg[1] < 150.0, "{filled:?}");
    assert!((filled.edge_m / 0.003 - 1.0).abs() < 0.1, "{filled:?}");
}

/// Filled with a coarse size, and a finer one at places.
fn graded(triangles: &[[[f64; 3]; 3]], fill: &str) -> Result<Mesh> {
    let filling = Some(fill.parse().unwrap());
    fill_with(&stl(triangles), MeshOptions { filling, ..MeshOptions::default() })
}

/// Middle and length of each edge.
fn edges(mesh: &Mesh) -> Vec<([f64; 3], f64)> {
    let place = |id: u32| mesh.nodes_m[id as usize];
    mesh.links
        .iter()
        .map(|[i, j]| {
            let (a, b) = (place(*i), place(*j));
            let middle = [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0);
            (middle, away(a, b))
        })
        .collect()
}

fn away(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Watertight, of the volume of the even one, sound in its worst tetrahedra; fine at the place, coarse far away,
/// and between them no edge longer than what the distance allows.
#[test]
fn a_finer_place_is_graded() {
    let (block, round) =
        (cuboid([-0.04, -0.04, 0.0], [0.04, 0.04, 0.04]), ball([0.0; 3], 0.04, 24));
    for (surface, fill, place_m) in [
        (&block, "0.008,0.002@0,0,0.04,0.01", [0.0, 0.0, 0.04]),
        (&block, "0.008,0.002@0.04,0.04,0.04,0.01", [0.04; 3]),
        (&round, "0.008,0.002@0,0,0.04,0.01", [0.0, 0.0, 0.04]),
    ] {
        let mesh = graded(surface, fill).unwrap();
        assert_eq!(mesh, graded(surface, fill).unwrap(), "the same bits");
        let filled = figures(&mesh);
        let even = figures(&self::fill(surface, 0.008).unwrap());
        assert!((volume_m3(&mesh) / filled.volume_m3 - 1.0 - filled.volume_error).abs() < 1e-9);
        assert!(filled.volume_error.abs() < even.volume_error.abs() + 0.002, "{filled:?} {even:?}");
        assert!(filled.dihedral_deg[0] > 10.0 && filled.dihedral_deg[1] < 160.0, "{filled:?}");
        assert!(filled.roundness > 0.2, "{filled:?}");
        assert_eq!((filled.parts, filled.handles), (1, [0, 0]), "{fill}");
        let [fine_m, coarse_m] = filled.graded_m.unwrap().map(Option::unwrap);
        assert!((fine_m / 0.002 - 1.0).abs() < 0.1, "{filled:?}");
        assert!((coarse_m / 0.008 - 1.0).abs() < 0.15, "{filled:?}");
        for (middle_m, edge_m) in edges(&mesh) {
            let outside_m = (away(middle_m, place_m) - 0.01).max(0.0);
            assert!(edge_m < 2.3 * (0.002 + 0.5 * outside_m), "{edge_m} at {middle_m:?}");
        }
    }
}

#[test]
fn several_places_and_selected_nodes_are_finer() {
    let surface = cuboid([-0.02, -0.02, 0.0], [0.02, 0.02, 0.02]);
    let mean = |mesh: &Mesh, place_m: [f64; 3]| {
        let near: Vec<f64> = edges(mesh)
            .into_iter()
            .filter(|of| away(of.0, place_m) < 0.004)
            .map(|of| of.1)
            .collect();
        near.iter().sum::<f64>() / near.len() as f64
    };
    let two = graded(&surface, "0.006,0.0015@-0.01,0,0.02,0.004@0.01,0,0.02,0.004").unwrap();
    let top =
        graded(&surface, "0.006,0.0015@near:box:-0.012,0.012,-0.004,0.004,0.018,0.03").unwrap();
    for mesh in [two, top] {
        for place_m in [[-0.01, 0.0, 0.02], [0.01, 0.0, 0.02]] {
            assert!((mean(&mesh, place_m) / 0.0015 - 1.0).abs() < 0.1, "{}", mean(&mesh, place_m));
        }
        assert!(mean(&mesh, [0.0, 0.0, 0.0]) > 0.0022, "{}", mean(&mesh, [0.0; 3]));
    }
}

/// Wherever the lattice lies in it.
#[test]
fn a_box_keeps_its_corners() {
    for (extents, size_m) in [([0.04, 0.06, 0.02], 0.00427), ([0.05, 0.03, 0.01], 0.002045)] {
        for shift in [0.0, 3.3e-4, 0.1] {
            let low =
                [0, 1, 2].map(|axis: usize| shift * (1.0 + axis as f64) - extents[axis] / 2.0);
            let high = [0, 1, 2].map(|axis| low[axis] + extents[axis]);
            let mesh = fill(&cuboid(low, high), size_m).unwrap();
            let is_corner = |place: &&[f64; 3]| {
                (0..3).all(|k| (place[k] - low[k]).min(high[k] - place[k]).abs() < 1e-12)
            };
            assert_eq!(mesh.nodes_m.iter().filter(is_corner).count(), 8, "{size_m} {shift}");
            assert!(figures(&mesh).roundness > 0.29, "{size_m} {shift}");
        }
    }
}

#[test]
fn a_ball_is_filled_and_a_finer_size_is_nearer() {
    let surface = ball([0.01, 0.0, 0.0], 0.03, 24);
    let [coarse, fine] = [0.006, 0.003].map(|size_m| figures(&fill(&surface, size_m).unwrap()));
    assert!(
        coarse.volume_error.abs() < 0.03
            && fine.volume_error.abs() < 0.3 * coarse.volume_error.abs()
    );
    assert!(fine.distance_m < coarse.distance_m && fine.roundness > 0.4, "{coarse:?} {fine:?}");
    assert_eq!((fine.bodies, fine.cavities, fine.turned, fine.handles), (1, 0, 0, [0, 0]));
}

#[test]
fn shells_inside_are_cavities_whichever_way_they_are_turned() {
    let outside = cuboid([-0.02; 3], [0.02; 3]);
    let hole = ball([0.0; 3], 0.008, 10);
    let wanted = 0.04f64.powi(3);
    for (first, second, turns) in [
        (outside.clone(), hole.clone(), hole.len()),
        (outside.clone(), turned(hole.clone()), 0),
        (turned(outside.clone()), turned(hole.clone()), 12),
    ] {
        let mesh = fill(&[first, second].concat(), 0.003).unwrap();
        let filled = figures(&mesh);
        assert_eq!((filled.bodies, filled.cavities, filled.turned), (1, 1, turns));
        assert!(
            filled.volume_m3 < wanted && (volume_m3(&mesh) / filled.volume_m3 - 1.0).abs() < 0.02
        );
    }
    // A body in the cavity is a part of its own.
    let core = ball([0.0; 3], 0.005, 8);
    let three = [outside, hole, core].concat();
    let why = fill(&three, 0.0015).unwrap_err().to_string();
    assert!(why.contains("2 unconnected parts") && why.contains("`allow_parts`"), "{why}");
}

#[test]
fn triangles_that_disagree_are_turned() {
    let mut surface = cuboid([0.0; 3], [0.02; 3]);
    let sound = fill(&surface, 0.003).unwrap();
    for at in [1, 4, 7] {
        surface[at].swap(0, 1);
    }
    let mesh = fill(&surface, 0.003).unwrap();
    assert_eq!(figures(&mesh).turned, 3);
    assert_eq!(mesh.nodes_m.len(), sound.nodes_m.len());
    assert!((volume_m3(&mesh) / volume_m3(&sound) - 1.0).abs() < 1e-3);
}

/// A frame, which has one handle; at a size as wide as its opening the tetrahedra may have none.
#[test]
fn handles_are_counted() {
    let mut frame = Triangles::new();
    let at = [-0.02, -0.006, 0.006, 0.02];
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).filter(|cell| *cell != (1, 1)) {
        let part = cuboid([at[i], at[j], -0.007], [at[i + 1], at[j + 1], 0.007]);
        // Walls between parts are left out: those of x below and above, then those of y.
        let is_part = |i: usize, j: usize| i < 3 && j < 3 && (i, j) != (1, 1);
        let walls = [
            is_part(i.wrapping_sub(1), j),
            is_part(i + 1, j),
            is_part(i, j.wrapping_sub(1)),
            is_part(i, j + 1),
        ];
        // `cuboid` gives the faces of x, then of y, then of z.
        frame.extend(
            part.into_iter()
                .enumerate()
                .filter(|(k, _)| !walls.get(k / 2).unwrap_or(&false))
                .map(|(_, t)| t),
        );
    }
    let filled = figures(&fill(&frame, 0.003).unwrap());
    assert_eq!((filled.handles, filled.parts), ([1, 1], 1), "{filled:?}");
}

#[test]
fn holes_and_shared_edges_are_named() {
    let mut open = cuboid([0.0; 3], [0.02; 3]);
    open.pop();
    refused(
        &open,
        0.003,
        &["3 edges with a triangle on one side", "(0.000000, ", "holes", "Close Holes"],
    );
    let mm = MeshOptions {
        filling: Some(Filling::even(0.003)),
        unit_m: 0.001,
        ..MeshOptions::default()
    };
    let scaled: Triangles = open.iter().map(|t| t.map(|p| p.map(|x| x * 1000.0))).collect();
    let why = fill_with(&stl(&scaled), mm).unwrap_err().to_string();
    assert!(why.contains("(0.000000, 20.000000, 20.000000)"), "in the file's unit: {why}");
    let beside = cuboid([0.02, 0.02, 0.0], [0.04, 0.04, 0.02]);
    let shared = [cuboid([0.0; 3], [0.02; 3]), beside].concat();
    refused(&shared, 0.003, &["1 edge with more than two triangles", "(0.020000, 0.020000, 0.0"]);
    let corner = [cuboid([0.0; 3], [0.02; 3]), cuboid([0.02; 3], [0.04; 3])].concat();
    refused(&corner, 0.003, &["at (0.020000, 0.020000, 0.020000)", "touch in one point"]);
}

#[test]
fn what_runs_through_itself_is_named() {
    let two = [cuboid([0.0; 3], [0.02; 3]), cuboid([0.01; 3], [0.03; 3])].concat();
    refused(
        &two,
        0.003,
        &["pairs of triangles that run through each other", "around (", "Self Intersecting"],
    );
    // A corner pushed through the opposite face.
    let mut pushed = cuboid([0.0; 3], [0.02; 3]);
    pushed
        .iter_mut()
        .flatten()
        .filter(|place| **place == [0.02; 3])
        .for_each(|place| *place = [0.005, 0.005, -0.01]);
    refused(&pushed, 0.003, &["run through each other"]);
    // On each other, in one plane.
    let lying =
        [cuboid([0.0; 3], [0.02; 3]), cuboid([0.005, 0.005, 0.02], [0.01, 0.01, 0.03])].concat();
    refused(&lying, 0.003, &["run through each other"]);
    let far =
        [cuboid([0.0; 3], [0.02; 3]), cuboid([0.005, 0.005, 0.021], [0.01, 0.01, 0.03])].concat();
    refused(&far, 0.002, &["the surface has 2 parts", "a gap", "smaller size"]);
    let near =
        [cuboid([0.0; 3], [0.02; 3]), cuboid([0.005, 0.005, 0.023], [0.01, 0.01, 0.03])].concat();
    let why = fill(&near, 0.0012).unwrap_err().to_string();
    assert!(why.contains("2 unconnected parts"), "{why}");
}

#[test]
fn triangles_without_area_are_named() {
    // A corner in the middle of an edge of the next triangle, closed by a triangle in a line.
    let mut surface = cuboid([0.0; 3], [0.02; 3]);
    let [a, b, c] = surface[0];
    let middle = [0, 1, 2].map(|k| (a[k] + b[k]) / 2.0);
    surface[0] = [a, middle, c];
    surface.push([middle, b, c]);
    surface.push([a, b, middle]);
    refused(&surface, 0.003, &["has no area", "Remove Zero Area Faces"]);
    let mut doubled = cuboid([0.0; 3], [0.02; 3]);
    doubled.push([a, a, b]);
    assert!(fill(&doubled, 0.003).is_ok(), "a triangle with a corner twice is left out");
}

#[test]
fn sizes_that_do_not_fit_say_which_do() {
    let surface = cuboid([0.0; 3], [0.02; 3]);
    for size_m in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(&surface, size_m, &["`fill_m`", "in metres"]);
    }
    for size_m in [1e-300, 1e-9, 0.0004] {
        refused(&surface, size_m, &["more than 65535 cells", "take `fill_m` ", " or more"]);
    }
    refused(&surface, 0.1, &["`fill_m` 0.1", "take"]);
    // No number runs over the line, and what is said to fit does not depend on the size asked for.
    for (size_m, part) in
        [(1e-300, "1e-300, more than"), (1e300, "1e300 fits"), (-1e300, "-1e300:")]
    {
        let why = fill(&surface, size_m).unwrap_err().to_string();
        assert!(why.len() < 160 && why.contains(part) && !why.contains("inf"), "{why}");
    }
    let fits = |size_m: f64| {
        let why = fill(&surface, size_m).unwrap_err().to_string();
        why.split_once("take `fill_m` ").unwrap().1[..7].to_owned()
    };
    assert_eq!(fits(1e-300), fits(1e-6));
    // A rod whose box is large and whose volume is small.
    let along: Triangles = cuboid([-1e-4, -1e-4, 0.0], [1e-4, 1e-4, 1.0])
        .iter()
        .map(|t| t.map(|[x, y, z]| [x + z, y + z, z]))
        .collect();
    refused(&along, 1e-3, &["a lattice of", "the limit is"]);
}

#[test]
fn a_thin_part_that_would_be_lost_is_named() {
    // A body with a fin much thinner than the tetrahedra, beside it and joined by nothing.
    let mut surface = cuboid([0.0; 3], [0.02; 3]);
    surface.extend(cuboid([0.03, 0.0, 0.0], [0.0302, 0.02, 0.02]));
    refused(&surface, 0.003, &["around (0.03", "is lost", "smaller size"]);
}

#[test]
fn an_option_where_it_has_no_meaning_is_refused() {
    let options = MeshOptions { filling: Some(Filling::even(0.01)), ..MeshOptions::default() };
    for spec in ["organ:300", "box:3x3x3x0.01", "plane:3x3x0.01"] {
        let why = chaincell_host::mesh::load(spec, &options).unwrap_err().to_string();
        assert!(why.contains("`fill_m`") && why.contains(spec), "{why}");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/meshes/box.ascii.vtk");
    let why = chaincell_host::mesh::load(path.to_str().unwrap(), &options).unwrap_err().to_string();
    assert!(why.contains("`fill_m`") && why.contains("STL"), "{why}");
    let surface = from_bytes("a.stl", &stl(&cuboid([0.0; 3], [0.02; 3])), &MeshOptions::default());
    let why = surface.unwrap_err().to_string();
    assert!(why.contains("a.stl") && why.contains("`fill_m` SIZE"), "{why}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    /// Moved, turned and bent boxes are filled to their volume.
    #[test]
    fn bent_boxes_are_filled(bend in -8.0..8.0f64, turn in 0.0..1.5f64, shift in prop::array::uniform3(-0.1..0.1)) {
        let (sine, cosine) = turn.sin_cos();
        let place = |[x, y, z]: [f64; 3]| {
            let z = z + bend * x * x;
            [cosine * x - sine * z + shift[0], y + shift[1], sine * x + cosine * z + shift[2]]
        };
        // Cut finely along x, where it bends.
        let mut surface = Vec::new();
        let steps = 8;
        let at = |i: usize| -0.03 + 0.06 * i as f64 / f64::from(steps);
        for i in 0..steps as usize {
            let part = cuboid([at(i), -0.01, -0.008], [at(i + 1), 0.01, 0.008]);
            // The walls between the parts are left out.
            let is_wall = |k: usize| k < 2 && i > 0 || (2..4).contains(&k) && i + 1 < steps as usize;
            surface.extend(part.into_iter().enumerate().filter(|(k, _)| !is_wall(*k)).map(|(_, t)| t.map(place)));
        }
        let mesh = fill(&surface, 0.004).unwrap();
        let filled = figures(&mesh);
        prop_assert!(filled.volume_error.abs() < 0.03 && filled.roundness > 0.1, "{:?}", filled);
        prop_assert!((volume_m3(&mesh) / filled.volume_m3 - 1.0 - filled.volume_error).abs() < 1e-9);
    }
}
