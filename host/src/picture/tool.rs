//! Tools as bodies.

use chaincell_kernel::{ProxyPose, Scissors, ToolPart, ToolPose};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::body::{Body, Paint};

/// Steel.
const COLOUR: [u8; 3] = [176, 180, 188];
/// Rings of latitude of a rounded part.
const FINE: u32 = 32;
/// Half height and half thickness of a blade above its edge [half lengths of the edge].
const BLADE: [f64; 2] = [0.4, 0.02];
/// Half thickness of a blade of scissors, which is as high as twice their offset [offsets].
const SHEET: f64 = 0.1;

/// Where a tool is: where the tissue meets it, or where it was told to be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed {
    pub position_m: [f32; 3],
    pub orientation: [f32; 4],
    pub radius_scale: f64,
    /// Opening of scissors \[rad\].
    pub opening_rad: f64,
}

impl Placed {
    /// A tool of a pose, and where the tissue meets it.
    pub fn new(pose: &ToolPose, proxy: Option<ProxyPose>) -> Self {
        let opening_rad = pose.opening_rad().into();
        // A tool that waits inside the tissue has no radius yet: it is drawn whole.
        match proxy.filter(|proxy| proxy.share > 0.0) {
            Some(ProxyPose { position_m, orientation, share }) => {
                Self { position_m, orientation, radius_scale: share.into(), opening_rad }
            }
            None => Self {
                position_m: pose.position_m.into(),
                orientation: pose.orientation,
                radius_scale: 1.0,
                opening_rad,
            },
        }
    }
}

/// A part of a tool where it is, its radius scaled. A half space is a plate of `plate_m` half edges \[m\], an edge
/// the lowest line of an upright plate; scissors are two plates that cross.
pub(super) fn body(part: &ToolPart, at: &Placed, plate_m: f64) -> Body {
    let (of_tool, of_part) = (rotation(at.orientation), rotation(part.orientation));
    let centre = part.centre_m.map(f64::from);
    let place = |point: [f64; 3]| {
        let in_tool = of_part * Vector3::from(point) + Vector3::from(centre);
        (of_tool * in_tool + Vector3::from(at.position_m.map(f64::from))).into()
    };
    let mut drawn = if part.is_half_space() {
        plate(plate_m)
    } else if let Some(blades) = part.blades() {
        scissors(blades, at.opening_rad)
    } else if part.is_edge() {
        blade(part.half_m[0].into())
    } else {
        let radius_m = f64::from(part.radius_m) * at.radius_scale;
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

/// Two plates side by side from the pivot at the origin along -z, turned apart about x by the opening. The inner
/// side of each is its edge.
fn scissors(blades: Scissors, opening_rad: f64) -> Body {
    let (length_m, offset_m) = (f64::from(blades.length_m), f64::from(blades.offset_m));
    let thickness_m = SHEET * offset_m;
    let core_m = [0.0, offset_m - thickness_m, 0.5 * length_m - thickness_m];
    let one = |side: f64| {
        let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.5 * side * opening_rad);
        let mut drawn = Body::rounded(core_m.map(|half| half.max(0.0)), thickness_m, COLOUR, FINE);
        for point in &mut drawn.points_m {
            let [x, y, z] = *point;
            let along = Vector3::new(x + side * thickness_m, y, z - 0.5 * length_m);
            *point = (turn * along).into();
        }
        drawn
    };
    let (mut both, other) = (one(1.0), one(-1.0));
    let count = both.points_m.len() as u32;
    both.points_m.extend(other.points_m);
    both.triangles.extend(other.triangles.iter().map(|ids| ids.map(|id| id + count)));
    both
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

    fn at(position_m: [f32; 3], orientation: [f32; 4]) -> Placed {
        Placed { position_m, orientation, radius_scale: 1.0, opening_rad: 0.0 }
    }

    /// Open by 60 degrees, the blades end at 30 degrees on both sides of -z; closed, they lie on it.
    #[test]
    fn scissors_are_two_blades() {
        let part = ToolPart::scissors(1.0, 0.1, 0.5);
        for half_rad in [0.0, std::f64::consts::FRAC_PI_6] {
            let opening_rad = 2.0 * half_rad;
            let at = Placed { opening_rad, ..at([0.0; 3], [0.0, 0.0, 0.0, 1.0]) };
            let drawn = body(&part, &at, 1.0);
            for side in [-1.0, 1.0] {
                // The farthest point along a blade, and its distance to the sides of the blade's middle.
                let (sin, cos) = (side * half_rad).sin_cos();
                let ends =
                    drawn.points_m.iter().map(|[_, y, z]| [y * sin - z * cos, y * cos + z * sin]);
                let far = ends.clone().fold(0.0_f64, |far, [along, _]| far.max(along));
                assert!((far - 1.0).abs() < 1e-3, "{far}");
                let tip = ends.filter(|[along, _]| *along > 0.95).map(|[_, aside]| aside.abs());
                let reach = tip.fold(0.0, f64::max);
                assert!((reach - 0.1).abs() < 2e-3, "{reach}");
            }
        }
    }

    /// Half edges and radius bound every shape, and a turn by 90 degrees exchanges axes.
    #[test]
    fn shapes_have_their_sizes_and_places() {
        let quarter = [0.0, 0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt()];
        for (part, most) in [
            (ToolPart::sphere(0.5), [0.5, 0.5, 0.5]),
            (ToolPart::capsule(2.0, 0.5), [0.5, 0.5, 2.5]),
            (ToolPart::rounded_box([1.0, 2.0, 3.0], 0.5), [2.5, 1.5, 3.5]),
        ] {
            let drawn = body(&part, &at([10.0, 0.0, 0.0], quarter), 1.0);
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
        let drawn = body(&ToolPart::edge(0.5), &at([10.0, 0.0, 3.0], quarter), 1.0);
        let ends = |axis: usize| {
            let along = || drawn.points_m.iter().map(|p| p[axis]);
            [along().fold(f64::MAX, f64::min), along().fold(f64::MIN, f64::max)]
        };
        for (axis, wanted) in [[9.99, 10.01], [-0.5, 0.5], [3.0, 3.4]].into_iter().enumerate() {
            let found = ends(axis);
            let is_there = found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3);
            assert!(is_there, "axis {axis}: {found:?}, not {wanted:?}");
        }
        let plate = body(&ToolPart::half_space(0.01), &at([0.0, 0.0, 3.0], quarter), 7.0);
        assert!(plate.points_m.iter().all(|p| p[2] == 3.0 && (p[0].abs() - 7.0).abs() < 1e-6));
    }
}
