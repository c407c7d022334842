use super::*;
use chaincell_kernel::Model;

use crate::bake::{BakeOptions, bake};
use crate::mesh::{MeshOptions, load};

/// A body with its groups and their links, all links of the mesh equally stiff.
struct Body {
    mesh: Mesh,
    groups: Groups,
    coarse: CoarseLinks,
}

fn body(spec: &str, cells: usize) -> Body {
    let mesh = load(spec, &MeshOptions::default()).unwrap();
    let groups = partition(&mesh, &mesh.default_fixed, cells).unwrap();
    let of_links = |value: f64| vec![value; mesh.links.len()];
    let coarse = couple(&mesh, &groups, &of_links(20.0), &of_links(0.0));
    Body { mesh, groups, coarse }
}

/// Rows of a homogeneous deformation.
type Rows = [[f64; 3]; 3];

fn moved(rows: &Rows, at: [f64; 3]) -> [f64; 3] {
    rows.map(|row| (0..3).map(|axis| row[axis] * at[axis]).sum())
}

/// Uniform stretches, compressions and shears by `by`, along the axes and askew.
fn deformations(by: f64) -> Vec<(&'static str, Rows)> {
    let one = |i: usize, j: usize, e: f64| {
        let mut rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        rows[i][j] += e;
        rows
    };
    let askew = |e: f64| {
        let n = [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0];
        std::array::from_fn(|i| {
            std::array::from_fn(|j| f64::from(u8::from(i == j)) + e * n[i] * n[j])
        })
    };
    vec![
        ("stretch x", one(0, 0, by)),
        ("stretch y", one(1, 1, by)),
        ("compression z", one(2, 2, -by)),
        ("compression x", one(0, 0, -by)),
        ("shear xy", one(0, 1, by)),
        ("shear yz", one(1, 2, by)),
        ("shear zx", one(2, 0, by)),
        ("stretch askew", askew(by)),
        ("compression askew", askew(-by)),
    ]
}

/// Energy of links between `nodes` under a homogeneous deformation.
fn energy(nodes: &[[f64; 3]], links: &[[u32; 2]], stiffness: &[f64], rows: &Rows) -> f64 {
    let length = |[i, j]: [u32; 2], rows: &Rows| {
        let (a, b) = (nodes[i as usize], nodes[j as usize]);
        let d: [f64; 3] = std::array::from_fn(|axis| b[axis] - a[axis]);
        squared(moved(rows, d), [0.0; 3]).sqrt()
    };
    let rest = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let of = |(link, k): (&[u32; 2], &f64)| {
        0.5 * k * (length(*link, rows) - length(*link, &rest)).powi(2)
    };
    links.iter().zip(stiffness).map(of).sum()
}

/// Returns true if links of the mesh connect the nodes of a group.
fn connected(mesh: &Mesh, of: &[u32], group: u32) -> bool {
    let inside: Vec<[u32; 2]> = (mesh.links.iter())
        .filter(|link| link.iter().all(|&node| of[node as usize] == group))
        .copied()
        .collect();
    let nodes: Vec<u32> = (0..of.len() as u32).filter(|&node| of[node as usize] == group).collect();
    Graph::new(&mesh.nodes_m, &inside).parts(&nodes).len() == 1
}

#[test]
fn groups_are_connected_and_keep_fixed_and_surface_apart() {
    for (spec, cells) in [("box:9x7x6x0.01", 60), ("organ:800", 90), ("plane:15x15x0.01", 25)] {
        let Body { mesh, groups, .. } = body(spec, cells);
        assert_eq!(groups.node.len(), cells, "{spec}");
        let mut surface = vec![false; mesh.nodes_m.len()];
        mesh.triangles.iter().flatten().for_each(|&node| surface[node as usize] = true);
        for (node, &group) in groups.of.iter().enumerate() {
            let middle = groups.node[group as usize] as usize;
            assert_eq!(surface[node], surface[middle], "{spec}: node {node}");
            let is_fixed = mesh.default_fixed.contains(&(node as u32));
            assert_eq!(is_fixed, groups.fixed[group as usize], "{spec}: node {node}");
        }
        for (group, &node) in (0_u32..).zip(&groups.node) {
            assert_eq!(groups.of[node as usize], group);
            assert!(connected(&mesh, &groups.of, group), "{spec}: group {group}");
        }
    }
}

