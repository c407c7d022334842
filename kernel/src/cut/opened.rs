//! The list of opened faces, as triangles behind those of the surface.
//!
//! A face is listed with both sides, once a corner of it has a cell on one side that it has not on the other: before,
//! the sides cannot part. As cells only change in splits, the list is made anew after the splits of a tick, from the
//! opened faces and the cells of the tetrahedra, by ascending tetrahedron and corner. So it follows from the state.
//! Faces for which no places are left are counted: they are open, and tools do not touch them.
//!
//! Cost: a look at each tetrahedron, and at the tetrahedra of a cell for each side of an opened face.

use super::body::CutBody;
use crate::model::cuttable::of_face;
use crate::model::image::{contact, nodal};
use crate::model::opened::ALONE;
use crate::number::cell::{dot, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::cross;

/// Least contact number, as in the bake.
const LEAST: f32 = 1.0e-9;

/// Young's modulus of Lamé's parameters, the first one three times.
fn young(mu: f32, lambda_3: f32) -> f32 {
    let lambda = lambda_3 / 3.0;
    mu * ((lambda_3 + 2.0 * mu) / (lambda + mu))
}

impl CutBody<'_, '_> {
    /// Makes the list anew.
    pub(crate) fn list_opened(&mut self) {
        let (mut count, mut promised, mut lacking) = (0, 0, 0);
        for tetrahedron in 0..self.arrays.faces.len() {
            for corner in self.open_corners(tetrahedron) {
                let Some(other) = self.across(tetrahedron, corner) else { continue };
                if self.drops(tetrahedron) {
                    continue;
                }
                let (here, there) = (self.side(tetrahedron, corner), self.side(other.0, other.1));
                if here.iter().all(|cell| there.contains(cell)) {
                    continue;
                }
                // A side whose other one is gone is alone.
                if self.drops(other.0) {
                    let name = self.name(tetrahedron, corner);
                    if count + promised < self.arrays.names.len() {
                        self.put_opened(count, [name, ALONE], here);
                        count += 1;
                    } else {
                        lacking += 1;
                    }
                    continue;
                }
                // The first side takes a place for both; the second one finds it.
                let (name, other) = (self.name(tetrahedron, corner), self.name(other.0, other.1));
                let first = self.place_of(other, count);
                match first {
                    None if other < name => continue,
                    None if count + promised + 2 > self.arrays.names.len() => {
                        lacking += 1;
                        continue;
                    }
                    None => promised += 1,
                    Some(first) => {
                        promised -= 1;
                        self.pair(first, count);
                    }
                }
                let other = first.unwrap_or(count) as u32;
                self.put_opened(count, [name, other], here);
                count += 1;
            }
        }
        *self.arrays.listed = [count as u32, lacking];
    }

    /// Cells of a face of a tetrahedron as they are now, outward.
    pub(super) fn side(&self, tetrahedron: usize, corner: usize) -> [u16; 3] {
        let corners = self.arrays.corners.get(tetrahedron).copied().unwrap_or_default();
        of_face(corners, corner)
    }

    /// Name of the triangle of a face, see [`Opened`](crate::model::opened::Opened).
    fn name(&self, tetrahedron: usize, corner: usize) -> u32 {
        (self.model.triangles.len() + 4 * tetrahedron + corner) as u32
    }

    /// Place of a name among the first `count`.
    fn place_of(&self, name: u32, count: usize) -> Option<usize> {
        let names = self.arrays.names.get(..count)?;
        names.binary_search_by_key(&name, |[name, _]| *name).ok()
    }

    /// Notes the other side of the triangle in a place.
    fn pair(&mut self, place: usize, side: usize) {
        if let Some([_, other]) = self.arrays.names.get_mut(place) {
            *other = side as u32;
        }
    }

    /// Lists a triangle: its name with the place of its other side, and its cells.
    fn put_opened(&mut self, place: usize, names: [u32; 2], cells: [u16; 3]) {
        let numbers = self.contact_numbers(cells);
        let behind = self.model.triangles.len() + place;
        if let (Some(slot), Some(own), Some(triangle)) = (
            self.arrays.names.get_mut(place),
            self.arrays.numbers.get_mut(place),
            self.arrays.triangles.get_mut(behind),
        ) {
            (*slot, *own, *triangle) = (names, numbers, cells);
        }
    }

    /// Contact numbers of a triangle, as the bake computes them.
    pub(super) fn contact_numbers(&self, cells: [u16; 3]) -> [f32; 3] {
        let [a, b, c] = cells.map(|cell| self.rest_position(self.origin(cell.into()) as u16));
        let length = |way: [f32; 3]| sqrt(dot(way, way));
        let edges = length(sub(b, a)) + length(sub(c, b)) + length(sub(a, c));
        let (edge, area) = (edges / 3.0, 0.5 * length(cross(sub(b, a), sub(c, a))));
        let of = |cell: u16, row| self.number(cell.into(), row);
        let [p, q, r] = cells.map(|cell| {
            if self.is_of_links() {
                self.young_of_links(cell.into())
            } else {
                young(of(cell, nodal::MU), of(cell, nodal::LAMBDA_3))
            }
        });
        let at_least = |x: f32| if x > LEAST { x } else { LEAST };
        let stiffness = (p + q + r) / 3.0 * (area / at_least(edge));
        let mut numbers = [0.0; 3];
        for (row, number) in
            [(contact::STIFFNESS, stiffness), (contact::EDGE, edge), (contact::AREA, area)]
        {
            if let Some(slot) = numbers.get_mut(row) {
                *slot = at_least(number);
            }
        }
        numbers
    }
}
