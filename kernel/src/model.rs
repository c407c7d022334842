//! The model: everything about a body that never changes, read in place from its image.

use core::ops::Range;

use crate::fine::Fine;
use crate::hats::Hats;
use crate::image::{ModelError, Sections, kind, params, validate};
use crate::two_float::LANES;

/// The links once more, in slices of [`LANES`] consecutive cells for vector units.
#[derive(Clone, Copy)]
pub(crate) struct Slices<'a> {
    /// Groups of each slice, slices + 1.
    pub rows: &'a [u32],
    /// Other ends, by group and lane.
    pub neighbours: &'a [[u16; LANES]],
    /// Rest lengths, by group and lane; 0 for padding.
    pub lengths: &'a [[f32; LANES]],
    /// Alpha, by group and lane, where links differ.
    pub alphas: Option<&'a [[f32; LANES]]>,
    /// Weights, by group and lane, where links differ; 1 for padding.
    pub weights: Option<&'a [[f32; LANES]]>,
}

/// The free cells in colours, for schemes that move cells in place.
#[derive(Clone, Copy)]
pub(crate) struct Colours<'a> {
    /// Starts of the colours, colours + 1.
    pub rows: &'a [u32],
    /// Cells, colour by colour.
    pub cells: &'a [u16],
}

/// A validated body: mesh, links, bands, weights and bounds, borrowed from the image's bytes.
///
/// Its existence means that every index is in range and every number fit for the tick.
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
    pub(crate) hats: Option<Hats<'a>>,
    pub(crate) colours: Option<Colours<'a>>,
    pub(crate) link_alphas: Option<&'a [f32]>,
    pub(crate) link_weights: Option<&'a [f32]>,
    /// Smallest weight of a link.
    pub(crate) weight_min: f32,
    pub(crate) surface: &'a [u16],
    pub(crate) normals: &'a [[f32; 3]],
    pub(crate) triangles: &'a [[u16; 3]],
    pub(crate) tetrahedra: &'a [[u16; 4]],
    pub(crate) notes: &'a [u8],
    pub(crate) fine: Option<Fine<'a>>,
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
    /// Reads an image in place. `bytes` must start at a multiple of 16
    /// ([`include_model!`](crate::include_model) sees to it).
    ///
    /// Cost: the checksum, about two sweeps and two looks at each element of the hats' inverse,
    /// once; no memory.
    ///
    /// # Errors
    /// What is wrong with the image, with section and position.
    pub fn from_bytes(bytes: &'a [u8]) -> Result<Self, ModelError> {
        let sections = Sections::parse(bytes)?;
        let words: &[u32] = sections.sized(kind::PARAMS, params::WORDS)?;
        let word = |index: usize| words.get(index).copied().unwrap_or(0);
        let real = |index: usize| f32::from_bits(word(index));
        let (cells, links) = (word(params::CELLS) as usize, word(params::LINKS) as usize);
        let ends = cells.checked_add(1).ok_or(ModelError::Parameter(0))?;
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
            hats: Hats::read(&sections, cells)?,
            colours: colours(&sections)?,
            link_alphas: per_link(kind::ALPHA)?,
            link_weights,
            weight_min: link_weights.map_or(1.0, |w| w.iter().fold(f32::MAX, least)),
            surface,
            normals,
            triangles: sections.optional(kind::TRIANGLES)?.unwrap_or(&[]),
            tetrahedra: sections.optional(kind::TETRAHEDRA)?.unwrap_or(&[]),
            notes: sections.optional(kind::NOTES)?.unwrap_or(&[]),
            fine: Fine::read(&sections, word(params::INPUT_NODES) as usize)?,
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
        validate::model(&model)?;
        Ok(model)
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.rest.len()
    }

    /// Number of links.
    #[must_use]
    pub fn links(&self) -> usize {
        self.upper.len()
    }

    /// Dimension of the grid, 1 to 3.
    #[must_use]
    pub fn dimension(&self) -> u32 {
        self.dimension
    }

    /// Number of connected parts.
    #[must_use]
    pub fn parts(&self) -> u32 {
        self.parts
    }

    /// Checksum of the image; it tells models apart.
    #[must_use]
    pub fn checksum(&self) -> u32 {
        self.checksum
    }

    /// Mean link length, the kernel's internal unit of length \[m\].
    #[must_use]
    pub fn unit_m(&self) -> f32 {
        self.unit_m
    }

    /// The body's centre, origin of the internal frame \[m\].
    #[must_use]
    pub fn centre_m(&self) -> [f32; 3] {
        self.centre_m
    }

    /// Stiffness of a link of weight 1 [N/m].
    #[must_use]
    pub fn stiffness_n_per_m(&self) -> f32 {
        self.stiffness_n_per_m
    }

    /// Half-width of the links' band in rest lengths (Eq. 5); the mean where links differ.
    #[must_use]
    pub fn alpha(&self) -> f32 {
        self.alpha
    }

    /// Saturation K of the output (Eq. 3) [mean link lengths].
    #[must_use]
    pub fn saturation(&self) -> f32 {
        self.saturation
    }

    /// Cell resistance `R_x` (Eq. 2).
    #[must_use]
    pub fn resistance(&self) -> f32 {
        self.resistance
    }

    /// Cell capacitance C (Eq. 2).
    #[must_use]
    pub fn capacitance(&self) -> f32 {
        self.capacitance
    }

    /// Largest proven common step of `euler`, 2 C / b with b the largest (`W_i` + `W_j`) / 2 over
    /// the links, and at most `R_x` C [dimensionless time].
    #[must_use]
    pub fn step_max(&self) -> f32 {
        let links = 2.0 * self.capacitance / self.degree_bound;
        let leak = self.resistance * self.capacitance;
        if leak < links { leak } else { links }
    }

    /// Largest energy a tool may load into the body, in internal units
    /// (times [`Self::energy_unit_j`] in joules).
    #[must_use]
    pub fn energy_max(&self) -> f32 {
        self.energy_max
    }

    /// Newtons per internal unit of force, 2 `k_ref` times the mean link length.
    #[must_use]
    pub fn force_unit_n(&self) -> f32 {
        2.0 * self.stiffness_n_per_m * self.unit_m
    }

    /// Joules per internal unit of energy, 2 `k_ref` times the mean link length squared.
    #[must_use]
    pub fn energy_unit_j(&self) -> f32 {
        self.force_unit_n() * self.unit_m
    }

    /// Fixed-state cells, ascending.
    #[must_use]
    pub fn fixed(&self) -> &'a [u16] {
        self.fixed
    }

    /// Whether a cell's state is fixed.
    #[must_use]
    pub fn is_fixed(&self, cell: u16) -> bool {
        self.fixed.binary_search(&cell).is_ok()
    }

    /// Surface cells, ascending; empty where the bake stored none.
    #[must_use]
    pub fn surface(&self) -> &'a [u16] {
        self.surface
    }

    /// Outward unit normals of the surface cells, in their order.
    #[must_use]
    pub fn normals(&self) -> &'a [[f32; 3]] {
        self.normals
    }

    /// Surface triangles for display, as cells, outward.
    #[must_use]
    pub fn triangles(&self) -> &'a [[u16; 3]] {
        self.triangles
    }

    /// Tetrahedra for display, as cells.
    #[must_use]
    pub fn tetrahedra(&self) -> &'a [[u16; 4]] {
        self.tetrahedra
    }

    /// What the host noted at the bake; empty where it noted nothing.
    #[must_use]
    pub fn notes(&self) -> &'a [u8] {
        self.notes
    }

    /// Input id of each cell; in a model with fine nodes, the node that the cell stands at.
    #[must_use]
    pub fn input_id(&self) -> &'a [u32] {
        self.input_id
    }

    /// The cell of an input id; `None` for a node that is no cell. Looks through all cells. In a
    /// model with fine nodes, the cell whose group holds the node, at once: several ids may have
    /// one cell.
    #[must_use]
    pub fn cell_of_input(&self, id: u32) -> Option<u16> {
        if let Some(fine) = self.fine {
            return fine.own_cell(id as usize);
        }
        let cell = self.input_id.iter().position(|&other| other == id)?;
        u16::try_from(cell).ok()
    }

    /// Number of nodes of the input's numbering.
    #[must_use]
    pub fn input_nodes(&self) -> u32 {
        self.input_nodes
    }

    /// Number of slices of eight consecutive cells.
    #[inline(always)]
    pub(crate) fn slice_count(&self) -> usize {
        self.cells().div_ceil(LANES)
    }

    /// Number of hat functions of the coarse level, 0 without one.
    #[must_use]
    pub fn hats(&self) -> usize {
        self.hats.map_or(0, |hats| hats.count)
    }

    /// Number of colours, 0 where the bake stored none.
    #[must_use]
    pub fn colours(&self) -> usize {
        self.colours.map_or(0, |colours| colours.rows.len().saturating_sub(1))
    }

    /// Whether the links are stored once more in slices for vector units.
    #[must_use]
    pub fn is_sliced(&self) -> bool {
        self.slices.is_some()
    }

    /// Whether alpha is stored for each link.
    #[must_use]
    pub fn alpha_varies(&self) -> bool {
        self.link_alphas.is_some()
    }

    /// Whether the stiffness is stored for each link.
    #[must_use]
    pub fn weight_varies(&self) -> bool {
        self.link_weights.is_some()
    }

    /// Upper ends of all links, row by row.
    #[must_use]
    pub fn upper(&self) -> &'a [u16] {
        self.upper
    }

    /// Rest lengths of all links [mean link lengths].
    #[must_use]
    pub fn rest_lengths(&self) -> &'a [f32] {
        self.rest_length
    }

    /// Rest position of a cell [mean link lengths from the centre]; zero beyond the last.
    #[must_use]
    #[inline]
    pub fn rest_position(&self, cell: usize) -> [f32; 3] {
        self.rest.get(cell).copied().unwrap_or([0.0; 3])
    }

    /// The links of `cell` as their lower end.
    #[must_use]
    #[inline]
    pub fn row(&self, cell: usize) -> Range<usize> {
        range(self.rows, cell)
    }

    /// The half-links of `cell` as their upper end.
    #[inline]
    pub(crate) fn back_row(&self, cell: usize) -> Range<usize> {
        range(self.back_rows, cell)
    }

    /// Alpha of a link.
    #[must_use]
    #[inline]
    pub fn link_alpha(&self, link: usize) -> f32 {
        self.link_alphas.and_then(|alphas| alphas.get(link).copied()).unwrap_or(self.alpha)
    }

    /// Weight k / `k_ref` of a link.
    #[must_use]
    #[inline]
    pub fn link_weight(&self, link: usize) -> f32 {
        self.link_weights.and_then(|weights| weights.get(link).copied()).unwrap_or(1.0)
    }

    /// The links of a cell with their other ends, in ascending order of the other end.
    pub fn neighbours(&self, cell: usize) -> impl Iterator<Item = (usize, usize)> + use<'a> {
        let (lower, back_link, upper) = (self.lower, self.back_link, self.upper);
        let below = self.back_row(cell).filter_map(move |half| {
            Some((*back_link.get(half)? as usize, usize::from(*lower.get(half)?)))
        });
        let above =
            self.row(cell).filter_map(move |link| Some((link, usize::from(*upper.get(link)?))));
        below.chain(above)
    }

    /// W: sum of the weights of a cell's links, in ascending order of their other ends.
    #[must_use]
    pub fn cell_weight(&self, cell: usize) -> f32 {
        self.neighbours(cell).fold(0.0, |sum, (link, _)| sum + self.link_weight(link))
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

/// The sliced links of an image, where it has them.
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

/// The colours of an image, where it has them.
fn colours<'a>(sections: &Sections<'a>) -> Result<Option<Colours<'a>>, ModelError> {
    let Some(rows) = sections.optional(kind::COLOUR_ROWS)? else { return Ok(None) };
    Ok(Some(Colours { rows, cells: sections.required(kind::COLOUR_CELLS)? }))
}

/// `rows[at]..rows[at + 1]`, empty beyond the end.
#[inline]
pub(crate) fn range(rows: &[u32], at: usize) -> Range<usize> {
    match rows.get(at..).and_then(|rows| rows.first_chunk()) {
        Some(&[start, end]) => start as usize..end as usize,
        None => 0..0,
    }
}

/// Links a model image into flash with the alignment that [`Model::from_bytes`] asks for.
///
/// The path is relative to the file the macro stands in. Gives a `&'static [u8]`.
#[macro_export]
macro_rules! include_model {
    ($path:expr $(,)?) => {{
        #[repr(C, align(16))]
        struct Aligned<Bytes: ?Sized>(Bytes);
        static IMAGE: &Aligned<[u8]> = &Aligned(*include_bytes!($path));
        &IMAGE.0
    }};
}
