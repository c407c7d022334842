//! The error of a body that comes from its mesh, by the same presses on the mesh cut once.
//!
//! The difference between the two is the estimate: under a held patch, on livers of 161 and 423 nodes, it is within a
//! factor of 1.3 of the distance to quadratic elements on the cut mesh (`tests/MEASURED.md`). Differences fall by
//! [`FALL`] when a mesh is cut twice, so the limit of finer meshes lies half as far again.

use chaincell_kernel::Model;
use serde::Serialize;

use super::Contact;
use super::place::Place;
use super::resting::resting;
use crate::error::Result;
use crate::mesh::Mesh;
use crate::mesh::geometry::volume6;

/// Factor by which differences fall when the edges are cut in half once more.
pub const FALL: f64 = 3.1;

/// A press on both meshes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PlaceError {
    /// Position of the tool at the touch \[m\].
    pub touch_m: [f64; 3],
    /// Force of the given mesh \[N\].
    pub force_n: f64,
    /// Force of the mesh cut once \[N\].
    pub finer_force_n: f64,
    /// Distance of the forces, as a share of the finer one's.
    pub force_error: f64,
    /// Distance of the displacements of the nodes that move freely, weighted by volume, as a share of the finer ones'.
    pub field_error: f64,
}

/// A body with its contact.
#[derive(Debug, Clone, Copy)]
pub struct Pressed<'a> {
    /// The baked body.
    pub model: Model<'a>,
    /// The tool, or the held cells.
    pub contact: &'a Contact,
}

/// Compares a press on a mesh with that on the mesh cut once. `volumes_m3` are those of the given mesh's nodes, which
/// come first on the finer one, 0 of those that cannot move freely.
///
/// # Errors
/// As [`resting`].
pub fn place_error(
    [given, finer]: [Pressed<'_>; 2],
    place: &Place,
    depth_m: f64,
    volumes_m3: &[f64],
) -> Result<PlaceError> {
    let press = |body: Pressed<'_>| resting(&body.model, body.contact, place, depth_m);
    let (given, finer) = (press(given)?, press(finer)?);
    let (mut apart, mut size) = (0.0, 0.0);
    let pairs = given.displacements_m.iter().zip(&finer.displacements_m);
    for ((one, other), volume) in pairs.zip(volumes_m3) {
        apart += volume * (one - other).norm_squared();
        size += volume * other.norm_squared();
    }
    Ok(PlaceError {
        touch_m: place.touch_m,
        force_n: given.force_n.norm(),
        finer_force_n: finer.force_n.norm(),
        force_error: (given.force_n - finer.force_n).norm() / finer.force_n.norm(),
        field_error: (apart / size).sqrt(),
    })
}

/// A quarter of the volume of its tetrahedra for each node that moves freely \[m^3\], 0 for these others.
#[must_use]
pub fn free_volumes_m3<'a>(mesh: &Mesh, others: impl IntoIterator<Item = &'a u32>) -> Vec<f64> {
    let mut volumes_m3 = vec![0.0; mesh.nodes_m.len()];
    for tetrahedron in &mesh.tetrahedra {
        let corners_m = tetrahedron.map(|node| mesh.nodes_m[node as usize]);
        let quarter_m3 = volume6(corners_m).abs() / 24.0;
        for &node in tetrahedron {
            volumes_m3[node as usize] += quarter_m3;
        }
    }
    for &node in others {
        volumes_m3[node as usize] = 0.0;
    }
    volumes_m3
}
