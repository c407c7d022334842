//! Reads a model in place from its image.

use super::body::{Model, Slices};
use super::coarse_basis::CoarseBasis;
use super::cuttable::Cuttable;
use super::embedded_mesh::EmbeddedMesh;
use super::image::{ModelError, Sections, cutting, kind, params};
use super::opened::Opened;
use super::others::Others;
use super::surface::ContactSurface;
use super::terms::TermData;
use super::validate;
use crate::number::float_env;
use crate::number::two_float::LANES;

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
        // Read all other sections; spare cells have no input id.
        let cuttable = Cuttable::read(&sections, cells)?;
        let spare_cells = ModelError::Value(kind::CUTTING, cutting::SPARE_CELLS as u32);
        let bodily = cells.checked_sub(cuttable.spare_cells()).ok_or(spare_cells)?;
        // A torn body stretches too far for the elasticity of its rest shape.
        let has_sides = cuttable.is_any() && cuttable.tear_limit().is_none();
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
            input_id: sections.sized(kind::INPUT_ID, bodily)?,
            slices: slices(&sections, cells)?,
            coarse_basis: CoarseBasis::read(&sections, cells, has_sides)?,
            link_alphas: per_link(kind::ALPHA)?,
            link_weights,
            weight_min: link_weights.map_or(1.0, |w| w.iter().fold(f32::MAX, least)),
            surface,
            normals,
            triangles: sections.optional(kind::TRIANGLES)?.unwrap_or(&[]),
            tetrahedra: sections.optional(kind::TETRAHEDRA)?.unwrap_or(&[]),
            contact: ContactSurface::read(&sections)?,
            opened: Opened::NONE,
            notes: sections.optional(kind::NOTES)?.unwrap_or(&[]),
            embedded: EmbeddedMesh::read(&sections, word(params::INPUT_NODES) as usize)?,
            cuttable,
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
