//! Tools as bodies.

use chaincell_kernel::ToolPart;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::body::{Body, Paint};

/// Steel.
const COLOUR: [u8; 3] = [176, 180, 188];
/// Rings of latitude of a rounded part.
const FINE: u32 = 32;
/// Half height and half thickness of a blade above its edge [half lengths of the edge].
const BLADE: [f64; 2] = [0.4, 0.02];

/// A part of a tool where it is, its radius times `radius_scale`. A half space is a plate of `plate_m` half
/// edges \[m\], an edge the lowest line of an upright plate.
pub(super) fn body(
    part: &ToolPart,
    position_m: [f32; 3],
    orientation: [f32; 4],
    radius_scale: f64,
    plate_m: f64,
) -> Body {
    let (of_tool, of_part) = (rotation(orientation), rotation(part.orientation));
    let centre = part.centre_m.map(f64::from);
    let place = |point: [f64; 3]| {
        let in_tool = of_part * Vector3::from(point) + Vector3::from(centre);
        (of_tool * in_tool + Vector3::from(position_m.map(f64::from))).into()
    };
    let mut drawn = if part.is_half_space() {
        plate(plate_m)
    } else if part.is_edge() {
        blade(part.half_m[0].into())
    } else {
        let radius_m = f64::from(part.radius_m) * radius_scale;
        Body::rounded(part.half_m.map(f64::from), radius_m, COLOUR, FINE)
    };
    for point in &mut drawn.points_m {
        *point = place(*point);
    }
    drawn
}

/// A square in the plane z = 0.
fn plate(half_m: f64) -> Body {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    Body {
        points_m: corners.map(|[x, y]| [half_m * x, half_m * y, 0.0]).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        paint: Paint::Plain(COLOUR),
        wires: Vec::new(),
        unlit: false,
    }
}

/// A thin plate in the plane of x and z, on an edge along x.
fn blade(half_m: f64) -> Body {
    let [height_m, thickness_m] = BLADE.map(|share| share * half_m);
    let core_m = [half_m, 0.0, height_m].map(|half: f64| (half - thickness_m).max(0.0));
    let mut drawn = Body::rounded(core_m, thickness_m, COLOUR, FINE);
    for [.., z] in &mut drawn.points_m {
        *z += height_m;
    }
    drawn
}

/// A ball of the tools' colour: a cell that a tool holds.
pub(super) fn ball(centre_m: [f64; 3], radius_m: f64) -> Body {
    Body::sphere(centre_m, radius_m, COLOUR, 16)
}

/// A quaternion x, y, z, w as a rotation; none where it is none.
fn rotation([x, y, z, w]: [f32; 4]) -> UnitQuaternion<f64> {
    let found = Quaternion::new(w.into(), x.into(), y.into(), z.into());
    UnitQuaternion::try_new(found, 1e-6).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Half edges and radius bound every shape, and a turn by 90 degrees exchanges axes.
    #[test]
    fn shapes_have_their_sizes_and_places() {
        let quarter = [0.0, 0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt()];
        for (part, most) in [
            (ToolPart::sphere(0.5), [0.5, 0.5, 0.5]),
            (ToolPart::capsule(2.0, 0.5), [0.5, 0.5, 2.5]),
            (ToolPart::rounded_box([1.0, 2.0, 3.0], 0.5), [2.5, 1.5, 3.5]),
        ] {
            let drawn = body(&part, [10.0, 0.0, 0.0], quarter, 1.0, 1.0);
            for (axis, most) in most.into_iter().enumerate() {
                let middle = if axis == 0 { 10.0 } else { 0.0 };
                let reach = drawn.points_m.iter().map(|p| p[axis] - middle).fold(0.0, f64::max);
                assert!((reach - most).abs() < 0.005 * most, "{part:?}, axis {axis}: {reach}");
            }
        }
        // A body without holes: every edge belongs to two triangles, those without area aside.
        let block = Body::rounded([1.0, 2.0, 3.0], 0.5, COLOUR, 8);
        let mut edges = std::collections::BTreeMap::new();
        for triangle in &block.triangles {
            let at =
                triangle.map(|id| block.points_m[id as usize].map(|x| (1e6 * x).round() as i64));
            for (from, to) in [(at[0], at[1]), (at[1], at[2]), (at[2], at[0])] {
                if from != to {
                    *edges.entry(if from < to { (from, to) } else { (to, from) }).or_insert(0) += 1;
                }
            }
        }
        assert!(edges.values().all(|count| count % 2 == 0), "open edges");
        // A blade stands on its edge, which the turn lays along y.
        let drawn = body(&ToolPart::edge(0.5), [10.0, 0.0, 3.0], quarter, 1.0, 1.0);
        let ends = |axis: usize| {
            let along = || drawn.points_m.iter().map(|p| p[axis]);
            [along().fold(f64::MAX, f64::min), along().fold(f64::MIN, f64::max)]
        };
        for (axis, wanted) in [[9.99, 10.01], [-0.5, 0.5], [3.0, 3.4]].into_iter().enumerate() {
            let found = ends(axis);
            let is_there = found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3);
            assert!(is_there, "axis {axis}: {found:?}, not {wanted:?}");
        }
        let plate = body(&ToolPart::half_space(0.01), [0.0, 0.0, 3.0], quarter, 1.0, 7.0);
        assert!(plate.points_m.iter().all(|p| p[2] == 3.0 && (p[0].abs() - 7.0).abs() < 1e-6));
    }
}
