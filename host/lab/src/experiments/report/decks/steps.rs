//! Steps that an explicit method needs in a millisecond: calculated, not run.
//!
//! A step may be no longer than a pressure wave takes through the smallest element: h / c with c the root of
//! (lambda + 2 mu) / density (Courant, Friedrichs, Lewy). Here h is the least height of a tetrahedron.

use serde::Serialize;

use super::law::Moduli;
use crate::reference::nodal::volume_m3;
use crate::reference::vectors::{dot, minus};
use chaincell_host::mesh::Mesh;

/// An explicit method on a mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepRow {
    /// The body.
    pub body: String,
    /// Nodes.
    pub cells: usize,
    /// Least height of a tetrahedron \[m\].
    pub height_m: f64,
    /// Speed of a pressure wave \[m/s\].
    pub wave_m_per_s: f64,
    /// Longest step \[s\].
    pub step_s: f64,
    /// Steps in a millisecond.
    pub steps: f64,
    /// Time in which a shear wave crosses the body's longest side \[s\].
    pub crossed_s: f64,
}

impl StepRow {
    /// A mesh of a material of some density \[kg/m^3\].
    pub fn of(body: String, mesh: &Mesh, of: Moduli, density: f64) -> Self {
        let height_m = mesh
            .tetrahedra
            .iter()
            .map(|nodes| least_height_m(mesh, *nodes))
            .fold(f64::MAX, f64::min);
        let wave_m_per_s = ((of.lambda_pa() + 2.0 * of.mu_pa()) / density).sqrt();
        let side_m = (0..3).map(|axis| {
            let each = || mesh.nodes_m.iter().map(|x| x[axis]);
            each().fold(f64::MIN, f64::max) - each().fold(f64::MAX, f64::min)
        });
        let step_s = height_m / wave_m_per_s;
        Self {
            body,
            cells: mesh.nodes_m.len() - mesh.unused.len(),
            height_m,
            wave_m_per_s,
            step_s,
            steps: (1e-3 / step_s).ceil(),
            crossed_s: side_m.fold(0.0, f64::max) / (of.mu_pa() / density).sqrt(),
        }
    }
}

/// Least distance of a corner from the other three's plane \[m\].
fn least_height_m(mesh: &Mesh, nodes: [u32; 4]) -> f64 {
    let volume_m3 = volume_m3(&mesh.nodes_m, nodes);
    let area_m2 = |out: usize| {
        let [a, b, c] = [1, 2, 3].map(|by| mesh.nodes_m[nodes[(out + by) % 4] as usize]);
        let (p, q) = (minus(b, a), minus(c, a));
        0.5 * (dot(p, p) * dot(q, q) - dot(p, q).powi(2)).max(0.0).sqrt()
    };
    3.0 * volume_m3 / (0..4).map(area_m2).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::mesh::{MeshOptions, load};

    /// The middle tetrahedron of a cube of 10 mm is regular: its height is 10 mm times 2 / root 3; those at the
    /// corners have 10 mm over root 3.
    #[test]
    fn a_cube_has_the_step_of_its_corners() {
        let mesh = load("box:3x3x3x0.01", &MeshOptions::default()).unwrap();
        let of = Moduli { young_pa: 5000.0, poisson: 0.0 };
        let row = StepRow::of("cube".to_owned(), &mesh, of, 1000.0);
        assert!((row.height_m - 0.01 / 3.0_f64.sqrt()).abs() < 1e-12, "{row:?}");
        assert!((row.wave_m_per_s - 5.0_f64.sqrt()).abs() < 1e-12, "{row:?}");
        assert!((row.steps - 1.0).abs() < f64::EPSILON, "{row:?}");
        assert!((row.crossed_s - 0.02 / 2.5_f64.sqrt()).abs() < 1e-12, "{row:?}");
    }
}
