//! Place of the built-in press on a body.

use chaincell_kernel::{Model, ToolPart};
use nalgebra::Vector3;

use super::contact::{automatic, farthest, inward};
use super::reach::Reach;
use super::{Contact, rest_m};
use crate::error::{Error, Result};

/// Point of touch and direction of a press.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Position of the tool at the touch \[m\]; all of a tool is then outside of the body.
    pub touch_m: [f64; 3],
    /// Unit vector of the press.
    pub direction: [f64; 3],
}

/// The middle of the held cells; with a tool the position of its first touch on the way to the middle cell
/// of `--contact auto`. The direction is into the body along the mean normal there, unless a direction is
/// given.
///
/// # Errors
/// A direction of zero length, a model without a free cell, a tool that would miss the body, a half space as
/// the first tool.
pub fn place(model: &Model<'_>, contact: &Contact, along: Option<[f64; 3]>) -> Result<Place> {
    if contact.first_tool().is_some_and(|parts| parts.iter().any(ToolPart::is_half_space)) {
        return Err(Error::input(
            "`tool` half-space: the built-in press needs a first tool of finite size; put another tool \
             first, or give run or control a `path`",
        ));
    }
    let cells = match contact {
        Contact::Cells(cells) => cells.clone(),
        _ => vec![farthest(model)?],
    };
    place_at(model, contact, &cells, along)
}

/// As [`place`], at these cells.
fn place_at(
    model: &Model<'_>,
    contact: &Contact,
    cells: &[u16],
    along: Option<[f64; 3]>,
) -> Result<Place> {
    let direction = Vector3::from(along.unwrap_or_else(|| inward(model, cells)));
    let length = direction.norm();
    if !(length.is_finite() && length > 0.0) {
        return Err(Error::input("`direction`: its length must be finite and above 0"));
    }
    let direction = direction / length;
    // Their mean position.
    let mut touch_m = [0.0; 3];
    for &cell in cells {
        let at = rest_m(model, cell.into());
        for axis in 0..3 {
            touch_m[axis] += at[axis] / cells.len() as f64;
        }
    }
    // A tool begins where it first touches.
    if let Some(parts) = contact.first_tool() {
        let way_m = Reach::of(model).first_touch_m(touch_m, (-direction).into(), parts);
        let way_m = way_m.ok_or_else(|| {
            Error::input(
                "the built-in press would pass by the body: give run or control `touch_m` and \
                 `direction`",
            )
        })?;
        touch_m = (Vector3::from(touch_m) - direction * way_m).into();
    }
    Ok(Place { touch_m, direction: direction.into() })
}

/// Places of presses apart from each other: the first is that of [`place`], each further one is as far as can be from
/// the fixed cells and from the places before. Those after the first lie where the surface bends by at most 30 degrees.
/// At least one: fewer than `count` of a body that has no more such cells, one of held cells.
///
/// # Errors
/// As [`place`] for the first one.
pub fn places(
    model: &Model<'_>,
    contact: &Contact,
    along: Option<[f64; 3]>,
    count: usize,
) -> Result<Vec<Place>> {
    let mut places = vec![place(model, contact, along)?];
    if matches!(contact, Contact::Cells(_)) {
        return Ok(places);
    }
    let at = |cell: u16| Vector3::from(model.rest_position(cell.into()));
    let mut taken: Vec<Vector3<f32>> = model.fixed().iter().map(|&cell| at(cell)).collect();
    taken.push(at(farthest(model)?));
    // A cell counts once: one where a tool would miss the body is left out.
    let is_smooth = |cell: &u16| bend_at_deg(model, *cell).is_some_and(|bend| bend <= SMOOTH_DEG);
    let mut left: Vec<u16> = model.surface().iter().copied().filter(is_smooth).collect();
    while places.len() < count {
        let clearance = |cell: u16| {
            taken
                .iter()
                .map(|other| (at(cell) - other).norm_squared())
                .fold(f32::INFINITY, f32::min)
        };
        let best = left.iter().copied().map(|cell| (clearance(cell), cell));
        let best = best.max_by(|one, other| one.0.total_cmp(&other.0).then(other.1.cmp(&one.1)));
        let Some((_, cell)) = best.filter(|best| best.0 > 0.0) else { break };
        left.retain(|&other| other != cell);
        if let Ok(found) = place_at(model, contact, &[cell], None) {
            taken.push(at(cell));
            places.push(found);
        }
    }
    Ok(places)
}

/// Largest bend of the surface at a place of a press that is not the first \[degrees\].
const SMOOTH_DEG: f64 = 30.0;

/// Largest angle between the mean normal of the surface and one of its sides \[degrees\], at the middle cell of
/// the default contact or across an edge between two of its cells: 55 at a corner of a box, 45 at an edge. `None`
/// if the model has no triangles or no free cell.
#[must_use]
pub fn bend_deg(model: &Model<'_>) -> Option<f64> {
    let held = automatic(model).ok()?;
    let middle = bend_at_deg(model, farthest(model).ok()?)?;
    Some(middle.max(bend_within_deg(model, &held)))
}

/// Unit normal of a triangle of the surface.
fn normal(model: &Model<'_>, corners: &[u16; 3]) -> Option<Vector3<f64>> {
    let [a, b, c] = corners.map(|cell| Vector3::from(rest_m(model, cell.into())));
    (b - a).cross(&(c - a)).try_normalize(0.0)
}

