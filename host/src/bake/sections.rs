//! The sections of an image: what is written, from the parts that compute it.

use chaincell_kernel::image::kind;
use chaincell_kernel::model::rest_length;

use super::adjacency::{Adjacency, adjacency, cell_weights, mobilities};
use super::coarse_basis::{self, Bound};
use super::image::{ImageBytes, Sections};
use super::layout::OrderedCells;
use super::network::Plan;
use super::notes::Notes;
use super::options::BakeOptions;
use super::scalars::scalars;
use super::tissue::Shapes;
use super::{contact, embedded, slices};
use crate::error::Result;
use crate::mesh::vertex_normals;

/// Writes the image section by section.
pub(super) fn write(
    plan: &Plan<'_>,
    body: &OrderedCells,
    options: &BakeOptions,
) -> Result<ImageBytes> {
    let (cells, links) = (body.all_cells(), &body.links);
    let at = |cell: u16| body.rest[usize::from(cell)];
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    // Bands, stiffness and weights of the links, or the nodal shapes.
    let (alphas, stiffness) = (plan.alpha(links), plan.stiffness(links));
    let is_cuttable = options.cuttable.is_some();
    let shaped = |tissue| Shapes::new(plan.mesh(), body, tissue, is_cuttable);
    let shapes = options.tissue.as_ref().map(shaped).transpose()?;
    let alpha = mean(&alphas.each) as f32;
    let reference =
        shapes.as_ref().map_or(mean(&stiffness.each) as f32, |shapes| shapes.stiffness_n_per_m);
    let weight: Vec<f32> = if stiffness.varies {
        stiffness.each.iter().map(|k| (k / f64::from(reference)) as f32).collect()
    } else {
        vec![1.0; links.len()]
    };
    let adjacency = adjacency(cells, links);
    let weights = match &shapes {
        None => cell_weights(body.rest.len(), &adjacency, &weight),
        Some(shapes) => shapes.weights.clone(),
    };
    let mobility = mobilities(body, &weights);
    let rest_lengths: Vec<f32> =
        links.iter().map(|&([i, j], _)| rest_length(at(i), at(j))).collect();
    // The scalars.
    let mut sections = Sections::default();
    let nodes = plan.mesh().nodes_m.len();
    let bound = match &shapes {
        None => Bound::Links(links, &weight),
        Some(shapes) => Bound::Shapes(shapes),
    };
    let largest = bound.largest(&weights);
    let params = scalars(nodes, body, options, &weights, largest, alpha, reference)?;
    sections.push(kind::PARAMS, &params);
    // Cells and links.
    network(&mut sections, body, &adjacency, &mobility, &rest_lengths);
    sections.push(kind::INPUT_ID, &plan.input_ids(body));
    // Values of each link, and the slices for vector units.
    let each_alpha: Vec<f32> = alphas.each.iter().map(|&alpha| alpha as f32).collect();
    let values = slices::Values {
        rest_lengths: &rest_lengths,
        alphas: alphas.varies.then_some(&each_alpha),
        weights: stiffness.varies.then_some(&weight),
    };
    for (kind, values) in [(kind::ALPHA, values.alphas), (kind::WEIGHT, values.weights)] {
        if let Some(values) = values {
            sections.push(kind, values);
        }
    }
    if !options.lean {
        let (rows, ids) = slices::push(&mut sections, cells, &adjacency, links, &values);
        if let Some(shapes) = &shapes {
            shapes.push(&mut sections, cells, &rows, &ids);
        }
        if let Some(relaxation) = &options.link_relaxation {
            relaxation.push(&mut sections);
        }
        if let Some(cuttable) = &options.cuttable {
            cuttable.push(&mut sections, plan.mesh(), body, &rows)?;
        }
    }
    // The coarse level, the surface, the contact and the embedded mesh.
    coarse_basis::push(&mut sections, body, &mobility, &bound, options.coarse_basis)?;
    let triangles = contact::triangles(plan, body, options)?;
    surface(&mut sections, plan, body, options.lean, &triangles);
    let of_links = (reference, &*stiffness.each);
    contact::push(&mut sections, plan, body, options, &triangles, of_links);
    if !options.lean {
        embedded::push(&mut sections, plan, body);
    }
    Ok(sections.finish())
}

/// Adds the cells with their links; spare cells rest at the centre.
fn network(
    sections: &mut Sections,
    body: &OrderedCells,
    adjacency: &Adjacency,
    mobility: &[f32],
    rest_lengths: &[f32],
) {
    let mut rest = body.rest.clone();
    rest.resize(body.all_cells(), [0.0; 3]);
    sections.push(kind::REST, rest.as_flattened());
    sections.push(kind::ROWS, &adjacency.rows);
    sections.push(kind::UPPER, &body.links.iter().map(|(ends, _)| ends[1]).collect::<Vec<_>>());
    sections.push(kind::REST_LENGTH, rest_lengths);
    sections.push(kind::BACK_ROWS, &adjacency.back_rows);
    sections.push(kind::LOWER, &adjacency.lower);
    sections.push(kind::BACK_LINK, &adjacency.back_link);
    sections.push(kind::MOBILITY, mobility);
    sections.push(kind::FIXED, &body.fixed);
}

/// Adds the surface cells with normals, the triangles and, unless the image is lean, the other elements for
/// display.
fn surface(
    sections: &mut Sections,
    plan: &Plan<'_>,
    body: &OrderedCells,
    lean: bool,
    triangles: &[[u16; 3]],
) {
    let mesh = plan.mesh();
    let normals = vertex_normals(&mesh.nodes_m, &mesh.triangles);
    let (cells, normals): (Vec<u16>, Vec<[f32; 3]>) = (plan.input_ids(body).iter().enumerate())
        .filter_map(|(cell, &id)| Some((cell as u16, normals[id as usize]?.map(|x| x as f32))))
        .unzip();
    if !cells.is_empty() {
        sections.push(kind::SURFACE, &cells);
        sections.push(kind::NORMALS, normals.as_flattened());
    }
    if !lean {
        sections.push(kind::NOTES, &Notes::of(mesh).to_bytes());
    }
    if !triangles.is_empty() {
        sections.push(kind::TRIANGLES, triangles.as_flattened());
    }
    if !lean && !plan.is_grouped() && !mesh.tetrahedra.is_empty() {
        let cell = |node: u32| body.cell_of[node as usize];
        let cells: Vec<u16> = mesh.tetrahedra.as_flattened().iter().map(|&id| cell(id)).collect();
        sections.push(kind::TETRAHEDRA, &cells);
    }
}
