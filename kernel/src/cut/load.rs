//! The load of a cell that may tear: its shape, and the energy that it stores for each volume.
//!
//! Nodal shapes have both at hand. A body of links has its tetrahedra: the shape at a cell is their mean by volume, as
//! that of nodal shapes is. The energy is that of its half-links, beyond their bands, which are stiffer at the surface
//! than the tissue to which the body is equivalent; so their volume is the one that their stiffness has in it:
//!
//! ```text
//! F_i   = sum of V_t F_t / sum of V_t          over the tetrahedra at cell i
//! psi_i = 3 E_i sum of w d^2 / sum of w l^2    over its half-links
//! E_i   = sum of s_j / sum of s_j / E_j        over the cell and its neighbours, s_j = sum of w l^2
//! ```
//!
//! with Young's modulus `E_j` of a cell as [`links`](super::links) has it. Closed bands count as open ones.
//!
//! Cost: at a cell of links some 30 operations for each half-link, and 100 for each tetrahedron where they are near the
//! strength or the limit is a stretch.

use super::body::CutBody;
use super::offset::of_shapes;
use super::place::edges;
use crate::energy::state::States;
use crate::model::image::nodal;
use crate::number::cell::{add, dot, scale};
use crate::number::turn::cross;

impl CutBody<'_, '_> {
    /// The shape F of a cell, of a body of shapes with its offset.
    pub(super) fn shape_of(&self, cell: usize, at: &impl Fn(usize) -> [f32; 3]) -> [[f32; 3]; 3] {
        if self.is_of_links() {
            self.shape_of_tetrahedra(cell, at)
        } else {
            self.shapes().shifted_at(cell, at)
        }
    }

    /// Energy of a cell's shape and bands for each volume, in the unit of the moduli; of a body of links over 3 `E_i`.
    pub(super) fn energy_density(
        &self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) -> f32 {
        if self.is_of_links() {
            return self.wd2_of_links(cell, None, at) / self.wl2_of_links(cell);
        }
        let volume = self.number(cell, nodal::VOLUME);
        self.shapes().energy_density(cell, at, of_shapes(states))
            + self.bands().energy_density(cell, volume, at)
    }

    /// 3 `E_i` of a cell of links of the image.
    pub(super) fn thrice_young_around(&self, cell: usize) -> f32 {
        let around = self.model.neighbours(cell).map(|(_, other)| other);
        let (mut sum, mut volume) = (0.0, 0.0);
        for cell in core::iter::once(cell).chain(around) {
            let stiffness = self.wl2_of_image(cell);
            sum += stiffness;
            volume += stiffness / self.young_of_links(cell);
        }
        3.0 * sum / volume
    }

    /// Mean shape of the tetrahedra that a cell still has: at least one, of a volume above 0.
    fn shape_of_tetrahedra(&self, cell: usize, at: &impl Fn(usize) -> [f32; 3]) -> [[f32; 3]; 3] {
        let (mut sum, mut volume) = ([[0.0; 3]; 3], 0.0);
        for index in 0..self.star(cell).len() {
            let Some(tetrahedron) = self.tetrahedron_at(cell, index) else { continue };
            let Some(rest) = self.corners_at_rest(tetrahedron) else { continue };
            let now = self.arrays.corners.get(tetrahedron).copied().unwrap_or_default();
            // 6 V F: each edge as it is now, times the area of the face between the two others.
            let ([a, b, c], now) = (edges(rest), edges(now.map(|cell| at(cell.into()))));
            let areas = [cross(b, c), cross(c, a), cross(a, b)];
            for (edge, area) in now.into_iter().zip(areas) {
                for (row, along) in sum.iter_mut().zip(edge) {
                    *row = add(*row, scale(along, area));
                }
            }
            volume += dot(a, cross(b, c));
        }
        sum.map(|row| scale(1.0 / volume, row))
    }
}
