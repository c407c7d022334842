//! Makes a model image of a mesh: cells in an order that keeps neighbours close, links with their
//! bands and weights, the bounds that the kernel's proofs need.
//!
//! - `network`: the mesh itself, with links up to `--rings` edges long, or groups of its nodes.
//! - `groups`: `--cells N` puts the nodes of a mesh of up to 2,000,000 nodes into N groups, a cell
//!   each. A tick takes the time of N cells; every node follows the cells around it.
//! - `embedded`: those nodes in the image; `--lean` leaves them out, and all other data that only
//!   pictures, selectors and vector units need.
//! - `order`, `slices`: the order of the cells, and their links for vector units.
//! - `coarse_basis`: the coarse level of `track`, `--coarse`.
//! - `tissue`: Young's modulus and Poisson's ratio in place of links.
//! - `contact`: the surface that tools touch, `--contact-surface`.
//! - `equivalent`: Young's modulus of the tissue to which links are equivalent.
//! - `notes`: node groups and border, for selectors.
//! - `image`: the layout of the image.

mod coarse_basis;
mod contact;
mod embedded;
mod equivalent;
mod groups;
mod image;
mod lengths;
mod network;
mod notes;
mod order;
mod slices;
pub mod tissue;

use chaincell_kernel::Model;
use chaincell_kernel::image::STIFFENING_MAX;
use chaincell_kernel::model::rest_length;

pub use coarse_basis::BasisSpacing;
use coarse_basis::Bound;
pub use contact::ContactSurface;
pub use equivalent::Equivalent;
pub use groups::{Groups, partition};
pub use image::ImageBytes;
use image::Sections;
use network::Plan;
pub use notes::Notes;
use tissue::{Band, STRETCH_MIN, Shapes, Tissue};

use crate::error::{Error, Result};
use crate::mesh::{Mesh, MeshOptions, load, vertex_normals};

/// A quantity of every link: one value, or one per input node, averaged over a link's ends.
#[derive(Debug, Clone, PartialEq)]
pub enum PerCell {
    /// One value everywhere; nothing is stored per link.
    Uniform(f64),
    /// One value per input node.
    Each(Vec<f64>),
}

impl PerCell {
    fn of_link(&self, [i, j]: [u32; 2]) -> f64 {
        match self {
            Self::Uniform(value) => *value,
            Self::Each(values) => {
                let at = |node: u32| values.get(node as usize).copied().unwrap_or(f64::NAN);
                0.5 * (at(i) + at(j))
            }
        }
    }
}

/// Largest Poisson's ratio: above it, the rounding of the volume's stress hides that of the shear.
const POISSON_MAX: f64 = 0.495;

/// Options of the bake.
#[derive(Debug, Clone, PartialEq)]
pub struct BakeOptions {
    /// Half-width of the band in rest lengths, in [0, 1).
    pub alpha: PerCell,
    /// Stiffness of a link \[N/m\].
    pub stiffness_n_per_m: PerCell,
    /// Nodal shapes in place of links; then alpha is 0, and the stiffness is not used.
    pub tissue: Option<Tissue>,
    /// Saturation K from the body's centre \[m\]; 4 times the largest coordinate if absent.
    pub saturation_m: Option<f64>,
    /// Cell resistance.
    pub resistance: f64,
    /// Cell capacitance C.
    pub capacitance: f64,
    /// Most energy that a tool may store in the body \[J\].
    pub energy_max_j: Option<f64>,
    /// The coarse level of `track`.
    pub coarse_basis: BasisSpacing,
    /// Leave out data that only a display or a vector unit needs.
    pub lean: bool,
    /// Choice of a contact surface, which tools touch.
    pub contact_surface: ContactSurface,
    /// Number of groups of nodes, each of them a cell; every node is a cell if absent.
    pub cells: Option<usize>,
}

impl Default for BakeOptions {
    fn default() -> Self {
        Self {
            alpha: PerCell::Uniform(0.0),
            stiffness_n_per_m: PerCell::Uniform(20.0),
            tissue: None,
            saturation_m: None,
            resistance: 1.0,
            capacitance: 1.0,
            energy_max_j: None,
            coarse_basis: BasisSpacing::BySize,
            lean: false,
            contact_surface: ContactSurface::Auto,
            cells: None,
        }
    }
}

/// Cells of a link, lower first, and the index of the mesh's link.
type Link = ([u16; 2], usize);

/// Cells in the model's order, with the data of the sections.
struct OrderedCells {
    /// Each cell's node in the network's mesh.
    node: Vec<u32>,
    /// Cell of each node of that mesh; `u16::MAX` for a node that is no cell.
    cell_of: Vec<u16>,
    centre_m: [f32; 3],
    unit_m: f32,
    rest: Vec<[f32; 3]>,
    /// Links of cells, `i < j`, sorted, with the index of the mesh's link.
    links: Vec<Link>,
    fixed: Vec<u16>,
}

