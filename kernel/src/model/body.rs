//! The data of a body.

use super::coarse_basis::CoarseBasis;
use super::cuttable::Cuttable;
use super::embedded_mesh::EmbeddedMesh;
use super::opened::Opened;
use super::others::Others;
use crate::number::two_float::LANES;

/// A second copy of the links, in slices of [`LANES`] consecutive cells for vector units.
#[derive(Clone, Copy)]
pub(crate) struct Slices<'a> {
    /// Groups of each slice, slices + 1.
    pub rows: &'a [u32],
    /// Other ends, by group and lane.
    pub neighbours: &'a [[u16; LANES]],
    /// Rest lengths, by group and lane; 0 for padding.
    pub lengths: &'a [[f32; LANES]],
    /// Alpha, by group and lane, if links differ.
    pub alphas: Option<&'a [[f32; LANES]]>,
    /// Weights, by group and lane, if links differ; 1 for padding.
    pub weights: Option<&'a [[f32; LANES]]>,
}

#[cfg(feature = "relax")]
impl Slices<'_> {
    pub const NONE: Self =
        Self { rows: &[], neighbours: &[], lengths: &[], alphas: None, weights: None };
}

/// A validated body: mesh, links, bands, weights and bounds, borrowed from the image's bytes.
///
/// A value exists only if every index is in range and every number is fit for the tick.
///
/// ```
/// use chaincell_kernel::{Model, include_model};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
///
/// let model = Model::from_bytes(image)?;
/// assert_eq!((model.cells(), model.links(), model.fixed().len()), (81, 272, 32));
/// assert_eq!(model.stiffness_n_per_m(), 20.0); // [N/m], of one link
/// let length_m = 0.5 * (0.010 + 0.014142); // edges of 10 mm and nearly as many diagonals
/// assert!((model.unit_m() - length_m).abs() < 2.0e-4); // [m], the mean of all links
/// # Ok::<(), chaincell_kernel::ModelError>(())
/// ```
#[derive(Clone, Copy)]
pub struct Model<'a> {
    pub(crate) rest: &'a [[f32; 3]],
    pub(crate) rows: &'a [u32],
    pub(crate) upper: &'a [u16],
    pub(crate) rest_length: &'a [f32],
    pub(crate) back_rows: &'a [u32],
    pub(crate) lower: &'a [u16],
    pub(crate) back_link: &'a [u32],
    pub(crate) mobility: &'a [f32],
    pub(crate) fixed: &'a [u16],
    pub(crate) input_id: &'a [u32],
    pub(crate) slices: Option<Slices<'a>>,
    pub(crate) coarse_basis: Option<CoarseBasis<'a>>,
    pub(crate) link_alphas: Option<&'a [f32]>,
    pub(crate) link_weights: Option<&'a [f32]>,
    /// Smallest weight of a link.
    pub(crate) weight_min: f32,
    pub(crate) surface: &'a [u16],
    pub(crate) normals: &'a [[f32; 3]],
    pub(crate) triangles: &'a [[u16; 3]],
    pub(crate) tetrahedra: &'a [[u16; 4]],
    /// Contact numbers of the triangles, if tools may touch them.
    pub(crate) contact: Option<&'a [[f32; 3]]>,
    /// The last triangles, of faces that a cut has opened.
    pub(crate) opened: Opened<'a>,
    pub(crate) notes: &'a [u8],
    pub(crate) embedded: Option<EmbeddedMesh<'a>>,
    /// The tetrahedra that a blade may part.
    pub(crate) cuttable: Cuttable<'a>,
    /// Energy terms besides the links.
    pub(crate) others: Others<'a>,
    pub(crate) dimension: u32,
    pub(crate) unit_m: f32,
    pub(crate) centre_m: [f32; 3],
    pub(crate) stiffness_n_per_m: f32,
    pub(crate) alpha: f32,
    pub(crate) saturation: f32,
    pub(crate) resistance: f32,
    pub(crate) capacitance: f32,
    pub(crate) degree_bound: f32,
    pub(crate) energy_max: f32,
    pub(crate) parts: u32,
    pub(crate) input_nodes: u32,
    pub(crate) checksum: u32,
}
