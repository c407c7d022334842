//! The surface that a probe meets: what each triangle resists with, see the kernel's module of
//! contact on surfaces.

use chaincell_kernel::image::{contact, kind};

use super::image::Sections;
use super::{BakeOptions, OrderedCells};
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// What a probe touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ProbeContact {
    /// Cells of the surface.
    #[default]
    Cells,
    /// Points of the surface's triangles; on a body of nodal shapes.
    Surface,
}

/// What a probe may touch.
pub(super) fn check(mesh: &Mesh, options: &BakeOptions) -> Result<()> {
    if options.probe_contact == ProbeContact::Cells {
        return Ok(());
    }
    let lacking = if options.tissue.is_none() {
        "of a body by Young's modulus alone; give `young_pa`, or leave it out"
    } else if mesh.triangles.is_empty() {
        "the mesh has no triangles; leave it out"
    } else {
        return Ok(());
    };
    Err(Error::input(format!("`probe_contact` surface: {lacking}")))
}

/// What a flat triangle is taken to have: nothing, within the range of the image.
const LEAST: f64 = 1.0e-9;

/// Adds the section where it is asked for; `stiffness_n_per_m` is `k_ref`. The triangles have their own section.
pub(super) fn push(
    sections: &mut Sections,
    mesh: &Mesh,
    body: &OrderedCells,
    (options, stiffness_n_per_m): (&BakeOptions, f32),
) {
    let (Some(tissue), ProbeContact::Surface) = (&options.tissue, options.probe_contact) else {
        return;
    };
    let young = super::tissue::each(&tissue.young_pa, body);
    let unit_pa = 2.0 * f64::from(stiffness_n_per_m) / f64::from(body.unit_m);
    let numbers: Vec<[f32; 3]> = (mesh.triangles.iter())
        .map(|nodes| {
            let cells = nodes.map(|node| usize::from(body.cell_of[node as usize]));
            let [a, b, c] =
                cells.map(|cell| nalgebra::Vector3::from(body.rest[cell].map(f64::from)));
            let edge = ((b - a).norm() + (c - b).norm() + (a - c).norm()) / 3.0;
            let area = 0.5 * (b - a).cross(&(c - a)).norm();
            let modulus = cells.iter().map(|&cell| young[cell]).sum::<f64>() / (3.0 * unit_pa);
            let mut numbers = [0.0; 3];
            for (row, value) in [
                (contact::STIFFNESS, modulus * area / edge.max(LEAST)),
                (contact::EDGE, edge),
                (contact::AREA, area),
            ] {
                numbers[row] = value.max(LEAST) as f32;
            }
            numbers
        })
        .collect();
    if !numbers.is_empty() {
        sections.push(kind::CONTACT, numbers.as_flattened());
    }
}
