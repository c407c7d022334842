//! The model: everything about a body that never changes, read in place from its image.

use super::coarse_basis::CoarseBasis;
use super::embedded_mesh::EmbeddedMesh;
use super::image::{ModelError, Sections, kind, params};
use super::surface::ContactSurface;
use super::terms::{Others, TermData};
use super::validate;
use crate::number::float_env;
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
    pub(crate) notes: &'a [u8],
    pub(crate) embedded: Option<EmbeddedMesh<'a>>,
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

impl<'a> Model<'a> {
    /// Reads and checks an image in place. `bytes` must be the whole image and start at a multiple of 16
    /// ([`include_model!`](crate::include_model) does this).
    ///
    /// Cost: the checksum, about two sweeps and two reads of each element of the inverse of the coarse level,
    /// once; no memory.
    ///
    /// ```
    /// use chaincell_kernel::{Model, ModelError, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    ///
    /// assert!(Model::from_bytes(image).is_ok());
    /// let half = &image[..image.len() / 2];
    /// assert_eq!(Model::from_bytes(half).err(), Some(ModelError::Truncated));
    /// ```
    ///
    /// # Errors
    /// The first fault of the image, with section and position; or a fault of the calling thread's
    /// floating-point environment, on which the checks rely.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, ModelError> {
        float_env::check().map_err(ModelError::Float)?;
        // Parse the header and read the parameters.
        let sections = Sections::parse(bytes)?;
        let words: &[u32] = sections.sized(kind::PARAMS, params::WORDS)?;
        let word = |index: usize| words.get(index).copied().unwrap_or(0);
        let real = |index: usize| f32::from_bits(word(index));
        let (cells, links) = (word(params::CELLS) as usize, word(params::LINKS) as usize);
        let ends = cells.checked_add(1).ok_or(ModelError::Parameter(0))?;
        // Read the optional arrays over the links and the surface.
        let per_link = |kind| match sections.optional::<f32>(kind)? {
            Some(values) if values.len() != links => Err(ModelError::SectionSize(kind)),
            values => Ok(values),
        };
        let link_weights = per_link(kind::WEIGHT)?;
        let least = |least: f32, &w: &f32| if w < least { w } else { least };
        let surface = sections.optional(kind::SURFACE)?.unwrap_or(&[]);
        let normals = sections.optional(kind::NORMALS)?.unwrap_or(&[]);
        if normals.len() != surface.len() {
            return Err(ModelError::SectionSize(kind::NORMALS));
        }
        // Read all other sections.
        let model = Self {
            rest: sections.sized(kind::REST, cells)?,
            rows: sections.sized(kind::ROWS, ends)?,
            upper: sections.sized(kind::UPPER, links)?,
            rest_length: sections.sized(kind::REST_LENGTH, links)?,
            back_rows: sections.sized(kind::BACK_ROWS, ends)?,
            lower: sections.sized(kind::LOWER, links)?,
            back_link: sections.sized(kind::BACK_LINK, links)?,
            mobility: sections.sized(kind::MOBILITY, cells)?,
            fixed: sections.required(kind::FIXED)?,
            input_id: sections.sized(kind::INPUT_ID, cells)?,
            slices: slices(&sections, cells)?,
            coarse_basis: CoarseBasis::read(&sections, cells)?,
            link_alphas: per_link(kind::ALPHA)?,
            link_weights,
            weight_min: link_weights.map_or(1.0, |w| w.iter().fold(f32::MAX, least)),
            surface,
            normals,
            triangles: sections.optional(kind::TRIANGLES)?.unwrap_or(&[]),
            tetrahedra: sections.optional(kind::TETRAHEDRA)?.unwrap_or(&[]),
            contact: ContactSurface::read(&sections)?,
            notes: sections.optional(kind::NOTES)?.unwrap_or(&[]),
            embedded: EmbeddedMesh::read(&sections, word(params::INPUT_NODES) as usize)?,
            others: Others::read(&sections)?,
            dimension: word(params::DIMENSION),
            unit_m: real(params::UNIT_M),
            centre_m: [0, 1, 2].map(|axis| real(params::CENTRE_M + axis)),
            stiffness_n_per_m: real(params::STIFFNESS_N_PER_M),
            alpha: real(params::ALPHA),
            saturation: real(params::SATURATION),
            resistance: real(params::RESISTANCE),
            capacitance: real(params::CAPACITANCE),
            degree_bound: real(params::DEGREE_BOUND),
            energy_max: real(params::ENERGY_MAX),
            parts: word(params::PARTS),
            input_nodes: word(params::INPUT_NODES),
            checksum: sections.checksum,
        };
        // Check everything that the tick relies on.
        validate::model(&model)?;
        Ok(model)
    }
}

impl core::fmt::Debug for Model<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Model")
            .field("cells", &self.cells())
            .field("links", &self.links())
            .field("checksum", &self.checksum)
            .finish_non_exhaustive()
    }
}

/// Reads the sliced links of an image, `None` if it has none.
fn slices<'a>(sections: &Sections<'a>, cells: usize) -> Result<Option<Slices<'a>>, ModelError> {
    let Some(rows) = sections.optional::<u32>(kind::SLICE_ROWS)? else { return Ok(None) };
    if rows.len() != cells.div_ceil(LANES) + 1 {
        return Err(ModelError::SectionSize(kind::SLICE_ROWS));
    }
    let groups = rows.last().map_or(0, |&last| last as usize);
    let neighbours = sections.sized(kind::SLICE_NEIGHBOURS, groups)?;
    let lengths = sections.sized(kind::SLICE_LENGTHS, groups)?;
    let per_slot = |of: u32, slots: u32| match sections.optional::<f32>(of)? {
        Some(_) => sections.sized(slots, groups).map(Some),
        None => Ok(None),
    };
    Ok(Some(Slices {
        rows,
        neighbours,
        lengths,
        alphas: per_slot(kind::ALPHA, kind::SLICE_ALPHAS)?,
        weights: per_slot(kind::WEIGHT, kind::SLICE_WEIGHTS)?,
    }))
}
