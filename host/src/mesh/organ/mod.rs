//! `organ[:NODES]`: a generated liver-shaped body of about NODES nodes.
//!
//! Every machine gets the same bits: only + - * / and square roots, in a fixed order.

mod shape;

use std::collections::BTreeMap;

use super::Mesh;
use super::geometry::distance;
use super::stuffing::smooth::smooth;
use super::stuffing::web::Web;
use super::stuffing::{TetMesh, fill};
use crate::error::{Error, Result};
use shape::Liver;

/// Default number of nodes.
const SIZE: usize = 5_762;
/// Fewest nodes: with fewer, the thin lobe has no inside.
const SIZE_MIN: usize = 150;
/// Most nodes.
const SIZE_MAX: usize = 60_000;

/// Error of the size that ends the search: 1 in 200, of 1 in 50 allowed.
const CLOSE: usize = 200;
/// Largest error of the size, 1 in 50: otherwise the size is refused.
const ALLOWED: usize = 50;

/// Middle of the held patch, a point of the back, in metres.
const BACK_M: [f64; 3] = [-0.03, 0.08, 0.012];

/// One in this many surface nodes is held.
const SURFACE_PER_FIXED: usize = 10;

/// Generates a body of 0.20 x 0.15 x 0.09 m with nodes within 2 % of `size` (150 to 60,000; default
/// 5,762), held at a patch of its back, a tenth of the surface nodes.
pub(super) fn generate(size: Option<&str>) -> Result<Mesh> {
    let size = match size.map(str::parse::<usize>) {
        None => SIZE,
        Some(Ok(size)) if (SIZE_MIN..=SIZE_MAX).contains(&size) => size,
        _ => {
            return Err(Error::input(format!(
                "mesh organ:{}: SIZE must be a whole number of nodes from {SIZE_MIN} to {SIZE_MAX}",
                size.unwrap_or("")
            )));
        }
    };
    let mut body = sized(size)?;
    smooth(&Liver, &Web::new(&body), &mut body, &[], &[]);
    let mesh = Mesh::from_tetrahedra(body.nodes_m, &body.tetrahedra, BTreeMap::new());
    Ok(Mesh { default_fixed: back(&mesh), ..mesh })
}

/// Returns the body whose number of nodes is close to `size`.
fn sized(size: usize) -> Result<TetMesh> {
    let off = |body: &TetMesh| body.nodes_m.len().abs_diff(size);
    let mut spacing_m = 0.02;
    let (mut best, mut best_m) = (fill(&Liver, spacing_m, 0.0), spacing_m);
    let mut latest = best.nodes_m.len();
    // Newton's steps find the spacing roughly: the number of nodes scales with its inverse cube.
    for _ in 0..12 {
        spacing_m *= (1.0 + (latest as f64 / size as f64 - 1.0) / 3.0).clamp(0.7, 1.3);
        let body = fill(&Liver, spacing_m, 0.0);
        latest = body.nodes_m.len();
        if off(&body) < off(&best) {
            (best, best_m) = (body, spacing_m);
        }
        if off(&best) * CLOSE <= size {
            return Ok(best);
        }
    }
    // Small steps around it with a shifted lattice find the numbers that small bodies skip.
    let middle_m = best_m;
    for step in (1..=200).map(f64::from) {
        for sign in [-1.0, 1.0] {
            let body = fill(&Liver, middle_m * (1.0 + sign * 0.0005 * step), 0.01 * step);
            if off(&body) < off(&best) {
                best = body;
            }
        }
        if off(&best) * CLOSE <= size {
            return Ok(best);
        }
    }
    if off(&best) * ALLOWED <= size {
        return Ok(best);
    }
    Err(Error::input(format!("mesh organ:{size}: no lattice comes near; take another SIZE")))
}

/// Returns the surface nodes nearest to the middle of the back, sorted.
fn back(mesh: &Mesh) -> Vec<u32> {
    let mut surface: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
    surface.sort_unstable();
    surface.dedup();
    let count = surface.len() / SURFACE_PER_FIXED;
    let away = |id: &u32| distance(mesh.nodes_m[*id as usize], BACK_M);
    surface.sort_by(|a, b| away(a).total_cmp(&away(b)));
    surface.truncate(count);
    surface.sort_unstable();
    surface
}

#[cfg(test)]
mod tests {
    use super::super::geometry::{corners, volume6};
    use super::*;
    use crate::mesh::stuffing::smooth::roundness;
    use crate::mesh::{MeshOptions, boundary, check};

