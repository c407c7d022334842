//! The signed distance from a closed surface, by the nearest point and its normal: on edges and corners it
//! is the sum of the triangles' normals, weighted by their angles (Baerentzen and Aanaes, 2005).

use super::closed::Closed;
use super::tree::{Part, area2};
use crate::mesh::geometry::{dot, minus, unit};
use crate::mesh::stuffing::{Shape, between};

/// Most evaluations for a crossing.
const STEPS: usize = 40;
/// Accuracy of a crossing, as a share of the edge.
const CLOSE: f64 = 1e-9;

/// A closed surface with its normals.
pub(super) struct Solid<'a> {
    closed: &'a Closed,
    /// Unit normal of each triangle.
    faces: Vec<[f64; 3]>,
    /// Direction of the normal at each point, of any length.
    points: Vec<[f64; 3]>,
}

impl<'a> Solid<'a> {
    /// Computes the normals of a surface.
    pub(super) fn new(closed: &'a Closed) -> Self {
        let corners = |triangle: &[u32; 3]| triangle.map(|id| closed.points_m[id as usize]);
        let faces: Vec<[f64; 3]> =
            closed.triangles.iter().map(|triangle| unit(area2(corners(triangle)))).collect();
        let mut points = vec![[0.0; 3]; closed.points_m.len()];
        for (triangle, normal) in closed.triangles.iter().zip(&faces) {
            let places = corners(triangle);
            for k in 0..3 {
                let ways = [1, 2].map(|step| unit(minus(places[(k + step) % 3], places[k])));
                let angle = libm::acos(dot(ways[0], ways[1]).clamp(-1.0, 1.0));
                for axis in 0..3 {
                    points[triangle[k] as usize][axis] += angle * normal[axis];
                }
            }
        }
        Self { closed, faces, points }
    }

    /// Unit normal of a triangle.
    pub(super) fn normal(&self, triangle: u32) -> [f64; 3] {
        self.faces[triangle as usize]
    }

    /// Unit normal of the triangle that is nearest to a point.
    pub(super) fn normal_at(&self, place_m: [f64; 3]) -> [f64; 3] {
        self.normal(self.closed.tree.nearest(place_m).triangle)
    }

    /// Distance of a point from the surface: positive inside.
    pub(super) fn distance_m(&self, place_m: [f64; 3]) -> f64 {
        let near = self.closed.tree.nearest(place_m);
        let triangle = near.triangle as usize;
        let own = self.faces[triangle];
        let normal = match near.part {
            Part::Face => own,
            Part::Edge(k) => {
                let other = self.faces[self.closed.across[triangle][k] as usize];
                [0, 1, 2].map(|axis| own[axis] + other[axis])
            }
            Part::Corner(k) => self.points[self.closed.triangles[triangle][k] as usize],
        };
        let is_outside = dot(minus(place_m, near.place), normal) > 0.0;
        near.square.sqrt() * if is_outside { -1.0 } else { 1.0 }
    }
}

impl Shape for Solid<'_> {
    fn bounds_m(&self) -> [[f64; 3]; 2] {
        self.closed.tree.bounds()
    }

    fn value(&self, place_m: [f64; 3]) -> f64 {
        self.distance_m(place_m)
    }

    fn same_side_m(&self, value: f64) -> f64 {
        value.abs()
    }

    /// Uses the Illinois variant of the false position method.
    fn crossing(&self, inside: [f64; 3], outside: [f64; 3]) -> [f64; 3] {
        let way = minus(outside, inside);
        let close = CLOSE * dot(way, way).sqrt();
        let (mut low, mut high) = (0.0, 1.0);
        let (mut above, mut below) = (self.distance_m(inside), self.distance_m(outside));
        let mut last = 0.0;
        for _ in 0..STEPS {
            let t = (low * below - high * above) / (below - above);
            let t = if t > low && t < high { t } else { (low + high) / 2.0 };
            let place_m = between(inside, outside, t);
            let value = self.distance_m(place_m);
            if value.abs() <= close {
                return place_m;
            }
            if value > 0.0 {
                (low, above) = (t, value);
                below *= if last > 0.0 { 0.5 } else { 1.0 };
            } else {
                (high, below) = (t, value);
                above *= if last < 0.0 { 0.5 } else { 1.0 };
            }
            last = value;
        }
        between(inside, outside, (low + high) / 2.0)
    }

    fn project(&self, place_m: [f64; 3]) -> [f64; 3] {
        self.closed.tree.nearest(place_m).place
    }
}