/// Size of the default body, and the instructions that its tick may take with AVX2: one sweep of `predict`
/// under a ball that is pressed in, with contact and state hash. `cargo bench -p chaincell-lab --bench sweep`
/// counts them, and fails beyond; it leaves most of a millisecond to a busy machine.
pub const ORGAN_SIZE: usize = 1000;
/// See [`ORGAN_SIZE`].
pub const ORGAN_TICK_INSTRUCTIONS: f64 = 3.3e6;

/// Young's modulus \[Pa\] and Poisson's ratio of the default body: those of a liver. Healthy ones have 4 to
/// 6 kPa by transient elastography (L. Sandrin and others, Ultrasound in Medicine and Biology 29, 2003, 1705 to
/// 1713), and are nearly incompressible.
pub const ORGAN_YOUNG_PA: f64 = 5000.0;
/// See [`ORGAN_YOUNG_PA`].
pub const ORGAN_POISSON: f64 = 0.45;

/// Bakes the default body of commands, an organ of [`ORGAN_SIZE`].
///
/// # Errors
/// As [`bake`].
pub fn organ() -> Result<ImageBytes> {
    organ_of(ORGAN_YOUNG_PA, ORGAN_POISSON)
}

/// Bakes the default body of another Young's modulus \[Pa\] and Poisson's ratio.
///
/// # Errors
/// As [`bake`].
pub fn organ_of(young_pa: f64, poisson: f64) -> Result<ImageBytes> {
    let mesh = load(&format!("organ:{ORGAN_SIZE}"), &MeshOptions::default())?;
    let of = PerCell::Uniform;
    let tissue = Some(Tissue::new(of(young_pa), of(poisson)));
    bake(&mesh, &mesh.default_fixed, &BakeOptions { tissue, ..BakeOptions::default() })
}

/// Bakes a checked mesh with the nodes `fixed` (input ids) held for ever.
///
/// # Errors
/// An option out of range, or a fixed node that is no cell.
pub fn bake(mesh: &Mesh, fixed: &[u32], options: &BakeOptions) -> Result<ImageBytes> {
    check(mesh, options)?;
    let plan = Plan::new(mesh, fixed, options)?;
    let body = lay_out(plan.net(), plan.fixed())?;
    lengths::check(&body)?;
    let image = write(&plan, &body, options)?;
    Model::from_bytes(image.as_bytes())
        .map_err(|why| Error::check(format!("the baked model is refused by the kernel: {why}")))?;
    Ok(image)
}

/// Checks the ranges of the options; an error names the option.
fn check(mesh: &Mesh, options: &BakeOptions) -> Result<()> {
    let each = |name: &str, value: &PerCell, holds: fn(f64) -> bool, range: &str| match value {
        PerCell::Uniform(value) if holds(*value) => Ok(()),
        PerCell::Uniform(value) => Err(Error::input(format!("{name} {value}: must be {range}"))),
        PerCell::Each(values) if values.len() != mesh.nodes_m.len() => Err(Error::input(format!(
            "{name}: {} values for {} nodes; give one per node of the input",
            values.len(),
            mesh.nodes_m.len()
        ))),
        PerCell::Each(values) => match values.iter().position(|&value| !holds(value)) {
            Some(at) => Err(Error::input(format!(
                "{name}: value {} of node {at}: must be {range}",
                values[at]
            ))),
            None => Ok(()),
        },
    };
    // Values of links.
    let positive = |value: f64| value > 0.0 && (value as f32).is_normal();
    each("`alpha`", &options.alpha, |a| (0.0..1.0).contains(&(a as f32)), "in [0, 1)")?;
    let stiffness = "above 0 and finite [N/m]";
    each("`stiffness_n_per_m`", &options.stiffness_n_per_m, positive, stiffness)?;
    // Tissue.
    if let Some(tissue) = &options.tissue {
        each("`young_pa`", &tissue.young_pa, positive, "above 0 and finite [Pa]")?;
        let ratios = |nu: f64| (0.0..=POISSON_MAX).contains(&nu);
        each("`poisson`", &tissue.poisson, ratios, "from 0 to 0.495")?;
        let stretch = PerCell::Uniform(tissue.stretch_min.unwrap_or(STRETCH_MIN));
        let stretches = |least: f64| (0.01..=0.95).contains(&least);
        each("`stretch_min`", &stretch, stretches, "from 0.01 to 0.95, or none")?;
        check_stiffening(&tissue.stiffening)?;
        check_shapes(options)?;
    }
    // The coarse level and the scalars of the body.
    if let BasisSpacing::Links(spacing) = options.coarse_basis
        && !(1.0..=1e6).contains(&spacing)
    {
        return Err(Error::input(format!(
            "`coarse_basis` {spacing}: must be at least 1 mean link length"
        )));
    }
    for (name, value) in
        [("`saturation_m`", options.saturation_m), ("`energy_max_j`", options.energy_max_j)]
    {
        if let Some(value) = value.filter(|&value| !positive(value)) {
            return Err(Error::input(format!("{name} {value}: must be above 0 and finite")));
        }
    }
    for (name, value) in
        [("`resistance`", options.resistance), ("`capacitance`", options.capacitance)]
    {
        if !(1e-11..=1e11).contains(&value) {
            return Err(Error::input(format!("{name} {value}: must be from 1e-11 to 1e11")));
        }
    }
    Ok(())
}

