//! Young's modulus of the tissue to which links are equivalent: contact takes its stiffness from it.
//!
//! Springs of stiffness k and length l with uniformly distributed directions make an isotropic solid
//! (Cauchy's). A small strain e stretches each by l n' e n, where n is its direction. The mean of
//! `n_a n_b n_c n_d` over all directions is (`d_ab d_cd` + `d_ac d_bd` + `d_ad d_bc`) / 15, so that
//!
//! ```text
//! lambda = mu = sum of k l^2 / (15 V),   nu = 1/4,   E = 5/2 mu = sum of k l^2 / (6 V)
//! ```
//!
//! V is the volume that they fill. A cell has half of each of its links and a quarter of each of its
//! tetrahedra. Inside their band links give no force; this takes their stiffness beyond it, so a body
//! with slack is softer than this.

use chaincell_kernel::Model;

use crate::mesh::geometry::volume6;

/// Least volume of a cell, as a share of the mean: flat tetrahedra have none.
const LEAST: f64 = 1.0e-3;

/// Young's moduli to which links are equivalent.
#[derive(Debug, Clone, PartialEq)]
pub struct Equivalent {
    /// Modulus of the whole body \[Pa\].
    pub body_pa: f64,
    /// Modulus at each cell \[Pa\].
    pub cells_pa: Vec<f64>,
}

impl Equivalent {
    /// Computes them for links with their stiffness \[N/m\] between cells at rest \[m\]; the tetrahedra
    /// give the volume: the cells at their corners, and the corners \[m\]. `None` if they have none.
    pub fn new(
        rest_m: &[[f64; 3]],
        links: impl Iterator<Item = ([usize; 2], f64)>,
        tetrahedra: impl Iterator<Item = ([usize; 4], [[f64; 3]; 4])>,
    ) -> Option<Self> {
        let (mut energies, mut volumes) = (vec![0.0; rest_m.len()], vec![0.0; rest_m.len()]);
        for ([i, j], stiffness) in links {
            let squared = (0..3).map(|axis| (rest_m[j][axis] - rest_m[i][axis]).powi(2));
            let half = 0.5 * stiffness * squared.sum::<f64>();
            energies[i] += half;
            energies[j] += half;
        }
        for (cells, corners_m) in tetrahedra {
            let volume_m3 = volume6(corners_m).abs() / 6.0;
            cells.into_iter().for_each(|cell| volumes[cell] += 0.25 * volume_m3);
        }
        let sum = |of: &[f64]| of.iter().sum::<f64>();
        let whole = sum(&volumes);
        let least = LEAST * whole / rest_m.len() as f64;
        let each = energies.iter().zip(&volumes);
        (whole > 0.0).then(|| Self {
            body_pa: sum(&energies) / (6.0 * whole),
            cells_pa: each.map(|(energy, volume)| energy / (6.0 * volume.max(least))).collect(),
        })
    }

    /// Computes them for a baked body of links with a contact surface; `None` for other bodies.
    #[must_use]
    pub fn of_model(model: &Model<'_>) -> Option<Self> {
        if model.is_nodal() || !model.has_contact_surface() {
            return None;
        }
        let unit_m = f64::from(model.unit_m());
        let rest_m: Vec<[f64; 3]> = (0..model.body_cells())
            .map(|cell| model.rest_position(cell).map(|x| unit_m * f64::from(x)))
            .collect();
        let stiffness = f64::from(model.stiffness_n_per_m());
        let links = (0..model.body_cells()).flat_map(|cell| {
            model.row(cell).map(move |link| {
                let ends = [cell, usize::from(model.upper()[link])];
                (ends, stiffness * f64::from(model.link_weight(link)))
            })
        });
        let tetrahedra = model.tetrahedra().iter().map(|cells| {
            let cells = cells.map(usize::from);
            (cells, cells.map(|cell| rest_m[cell]))
        });
        Self::new(&rest_m, links, tetrahedra)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{MeshOptions, load};

    /// Far from its surface, a box is a lattice of cubes; a cube has on average 3 edges of length d and
    /// 6 halves of diagonals of length sqrt(2) d in a volume d^3.
    #[test]
    fn a_lattice_has_the_modulus_of_its_springs() {
        let (d, k) = (0.01, 20.0);
        let mesh = load("box:9x9x9x0.01", &MeshOptions::default()).unwrap();
        let links = mesh.links.iter().map(|ends| (ends.map(|node| node as usize), k));
        let tetrahedra = mesh.tetrahedra.iter().map(|nodes| {
            let nodes = nodes.map(|node| node as usize);
            (nodes, nodes.map(|node| mesh.nodes_m[node]))
        });
        let of = Equivalent::new(&mesh.nodes_m, links, tetrahedra).unwrap();
        let wanted_pa = k * d * d * (3.0 + 3.0 * 2.0) / (6.0 * d * d * d);
        let middle = of.cells_pa[(4 * 9 + 4) * 9 + 4];
        assert!((middle / wanted_pa - 1.0).abs() < 1e-9, "{middle} {wanted_pa}");
        // The surface has whole links and half the volume.
        assert!(of.body_pa > middle && of.body_pa < 1.5 * middle, "{}", of.body_pa);
        assert_eq!(Equivalent::new(&mesh.nodes_m, [].into_iter(), [].into_iter()), None);
    }
}
