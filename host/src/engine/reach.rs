//! Distances of points from the surface that tools touch, at rest.

use std::f64::consts::TAU;

use chaincell_kernel::{Model, ToolPart};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::rest_m;

/// The triangles of the surface that tools touch.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    triangles_m: Vec<[Vector3<f64>; 3]>,
}

/// Largest number of steps in the search for a tool's first touch.
const LOOKS: usize = 400;
/// A tool this near to the surface touches it [sizes of its smallest part].
const CLOSE: f64 = 1e-4;
/// Largest number of looks at the nearest points of a core and a triangle.
const TURNS: usize = 64;
/// A nearest point that moves by less has been found [sizes of the part].
const ROUNDING: f64 = 1e-9;

impl Reach {
    /// The triangles of a model's surface.
    #[must_use]
    pub fn of(model: &Model<'_>) -> Self {
        let at = |cell: u16| Vector3::from(rest_m(model, cell.into()));
        let triangles_m = model.triangles().iter().map(|corners| corners.map(at)).collect();
        Self { triangles_m }
    }

    /// Distance of a point from the surface \[m\]; `None` if there is nothing to touch.
    ///
    /// Cost: one look at each triangle.
    #[must_use]
    pub fn distance_m(&self, point_m: [f64; 3]) -> Option<f64> {
        let point = Vector3::from(point_m);
        let squared =
            |corners: &[Vector3<f64>; 3]| (nearest(point, *corners) - point).norm_squared();
        self.triangles_m.iter().map(squared).min_by(f64::total_cmp).map(libm::sqrt)
    }

    /// The point of the surface nearest to a point \[m\]; `None` if there is nothing to touch.
    #[must_use]
    pub fn nearest_m(&self, point_m: [f64; 3]) -> Option<[f64; 3]> {
        let point = Vector3::from(point_m);
        let places = self.triangles_m.iter().map(|corners| nearest(point, *corners));
        let away = |place: &Vector3<f64>| (place - point).norm_squared();
        places.min_by(|a, b| away(a).total_cmp(&away(b))).map(Into::into)
    }

    /// Mean edge of the triangles nearest to a point, and of those within `radius_m` of the nearest one \[m\];
    /// `None` if there is nothing to touch.
    #[must_use]
    pub fn edge_near_m(&self, point_m: [f64; 3], radius_m: f64) -> Option<f64> {
        let point = Vector3::from(point_m);
        let within_m = self.distance_m(point_m)? + radius_m;
        let is_near =
            |corners: &&[Vector3<f64>; 3]| (nearest(point, **corners) - point).norm() <= within_m;
        let (mut sum_m, mut edges) = (0.0, 0.0);
        for [a, b, c] in self.triangles_m.iter().filter(is_near) {
            sum_m += (b - a).norm() + (c - b).norm() + (a - c).norm();
            edges += 3.0;
        }
        Some(sum_m / edges)
    }

    /// Returns true if a point is inside the closed surface of the triangles.
    #[must_use]
    pub fn is_around(&self, point_m: [f64; 3]) -> bool {
        let point = Vector3::from(point_m);
        let angle = |corners: &[Vector3<f64>; 3]| {
            let [a, b, c] = corners.map(|corner| corner - point);
            let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
            let above = a.dot(&b.cross(&c));
            let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            2.0 * libm::atan2(above, below)
        };
        // Inside, the triangles cover the whole solid angle; outside, none of it.
        self.triangles_m.iter().map(angle).sum::<f64>().abs() > TAU
    }