#[test]
fn spacing_is_about_even_and_the_same_each_time() {
    let first = body("organ:3000", 300);
    assert_eq!(first.groups, body("organ:3000", 300).groups);
    let mut sizes = vec![0_usize; 300];
    first.groups.of.iter().for_each(|&group| sizes[group as usize] += 1);
    let mut surface = vec![false; first.mesh.nodes_m.len()];
    first.mesh.triangles.iter().flatten().for_each(|&node| surface[node as usize] = true);
    for on_surface in [true, false] {
        let of: Vec<usize> = (first.groups.node.iter().zip(&sizes))
            .filter(|(node, _)| surface[**node as usize] == on_surface)
            .map(|(_, &size)| size)
            .collect();
        let mean = of.iter().sum::<usize>() as f64 / of.len() as f64;
        let off = of.iter().map(|&size| (size as f64 - mean).abs()).sum::<f64>() / of.len() as f64;
        assert!(off < 0.4 * mean, "{on_surface}: mean {mean}, off by {off}");
    }
}

#[test]
fn bad_numbers_of_cells_are_refused() {
    let mesh = load("box:4x4x4x0.01", &MeshOptions::default()).unwrap();
    for cells in [0, 1, 65, usize::MAX] {
        let why = partition(&mesh, &mesh.default_fixed, cells).unwrap_err().to_string();
        assert!(why.contains(&format!("`cells` {cells}: must be from 2 to 64")), "{why}");
    }
    // Fixed and free, surface and inside: three kinds stay apart.
    assert_eq!(partition(&mesh, &mesh.default_fixed, 2).unwrap().node.len(), 3);
    let with = |cells| {
        let options = BakeOptions { cells, ..BakeOptions::default() };
        bake(&mesh, &mesh.default_fixed, &options).unwrap()
    };
    assert_eq!(with(Some(64)), with(None));
}

#[test]
fn carried_nodes_rest_and_follow_linear_fields() {
    for (spec, cells) in [("box:9x7x6x0.01", 60), ("organ:2000", 150), ("plane:15x15x0.01", 25)] {
        let mesh = load(spec, &MeshOptions::default()).unwrap();
        let options = BakeOptions { cells: Some(cells), ..BakeOptions::default() };
        let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        assert_eq!((model.cells(), model.fine_nodes()), (cells, mesh.nodes_m.len()));
        let rows = [[0.9, 0.3, -0.2], [-0.1, 1.2, 0.4], [0.2, -0.3, 0.8]];
        let linear = |p: [f32; 3]| moved(&rows, p.map(f64::from)).map(|x| x as f32 + 0.5);
        for node in 0..model.fine_nodes() {
            let rest = model.fine_rest(node).unwrap();
            let unmoved = model.fine_position(node, |cell| Some(model.rest_position(cell)));
            assert_eq!(unmoved, Some(rest), "{spec}: node {node}");
            let total: f32 = model.fine_weights(node).map(|(_, w)| w).sum();
            assert!((total - 1.0).abs() < 1e-5, "{spec}: node {node}: {total}");
            let cell = model.cell_of_input(node as u32).unwrap();
            if model.is_fixed(cell) {
                continue;
            }
            let place =
                model.fine_position(node, |cell| Some(linear(model.rest_position(cell)))).unwrap();
            let off = (0..3).map(|axis| (place[axis] - linear(rest)[axis]).abs());
            assert!(off.fold(0.0, f32::max) < 1e-5, "{spec}: node {node}: {place:?}");
        }
    }
}

#[test]
fn homogeneous_strains_cost_what_they_cost_the_mesh() {
    for (spec, cells, within) in [("box:21x21x11x0.005", 1000, 0.03), ("organ:5762", 500, 0.06)] {
        let Body { mesh, groups, coarse } = body(spec, cells);
        let cells_m: Vec<[f64; 3]> =
            groups.node.iter().map(|&node| mesh.nodes_m[node as usize]).collect();
        for (name, rows) in deformations(0.05) {
            let fine = energy(&mesh.nodes_m, &mesh.links, &vec![20.0; mesh.links.len()], &rows);
            let ours = energy(&cells_m, &coarse.links, &coarse.stiffness_n_per_m, &rows);
            let off = ours / fine - 1.0;
            println!("{spec}, {cells} cells, {name}: energy off by {:.1} %", 100.0 * off);
            assert!(off.abs() < within, "{spec}: {name}: {off}");
        }
    }
}
