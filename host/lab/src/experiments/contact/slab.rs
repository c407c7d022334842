//! A round slab of tetrahedra with a flat top, its mesh nothing special.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use super::{HEIGHT_M, POISSON, RADIUS_M, YOUNG_PA};
use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, ProbeContact, bake};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{Mesh, MeshOptions, RawMesh, load};

/// A node lies aside of its lattice place by so many edges of a cube at most, along each axis.
const ASIDE: f64 = 0.15;
/// Mean edge of a surface triangle of a cube's lattice, over the cube's: two edges, one diagonal.
const MEAN_EDGE: f64 = (2.0 + std::f64::consts::SQRT_2) / 3.0;
/// What is taken as the same height \[m\].
const FLAT_M: f64 = 1e-9;

/// A body that a sphere is pressed into.
pub struct Slab {
    /// Nodal shapes with a contact surface.
    pub image: ImageBytes,
    /// Mean edge of the triangles of its top \[m\].
    pub edge_m: f64,
    /// Nodes of the mesh.
    pub cells: usize,
    /// Where on the top a sphere is set (x, y) \[m\]: over the node nearest to the axis and over its
    /// nearest neighbour, over the middle of an edge and over that of a triangle.
    pub places_m: [[f64; 2]; 4],
}

impl Slab {
    /// A slab of [`RADIUS_M`] and [`HEIGHT_M`] held at its bottom, the edges of its top of about
    /// `edge_m`.
    ///
    /// Whole cubes of a lattice, stretched to the volume of the round slab; nodes inside are moved
    /// aside by chance, those of the top within it.
    ///
    /// # Errors
    /// As [`bake()`].
    pub fn new(edge_m: f64, seed: u64) -> Result<Self> {
        let mesh = mesh(edge_m, seed)?;
        let held =
            (0..mesh.nodes_m.len() as u32).filter(|&node| mesh.nodes_m[node as usize][2] < FLAT_M);
        let held: Vec<u32> = held.collect();
        let tissue = Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(POISSON));
        let options = BakeOptions {
            tissue: Some(tissue),
            probe_contact: ProbeContact::Surface,
            ..BakeOptions::default()
        };
        let top: Vec<[[f64; 2]; 3]> = (mesh.triangles.iter())
            .map(|nodes| nodes.map(|node| mesh.nodes_m[node as usize]))
            .filter(|corners| corners.iter().all(|x| x[2] > HEIGHT_M - FLAT_M))
            .map(|corners| corners.map(|[x, y, _]| [x, y]))
            .collect();
        let edges = top.iter().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
        let lengths: f64 = edges.map(|[a, b]| (a[0] - b[0]).hypot(a[1] - b[1])).sum();
        Ok(Self {
            image: bake(&mesh, &held, &options)?,
            edge_m: lengths / (3 * top.len()) as f64,
            cells: mesh.nodes_m.len(),
            places_m: places(&top),
        })
    }
}

/// Nearest places to the axis.
fn places(top: &[[[f64; 2]; 3]]) -> [[f64; 2]; 4] {
    let mean = |of: &[[f64; 2]]| {
        [0, 1].map(|axis| of.iter().map(|x| x[axis]).sum::<f64>() / of.len() as f64)
    };
    let nearest = |of: &mut dyn Iterator<Item = [f64; 2]>| {
        of.min_by(|a, b| a[0].hypot(a[1]).total_cmp(&b[0].hypot(b[1]))).unwrap_or([0.0; 2])
    };
    let node = nearest(&mut top.iter().flatten().copied());
    let next = nearest(&mut top.iter().flatten().copied().filter(|x| *x != node));
    let edges = top.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
    let edge = nearest(&mut edges.map(|ends| mean(&ends)));
    [node, next, edge, nearest(&mut top.iter().map(|corners| mean(corners)))]
}