    /// Checks the properties of every size; returns the body.
    fn sound(size: usize) -> Mesh {
        let mesh = generate(Some(&size.to_string())).unwrap();
        let nodes = mesh.nodes_m.len();
        assert!(nodes.abs_diff(size) * 50 <= size, "{size}: {nodes} nodes");
        assert_eq!(check::check("organ", &mesh, &MeshOptions::default()), Ok(vec![]));
        for tetrahedron in &mesh.tetrahedra {
            let roundness = roundness(corners(&mesh.nodes_m, *tetrahedron));
            assert!(roundness > 0.4, "{size}: roundness {roundness}");
        }
        let place = |id: u32| mesh.nodes_m[id as usize];
        let lengths = mesh.links.iter().map(|[i, j]| distance(place(*i), place(*j)));
        let mean = lengths.clone().sum::<f64>() / mesh.links.len() as f64;
        assert!(lengths.clone().all(|l| l > 0.35 * mean && l < 2.1 * mean), "{size}: lengths");
        let mut valence = vec![0; nodes];
        mesh.links.iter().flatten().for_each(|id| valence[*id as usize] += 1);
        assert!(valence.iter().all(|v| (5..=20).contains(v)), "{size}: valence");
        mesh
    }

    fn surface(mesh: &Mesh) -> Vec<u32> {
        let mut ids: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    }

    #[test]
    fn small_and_large_sizes_are_sound() {
        for size in (150..800).step_by(41).chain([1_000, 2_013, 20_000, 60_000]) {
            sound(size);
        }
    }

    #[test]
    fn default_is_a_liver() {
        let mesh = sound(SIZE);
        assert_eq!(mesh, generate(None).unwrap());
        for (axis, (expected_m, tolerance_m)) in
            [(0.2, 0.002), (0.15, 0.002), (0.09, 0.002)].into_iter().enumerate()
        {
            let along = mesh.nodes_m.iter().map(|place| place[axis]);
            let low = along.clone().fold(f64::INFINITY, f64::min);
            let high = along.fold(f64::NEG_INFINITY, f64::max);
            assert!((high - low - expected_m).abs() < tolerance_m, "axis {axis}: {}", high - low);
        }
        let skin = surface(&mesh);
        // Closed and without a hole: Euler's number of a sphere.
        assert_eq!(skin.len() - mesh.triangles.len() / 2, 2);
        for id in &skin {
            assert!(shape::value(mesh.nodes_m[*id as usize]).abs() < 1e-9);
        }
        // The right third is large, the left one thin.
        let volume = |sign: f64| -> f64 {
            let all = mesh.tetrahedra.iter().map(|t| corners(&mesh.nodes_m, *t));
            let side = all.filter(|points| points[0][0] * sign > 0.033);
            side.map(|points| volume6(points) / 6.0).sum()
        };
        assert!(volume(-1.0) > 2.0 * volume(1.0), "{} {}", volume(-1.0), volume(1.0));
    }

    #[test]
    fn fixed_at_the_back() {
        let mesh = generate(Some("2000")).unwrap();
        let skin = surface(&mesh);
        assert_eq!(mesh.default_fixed.len(), skin.len() / 10);
        assert!(mesh.default_fixed.windows(2).all(|pair| pair[0] < pair[1]));
        for id in &mesh.default_fixed {
            assert!(skin.binary_search(id).is_ok() && mesh.nodes_m[*id as usize][1] > 0.03);
        }
    }

    /// The bits are the same on every machine and in every build: a golden sum over the default body.
    #[test]
    fn same_bits_everywhere() {
        let mesh = generate(None).unwrap();
        let places = mesh.nodes_m.iter().flatten().map(|x| x.to_bits());
        let ids = mesh.tetrahedra.iter().flatten().map(|id| u64::from(*id));
        let sum = places.chain(ids).fold(0xcbf2_9ce4_8422_2325, |hash: u64, word| {
            (hash ^ word).wrapping_mul(0x0000_0100_0000_01b3)
        });
        let counts = (mesh.nodes_m.len(), mesh.tetrahedra.len(), mesh.links.len());
        assert_eq!((counts, sum), ((5_783, 28_039, 35_753), 0xb0dba96fcfd9e481));
    }

    #[test]
    fn faces_conform() {
        let mesh = generate(Some("300")).unwrap();
        // Faces that do not conform would stay single inside.
        let skin = surface(&mesh);
        assert_eq!(boundary(&mesh.tetrahedra).len(), 2 * (skin.len() - 2));
    }

    #[test]
    fn sizes_are_bounded() {
        for size in ["", "149", "60001", "-5", "many", "99999999999999999999999"] {
            let text = generate(Some(size)).unwrap_err().to_string();
            assert!(text.contains(&format!("mesh organ:{size}: SIZE")), "{text}");
            assert!(text.contains("from 150 to 60000"), "{text}");
        }
    }
}