/// Angle of the unit vectors from each other \[degrees\].
fn angle_deg(one: &Vector3<f64>, other: &Vector3<f64>) -> f64 {
    one.dot(other).clamp(-1.0, 1.0).acos().to_degrees()
}

/// The bend at a cell.
fn bend_at_deg(model: &Model<'_>, cell: u16) -> Option<f64> {
    let around = model.triangles().iter().filter(|corners| corners.contains(&cell));
    let normals: Vec<Vector3<f64>> = around.filter_map(|corners| normal(model, corners)).collect();
    // A side counts once, however many triangles it has at the cell.
    let mut sides: Vec<Vector3<f64>> = Vec::new();
    for normal in &normals {
        if sides.iter().all(|side| side.dot(normal) < SAME_SIDE) {
            sides.push(*normal);
        }
    }
    let mean = sides.iter().sum::<Vector3<f64>>().try_normalize(0.0)?;
    sides.iter().map(|side| angle_deg(&mean, side)).reduce(f64::max)
}

/// The largest bend at an edge between two of some cells, ascending: half the angle between its two triangles.
fn bend_within_deg(model: &Model<'_>, cells: &[u16]) -> f64 {
    let has = |cell: &u16| cells.binary_search(cell).is_ok();
    // The triangles with an edge between two of the cells.
    let near = model.triangles().iter();
    let near = near.filter(|corners| corners.iter().filter(|cell| has(cell)).count() >= 2);
    let sides: Vec<([u16; 3], Vector3<f64>)> =
        near.filter_map(|corners| Some((*corners, normal(model, corners)?))).collect();
    // The pairs of them that share one.
    let shares = |one: &[u16; 3], other: &[u16; 3]| {
        one.iter().filter(|cell| has(cell) && other.contains(cell)).count() == 2
    };
    let pairs = sides.iter().enumerate().flat_map(|(at, one)| {
        let later = sides[at + 1..].iter().filter(|other| shares(&one.0, &other.0));
        later.map(|other| 0.5 * angle_deg(&one.1, &other.1))
    });
    pairs.fold(0.0, f64::max)
}

/// Cosine of the angle below which two triangles are of the same side.
const SAME_SIDE: f64 = 0.95;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::{BakeOptions, bake};
    use crate::engine::fixture::plane;
    use crate::mesh::{Filling, Mesh, MeshOptions, from_surface, load};

    #[test]
    fn further_places_lie_apart_from_each_other_and_from_the_fixed_cells() {
        let mesh = load("organ:300", &MeshOptions::default()).unwrap();
        let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default()).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let sphere = Contact::sphere(0.01, 0.0);
        let found = places(&model, &sphere, None, 3).unwrap();
        assert_eq!((found.len(), found[0]), (3, place(&model, &sphere, None).unwrap()));
        for (at, one) in found.iter().enumerate() {
            let apart =
                |other: [f64; 3]| (Vector3::from(one.touch_m) - Vector3::from(other)).norm();
            assert!(found[..at].iter().all(|other| apart(other.touch_m) > 0.05), "{found:?}");
            let fixed = model.fixed().iter().map(|&cell| apart(rest_m(&model, cell.into())));
            assert!(fixed.fold(f64::INFINITY, f64::min) > 0.03, "{found:?}");
        }
    }

    #[test]
    fn a_corner_of_a_box_bends_and_a_plane_does_not() {
        let mesh = load("box:4x4x3x0.01", &MeshOptions::default()).unwrap();
        let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default()).unwrap();
        let bend = bend_deg(&Model::from_bytes(image.as_bytes()).unwrap()).unwrap();
        assert!((bend - 54.7).abs() < 0.1, "{bend}");
        let image = plane();
        let flat = bend_deg(&Model::from_bytes(image.as_bytes()).unwrap());
        assert!(flat.is_none_or(|bend| bend < 1.0), "{flat:?}");
    }

    /// Filled, the farthest cell lies on a side of the box, and the contact around it reaches an edge.
    #[test]
    fn a_contact_that_reaches_an_edge_of_a_filled_box_bends() {
        let filled = |surface: &Mesh, size_m| {
            let filling = Some(Filling::even(size_m));
            let options = MeshOptions { filling, ..MeshOptions::default() };
            let triangles = surface.triangles.clone();
            let mesh = from_surface("a body", &surface.nodes_m, triangles, &options).unwrap();
            let low = (0..).zip(&mesh.nodes_m).filter(|(_, node)| node[2] < 1e-3);
            let fixed: Vec<u32> = low.map(|(id, _)| id).collect();
            let image = bake(&mesh, &fixed, &BakeOptions::default()).unwrap();
            let model = Model::from_bytes(image.as_bytes()).unwrap();
            let middle = bend_at_deg(&model, farthest(&model).unwrap()).unwrap();
            (middle, bend_deg(&model).unwrap())
        };
        let cube = load("box:5x5x5x0.01", &MeshOptions::default()).unwrap();
        let (middle, bend) = filled(&cube, 0.009);
        assert!(middle < 1.0 && (bend - 45.0).abs() < 1.0, "{middle} {bend}");
        let round = load("organ:500", &MeshOptions::default()).unwrap();
        let (_, bend) = filled(&round, 0.012);
        assert!(bend < 30.0, "{bend}");
    }
}
