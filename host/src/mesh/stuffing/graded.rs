//! Fills a shape with tetrahedra of graded sizes: isosurface stuffing on the cubes of an octree, after Labelle
//! and Shewchuk (2007).
//!
//! Between equal cubes the lattice is the body-centred one, with edges halved where smaller cubes meet them;
//! between a cube and four smaller ones it has half pyramids, all along the diagonals to the middle of the face.

use std::collections::BTreeMap;

use super::octree::{Octree, Place};
use super::{Corner, NEAR_LONG, NEAR_SHORT, OFFSET, SURE, Shape, TetMesh, TooMany, cut, number};
use crate::mesh::geometry::{EDGES, distance};

/// Longest edge of the body-centred lattice over the shortest.
const LONG: f64 = 1.154_700_538_379_251_5;
/// A cube that is farther outside than this many edges needs no division.
const OUTSIDE: f64 = 2.0;

/// Sizes of the cubes.
pub(in crate::mesh) struct Grading<'a> {
    /// Edge of the coarsest cubes \[m\].
    pub(in crate::mesh) cube_m: f64,
    /// The number of times that they can be halved.
    pub(in crate::mesh) levels: u32,
    /// Largest cube with its centre at a place \[m\]; it changes by at most half of a distance.
    pub(in crate::mesh) largest_m: &'a dyn Fn([f64; 3]) -> f64,
    /// Most cubes beyond the coarsest ones.
    pub(in crate::mesh) cubes_max: usize,
}

/// Points and tetrahedra of the lattice.
struct Lattice<'a, S> {
    shape: &'a S,
    places_m: Vec<[f64; 3]>,
    /// As in the even lattice: positive inside, 0 for points on the surface.
    values: Vec<f64>,
    tetrahedra: Vec<[u32; 4]>,
}

/// Fills the shape.
///
/// # Errors
/// More cubes than allowed.
pub(in crate::mesh) fn fill(shape: &impl Shape, grading: &Grading<'_>) -> Result<TetMesh, TooMany> {
    let mut lattice = Lattice::new(shape, grading)?;
    lattice.warp();
    let (mut pieces, mut crossings) = (Vec::new(), BTreeMap::new());
    for indices in &lattice.tetrahedra {
        let corners = indices.map(|index| Corner {
            index,
            place_m: lattice.places_m[index as usize],
            value: lattice.values[index as usize],
        });
        let mut crossing = |inside: &Corner, outside: &Corner| {
            *crossings
                .entry([inside.index, outside.index])
                .or_insert_with(|| shape.crossing(inside.place_m, outside.place_m))
        };
        cut(corners, &mut crossing, &mut pieces);
    }
    Ok(number(shape, &lattice.places_m, &pieces, &crossings))
}

impl<'a, S: Shape> Lattice<'a, S> {
    fn new(shape: &'a S, grading: &Grading<'_>) -> Result<Self, TooMany> {
        let Grading { cube_m, levels, .. } = *grading;
        let [low_m, high_m] = shape.bounds_m();
        // The cubes also cover the offset and a layer outside.
        let counts = [0, 1, 2].map(|axis| ((high_m[axis] - low_m[axis]) / cube_m) as i32 + 5);
        let unit_m = cube_m / f64::from(2 << levels);
        let place_m = |at: Place| {
            [0, 1, 2].map(|axis| {
                low_m[axis] - (1.0 + OFFSET[axis]) * cube_m + f64::from(at[axis]) * unit_m
            })
        };
        let mut tree = Octree::new(counts, levels, grading.cubes_max);
        tree.refine(|low, edge| {
            let (middle_m, edge_m) = (place_m(centre(low, edge)), f64::from(edge) * unit_m);
            // Rounding must not divide a cube of the very size.
            if edge_m * SURE <= (grading.largest_m)(middle_m) {
                return false;
            }
            let value = shape.value(middle_m);
            value > 0.0 || shape.same_side_m(value) < OUTSIDE * edge_m
        })?;
        let points = points(&tree);
        let tetrahedra = tetrahedra(&tree, &points);
        let places_m: Vec<[f64; 3]> = points.iter().map(|at| place_m(*at)).collect();
        let values = values(shape, &tree, &points, &places_m);
        Ok(Self { shape, places_m, values, tetrahedra })
    }

