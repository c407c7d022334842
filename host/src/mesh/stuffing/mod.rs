//! Fills the shape with tetrahedra: isosurface stuffing after Labelle and Shewchuk (2007).
//!
//! A body-centred cubic lattice covers the shape. Lattice points very near the surface are moved
//! onto it, tetrahedra that still cross it are cut, and the parts inside are kept.

mod cut;
pub(super) mod graded;
mod octree;
pub(super) mod smooth;
pub(super) mod web;

use std::collections::BTreeMap;

use super::geometry::{corners, distance, volume6};
use cut::{Corner, cut};
pub(super) use octree::TooMany;

/// Share of an edge along an axis within which a crossing moves the point onto the surface.
const NEAR_LONG: f64 = 0.24999;
/// The same for an edge between a corner and a centre of a cube.
const NEAR_SHORT: f64 = 0.41189;

/// Offset of the lattice in cubes, uneven so that no layer coincides with a plane of the shape.
const OFFSET: [f64; 3] = [0.137, 0.291, 0.413];

/// Share of a distance that is certain despite rounding.
const SURE: f64 = 0.999;

/// A body that can be filled.
pub(super) trait Shape {
    /// Returns opposite corners of a box around it, in metres.
    fn bounds_m(&self) -> [[f64; 3]; 2];
    /// Returns a value that is positive inside, negative outside.
    fn value(&self, place_m: [f64; 3]) -> f64;
    /// Returns the radius around a point of this value in which all points lie on the same side of the
    /// surface.
    fn same_side_m(&self, _value: f64) -> f64 {
        0.0
    }
    /// Returns the point at which the line from a point inside to a point outside leaves it.
    fn crossing(&self, inside: [f64; 3], outside: [f64; 3]) -> [f64; 3];
    /// Returns a point of its surface near `place_m`, which must be near the surface.
    fn project(&self, place_m: [f64; 3]) -> [f64; 3];
}

/// Nodes `[node][axis]` in metres and tetrahedra of positive volume.
pub(super) struct TetMesh {
    pub(super) nodes_m: Vec<[f64; 3]>,
    pub(super) tetrahedra: Vec<[u32; 4]>,
}

/// Lattice points at even coordinates (corners of cubes) and odd ones (their centres).
struct Lattice<'a, S> {
    shape: &'a S,
    counts: [usize; 3],
    places_m: Vec<[f64; 3]>,
    /// [`Shape::value`] of the point or of a near one on the same side; 0 for points on the surface.
    values: Vec<f64>,
}

/// Points at which cut edges leave the shape, by the indices of their ends inside and outside.
type Crossings = BTreeMap<[u32; 2], [f64; 3]>;

/// Returns the approximate number of points of the lattice of [`fill`] around a box.
pub(super) fn points([low_m, high_m]: [[f64; 3]; 2], spacing_m: f64) -> f64 {
    (0..3).map(|axis| 2.0 * ((high_m[axis] - low_m[axis]) / spacing_m + 5.0) + 1.0).product()
}

/// Fills the shape with a lattice of cubes of `spacing_m`, moved down by `shift` cubes (0 to 2).
pub(super) fn fill(shape: &impl Shape, spacing_m: f64, shift: f64) -> TetMesh {
    let mut lattice = Lattice::new(shape, spacing_m, shift);
    lattice.warp();
    let (mut pieces, mut crossings) = (Vec::new(), Crossings::new());
    lattice.each_tetrahedron(|indices| {
        let corners = indices.map(|index| Corner {
            index: index as u32,
            place_m: lattice.places_m[index],
            value: lattice.values[index],
        });
        let mut crossing = |inside: &Corner, outside: &Corner| {
            *crossings
                .entry([inside.index, outside.index])
                .or_insert_with(|| shape.crossing(inside.place_m, outside.place_m))
        };
        cut(corners, &mut crossing, &mut pieces);
    });
    number(shape, &lattice.places_m, &pieces, &crossings)
}

impl<'a, S: Shape> Lattice<'a, S> {
    fn new(shape: &'a S, spacing_m: f64, shift: f64) -> Self {
        let offset = [OFFSET[0], OFFSET[1], OFFSET[2] + shift];
        let [low_m, high_m] = shape.bounds_m();
        let extents_m = [0, 1, 2].map(|axis| high_m[axis] - low_m[axis]);
        // The lattice also covers the offset, the shift and a layer outside.
        let counts = extents_m.map(|extent_m| 2 * ((extent_m / spacing_m) as usize + 5) + 1);
        let total = counts[0] * counts[1] * counts[2];
        let (places_m, values) = (Vec::with_capacity(total), Vec::with_capacity(total));
        let mut lattice = Self { shape, counts, places_m, values };
        for index in 0..total {
            let mut place_m = [0.0; 3];
            let at = lattice.at(index);
            for (axis, at) in at.into_iter().enumerate() {
                let cubes = at as f64 / 2.0 - 1.0 - offset[axis];
                place_m[axis] = low_m[axis] + cubes * spacing_m;
            }
            lattice.places_m.push(place_m);
            lattice.values.push(if is_point(at) { f64::NAN } else { 0.0 });
        }
        for index in 0..total {
            if lattice.values[index].is_nan() {
                lattice.evaluate(index, spacing_m);
            }
        }
        lattice
    }

