//! Measures how much softer a network of groups is than its links' energy predicts.
//!
//! Under homogeneous stress the cells of an irregular network leave the homogeneous strain and yield
//! more than single links would. Forces that hold the mesh in a homogeneous strain, distributed to
//! the cells by the weights of the nodes, strain the network more. The ratio, over six strains, is
//! the factor by which all its links are stiffened (a patch test).

use super::embedding::Embedding;
use super::graph::{mean, squared};
use crate::mesh::Mesh;

use chaincell_kernel::image::NO_CELL;

/// Most steps of conjugate gradients for a strain.
const STEPS_MAX: usize = 400;
/// Residual at which they end, as a share of the first.
const RESIDUAL: f64 = 1e-4;
/// Stiffness of a spring from every cell to its position in the homogeneous strain, as a share of its
/// links: it holds loose cells.
const BED: f64 = 1e-3;
/// Limit of a cell's deviation, as a share of the mean displacement: some cells are loose.
const CAP: f64 = 0.5;
/// Range to which the factor is limited.
const FACTORS: std::ops::RangeInclusive<f64> = 1.0..=1.5;

/// Springs along the links of a body at rest: the second derivative of its energy.
struct Springs<'a> {
    links: &'a [[u32; 2]],
    /// Stiffness and direction of each.
    along: Vec<(f64, [f64; 3])>,
    bed: Vec<f64>,
}

impl<'a> Springs<'a> {
    fn new(nodes_m: &[[f64; 3]], links: &'a [[u32; 2]], stiffness: &[f64]) -> Self {
        let mut bed = vec![0.0; nodes_m.len()];
        let along = links.iter().zip(stiffness).map(|(&[i, j], &k)| {
            let (a, b) = (nodes_m[i as usize], nodes_m[j as usize]);
            let length = squared(a, b).sqrt();
            bed[i as usize] += k;
            bed[j as usize] += k;
            (k, std::array::from_fn(|axis| (b[axis] - a[axis]) / length))
        });
        let along = along.collect();
        Self { links, along, bed }
    }

    /// Returns the forces that hold the nodes at displacements, without those of the bed.
    fn forces(&self, moved: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut forces = vec![[0.0; 3]; moved.len()];
        for (&[i, j], &(k, n)) in self.links.iter().zip(&self.along) {
            let (i, j) = (i as usize, j as usize);
            let force: f64 =
                k * (0..3).map(|axis| n[axis] * (moved[j][axis] - moved[i][axis])).sum::<f64>();
            for axis in 0..3 {
                forces[i][axis] -= force * n[axis];
                forces[j][axis] += force * n[axis];
            }
        }
        forces
    }

    /// Returns the displacements under forces, by conjugate gradients scaled with the cells' links.
    fn yields(&self, forces: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let scaled = |r: &[[f64; 3]]| -> Vec<[f64; 3]> {
            r.iter()
                .zip(&self.bed)
                .map(|(r, k)| r.map(|x| if *k > 0.0 { x / k } else { 0.0 }))
                .collect()
        };
        // Start at rest, with the residual as the first direction.
        let mut moved = vec![[0.0; 3]; forces.len()];
        let mut left = forces.to_vec();
        let mut way = scaled(&left);
        let mut size = work(&left, &way);
        let enough = RESIDUAL * RESIDUAL * size;
        for _ in 0..STEPS_MAX {
            if size <= enough {
                break;
            }
            // Step along the direction.
            let mut against = self.forces(&way);
            for ((f, d), k) in against.iter_mut().zip(&way).zip(&self.bed) {
                *f = std::array::from_fn(|axis| f[axis] + BED * k * d[axis]);
            }
            let step = size / work(&way, &against);
            for (((u, r), d), f) in moved.iter_mut().zip(&mut left).zip(&way).zip(&against) {
                *u = std::array::from_fn(|axis| u[axis] + step * d[axis]);
                *r = std::array::from_fn(|axis| r[axis] - step * f[axis]);
            }
            // The next direction.
            let next = scaled(&left);
            let grown = work(&left, &next);
            for (d, z) in way.iter_mut().zip(next) {
                *d = std::array::from_fn(|axis| z[axis] + grown / size * d[axis]);
            }
            size = grown;
        }
        moved
    }
}

/// Returns the inner product of forces and displacements.
fn work(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| a * b).sum()
}

/// Returns the factor for links of `coarse_k` between cells at `cells_m`, for a mesh with links of `k`;
/// 1 for a body without an extent along each axis. Cost: a few hundred passes over both.
pub fn stiffening(
    mesh: &Mesh,
    k: &[f64],
    cells_m: &[[f64; 3]],
    links: &[[u32; 2]],
    coarse_k: &[f64],
    embedding: &Embedding,
) -> f64 {
    let flat = |axis: usize| mesh.nodes_m.iter().all(|p| p[axis] == mesh.nodes_m[0][axis]);
    if (0..3).any(flat) {
        return 1.0;
    }
    let (fine, coarse) =
        (Springs::new(&mesh.nodes_m, &mesh.links, k), Springs::new(cells_m, links, coarse_k));
    let centre = mean(cells_m.iter().copied());
    let (mut of_mesh, mut beyond) = (0.0, 0.0);
    for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)] {
        let strain = |p: [f64; 3]| {
            let mut u = [0.0; 3];
            u[i] += 0.5 * (p[j] - centre[j]);
            u[j] += 0.5 * (p[i] - centre[i]);
            u
        };
        // Forces that hold the mesh in the strain, distributed to the cells.
        let strained: Vec<[f64; 3]> = mesh.nodes_m.iter().map(|&p| strain(p)).collect();
        let forces = fine.forces(&strained);
        let mut handed = vec![[0.0; 3]; cells_m.len()];
        for (node, force) in forces.iter().enumerate() {
            let cells = embedding.groups[node].iter().zip(&embedding.weights[node]);
            for (&group, &w) in cells.filter(|entry| *entry.0 != NO_CELL) {
                let cell = &mut handed[usize::from(group)];
                *cell = std::array::from_fn(|axis| cell[axis] + f64::from(w) * force[axis]);
            }
        }
        // Compare the mean strain, not the work, which a few loose cells would dominate.
        let expected: Vec<[f64; 3]> = cells_m.iter().map(|&p| strain(p)).collect();
        let held = coarse.forces(&expected);
        for (handed, held) in handed.iter_mut().zip(&held) {
            *handed = std::array::from_fn(|axis| handed[axis] - held[axis]);
        }
        let whole = work(&expected, &expected);
        let cap = CAP * CAP * whole / cells_m.len() as f64;
        // Displacements beyond the strain, each limited.
        let mut moved = coarse.yields(&handed);
        for u in &mut moved {
            let size = squared(*u, [0.0; 3]);
            if size > cap {
                *u = u.map(|x| x * (cap / size).sqrt());
            }
        }
        of_mesh += whole;
        beyond += work(&expected, &moved);
    }
    (1.0 + beyond / of_mesh).clamp(*FACTORS.start(), *FACTORS.end())
}
