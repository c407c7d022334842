//! The elasticity K of the rest shape: the second derivative of the energy there.
//!
//! A small displacement v changes a cell's shape by G, the sum of (`v_j` - `v_i`) `a_ij'` over `V_i`, and
//!
//! ```text
//! P_i = mu (G + G') + lambda tr G - 2 beta mu G
//! (K v)_i = P_i a_ii + sum_j P_j a_ji - sum_j s_ij (v_j - v_i)
//! ```

use super::state::ShapeState;
use crate::energy::state::StatesOf;
use crate::model::image::nodal;
use crate::model::nodal::Nodal;
use crate::number::cell::{dot, scale, sub};

impl Nodal<'_> {
    /// The state with the stress of a small displacement; it replaces the results of the last pass.
    pub(super) fn strained(
        self,
        cell: usize,
        state: ShapeState,
        field: &impl Fn(usize) -> [f32; 3],
    ) -> ShapeState {
        // G, up to the volume.
        let (here, mut slope) = (field(cell), [[0.0; 3]; 3]);
        for (other, slot) in self.slots_of(cell) {
            let (way, area) = (sub(field(other), here), slot.three(nodal::AREA));
            for (row, way) in slope.iter_mut().zip(way) {
                for (sum, area) in row.iter_mut().zip(area) {
                    *sum += way * area;
                }
            }
        }
        // The stress of G.
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = slope;
        let (mu, lambda) = (self.number(cell, nodal::MU), self.number(cell, nodal::LAMBDA_3) / 3.0);
        let (own, even) = (mu * (1.0 - 2.0 * nodal::BETA), lambda * (xx + yy + zz));
        let share = 1.0 / self.number(cell, nodal::VOLUME);
        let part = |here: f32, turned: f32| share * (own * here + mu * turned);
        let along = |here: f32| share * ((own + mu) * here + even);
        let stress = [
            [along(xx), part(xy, yx), part(xz, zx), 0.0],
            [part(yx, xy), along(yy), part(yz, zy), 0.0],
            [part(zx, xz), part(zy, yz), along(zz), 0.0],
        ];
        ShapeState { stress, ..state }
    }

    /// K times the displacement at a cell; the stresses are those of the states.
    pub(super) fn resistance(
        self,
        cell: usize,
        field: &impl Fn(usize) -> [f32; 3],
        states: StatesOf<'_>,
    ) -> [f32; 3] {
        let push = |of: usize, area: [f32; 3]| {
            states.shape(of).stress.map(|[x, y, z, _]| dot([x, y, z], area))
        };
        let here = field(cell);
        let mut sum = push(cell, [0, 1, 2].map(|axis| self.number(cell, nodal::OWN + axis)));
        for (other, slot) in self.slots_of(cell) {
            let pushed = push(other, slot.three(nodal::BACK_AREA));
            let spread = scale(slot.number(nodal::SPREAD), sub(field(other), here));
            for ((sum, pushed), spread) in sum.iter_mut().zip(pushed).zip(spread) {
                *sum += pushed - spread;
            }
        }
        sum
    }
}