    /// Moves points that are too near a crossing of one of their edges to the nearest crossing.
    fn warp(&mut self) {
        // The shortest edge at each point, and the edges with ends on two sides.
        let mut shortest_m = vec![f64::INFINITY; self.places_m.len()];
        let mut across = Vec::new();
        for tetrahedron in &self.tetrahedra {
            for [i, j] in EDGES.map(|ends| ends.map(|end| tetrahedron[end])) {
                let length_m = distance(self.places_m[i as usize], self.places_m[j as usize]);
                for end in [i, j] {
                    let shortest = &mut shortest_m[end as usize];
                    *shortest = shortest.min(length_m);
                }
                if self.values[i as usize] * self.values[j as usize] < 0.0 {
                    across.extend([[i, j], [j, i]]);
                }
            }
        }
        across.sort_unstable();
        across.dedup();
        for edges in across.chunk_by(|one, other| one[0] == other[0]) {
            let index = edges[0][0] as usize;
            if let Some(crossing) = self.nearest(edges, shortest_m[index]) {
                self.places_m[index] = crossing;
                self.values[index] = 0.0;
            }
        }
    }

    /// Returns the nearest crossing of a point's edges if it is too near.
    fn nearest(&self, edges: &[[u32; 2]], shortest_m: f64) -> Option<[f64; 3]> {
        let mut nearest: Option<(f64, [f64; 3])> = None;
        for [index, other] in edges.iter().map(|ends| ends.map(|end| end as usize)) {
            if self.values[index] * self.values[other] >= 0.0 {
                continue;
            }
            let (own, far) = (self.places_m[index], self.places_m[other]);
            let is_inside = self.values[index] > 0.0;
            let crossing = match is_inside {
                true => self.shape.crossing(own, far),
                false => self.shape.crossing(far, own),
            };
            let (away_m, length_m) = (distance(own, crossing), distance(own, far));
            let is_short = length_m <= 0.5 * (1.0 + LONG) * shortest_m;
            let near_m = match is_short {
                true => NEAR_SHORT * length_m.min(shortest_m),
                false => NEAR_LONG * length_m.min(LONG * shortest_m),
            };
            if away_m < near_m && nearest.is_none_or(|(best, _)| away_m < best) {
                nearest = Some((away_m, crossing));
            }
        }
        nearest.map(|(_, crossing)| crossing)
    }
}

/// Corners and centres of all cubes, sorted.
fn points(tree: &Octree) -> Vec<Place> {
    let mut points: Vec<Place> = tree
        .leaves()
        .flat_map(|(low, edge)| corners(low, edge).chain([centre(low, edge)]))
        .collect();
    points.sort_unstable();
    points.dedup();
    points
}

fn corners(low: Place, edge: i32) -> impl Iterator<Item = Place> {
    (0..8).map(move |at| [0, 1, 2].map(|axis| low[axis] + edge * (at >> axis & 1)))
}

fn centre(low: Place, edge: i32) -> Place {
    low.map(|x| x + edge / 2)
}

/// The tetrahedra around each face between two cubes.
fn tetrahedra(tree: &Octree, points: &[Place]) -> Vec<[u32; 4]> {
    let mut all = Vec::new();
    for (low, edge) in tree.leaves() {
        for (axis, is_upper) in (0..3).flat_map(|axis| [(axis, false), (axis, true)]) {
            let face = Face { low, edge, axis, is_upper };
            if tree.is_leaf(face.beside(edge), edge) {
                // Each pair of equal cubes is met twice.
                if is_upper {
                    face.between_equal(points, &mut all);
                }
            } else if edge > 2 && tree.is_leaf(face.beside(edge / 2), edge / 2) {
                face.to_smaller(points, &mut all);
            }
        }
    }
    all
}