    /// Evaluates the shape at a point, and sets the points around on the same side to the same value.
    fn evaluate(&mut self, index: usize, spacing_m: f64) {
        let value = self.shape.value(self.places_m[index]);
        self.values[index] = value;
        // The points one step away along all axes are half of a cube's diagonal away.
        let steps = SURE * self.shape.same_side_m(value) / (0.5 * spacing_m * 3f64.sqrt());
        let at = self.at(index);
        let range = |axis: usize| {
            let last = at[axis].saturating_add(steps as usize).min(self.counts[axis] - 1);
            at[axis].saturating_sub(steps as usize)..=last
        };
        let [ny, nz] = [self.counts[1], self.counts[2]];
        for (i, j) in range(0).flat_map(|i| range(1).map(move |j| (i, j))) {
            for index in range(2).map(|k| (i * ny + j) * nz + k) {
                if self.values[index].is_nan() {
                    self.values[index] = value;
                }
            }
        }
    }

    fn at(&self, index: usize) -> [usize; 3] {
        let [_, ny, nz] = self.counts;
        [index / (ny * nz), index / nz % ny, index % nz]
    }

    /// Returns the index of the point at an offset; none outside the lattice.
    fn index(&self, at: [usize; 3], offset: [isize; 3]) -> Option<usize> {
        let mut index = 0;
        for axis in 0..3 {
            let moved = at[axis].checked_add_signed(offset[axis])?;
            if moved >= self.counts[axis] {
                return None;
            }
            index = index * self.counts[axis] + moved;
        }
        Some(index)
    }

    /// Moves points that are too near a crossing of one of their edges to the nearest crossing.
    fn warp(&mut self) {
        for index in 0..self.values.len() {
            let at = self.at(index);
            if !is_point(at) {
                continue;
            }
            let own = self.places_m[index];
            let mut nearest: Option<(f64, [f64; 3])> = None;
            for (offset, near) in neighbours() {
                let Some(other) = self.index(at, offset) else { continue };
                if self.values[index] * self.values[other] >= 0.0 {
                    continue;
                }
                let far = self.places_m[other];
                let crossing = if self.values[index] > 0.0 {
                    self.shape.crossing(own, far)
                } else {
                    self.shape.crossing(far, own)
                };
                let away = distance(own, crossing);
                if away < near * distance(own, far) && nearest.is_none_or(|(best, _)| away < best) {
                    nearest = Some((away, crossing));
                }
            }
            if let Some((_, crossing)) = nearest {
                self.places_m[index] = crossing;
                self.values[index] = 0.0;
            }
        }
    }

    /// Calls `take` with the four tetrahedra around each line from a cube's centre to the next.
    fn each_tetrahedron(&self, mut take: impl FnMut([usize; 4])) {
        const RING: [[isize; 2]; 5] = [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]];
        for index in 0..self.values.len() {
            let at = self.at(index);
            if at.iter().any(|coordinate| coordinate % 2 == 0) {
                continue;
            }
            for axis in 0..3 {
                let mut along = [0; 3];
                along[axis] = 2;
                let Some(next) = self.index(at, along) else { continue };
                let corner = |[u, v]: [isize; 2]| {
                    let mut offset = [1; 3];
                    offset[(axis + 1) % 3] = u;
                    offset[(axis + 2) % 3] = v;
                    self.index(at, offset)
                };
                for pair in RING.windows(2) {
                    if let (Some(a), Some(b)) = (corner(pair[0]), corner(pair[1])) {
                        take([index, next, a, b]);
                    }
                }
            }
        }
    }
}

/// Numbers the nodes in lattice order and orients every tetrahedron to positive volume.
fn number(
    shape: &impl Shape,
    places_m: &[[f64; 3]],
    pieces: &[[[u32; 2]; 4]],
    crossings: &Crossings,
) -> TetMesh {
    let mut keys: Vec<[u32; 2]> = pieces.iter().flatten().copied().collect();
    keys.sort_unstable();
    keys.dedup();
    let place = |key: &[u32; 2]| match crossings.get(key) {
        Some(crossing) => *crossing,
        None if key[0] == key[1] => places_m[key[0] as usize],
        None => shape.crossing(places_m[key[0] as usize], places_m[key[1] as usize]),
    };
    let nodes_m: Vec<[f64; 3]> = keys.iter().map(place).collect();
    let id = |key: [u32; 2]| keys.partition_point(|known| *known < key) as u32;
    let turned = |mut ids: [u32; 4]| {
        if volume6(corners(&nodes_m, ids)) < 0.0 {
            ids.swap(2, 3);
        }
        ids
    };
    let tetrahedra = pieces.iter().map(|piece| turned(piece.map(id))).collect();
    TetMesh { nodes_m, tetrahedra }
}

/// Returns true if the lattice has a point at these coordinates: all even or all odd.
fn is_point(at: [usize; 3]) -> bool {
    at[0] % 2 == at[1] % 2 && at[1] % 2 == at[2] % 2
}

/// Interpolates between a (`t` = 0) and b (`t` = 1).
pub(super) fn between(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])]
}

/// Offsets of the 14 neighbours of a lattice point, with the share within which it moves.
fn neighbours() -> impl Iterator<Item = ([isize; 3], f64)> {
    const SIGNS: [isize; 2] = [-1, 1];
    let long = (0..3).flat_map(|axis| {
        SIGNS.map(|sign| {
            let mut offset = [0; 3];
            offset[axis] = 2 * sign;
            (offset, NEAR_LONG)
        })
    });
    let short = (0..8usize)
        .map(|bits| ([SIGNS[bits & 1], SIGNS[bits >> 1 & 1], SIGNS[bits >> 2 & 1]], NEAR_SHORT));
    long.chain(short)
}