    /// Distance from a point, along the unit vector `outward`, at which a tool of these parts that comes from
    /// outside first touches \[m\]; `None` if it misses everything. The tool is not turned.
    #[must_use]
    pub fn first_touch_m(
        &self,
        point_m: [f64; 3],
        outward: [f64; 3],
        parts: &[ToolPart],
    ) -> Option<f64> {
        let (point, outward) = (Vector3::from(point_m), Vector3::from(outward));
        let parts: Vec<Solid> = parts.iter().map(Solid::of).collect();
        let arm_m = parts.iter().map(Solid::arm_m).reduce(f64::max)?;
        let close_m = CLOSE * parts.iter().map(Solid::size_m).reduce(f64::min)?;
        let along = |at: &Vector3<f64>| (at - point).dot(&outward);
        let beside = |at: &Vector3<f64>| (at - point - outward * along(at)).norm();
        // Triangles that are entirely to the side of the path are never touched.
        let is_met = |corners: &&[Vector3<f64>; 3]| {
            let [a, b, c] = **corners;
            let longest = (b - a).norm().max((c - a).norm());
            beside(&a) <= arm_m + longest
        };
        let met: Vec<_> = self.triangles_m.iter().filter(is_met).copied().collect();
        let ways = || met.iter().flatten().map(along);
        let (lowest, highest) = (ways().reduce(f64::min)?, ways().reduce(f64::max)?);
        // Move in by the free distance until the tool touches.
        let mut way_m = highest + arm_m;
        for _ in 0..LOOKS {
            let position = point + outward * way_m;
            let gap = |part: &Solid| part.gap_m(position, &met);
            let gap_m = parts.iter().map(gap).reduce(f64::min)?;
            if gap_m <= close_m {
                break;
            }
            way_m -= gap_m;
            if way_m < lowest - arm_m {
                return None;
            }
        }
        Some(way_m)
    }
}

/// A part of a tool: a box in the tool's frame, which may be a point or a segment, and a radius around it, 0 for
/// an edge. Scissors are the edge at their tip.
struct Solid {
    centre_m: Vector3<f64>,
    turn: UnitQuaternion<f64>,
    half_m: Vector3<f64>,
    radius_m: f64,
}

impl Solid {
    fn of(part: &ToolPart) -> Self {
        let [x, y, z, w] = part.orientation.map(f64::from);
        let turn = UnitQuaternion::new_normalize(Quaternion::new(w, x, y, z));
        let centre_m = Vector3::from(part.centre_m.map(f64::from));
        let half_m = part.half_m.map(f64::from);
        if let Some(blades) = part.blades() {
            let tip_m = Vector3::new(0.0, 0.0, -f64::from(blades.length_m));
            let half_m = Vector3::new(0.0, half_m[0], 0.0);
            return Self { centre_m: centre_m + turn * tip_m, turn, half_m, radius_m: 0.0 };
        }
        Self { centre_m, turn, half_m: Vector3::from(half_m), radius_m: part.radius_m.into() }
    }

    /// Distance of its farthest point from the tool's position, at most.
    fn arm_m(&self) -> f64 {
        self.centre_m.norm() + self.half_m.norm() + self.radius_m
    }

    /// Its radius; half the length of an edge, which has none.
    fn size_m(&self) -> f64 {
        if self.radius_m > 0.0 { self.radius_m } else { self.half_m.norm() }
    }

    /// Distance of the part from the triangles with the tool at a position, negative inside; never more than
    /// it is.
    fn gap_m(&self, position: Vector3<f64>, triangles: &[[Vector3<f64>; 3]]) -> f64 {
        let middle = position + self.centre_m;
        let mut least_m = f64::MAX;
        for corners in triangles {
            // Most triangles are too far from the ball around the core.
            let far_m = (nearest(middle, *corners) - middle).norm() - self.half_m.norm();
            if far_m < least_m {
                least_m = least_m.min(self.core_gap_m(middle, corners));
            }
        }
        least_m - self.radius_m
    }

    /// Distance of the core from a triangle: the nearest points of both, each found from the other in turn.
    fn core_gap_m(&self, middle: Vector3<f64>, corners: &[Vector3<f64>; 3]) -> f64 {
        let mut core = middle;
        for _ in 0..TURNS {
            let place = nearest(core, *corners);
            let local = self.turn.inverse_transform_vector(&(place - middle));
            let inside = local.zip_map(&self.half_m, |x, half| x.clamp(-half, half));
            let next = middle + self.turn * inside;
            let has_come = (next - core).norm() <= ROUNDING * self.size_m();
            core = next;
            if has_come {
                return (nearest(core, *corners) - core).norm();
            }
        }
        // The planes across the line between the two are apart by no more than core and triangle.
        let way = nearest(core, *corners) - core;
        let Some(normal) = way.try_normalize(0.0) else { return 0.0 };
        let support = self.turn.inverse_transform_vector(&normal).abs().dot(&self.half_m);
        let corner = corners.iter().map(|corner| (corner - middle).dot(&normal)).reduce(f64::min);
        (corner.unwrap_or(0.0) - support).max(0.0)
    }
}

