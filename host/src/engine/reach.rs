//! Distances of points from the surface that tools touch, at rest.

use std::f64::consts::TAU;

use chaincell_kernel::Model;
use nalgebra::Vector3;

use super::rest_m;

/// The triangles of the surface that tools touch.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    triangles_m: Vec<[Vector3<f64>; 3]>,
}

/// Largest number of steps in the search for a sphere's first touch.
const LOOKS: usize = 400;
/// A sphere this near to the surface touches it [radii].
const CLOSE: f64 = 1e-4;

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

    /// Distance from a point, along the unit vector `outward`, at which the centre of a sphere that comes
    /// from outside first touches \[m\]; `None` if it misses everything.
    #[must_use]
    pub fn first_touch_m(
        &self,
        point_m: [f64; 3],
        outward: [f64; 3],
        radius_m: f64,
    ) -> Option<f64> {
        let (point, outward) = (Vector3::from(point_m), Vector3::from(outward));
        let along = |at: &Vector3<f64>| (at - point).dot(&outward);
        let beside = |at: &Vector3<f64>| (at - point - outward * along(at)).norm();
        // Triangles that are entirely to the side of the path are never touched.
        let is_met = |corners: &&[Vector3<f64>; 3]| {
            let [a, b, c] = **corners;
            let longest = (b - a).norm().max((c - a).norm());
            beside(&a) <= radius_m + longest
        };
        let met: Vec<_> = self.triangles_m.iter().filter(is_met).copied().collect();
        let ways = || met.iter().flatten().map(along);
        let (lowest, highest) = (ways().reduce(f64::min)?, ways().reduce(f64::max)?);
        let met = Self { triangles_m: met };
        // Move in by the free distance until the sphere touches.
        let mut way_m = highest + radius_m;
        for _ in 0..LOOKS {
            let gap_m = met.distance_m((point + outward * way_m).into())? - radius_m;
            if gap_m <= CLOSE * radius_m {
                break;
            }
            way_m -= gap_m;
            if way_m < lowest - radius_m {
                return None;
            }
        }
        Some(way_m)
    }
}

/// Length of a body in a direction, a unit vector \[m\].
#[must_use]
pub fn extent_m(model: &Model<'_>, direction: [f64; 3]) -> f64 {
    let along = |cell: usize| Vector3::from(rest_m(model, cell)).dot(&Vector3::from(direction));
    let ways = || (0..model.cells()).map(along);
    let (low, high) = (ways().reduce(f64::min), ways().reduce(f64::max));
    high.zip(low).map_or(0.0, |(high, low)| high - low)
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
    fn a_sphere_stops_where_it_first_touches() {
        let reach = tetrahedron();
        // Next to the tip: the sphere touches it with its side.
        let off = reach.first_touch_m([0.06, 0.0, 0.0], [0.0, 0.0, 1.0], 0.1).unwrap();
        let centre = [0.06, 0.0, off];
        assert!((reach.distance_m(centre).unwrap() - 0.1).abs() < 1e-4, "{off}");
        assert!(off > 1.0 && off < 1.1, "{off}");
        assert_eq!(reach.first_touch_m([3.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.1), None);
    }
}
