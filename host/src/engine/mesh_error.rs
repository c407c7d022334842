//! The error of a body that comes from its mesh, by the same presses on the mesh cut once.
//!
//! The difference between the two is the estimate: on livers of 161 to 5,773 nodes it is within a factor of 1.25 of the
//! distance to quadratic elements on the cut mesh. Differences fall by [`FALL`] when a mesh is cut twice, so what all
//! finer meshes come to lies half as far again.

use chaincell_kernel::Model;
use nalgebra::Vector3;
use serde::Serialize;

use super::Contact;
use super::place::Place;
use super::resting::{Resting, resting};
use crate::bake::ImageBytes;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

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
    pub image: &'a ImageBytes,
    /// The tool, or the held cells.
    pub contact: &'a Contact,
}

impl Pressed<'_> {
    fn resting(&self, place: &Place, depth_m: f64) -> Result<Resting> {
        let model = Model::from_bytes(self.image.as_bytes()).map_err(Error::check)?;
        resting(&model, self.contact, place, depth_m)
    }
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
    let (given, finer) = (given.resting(place, depth_m)?, finer.resting(place, depth_m)?);
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
        let [a, b, c, d] = tetrahedron.map(|node| Vector3::from(mesh.nodes_m[node as usize]));
        let quarter_m3 = (b - a).cross(&(c - a)).dot(&(d - a)).abs() / 24.0;
        for &node in tetrahedron {
            volumes_m3[node as usize] += quarter_m3;
        }
    }
    for &node in others {
        volumes_m3[node as usize] = 0.0;
    }
    volumes_m3
}