/// Length of a body in a direction, a unit vector \[m\].
#[must_use]
pub fn extent_m(model: &Model<'_>, direction: [f64; 3]) -> f64 {
    let along = |cell: usize| Vector3::from(rest_m(model, cell)).dot(&Vector3::from(direction));
    let ways = || (0..model.body_cells()).map(along);
    let (low, high) = (ways().reduce(f64::min), ways().reduce(f64::max));
    high.zip(low).map_or(0.0, |(high, low)| high - low)
}

/// Length of a body along the axis on which it is longest \[m\].
#[must_use]
pub fn size_m(model: &Model<'_>) -> f64 {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    axes.map(|axis| extent_m(model, axis)).into_iter().fold(0.0, f64::max)
}

/// The point of a triangle nearest to a given point.
fn nearest(point: Vector3<f64>, [a, b, c]: [Vector3<f64>; 3]) -> Vector3<f64> {
    let (ab, ac) = (b - a, c - a);
    let from = |corner: Vector3<f64>| (ab.dot(&(point - corner)), ac.dot(&(point - corner)));
    // Nearest to a corner.
    let (along_a, across_a) = from(a);
    if along_a <= 0.0 && across_a <= 0.0 {
        return a;
    }
    let (along_b, across_b) = from(b);
    if along_b >= 0.0 && across_b <= along_b {
        return b;
    }
    let (along_c, across_c) = from(c);
    if across_c >= 0.0 && along_c <= across_c {
        return c;
    }
    // Nearest to an edge.
    let beyond_ab = along_a * across_b - along_b * across_a;
    if beyond_ab <= 0.0 && along_a >= 0.0 && along_b <= 0.0 {
        return a + ab * (along_a / (along_a - along_b));
    }
    let beyond_ac = along_c * across_a - along_a * across_c;
    if beyond_ac <= 0.0 && across_a >= 0.0 && across_c <= 0.0 {
        return a + ac * (across_a / (across_a - across_c));
    }
    let beyond_bc = along_b * across_c - along_c * across_b;
    let (to_b, to_c) = (across_b - along_b, along_c - across_c);
    if beyond_bc <= 0.0 && to_b >= 0.0 && to_c >= 0.0 {
        return b + (c - b) * (to_b / (to_b + to_c));
    }
    // Nearest to the inside.
    let all = beyond_ab + beyond_ac + beyond_bc;
    a + ab * (beyond_ac / all) + ac * (beyond_ab / all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tetrahedron() -> Reach {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let triangles_m =
            faces.map(|face| face.map(|corner: usize| Vector3::from(corners[corner])));
        Reach { triangles_m: triangles_m.to_vec() }
    }

    /// Compared with the smallest distance of many points of each triangle.
    #[test]
    fn no_point_of_the_surface_is_nearer() {
        let reach = tetrahedron();
        for point in [[0.3, 0.2, 2.0], [-1.0, 0.4, 0.1], [2.0, 2.0, -1.0], [0.2, 0.2, 0.2]] {
            let mut least = f64::MAX;
            for [a, b, c] in &reach.triangles_m {
                for i in 0..=200 {
                    for j in 0..=200 - i {
                        let (u, v) = (f64::from(i) / 200.0, f64::from(j) / 200.0);
                        let at = a + (b - a) * u + (c - a) * v;
                        least = least.min((at - Vector3::from(point)).norm());
                    }
                }
            }
            let found = reach.distance_m(point).unwrap();
            assert!(found <= least + 1e-12 && found > least - 1e-2, "{point:?}: {found} {least}");
        }
        assert_eq!(reach.distance_m([0.0, 0.0, 3.0]), Some(2.0));
    }

    #[test]
    fn a_closed_surface_has_an_inside() {
        let reach = tetrahedron();
        assert!(reach.is_around([0.1, 0.1, 0.1]));
        assert!(!reach.is_around([-0.1, 0.1, 0.1]) && !reach.is_around([0.5, 0.5, 0.5]));
        let open = Reach { triangles_m: vec![reach.triangles_m[0]] };
        assert!(!open.is_around([0.1, 0.1, 1e-3]));
    }

    #[test]
    fn edges_are_those_near_a_point() {
        let reach = tetrahedron();
        // The three faces at the origin have two edges of 1 and one of the root of 2.
        let found = reach.edge_near_m([-1.0, -1.0, -1.0], 0.0).unwrap();
        assert!((found - (2.0 + f64::sqrt(2.0)) / 3.0).abs() < 1e-12, "{found}");
        let far = reach.edge_near_m([1.0, 1.0, 1.0], 0.0).unwrap();
        assert!((far - f64::sqrt(2.0)).abs() < 1e-12, "{far}");
        assert_eq!(Reach { triangles_m: vec![] }.edge_near_m([0.0; 3], 1.0), None);
    }

    const UP: [f64; 3] = [0.0, 0.0, 1.0];

    /// A floor at z = 0.
    fn floor() -> Reach {
        let corners = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 9.0, 0.0]];
        Reach { triangles_m: vec![corners.map(Vector3::from)] }
    }

    #[test]
    fn every_kind_of_part_stops_where_its_lowest_point_touches() {
        let (sin, cos) = (std::f32::consts::PI / 8.0).sin_cos();
        let about_x = |part| ToolPart { orientation: [sin, 0.0, 0.0, cos], ..part };
        let moved = |part, z| ToolPart { centre_m: [0.2, 0.1, z], ..part };
        let capsule = ToolPart::capsule(0.5, 0.1);
        let block = ToolPart::rounded_box([0.4, 0.3, 0.2], 0.1);
        let half = f64::sqrt(0.5);
        for (parts, height) in [
            (vec![ToolPart::sphere(0.1)], 0.1),
            (vec![capsule], 0.6),
            (vec![about_x(capsule)], 0.5 * half + 0.1),
            (vec![block], 0.3),
            (vec![about_x(block)], 0.5 * half + 0.1),
            (vec![moved(block, -0.2), capsule], 0.6),
            (vec![ToolPart::edge(0.5)], 0.0),
            (vec![capsule, moved(ToolPart::edge(0.5), -0.8)], 0.8),
            (vec![moved(about_x(block), -0.4), capsule], 0.5 * half + 0.5),
        ] {
            let found = floor().first_touch_m([0.0; 3], UP, &parts).unwrap();
            assert!((found - height).abs() < 1e-4, "{parts:?}: {found}, not {height}");
            assert!(found >= height - 1e-6, "{parts:?} begins inside: {found}, not {height}");
        }
        // Over the tip of the tetrahedron, which the lowest edge of the box meets first.
        let found = tetrahedron().first_touch_m([0.0, 0.1, 0.0], UP, &[about_x(block)]).unwrap();
        assert!(found > 1.2 && found < 1.5, "{found}");
        for (kind, part) in [("box", block), ("capsule", capsule)] {
            assert_eq!(floor().first_touch_m([30.0, 0.0, 0.0], UP, &[part]), None, "{kind}");
        }
    }

    #[test]
    fn a_sphere_stops_where_it_first_touches() {
        let reach = tetrahedron();
        // Next to the tip: the sphere touches it with its side.
        let off = reach.first_touch_m([0.06, 0.0, 0.0], UP, &[ToolPart::sphere(0.1)]).unwrap();
        let centre = [0.06, 0.0, off];
        assert!((reach.distance_m(centre).unwrap() - 0.1).abs() < 1e-4, "{off}");
        assert!(off > 1.0 && off < 1.1, "{off}");
        assert_eq!(reach.first_touch_m([3.0, 0.0, 0.0], UP, &[ToolPart::sphere(0.1)]), None);
    }
}
