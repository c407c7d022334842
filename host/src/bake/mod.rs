//! Makes a model image of a mesh: cells in an order that keeps neighbours close, links with their
//! bands and weights, the bounds that the kernel's proofs need.
//!
//! - `options`, `per_cell`: the options and their ranges; values that differ by node.
//! - `network`: the mesh itself, with links up to `--rings` edges long, or groups of its nodes.
//! - `groups`: `--cells N` puts the nodes of a mesh of up to 2,000,000 nodes into N groups, a cell
//!   each. A tick takes the time of N cells; every node follows the cells around it.
//! - `embedded`: those nodes in the image; `--lean` leaves them out, and all other data that only
//!   pictures, selectors and vector units need.
//! - `order`, `layout`, `adjacency`, `slices`: the order of the cells, their frame, neighbours and weights,
//!   and their links for vector units.
//! - `coarse_basis`: the coarse level of `track`, `--coarse`.
//! - `tissue`: Young's modulus and Poisson's ratio in place of links.
//! - `cutting`: tetrahedra by cell and spare cells, `--cuttable`.
//! - `contact`: the surface that tools touch, `--contact-surface`.
//! - `equivalent`: Young's modulus of the tissue to which links are equivalent.
//! - `notes`: node groups and border, for selectors.
//! - `image`, `scalars`, `sections`: the layout of the image, and what is written into it.

mod adjacency;
mod coarse_basis;
mod contact;
mod cutting;
mod embedded;
mod equivalent;
mod groups;
mod image;
mod layout;
mod lengths;
mod network;
mod notes;
mod options;
mod order;
mod per_cell;
mod scalars;
mod sections;
mod slices;
pub mod tissue;

use chaincell_kernel::Model;

pub use coarse_basis::BasisSpacing;
pub use cutting::{CUT_SPARE, Cuttable, TOUGHNESS_J_PER_M2};
pub use equivalent::Equivalent;
pub use groups::{Groups, partition};
pub use image::ImageBytes;
use network::Plan;
pub use notes::Notes;
pub use options::{BakeOptions, ContactSurface};
pub use per_cell::PerCell;
use tissue::{KnownTissue, Tissue, relaxation};

use crate::error::{Error, Result};
use crate::mesh::{Mesh, MeshOptions, load};

/// Size of the default body, and the instructions that its tick may take with AVX2: one sweep of `predict`
/// under a ball that is pressed in, with contact and state hash. `cargo bench -p chaincell-lab --bench sweep`
/// counts them, and fails beyond; it leaves most of a millisecond to a busy machine.
pub const ORGAN_SIZE: usize = 1000;
/// See [`ORGAN_SIZE`].
pub const ORGAN_TICK_INSTRUCTIONS: f64 = 3.3e6;

/// Tissue of the default body, by its name in the table of known ones, which has its source.
pub const ORGAN_TISSUE: &str = "liver";
/// Young's modulus \[Pa\] of that tissue; a test holds it and Poisson's ratio equal to the table's.
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
    organ_made_of(Tissue::new(PerCell::Uniform(young_pa), PerCell::Uniform(poisson)))
}

/// Bakes the default body of a tissue known by name, with its branches and bands, for sessions of 1,000 ticks a
/// second.
///
/// # Errors
/// As [`bake`].
pub fn organ_of_known(known: &KnownTissue) -> Result<ImageBytes> {
    let relaxation = relaxation(Some(known), None, false, false, None)?;
    let stiffening = known.stiffening.clone();
    let of = PerCell::Uniform;
    organ_made_of(Tissue {
        stiffening,
        relaxation,
        row: known.row(|_| false),
        ..Tissue::new(of(known.young_pa), of(known.poisson))
    })
}

/// Bakes the default body of a tissue.
fn organ_made_of(tissue: Tissue) -> Result<ImageBytes> {
    let mesh = load(&format!("organ:{ORGAN_SIZE}"), &MeshOptions::default())?;
    let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
    bake(&mesh, &mesh.default_fixed, &options)
}

/// Bakes a checked mesh with the nodes `fixed` (input ids) held for ever.
///
/// # Errors
/// An option out of range, or a fixed node that is no cell.
pub fn bake(mesh: &Mesh, fixed: &[u32], options: &BakeOptions) -> Result<ImageBytes> {
    options::check(mesh, options)?;
    let plan = Plan::new(mesh, fixed, options)?;
    let mut body = layout::lay_out(plan.net(), plan.fixed())?;
    lengths::check(&body)?;
    if let Some(cuttable) = &options.cuttable {
        body.spare = cuttable.spare_cells(body.rest.len())?;
    }
    let image = sections::write(&plan, &body, options)?;
    Model::from_bytes(image.as_bytes())
        .map_err(|why| Error::check(format!("the baked model is refused by the kernel: {why}")))?;
    Ok(image)
}