/// Checks that there are at most three bands, each with a different width.
fn check_stiffening(bands: &[Band]) -> Result<()> {
    if bands.len() > STIFFENING_MAX {
        let (given, most) = (bands.len(), STIFFENING_MAX);
        return Err(Error::input(format!("`stiffening`: {given} bands, at most {most}")));
    }
    for (at, band) in bands.iter().enumerate() {
        let Band { half_width, modulus_pa } = *band;
        if !(0.01..1.0).contains(&(half_width as f32)) {
            return Err(Error::input(format!(
                "`stiffening`: half-width {half_width}: must be from 0.01 to below 1"
            )));
        }
        if !(1e-3..=1e12).contains(&modulus_pa) {
            return Err(Error::input(format!(
                "`stiffening`: modulus {modulus_pa} of half-width {half_width}: must be from 1e-3 to \
                 1e12 [Pa]"
            )));
        }
        if bands[..at].iter().any(|other| other.half_width as f32 == half_width as f32) {
            return Err(Error::input(format!(
                "`stiffening`: half-width {half_width} twice: add up the moduli"
            )));
        }
    }
    Ok(())
}

/// Checks the options that nodal shapes exclude.
fn check_shapes(options: &BakeOptions) -> Result<()> {
    for (name, is_asked, why) in [
        ("alpha", options.alpha != PerCell::Uniform(0.0), "shapes have no slack"),
        ("lean", options.lean, "shapes need the links in slices"),
        ("cells", options.cells.is_some(), "groups of nodes are joined by links alone"),
    ] {
        if is_asked {
            return Err(Error::input(format!("`{name}` with `young_pa`: {why}; leave one out")));
        }
    }
    Ok(())
}

/// Chooses the frame and the order of the cells, and renumbers links and fixed nodes.
fn lay_out(mesh: &Mesh, fixed: &[u32]) -> Result<OrderedCells> {
    let mut used = vec![true; mesh.nodes_m.len()];
    for &node in &mesh.unused {
        used[node as usize] = false;
    }
    let nodes: Vec<u32> = (0..mesh.nodes_m.len() as u32).filter(|&id| used[id as usize]).collect();
    let mut valence = vec![0_u32; mesh.nodes_m.len()];
    for &node in mesh.links.as_flattened() {
        valence[node as usize] += 1;
    }
    // Number the cells.
    let order = order::by_place(&mesh.nodes_m, &valence, nodes);
    let mut cell_of = vec![u16::MAX; mesh.nodes_m.len()];
    for (cell, &node) in order.iter().enumerate() {
        cell_of[node as usize] = cell as u16;
    }
    let mut links: Vec<Link> = (mesh.links.iter().enumerate())
        .map(|(at, &[i, j])| {
            let (a, b) = (cell_of[i as usize], cell_of[j as usize]);
            ([a.min(b), a.max(b)], at)
        })
        .collect();
    links.sort_unstable();
    // Renumber the fixed nodes.
    let mut fixed_cells = Vec::with_capacity(fixed.len());
    for &node in fixed {
        match cell_of.get(node as usize) {
            Some(&cell) if cell != u16::MAX => fixed_cells.push(cell),
            _ => return Err(Error::input(format!("`fixed`: node {node} is no cell of the body"))),
        }
    }
    fixed_cells.sort_unstable();
    fixed_cells.dedup();
    // Rest positions in the frame.
    let (centre_m, unit_m) = frame(mesh, &order);
    let rest = order.iter().map(|&node| internal(mesh.nodes_m[node as usize], centre_m, unit_m));
    Ok(OrderedCells {
        rest: rest.collect(),
        node: order,
        cell_of,
        centre_m,
        unit_m,
        links,
        fixed: fixed_cells,
    })
}

/// Converts a position to mean link lengths from the centre.
fn internal(position_m: [f64; 3], centre_m: [f32; 3], unit_m: f32) -> [f32; 3] {
    // Adding +0.0 turns -0.0 into +0.0.
    std::array::from_fn(|axis| {
        ((position_m[axis] - f64::from(centre_m[axis])) / f64::from(unit_m)) as f32 + 0.0
    })
}

