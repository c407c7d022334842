//! The pressure of a probe at the points of `final.vtu` and of snapshots.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeMap;
use std::path::Path;

use chaincell_tests::files::{Table, array, bake, scratch, text};
use chaincell_tests::run;

use super::run::check_vtu;

/// Each point with a third of the area at rest of the triangles around it \[m2\].
fn areas_m2(vtu: &str) -> Vec<f64> {
    let (at, moved) = (array(vtu, "position_m"), array(vtu, "displacement_m"));
    let rest = |point: usize, axis: usize| at[3 * point + axis] - moved[3 * point + axis];
    let mut faces: BTreeMap<[usize; 3], usize> = BTreeMap::new();
    for tetrahedron in array(vtu, "connectivity").chunks_exact(4) {
        for left_out in 0..4 {
            let mut face: Vec<usize> = tetrahedron.iter().map(|&point| point as usize).collect();
            face.remove(left_out);
            face.sort_unstable();
            *faces.entry([face[0], face[1], face[2]]).or_default() += 1;
        }
    }
    let mut areas_m2 = vec![0.0; at.len() / 3];
    for (corners, _) in faces.into_iter().filter(|(_, times)| *times == 1) {
        let edge =
            |corner: usize, axis: usize| rest(corners[corner], axis) - rest(corners[0], axis);
        let across = |one: usize, other: usize| {
            edge(1, one) * edge(2, other) - edge(1, other) * edge(2, one)
        };
        let twice = across(0, 1).hypot(across(1, 2)).hypot(across(2, 0));
        corners.iter().for_each(|&corner| areas_m2[corner] += twice / 6.0);
    }
    areas_m2
}

/// Pressure times area over all points \[N\], and where the pressure is largest.
fn total(file: &Path) -> (f64, usize) {
    check_vtu_of_tools(file);
    let vtu = std::fs::read_to_string(file).unwrap();
    let pressure_pa = array(&vtu, "contact_pressure_pa");
    assert!(pressure_pa.iter().all(|&of| of >= 0.0));
    let of_point = pressure_pa.iter().zip(areas_m2(&vtu)).map(|(p, area)| p * area);
    let (mut most, nodes) = (0, array(&vtu, "node"));
    for (point, of) in pressure_pa.iter().enumerate() {
        most = if *of > pressure_pa[most] { point } else { most };
    }
    (of_point.sum(), nodes[most] as usize)
}

/// Well-formed, with a number at each point.
fn check_vtu_of_tools(file: &Path) {
    let vtu = std::fs::read_to_string(file).unwrap();
    assert_eq!(array(&vtu, "contact_pressure_pa").len(), array(&vtu, "node").len());
    assert_eq!(vtu.matches("<DataArray").count(), vtu.matches("</DataArray>").count());
}

#[test]
fn pressure_times_area_is_the_sum_of_the_normal_forces() {
    let folder = scratch();
    let options = ["--young-pa", "5000"];
    let model = bake(folder.path(), "box:7x7x5x0.01", &options);
    let out = folder.path().join("out");
    let args = ["run", text(&model), "--motion", "press", "--seconds", "1", "--out", text(&out)];
    let how = ["--contact", "probe:0.006", "--friction", "0.3", "--snapshot-ticks", "0,500,550"];
    run([&args[..], &how].concat()).with(0);
    let contacts = Table::read(&out.join("contacts.csv"));
    let (ticks, forces) = (contacts.whole("tick"), contacts.vectors("normal_x_n"));
    for tick in [0, 500, 550] {
        let sizes = ticks.iter().zip(&forces).filter(|(of, _)| **of == tick);
        let wanted_n: f64 = sizes.map(|(_, [x, y, z])| x.hypot(*y).hypot(*z)).sum();
        let (found_n, node) = total(&out.join(format!("state_{tick}.vtu")));
        assert!((found_n - wanted_n).abs() <= 1e-6 * wanted_n, "{tick}: {found_n} N, {wanted_n} N");
        assert_eq!(wanted_n > 0.05, tick > 0, "{tick}: {wanted_n} N");
        // The press goes down on the corner of the top that comes first: (i 7 + j) 5 + k, k = 4.
        assert!(tick == 0 || node == 4, "{tick}: most at node {node}");
    }
    let last_n = total(&out.join("final.vtu")).0;
    assert_eq!(last_n, 0.0, "the press ends away from the body");
}

#[test]
fn bodies_without_a_tool_on_a_surface_have_no_pressure() {
    let folder = scratch();
    let model = bake(folder.path(), "box:3x3x4x0.01", &[]);
    let out = folder.path().join("out");
    let args = ["run", text(&model), "--motion", "press", "--seconds", "0.1", "--out", text(&out)];
    run(args).with(0);
    check_vtu(&out.join("final.vtu"), 60, 4);
    assert!(!std::fs::read_to_string(out.join("final.vtu")).unwrap().contains("pressure"));
}