/// A face of a cube.
struct Face {
    low: Place,
    edge: i32,
    axis: usize,
    is_upper: bool,
}

impl Face {
    /// Lower corner of the cube of an edge beyond the face, at its first corner.
    fn beside(&self, edge: i32) -> Place {
        let mut low = self.low;
        low[self.axis] += if self.is_upper { self.edge } else { -edge };
        low
    }

    /// The four sides of the face: ends and the middle between them.
    fn sides(&self) -> impl Iterator<Item = [Place; 3]> {
        let corner = |[u, v]: [i32; 2]| {
            let mut at = self.beside(0);
            at[(self.axis + 1) % 3] += u * self.edge;
            at[(self.axis + 2) % 3] += v * self.edge;
            at
        };
        let ring = [[0, 0], [1, 0], [1, 1], [0, 1]].map(corner);
        (0..4).map(move |at| {
            let (a, b) = (ring[at], ring[(at + 1) % 4]);
            [a, [0, 1, 2].map(|x| (a[x] + b[x]) / 2), b]
        })
    }

    /// Four tetrahedra around the line between the centres, each halved where its side is.
    fn between_equal(&self, points: &[Place], all: &mut Vec<[u32; 4]>) {
        let [own, next] =
            [self.low, self.beside(self.edge)].map(|low| id(points, centre(low, self.edge)));
        for [a, half, b] in self.sides() {
            let [first, last] = [a, b].map(|end| id(points, end));
            if points.binary_search(&half).is_ok() {
                let half = id(points, half);
                all.extend([[own, next, first, half], [own, next, half, last]]);
            } else {
                all.push([own, next, first, last]);
            }
        }
    }

    /// Half pyramids over the eight triangles of the face, from the centre and from those of the smaller cubes.
    fn to_smaller(&self, points: &[Place], all: &mut Vec<[u32; 4]>) {
        let small = self.edge / 2;
        let middle = centre(self.beside(0), self.edge);
        let middle = [0, 1, 2].map(|x| if x == self.axis { self.beside(0)[x] } else { middle[x] });
        let own = id(points, centre(self.low, self.edge));
        for [a, half, b] in self.sides() {
            for end in [a, b] {
                // The smaller cube at that corner of the face.
                let mut low = self.beside(small);
                for x in (0..3).filter(|x| *x != self.axis && end[*x] > self.low[*x]) {
                    low[x] += small;
                }
                let triangle = [middle, half, end].map(|at| id(points, at));
                for apex in [own, id(points, centre(low, small))] {
                    all.push([apex, triangle[0], triangle[1], triangle[2]]);
                }
            }
        }
    }
}

/// The number of a point.
fn id(points: &[Place], at: Place) -> u32 {
    points.partition_point(|known| *known < at) as u32
}

/// The value of each point, or of a near one on the same side.
fn values(shape: &impl Shape, tree: &Octree, points: &[Place], places_m: &[[f64; 3]]) -> Vec<f64> {
    let mut values = vec![f64::NAN; points.len()];
    for (low, edge) in tree.leaves() {
        let own = id(points, centre(low, edge)) as usize;
        let value = shape.value(places_m[own]);
        values[own] = value;
        let sure_m = SURE * shape.same_side_m(value);
        for corner in corners(low, edge).map(|at| id(points, at) as usize) {
            if values[corner].is_nan() && sure_m > distance(places_m[own], places_m[corner]) {
                values[corner] = value;
            }
        }
    }
    for (value, place_m) in values.iter_mut().zip(places_m) {
        if value.is_nan() {
            *value = shape.value(*place_m);
        }
    }
    values
}
