//! The surface that tools touch: stiffness, edge and area of each triangle, see the kernel's module of
//! contact on surfaces.

use std::collections::BTreeSet;

use chaincell_kernel::image::{contact, kind};

use super::equivalent::Equivalent;
use super::image::Sections;
use super::layout::OrderedCells;
use super::network::Plan;
use super::options::{BakeOptions, ContactSurface};
use crate::error::{Error, Result};

/// Returns true if the image gets a contact surface, where there are triangles.
fn is_wanted(options: &BakeOptions) -> bool {
    match options.contact_surface {
        ContactSurface::Auto => !options.lean,
        ContactSurface::Yes => true,
        ContactSurface::No => false,
    }
}

/// Returns the triangles of cells for contact and for display: those of the mesh, or for contact those
/// between three of its groups, each once. They are empty if nothing needs them.
///
/// # Errors
/// A contact surface that is asked for, and no triangle that it could have.
pub(super) fn triangles(
    plan: &Plan<'_>,
    body: &OrderedCells,
    options: &BakeOptions,
) -> Result<Vec<[u16; 3]>> {
    if !is_wanted(options) && (options.lean || plan.is_grouped()) {
        return Ok(Vec::new());
    }
    let cell = |node: u32| body.cell_of[plan.net_node(node) as usize];
    let mut all: Vec<[u16; 3]> =
        plan.mesh().triangles.iter().map(|nodes| nodes.map(cell)).collect();
    if plan.is_grouped() {
        let mut known = BTreeSet::new();
        all.retain(|&[a, b, c]| {
            let mut corners = [a, b, c];
            corners.sort_unstable();
            a != b && b != c && c != a && known.insert(corners)
        });
    }
    if options.contact_surface == ContactSurface::Yes && all.is_empty() {
        let lacking = if plan.is_grouped() {
            "no triangle joins three groups of `cells`; take more cells, or leave it out"
        } else {
            "the mesh has no triangles; leave it out, and hold cells"
        };
        return Err(Error::input(format!("`contact_surface` yes: {lacking}")));
    }
    Ok(all)
}

/// Value of a flat triangle in place of 0, within the range of the image.
const LEAST: f64 = 1.0e-9;

/// Returns Young's modulus of each cell \[Pa\]; for links of this stiffness \[N/m\], that of the
/// equivalent tissue.
fn young_pa(
    plan: &Plan<'_>,
    body: &OrderedCells,
    options: &BakeOptions,
    stiffness: &[f64],
) -> Vec<f64> {
    if let Some(tissue) = &options.tissue {
        return tissue.instant_pa(body);
    }
    let unit_m = f64::from(body.unit_m);
    let rest_m: Vec<[f64; 3]> =
        body.rest.iter().map(|place| place.map(|x| unit_m * f64::from(x))).collect();
    let links = || {
        let ends = body.links.iter().map(|(ends, _)| ends.map(usize::from));
        ends.zip(stiffness.iter().copied())
    };
    let mesh = plan.mesh();
    let cell = |node: u32| usize::from(body.cell_of[plan.net_node(node) as usize]);
    let tetrahedra = mesh
        .tetrahedra
        .iter()
        .map(|nodes| (nodes.map(cell), nodes.map(|node| mesh.nodes_m[node as usize])));
    let of = Equivalent::new(&rest_m, links(), tetrahedra);
    of.map_or_else(|| sheet_pa(&rest_m, links()), |of| of.cells_pa)
}

/// Returns the modulus of each cell of a body without volume \[Pa\]: the mean of its links' stiffness over
/// their length, as in a body that is as thick as the links are long.
fn sheet_pa(rest_m: &[[f64; 3]], links: impl Iterator<Item = ([usize; 2], f64)>) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); rest_m.len()];
    for ([i, j], stiffness) in links {
        let squared = (0..3).map(|axis| (rest_m[j][axis] - rest_m[i][axis]).powi(2));
        let length_m = squared.sum::<f64>().sqrt();
        for cell in [i, j] {
            sums[cell].0 += stiffness / length_m;
            sums[cell].1 += 1.0;
        }
    }
    sums.into_iter().map(|(sum, links)| if links > 0.0 { sum / links } else { LEAST }).collect()
}

/// Adds the section of the triangles' contact if the options ask for it; `reference` is `k_ref`, and
/// `stiffness` that of every link \[N/m\]. The triangles are in another section.
pub(super) fn push(
    sections: &mut Sections,
    plan: &Plan<'_>,
    body: &OrderedCells,
    options: &BakeOptions,
    triangles: &[[u16; 3]],
    (reference, stiffness): (f32, &[f64]),
) {
    if !is_wanted(options) || triangles.is_empty() {
        return;
    }
    // Stiffness, mean edge and area of each triangle, in internal units.
    let young = young_pa(plan, body, options, stiffness);
    let unit_pa = 2.0 * f64::from(reference) / f64::from(body.unit_m);
    let numbers: Vec<[f32; 3]> = triangles
        .iter()
        .map(|corners| {
            let cells = corners.map(usize::from);
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
    sections.push(kind::CONTACT, numbers.as_flattened());
}
