//! The surface that a probe touches: stiffness, edge and area of each triangle, see the kernel's module
//! of contact on surfaces.

use chaincell_kernel::image::{contact, kind};

use super::equivalent::Equivalent;
use super::image::Sections;
use super::{BakeOptions, OrderedCells};
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// Kind of contact with a probe.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ProbeContact {
    /// Cells of the surface.
    #[default]
    Cells,
    /// Points of the surface's triangles.
    Surface,
}

/// Checks that the body supports the kind of contact.
pub(super) fn check(mesh: &Mesh, options: &BakeOptions) -> Result<()> {
    if options.probe_contact == ProbeContact::Cells {
        return Ok(());
    }
    let lacking = if mesh.triangles.is_empty() {
        "the mesh has no triangles; leave it out"
    } else if options.tissue.is_none() && mesh.tetrahedra.len() == mesh.flat_tetrahedra {
        "the mesh has no volume, which says how stiff its links are together; leave it out"
    } else if options.lean {
        "a lean model has no triangles; leave out `lean`, or this"
    } else if options.cells.is_some() {
        "triangles join nodes, and cells are groups of them; leave out `cells`, or this"
    } else {
        return Ok(());
    };
    Err(Error::input(format!("`probe_contact` surface: {lacking}")))
}

/// Value of a flat triangle in place of 0, within the range of the image.
const LEAST: f64 = 1.0e-9;

/// Returns Young's modulus of each cell \[Pa\]; for links of this stiffness \[N/m\], that of the
/// equivalent tissue.
fn young_pa(
    mesh: &Mesh,
    body: &OrderedCells,
    options: &BakeOptions,
    stiffness: &[f64],
) -> Vec<f64> {
    if let Some(tissue) = &options.tissue {
        return super::tissue::each(&tissue.young_pa, body);
    }
    let unit_m = f64::from(body.unit_m);
    let rest_m: Vec<[f64; 3]> =
        body.rest.iter().map(|place| place.map(|x| unit_m * f64::from(x))).collect();
    let links = body.links.iter().map(|(ends, _)| ends.map(usize::from));
    let cell = |node: u32| usize::from(body.cell_of[node as usize]);
    let tetrahedra = mesh.tetrahedra.iter().map(|nodes| nodes.map(cell));
    let of = Equivalent::new(&rest_m, links.zip(stiffness.iter().copied()), tetrahedra);
    of.map_or_else(|| vec![LEAST; rest_m.len()], |of| of.cells_pa)
}

/// Adds the section if the options ask for it; `reference` is `k_ref`, and `stiffness` that of every link
/// \[N/m\]. The triangles are in another section.
pub(super) fn push(
    sections: &mut Sections,
    mesh: &Mesh,
    body: &OrderedCells,
    options: &BakeOptions,
    (reference, stiffness): (f32, &[f64]),
) {
    if options.probe_contact == ProbeContact::Cells {
        return;
    }
    // Stiffness, mean edge and area of each triangle, in internal units.
    let young = young_pa(mesh, body, options, stiffness);
    let unit_pa = 2.0 * f64::from(reference) / f64::from(body.unit_m);
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