fn mesh(edge_m: f64, seed: u64) -> Result<Mesh> {
    let cube_m = edge_m / MEAN_EDGE;
    let layers = (HEIGHT_M / cube_m).round().max(1.0);
    let half = (RADIUS_M / cube_m).ceil() as usize + 1;
    let (across, high) = (2 * half + 1, layers as usize + 1);
    let whole = load(&format!("box:{across}x{across}x{high}x{cube_m}"), &MeshOptions::default())?;
    let inside = |ids: &&[u32; 4]| {
        let middle = |axis: usize| {
            let at = |id: &u32| whole.nodes_m[*id as usize][axis];
            let low = ids.iter().map(at).fold(f64::MAX, f64::min);
            low + 0.5 * cube_m
        };
        middle(0).hypot(middle(1)) <= RADIUS_M
    };
    let kept: Vec<[u32; 4]> = whole.tetrahedra.iter().filter(inside).copied().collect();
    let used: BTreeSet<u32> = kept.iter().flatten().copied().collect();
    let place: BTreeMap<u32, u32> = used.iter().zip(0..).map(|(&id, new)| (id, new)).collect();
    let tetrahedra: Vec<[u32; 4]> = kept.iter().map(|ids| ids.map(|id| place[&id])).collect();
    // Five tetrahedra a cube; each layer has as many.
    let area = (kept.len() / 5) as f64 / layers * cube_m * cube_m;
    let [wide, tall] = [(PI / area).sqrt() * RADIUS_M, HEIGHT_M / (layers * cube_m)];
    let lattice: Vec<[f64; 3]> = (used.iter())
        .map(|&id| whole.nodes_m[id as usize])
        .map(|[x, y, z]| [wide * x, wide * y, tall * z])
        .collect();
    let straight = Mesh::from(RawMesh { nodes_m: lattice, tetrahedra, groups: BTreeMap::new() });
    let nodes_m = aside(&straight, ASIDE * cube_m, seed)?;
    let tetrahedra = straight.tetrahedra.clone();
    let mesh = Mesh::from(RawMesh { nodes_m, tetrahedra, groups: BTreeMap::new() });
    // A tetrahedron that was turned inside out would have been given another order.
    if mesh.tetrahedra == straight.tetrahedra {
        Ok(mesh)
    } else {
        Err(Error::check(format!("seed {seed} turns a tetrahedron inside out; take another one")))
    }
}

/// Nodes moved aside by up to `by_m` along each axis: those inside freely, those of the top alone
/// within it, others not.
fn aside(mesh: &Mesh, by_m: f64, seed: u64) -> Result<Vec<[f64; 3]>> {
    let mut random = Pcg64::seed_from_u64(seed);
    let span = Uniform::new(-by_m, by_m).map_err(Error::check)?;
    let mut is_free = vec![[1.0; 3]; mesh.nodes_m.len()];
    for nodes in &mesh.triangles {
        let is_top = nodes.iter().all(|&n| mesh.nodes_m[n as usize][2] > HEIGHT_M - FLAT_M);
        for &node in nodes {
            let [along, _, up] = &mut is_free[node as usize];
            *up = 0.0;
            *along *= f64::from(u8::from(is_top));
        }
    }
    let moved = mesh.nodes_m.iter().zip(is_free).map(|([x, y, z], [along, _, up])| {
        let [a, b, c] = [along, along, up].map(|share| share * span.sample(&mut random));
        [x + a, y + b, z + c]
    });
    Ok(moved.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::bake::tissue::shape::Shape;

    #[test]
    fn a_slab_has_the_volume_of_a_round_one_and_a_flat_top() {
        let mesh = mesh(0.008, 1).unwrap();
        let shape = Shape::new(&mesh.nodes_m, &mesh.tetrahedra).unwrap();
        let volume: f64 = (0..mesh.nodes_m.len()).map(|node| shape.volume_m3(node)).sum();
        let round = PI * RADIUS_M * RADIUS_M * HEIGHT_M;
        assert!((volume / round - 1.0).abs() < 1e-9, "{volume} {round}");
        let top = mesh.nodes_m.iter().filter(|x| x[2] > HEIGHT_M - FLAT_M).count();
        let highest = mesh.nodes_m.iter().filter(|x| x[2] > 0.9 * HEIGHT_M).count();
        assert_eq!(top, highest);
        let far = mesh.nodes_m.iter().map(|[x, y, _]| x.hypot(*y)).fold(0.0, f64::max);
        assert!(far < 1.12 * RADIUS_M, "{far}");
    }
}
