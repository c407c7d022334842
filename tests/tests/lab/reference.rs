//! The project's own double-precision references against data computed elsewhere.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::mesh::{MeshOptions, load};
use chaincell_lab::reference::vectors::farthest;
use chaincell_lab::reference::{Links, Npz, minimum, trajectory};
use chaincell_tests::reference;

const CENTRE: usize = 220;

/// The paper's plane: 21 x 21 cells, 10 mm apart, border fixed.
fn plane(diagonals: bool, alpha: f64) -> Links {
    let options = MeshOptions { diagonals, ..MeshOptions::default() };
    let mesh = load("plane:21x21x0.01", &options).unwrap();
    Links::from_edges(&mesh.nodes_m, &mesh.links, alpha, &mesh.border).unwrap()
}

/// Every flow of the plane, by an integrator of order 8 at 1e-10, at t = 1, 10, 100 and 1000.
#[test]
fn plane_trajectories() {
    let Some(folder) = reference("plane_trajectories") else { return };
    let mut flows = 0;
    for entry in std::fs::read_dir(folder.join("plane")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let Some(parts) = name.strip_prefix("flow_c") else { continue };
        flows += 1;
        let number = |at: usize, skip: usize| -> f64 {
            parts.split('_').nth(at).unwrap()[skip..].parse().unwrap()
        };
        let links = plane(number(0, 0) == 8.0, number(1, 1) * 1e-3);
        let mut exact = Npz::open(&path).unwrap();
        let held = [(CENTRE, [0.0, 0.0, number(2, 1) * 1e-3])];
        let found = trajectory(&links, &held, &[1.0, 10.0, 100.0, 1000.0], 1e-9);
        for (positions, moment) in found.iter().zip(["x_t1", "x_t10", "x_t100", "x_t1000"]) {
            let error = farthest(positions, &exact.vectors(moment).unwrap());
            println!("{name} {moment}: {error:.1e} m");
            assert!(error < 1e-7, "{name} {moment}: {error:e} m");
        }
    }
    assert_eq!(flows, 10);
}

/// The plane's minima where they are unique.
#[test]
fn plane_minima() {
    let Some(folder) = reference("plane_minima") else { return };
    for name in ["c4_a000_d010", "c4_a000_d050", "c4_a000_d100", "c8_a000_d010", "c8_a000_d050"] {
        let links = plane(name.starts_with("c8"), 0.0);
        let depth_m = name[9..].parse::<f64>().unwrap() * 1e-3;
        let mut exact = Npz::open(&folder.join(format!("plane/flow_{name}.npz"))).unwrap();
        let start = trajectory(&links, &[(CENTRE, [0.0, 0.0, depth_m])], &[10.0], 1e-6);
        let found = minimum(&links, &[(CENTRE, [0.0, 0.0, depth_m])], &start[0], 1e-13);
        let error = farthest(&found.positions, &exact.vectors("x_min").unwrap());
        println!("{name}: {error:.1e} m, {} iterations", found.iterations);
        assert!(found.residual_max <= 1e-13, "{name}: residual {:e}", found.residual_max);
        assert!(error < 1e-7, "{name}: {error:e} m");
    }
}

/// Minima of the box's links, uniform and with a stiffness each, followed from depth to depth.
#[test]
fn box_minima() {
    let Some(folder) = reference("box_minima") else { return };
    let mut mesh = Npz::open(&folder.join("meshes/box_reg.npz")).unwrap();
    let mut edges = Npz::open(&folder.join("boxlinks/box_reg_edges.npz")).unwrap();
    let (rest, fixed) = (mesh.vectors("X").unwrap(), mesh.ids("fixed").unwrap());
    let uniform = Links::from_edges(&rest, &edges.rows("edges").unwrap(), 0.0, &fixed).unwrap();
    let stiffness_n_per_m = edges.reals("k_vangelder_E5000").unwrap();
    let vangelder = uniform.clone().with_weights(stiffness_n_per_m).unwrap();
    // The uniform data are for k = 0.5 N/m; the force is the tool's, ours the tissue's.
    let cases = [
        ("node", "node_min_uniform", uniform, 1.0),
        ("patch", "patch_min_vangelder", vangelder, 2.0),
    ];
    for (contact, name, links, newtons) in cases {
        let contact: Vec<usize> =
            mesh.ids(contact).unwrap().into_iter().map(|id| id as usize).collect();
        let mut exact =
            Npz::open(&folder.join(format!("boxlinks/box_reg_{name}_a000.npz"))).unwrap();
        let (depth_m, u) = (exact.reals("d").unwrap(), exact.vectors("u").unwrap());
        let force = exact.vectors("F").unwrap();
        let mut start = rest.clone();
        for (step, depth_m) in depth_m.iter().enumerate() {
            let u = &u[step * rest.len()..(step + 1) * rest.len()];
            let held: Vec<_> = (contact.iter())
                .map(|&cell| (cell, std::array::from_fn(|x| rest[cell][x] + u[cell][x])))
                .collect();
            let found = minimum(&links, &held, &start, 1e-12);
            let field: Vec<[f64; 3]> = (found.positions.iter().zip(&rest))
                .map(|(p, r)| std::array::from_fn(|x| p[x] - r[x]))
                .collect();
            let error = farthest(&field, u);
            let own = links.force(&found.positions, &contact);
            println!("{name} {depth_m}: {error:.1e} m, {} iterations", found.iterations);
            assert!(found.residual_max <= 1e-12, "{name}: residual {:e}", found.residual_max);
            assert!(error < 1e-9, "{name} {depth_m}: {error:e} m");
            for axis in 0..3 {
                let difference = newtons * own[axis] + force[step][axis];
                let force_n = force[step][2].abs();
                assert!(difference.abs() < 1e-6 * force_n, "{name} {depth_m}: {own:?}");
            }
            start = found.positions;
        }
    }
}