/// Returns the centre of the bounding box and the mean link length, in single precision, as all later
/// conversions use them.
fn frame(mesh: &Mesh, nodes: &[u32]) -> ([f32; 3], f32) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for &node in nodes {
        for (axis, &x) in mesh.nodes_m[node as usize].iter().enumerate() {
            low[axis] = low[axis].min(x);
            high[axis] = high[axis].max(x);
        }
    }
    let centre = [0, 1, 2].map(|axis| (0.5 * (low[axis] + high[axis])) as f32 + 0.0);
    let lengths = mesh.links.iter().map(|&[i, j]| {
        let (a, b) = (mesh.nodes_m[i as usize], mesh.nodes_m[j as usize]);
        (0..3).map(|axis| (b[axis] - a[axis]).powi(2)).sum::<f64>().sqrt()
    });
    let mean = lengths.sum::<f64>() / mesh.links.len() as f64;
    (centre, mean as f32)
}

/// Adjacency in the two halves that the kernel reads.
struct Adjacency {
    rows: Vec<u32>,
    back_rows: Vec<u32>,
    lower: Vec<u16>,
    back_link: Vec<u32>,
}

fn adjacency(cells: usize, links: &[Link]) -> Adjacency {
    let mut rows = vec![0_u32; cells + 1];
    let mut back_rows = vec![0_u32; cells + 1];
    for &([i, j], _) in links {
        rows[usize::from(i) + 1] += 1;
        back_rows[usize::from(j) + 1] += 1;
    }
    for cell in 0..cells {
        rows[cell + 1] += rows[cell];
        back_rows[cell + 1] += back_rows[cell];
    }
    let mut next = back_rows.clone();
    let (mut lower, mut back_link) = (vec![0; links.len()], vec![0; links.len()]);
    for (link, &([i, j], _)) in links.iter().enumerate() {
        let half = &mut next[usize::from(j)];
        lower[*half as usize] = i;
        back_link[*half as usize] = link as u32;
        *half += 1;
    }
    Adjacency { rows, back_rows, lower, back_link }
}

/// Returns W of every cell, added in ascending order of the other end, as in the kernel.
fn cell_weights(cells: usize, adjacency: &Adjacency, weight: &[f32]) -> Vec<f32> {
    let range = |rows: &[u32], cell: usize| rows[cell] as usize..rows[cell + 1] as usize;
    (0..cells)
        .map(|cell| {
            let below = range(&adjacency.back_rows, cell)
                .map(|half| weight[adjacency.back_link[half] as usize]);
            let above = range(&adjacency.rows, cell).map(|link| weight[link]);
            below.chain(above).fold(0.0, |sum, w| sum + w)
        })
        .collect()
}

/// 1 / W of the free cells, 0 of the others.
fn mobilities(body: &OrderedCells, weights: &[f32]) -> Vec<f32> {
    (weights.iter().enumerate())
        .map(|(cell, &w)| {
            let held = w == 0.0 || body.fixed.binary_search(&(cell as u16)).is_ok();
            if held { 0.0 } else { 1.0 / w }
        })
        .collect()
}

fn write(plan: &Plan<'_>, body: &OrderedCells, options: &BakeOptions) -> Result<ImageBytes> {
    use chaincell_kernel::image::kind;
    let (cells, links) = (body.rest.len(), &body.links);
    let at = |cell: u16| body.rest[usize::from(cell)];
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    // Bands, stiffness and weights of the links, or the nodal shapes.
    let (alphas, stiffness) = (plan.alpha(links), plan.stiffness(links));
    let shaped = |tissue| Shapes::new(plan.mesh(), body, tissue);
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
        None => cell_weights(cells, &adjacency, &weight),
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
    let params = image::params(nodes, body, options, &weights, largest, alpha, reference)?;
    sections.push(kind::PARAMS, &params);
    // Cells and links.
    sections.push(kind::REST, body.rest.as_flattened());
    sections.push(kind::ROWS, &adjacency.rows);
    sections.push(kind::UPPER, &links.iter().map(|(ends, _)| ends[1]).collect::<Vec<_>>());
    sections.push(kind::REST_LENGTH, &rest_lengths);
    sections.push(kind::BACK_ROWS, &adjacency.back_rows);
    sections.push(kind::LOWER, &adjacency.lower);
    sections.push(kind::BACK_LINK, &adjacency.back_link);
    sections.push(kind::MOBILITY, &mobility);
    sections.push(kind::FIXED, &body.fixed);
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
            shapes.push(&mut sections, &rows, &ids);
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

/// Adds the surface cells with normals, the triangles and, unless the image is lean, the other elements for
/// display.
fn surface(
    sections: &mut Sections,
    plan: &Plan<'_>,
    body: &OrderedCells,
    lean: bool,
    triangles: &[[u16; 3]],
) {
    use chaincell_kernel::image::kind;
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
