//! The elasticity K of the rest shape: the second derivative of the energy there.
//!
//! A small displacement v changes a cell's shape by G, the sum of (`v_j` - `v_i`) `a_ij'` over `V_i`, and
//!
//! ```text
//! P_i = mu (G + G') + lambda tr G - 2 beta mu G
//! (K v)_i = P_i a_ii + sum_j P_j a_ji - sum_j s_ij (v_j - v_i)
//! ```

use crate::model::image::nodal;
use crate::model::nodal::Nodal;
use crate::number::cell::{Cell, add, dot, scale, sub};

impl Nodal<'_> {
    /// The stress of a cell for a small displacement of the cells.
    fn strained(self, cell: usize, field: &impl Fn(usize) -> [f32; 3]) -> [[f32; 3]; 3] {
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
        [
            [along(xx), part(xy, yx), part(xz, zx)],
            [part(yx, xy), along(yy), part(yz, zy)],
            [part(zx, xz), part(zy, yz), along(zz)],
        ]
    }

    /// Adds K times the displacement `field`, cell by cell: what a cell's stress and the spread of its links
    /// exert on itself and on its neighbours.
    pub(super) fn add_resistance(self, field: &[Cell], product: &mut [Cell]) {
        let at = |cell: usize| field.get(cell).map_or([0.0; 3], |field| field.xyz());
        for cell in 0..self.count {
            let stress = self.strained(cell, &at);
            let mut add_to = |of: usize, push: [f32; 3]| {
                if let Some(sum) = product.get_mut(of) {
                    *sum = Cell::at(add(sum.xyz(), push));
                }
            };
            add_to(cell, stress.map(|row| dot(row, self.own_area(cell))));
            for (other, slot) in self.slots_of(cell) {
                add_to(other, stress.map(|row| dot(row, slot.three(nodal::AREA))));
                add_to(cell, scale(slot.number(nodal::SPREAD), sub(at(cell), at(other))));
            }
        }
    }

    /// The part of K times a displacement along one axis, of these lengths, that a cell's stress and the spread of its
    /// links exert: on itself and on its neighbours, as `add_to(cell, push)`.
    #[cfg(feature = "cut")]
    pub(crate) fn resist_along(
        self,
        cell: usize,
        axis: usize,
        length: &impl Fn(usize) -> f32,
        add_to: &mut impl FnMut(usize, [f32; 3]),
    ) {
        // The gradient of the length, up to the volume, and the spread.
        let (here, mut slope, mut spread) = (length(cell), [0.0; 3], 0.0);
        for (other, slot) in self.slots_of(cell) {
            let way = length(other) - here;
            slope = add(slope, scale(way, slot.three(nodal::AREA)));
            spread -= slot.number(nodal::SPREAD) * way;
        }
        // The stress times an area.
        let (mu, lambda) = (self.number(cell, nodal::MU), self.number(cell, nodal::LAMBDA_3) / 3.0);
        let share = 1.0 / self.number(cell, nodal::VOLUME);
        let [own, mu, lambda] = [mu * (1.0 - 2.0 * nodal::BETA), mu, lambda].map(|x| share * x);
        let of = |v: [f32; 3]| v.get(axis).copied().unwrap_or(0.0);
        let even = lambda * of(slope);
        let push = |area: [f32; 3], along: f32| {
            let mut push = add(scale(mu * of(area), slope), scale(even, area));
            if let Some(x) = push.get_mut(axis) {
                *x += own * dot(slope, area) + along;
            }
            push
        };
        add_to(cell, push(self.own_area(cell), spread));
        for (other, slot) in self.slots_of(cell).filter(|&(other, _)| other != cell) {
            add_to(other, push(slot.three(nodal::AREA), 0.0));
        }
    }
}
