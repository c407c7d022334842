//! Memory of the caller for cutting and for relaxation, and its division into the arrays of a body that is cut.

#[cfg(feature = "cut")]
use super::renewal::Renewal;
use crate::model::Model;
#[cfg(feature = "cut")]
use crate::model::lips::LipNumbers;
#[cfg(feature = "cut")]
use crate::model::loose::Loose;
#[cfg(feature = "cut")]
use crate::model::nodal::{CellNumbers, OffsetNumbers, SlotNumbers};
#[cfg(feature = "cut")]
use crate::model::others;
#[cfg(feature = "cut")]
use crate::number::two_float::{Eight, LANES};
#[cfg(feature = "cut")]
use crate::number::words::{Double, take};
#[cfg(feature = "relax")]
use crate::relax::memory;

/// 1 in a kernel that cuts, so that arrays of this length have no size in another.
const BUILT: usize = cfg!(any(feature = "cut", feature = "relax")) as usize;

/// Memory for cutting a body, or for the strain that a body remembers: words of the caller, [`cut_words`] for a body;
/// without size in a kernel without the features `cut` and `relax`.
///
/// ```
/// use chaincell_kernel::{Model, CutRoom, cut_words, include_model};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// let model = Model::from_bytes(image)?;
///
/// let mut words = vec![0; cut_words(&model)];
/// let memory = CutRoom::new(&mut words); // for the field `cut` of a `TissueMut`
/// assert!(words.is_empty()); // this body has no tetrahedra to part
/// # Ok::<(), chaincell_kernel::ModelError>(())
/// ```
pub struct CutRoom<'a>([&'a mut [u32]; BUILT]);

impl<'a> CutRoom<'a> {
    /// Memory in these words; a body for which they are too few stays whole.
    #[must_use]
    pub fn new(words: &'a mut [u32]) -> Self {
        let mut words = Some(words);
        Self([(); BUILT].map(|()| words.take().unwrap_or_default()))
    }

    /// No memory: a body stays whole.
    #[must_use]
    pub fn none() -> Self {
        Self([(); BUILT].map(|()| &mut [][..]))
    }

    /// The same memory, for a shorter lifetime.
    #[must_use]
    pub fn reborrow(&mut self) -> CutRoom<'_> {
        CutRoom(self.0.each_mut().map(|words| &mut **words))
    }
}

impl Default for CutRoom<'_> {
    fn default() -> Self {
        Self::none()
    }
}

/// Number of words of [`CutRoom`] with which a body can be cut, or relaxes; 0 for one that does neither.
///
/// One of shapes that relaxes takes 40 bytes a cell, and 36 for each branch; one of links 8 bytes a half-link, and 4
/// for each branch. One that can be cut takes 360 to 430 bytes a cell, in a body of links too: the half-links, a copy
/// of which changes, are most of it. Stiffening bands take 100 to 130 bytes a cell more. Each spare cell takes 88
/// bytes more for lips, and with a contact surface 208 more. A coarse level of n functions, 24 or more, takes
/// 1,200 n + 40,000 bytes and 29 a cell for up to 32 functions on one side of a cut.
#[must_use]
pub fn cut_words(model: &Model<'_>) -> usize {
    #[cfg(feature = "relax")]
    if let Some(sizes) = memory::sizes(model) {
        return sizes.iter().sum();
    }
    #[cfg(feature = "cut")]
    if let Some(Sizes(sizes)) = Sizes::of(model) {
        return sizes.iter().sum();
    }
    let _ = model;
    0
}

/// Most triangles that the surface of a body can have, however it is cut: capacity for those of
/// [`TissueMut::triangles`](crate::TissueMut::triangles).
///
/// ```
/// use chaincell_kernel::{Model, include_model, triangles_max};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// let model = Model::from_bytes(image)?;
/// assert_eq!(triangles_max(&model), model.triangles().len()); // this body cannot be cut
/// # Ok::<(), chaincell_kernel::ModelError>(())
/// ```
#[must_use]
pub fn triangles_max(model: &Model<'_>) -> usize {
    #[cfg(feature = "cut")]
    let of_faces = places(model);
    #[cfg(not(feature = "cut"))]
    let of_faces = 0;
    model.triangles.len() + of_faces
}

/// Words of the state of the cuts or of the remembered strain in memory for them; `None` for a body that is whole and
/// elastic.
///
/// ```
/// use chaincell_kernel::{Model, cut_state, include_model};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// let model = Model::from_bytes(image)?;
/// assert!(cut_state(&[], &model).is_none());
/// # Ok::<(), chaincell_kernel::ModelError>(())
/// ```
#[must_use]
pub fn cut_state<'w>(words: &'w [u32], model: &Model<'_>) -> Option<&'w [u32]> {
    #[cfg(feature = "relax")]
    if let Some(state) = memory::state(words, model) {
        return Some(state);
    }
    #[cfg(feature = "cut")]
    if let Some(Sizes(sizes)) = Sizes::of(model) {
        let words = words.get(..sizes.iter().sum())?.get(..sizes.iter().take(STATE).sum())?;
        return words.get(OPENED).is_some_and(|&opened| opened > 0).then_some(words);
    }
    let _ = (words, model);
    None
}

/// Arrays of a body that is cut: first its state, then the numbers that follow from state and image.
#[cfg(feature = "cut")]
pub(crate) struct Arrays<'a> {
    pub counts: &'a mut Counts,
    /// Cells of each tetrahedron.
    pub corners: &'a mut [[u16; 4]],
    /// Opened faces of each tetrahedron: bit k for the face opposite to corner k.
    pub faces: &'a mut [u8],
    /// 1 for a cell that waits for a look at its tetrahedra, else 0.
    pub marks: &'a mut [u8],
    /// Cell of the image from which each spare cell was copied.
    pub origins: &'a mut [u16],
    /// Groups of half-links of each slice, slices + 1.
    pub rows: &'a mut [u32],
    /// 1 for each slice with an offset.
    pub is_offset: &'a mut [u8],
    /// Offsets of the cells, by slice.
    pub offsets: &'a mut [OffsetNumbers],
    /// Normal of the lip in each place, times the root of its share.
    pub normals: &'a mut [[f32; 3]],
    /// Words of a body that tears, [`TEAR_WORDS`], else none.
    pub tear: &'a mut [u32],
    /// Where the renewal of the two-sided functions is; none in a body without them.
    pub renewal: &'a mut [Renewal],
    /// 1 for each cell of a loose piece; none in a body whose image leaves them.
    pub loose: &'a mut [u8],
    /// Work of the blades in internal units; none in a body of one toughness, where it is that times the swept area.
    pub work: &'a mut [Double],
    /// Numbers of the cells, by slice.
    pub cells: &'a mut [CellNumbers],
    /// Numbers of the half-links, by group.
    pub slots: &'a mut [SlotNumbers],
    /// Other ends of the half-links, by group and lane.
    pub ids: &'a mut [[u16; LANES]],
    /// Rest positions.
    pub rest: &'a mut [[f32; 3]],
    /// Inverse bounds of the cells.
    pub mobility: &'a mut [f32],
    /// Factors of an elastic coarse level.
    pub factors: &'a mut [f32],
    /// Place of each cell in the pairs of the coarse level.
    pub entry: &'a mut [u16],
    /// Pairs of each box, boxes + 1.
    pub box_rows: &'a mut [u32],
    /// Cells of the pairs.
    pub pairs: &'a mut [[u16; 2]],
    /// Weights of the pairs.
    pub weights: &'a mut [[Eight; 2]],
    /// Triangles of the surface, then places for those of opened faces.
    pub triangles: &'a mut [[u16; 3]],
    /// Name of the triangle in each of these places, and the place of the face's other side.
    pub names: &'a mut [[u32; 2]],
    /// Contact numbers of the triangle in each place.
    pub numbers: &'a mut [[f32; 3]],
    /// Number of places taken, and of faces without one.
    pub listed: &'a mut [u32; 2],
    /// Cells of the lip in each place.
    pub lip_cells: &'a mut [[u16; 2]],
    /// Its numbers, 0 in a free place.
    pub lip_numbers: &'a mut [LipNumbers],
    /// Range of each slice in the ends of the lips, slices + 1.
    pub lip_rows: &'a mut [u32],
    /// The lips at each of their cells.
    pub ends: &'a mut [u32],
    /// Strength of each cell of the image of a body that tears.
    pub strengths: &'a mut [f32],
    /// The cell whose rotation each two-sided function takes.
    pub turns: &'a mut [u16],
    /// Side of a cut on which each cell lies, with marks.
    pub labels: &'a mut [u8],
    /// The two-sided function at each corner of a cell's box.
    pub side_rows: &'a mut [[u8; LANES]],
    /// Cells under these functions.
    pub side_cells: &'a mut [u16],
    /// Columns of Y, and a further one as scratch.
    pub columns: &'a mut [Eight],
    /// Another cell of each one's side, while sides are joined.
    pub parents: &'a mut [u16],
    /// Displacements of the cells, and pushes on them, for one column.
    pub lengths: &'a mut [f32],
    pub pushes: &'a mut [[f32; 3]],
    /// The cell that stands for each one's piece, and the number of cells of a loose piece at that, while pieces are
    /// found.
    pub roots: &'a mut [u16],
    pub sizes: &'a mut [u16],
    pub links: LinkArrays<'a>,
    pub bands: BandArrays<'a>,
}

/// The stiffening bands of the half-links, by group and lane, which follow from state and image; empty in a body
/// without bands.
#[cfg(feature = "cut")]
pub(crate) struct BandArrays<'a> {
    /// 2 V / l0^2, V the volume of the tetrahedra around the link; 0 for padding.
    pub volumes: &'a mut [Eight],
    /// Rest lengths; 0 for padding.
    pub lengths: &'a mut [Eight],
}

/// Arrays of a body of links, all of which follow from state and image; empty in a body of shapes.
#[cfg(feature = "cut")]
pub(crate) struct LinkArrays<'a> {
    /// Rest lengths of the half-links, by group and lane; 0 for padding.
    pub lengths: &'a mut [Eight],
    /// Their weights; 1 for padding.
    pub weights: &'a mut [Eight],
    /// The half-widths of their bands; none if links do not differ in them.
    pub alphas: &'a mut [Eight],
    /// The links of each cell as their lower end, cells + 1.
    pub rows: &'a mut [u32],
    /// Numbers of each link: its upper end, rest length, weight and half-width of its band.
    pub upper: &'a mut [u16],
    pub link_lengths: &'a mut [f32],
    pub link_weights: &'a mut [f32],
    pub link_alphas: &'a mut [f32],
    /// The links of each cell as their upper end, cells + 1.
    pub back_rows: &'a mut [u32],
    /// Lower end and number of each of these.
    pub lower: &'a mut [u16],
    pub back_link: &'a mut [u32],
    /// Young's modulus of each cell of the image [2 `k_ref` / l].
    pub young: &'a mut [f32],
    /// Area of the lip in each place as it is in this tick.
    pub lip_areas: &'a mut [[f32; 3]],
}

/// Words of [`Counts`].
#[cfg(feature = "cut")]
pub(super) const COUNTS: usize = 6;

/// Counts of a body that is cut; the last two words are the swept area [mean link lengths^2], a `Double`.
#[cfg(feature = "cut")]
pub(crate) type Counts = [u32; COUNTS];
/// Index of the number of spare cells in use.
#[cfg(feature = "cut")]
pub(crate) const USED: usize = 0;
/// Index of the number of opened faces.
#[cfg(feature = "cut")]
pub(crate) const OPENED: usize = 1;
/// Index of the number of refused splits.
#[cfg(feature = "cut")]
pub(crate) const REFUSED: usize = 2;
/// Index of the number of cells that wait.
#[cfg(feature = "cut")]
pub(crate) const WAITING: usize = 3;

/// Words of a body that tears.
#[cfg(feature = "cut")]
const TEAR_WORDS: usize = 3;
/// Index of the number of torn cells.
#[cfg(feature = "cut")]
pub(crate) const TORN: usize = 0;
/// Index of the turn of the slices that the next tick looks at.
#[cfg(feature = "cut")]
pub(super) const TURN: usize = 1;
/// Index of the bits of the energy that the decay of offsets may use, in internal units (`f32`).
#[cfg(feature = "cut")]
pub(super) const CREDIT: usize = 2;

/// Places for triangles of opened faces for each spare cell. A cut that doubles n cells parts about 2 n faces, at its
/// front some more.
#[cfg(feature = "cut")]
const PLACES: usize = 8;

/// Places for lips of each spare cell.
#[cfg(feature = "cut")]
pub(super) const LIPS: usize = 2;

/// Number of places for triangles of opened faces, none for a body that tools do not touch.
#[cfg(feature = "cut")]
fn places(model: &Model<'_>) -> usize {
    if model.has_contact_surface() { PLACES * model.cuttable().spare_cells } else { 0 }
}

/// Number of places for lips.
#[cfg(feature = "cut")]
fn lips(model: &Model<'_>) -> usize {
    LIPS * model.cuttable().spare_cells
}

/// Most two-sided functions.
#[cfg(feature = "cut")]
fn sides(model: &Model<'_>) -> usize {
    model.coarse_basis.map_or(0, |basis| basis.side_blocks() / 3 * LANES)
}

/// Blocks of a column of Y.
#[cfg(feature = "cut")]
fn column(model: &Model<'_>) -> usize {
    model.coarse_basis.map_or(0, |basis| basis.row_blocks() + basis.side_blocks())
}

/// Groups of half-links in the image.
#[cfg(feature = "cut")]
#[derive(Clone, Copy)]
pub(super) struct ImageGroups<'m> {
    /// Those of each slice, slices + 1.
    pub rows: &'m [u32],
    /// Other ends, by group and lane.
    pub ids: &'m [[u16; LANES]],
}

/// The groups of half-links in the image of a body that can be cut.
#[cfg(feature = "cut")]
pub(super) fn image_groups<'m>(model: &Model<'m>) -> ImageGroups<'m> {
    let slices = model.slices.as_ref();
    let rows = slices.map_or(&[][..], |slices| slices.rows);
    ImageGroups { rows, ids: slices.map_or(&[], |slices| slices.neighbours) }
}

/// Arrays of the state: those before this index.
#[cfg(feature = "cut")]
const STATE: usize = 13;

/// Arrays of every body, and those of links and bands after them.
#[cfg(feature = "cut")]
const BODY_ARRAYS: usize = 42;
#[cfg(feature = "cut")]
const LINK_ARRAYS: usize = 15;

/// Words of each array, in their order.
#[cfg(feature = "cut")]
struct Sizes([usize; BODY_ARRAYS + LINK_ARRAYS]);

#[cfg(feature = "cut")]
impl Sizes {
    /// `None` for a body that is not cut.
    fn of(model: &Model<'_>) -> Option<Self> {
        let cut = Some(model.cuttable()).filter(|cut| cut.is_any())?;
        let (cells, slices, basis) = (model.cells(), model.slice_count(), model.coarse_basis);
        let groups = image_groups(model).ids.len() + cut.spare_groups;
        let pairs = basis.map_or(0, |basis| basis.cells.len() + cut.spare_cells);
        let cells_of = |is_any: bool| if is_any { cells } else { 0 };
        let of_tears = |words: usize| if cut.tear_limit.is_some() { words } else { 0 };
        let (sides, of_sides) =
            (sides(model), |words: usize| if sides(model) > 0 { words } else { 0 });
        let of_loose = |words: usize| if cut.loose == Loose::Leave { 0 } else { words };
        let of_shapes = |words: usize| if model.is_nodal() { words } else { 0 };
        let mut sizes = [0; BODY_ARRAYS + LINK_ARRAYS];
        let (body, links) = sizes.split_first_chunk_mut::<BODY_ARRAYS>()?;
        *links.first_chunk_mut()? = Self::of_links(model, groups);
        *body = [
            COUNTS,
            2 * cut.corners.len(),
            cut.corners.len().div_ceil(4),
            cells.div_ceil(4),
            cut.spare_cells.div_ceil(2),
            slices + 1,
            of_shapes(slices.div_ceil(4)),
            of_shapes(slices * size_of::<OffsetNumbers>() / 4),
            3 * lips(model),
            of_tears(TEAR_WORDS),
            of_sides(size_of::<Renewal>() / 4),
            of_loose(cells.div_ceil(4)),
            if cut.cell_toughness.is_empty() { 0 } else { size_of::<Double>() / 4 },
            of_shapes(slices * size_of::<CellNumbers>() / 4),
            of_shapes(groups * size_of::<SlotNumbers>() / 4),
            groups * LANES / 2,
            3 * cells,
            cells,
            cells_of(basis.is_some_and(|basis| basis.elastic().is_some())),
            cells_of(basis.is_some()).div_ceil(2),
            basis.map_or(0, |basis| basis.rows.len()),
            pairs,
            pairs * 2 * LANES,
            (3 * (model.triangles.len() + places(model))).div_ceil(2),
            2 * places(model),
            3 * places(model),
            2,
            lips(model),
            lips(model) * size_of::<LipNumbers>() / 4,
            slices + 1,
            2 * lips(model),
            of_tears(cells - cut.spare_cells),
            sides.div_ceil(2),
            of_sides(cells.div_ceil(4)),
            of_sides(2 * cells),
            of_sides(cells.div_ceil(2)),
            of_sides((3 * sides + 1) * column(model) * LANES),
            of_sides(cells.div_ceil(2)),
            of_sides(cells),
            of_sides(3 * cells),
            of_loose(cells.div_ceil(2)),
            of_loose(cells.div_ceil(2)),
        ];
        Some(Self(sizes))
    }

    /// Those of the arrays of links and bands in this many groups of half-links.
    fn of_links(model: &Model<'_>, groups: usize) -> [usize; LINK_ARRAYS] {
        let cells = model.cells();
        let of_links = |words: usize| if model.is_nodal() { 0 } else { words };
        let of_alphas = |words: usize| if model.alpha_varies() { of_links(words) } else { 0 };
        let has_bands = others::bands(&model.others).is_any();
        let of_bands = |words: usize| if has_bands { words } else { 0 };
        // Every link takes two of the half-links.
        let (halves, links) = (groups * LANES, groups * LANES / 2);
        [
            of_links(halves),
            of_links(halves),
            of_alphas(halves),
            of_links(cells + 1),
            of_links(links.div_ceil(2)),
            of_links(links),
            of_links(links),
            of_alphas(links),
            of_links(cells + 1),
            of_links(links.div_ceil(2)),
            of_links(links),
            of_links(model.body_cells()),
            of_links(3 * lips(model)),
            of_bands(halves),
            of_bands(halves),
        ]
    }
}

#[cfg(any(feature = "cut", feature = "relax"))]
impl CutRoom<'_> {
    /// The words of the caller.
    pub(crate) fn words(&self) -> &[u32] {
        self.0.first().map_or(&[], |words| words)
    }

    /// The words of the caller, to be changed.
    #[cfg(feature = "relax")]
    pub(crate) fn words_mut(&mut self) -> &mut [u32] {
        self.0.first_mut().map_or(&mut [], |words| words)
    }
}

#[cfg(feature = "cut")]
impl<'a> CutRoom<'a> {
    /// The words of the state; `None` for a body that is not cut, or with too little memory.
    pub(crate) fn state(&self, model: &Model<'_>) -> Option<&[u32]> {
        let Sizes(sizes) = Sizes::of(model)?;
        let words = self.0.first()?.get(..sizes.iter().sum())?;
        words.get(..sizes.iter().take(STATE).sum())
    }

    /// The arrays of a body; `None` for one that is not cut, or with too little memory.
    pub(crate) fn arrays(&mut self, model: &Model<'_>) -> Option<Arrays<'_>> {
        let Sizes(sizes) = Sizes::of(model)?;
        let mut rest = &mut **self.0.first_mut()?;
        let rest = &mut rest;
        let (cells, spare) = (model.cells(), model.cuttable().spare_cells);
        let tetrahedra = model.cuttable().corners.len();
        let has_basis = model.coarse_basis.is_some();
        let sides = sides(model);
        let of_sides = if sides > 0 { cells } else { 0 };
        let of_loose = if model.cuttable().loose == Loose::Leave { 0 } else { cells };
        let shaped_slices = if model.is_nodal() { model.slice_count() } else { 0 };
        let mut sizes = sizes.into_iter();
        Some(Arrays {
            counts: take::<u32>(rest, sizes.next()?)?.first_chunk_mut()?,
            corners: take(rest, sizes.next()?)?,
            faces: take(rest, sizes.next()?)?.get_mut(..tetrahedra)?,
            marks: take(rest, sizes.next()?)?.get_mut(..cells)?,
            origins: take(rest, sizes.next()?)?.get_mut(..spare)?,
            rows: take(rest, sizes.next()?)?,
            is_offset: take(rest, sizes.next()?)?.get_mut(..shaped_slices)?,
            offsets: take(rest, sizes.next()?)?,
            normals: take(rest, sizes.next()?)?,
            tear: take(rest, sizes.next()?)?,
            renewal: take(rest, sizes.next()?)?,
            loose: take(rest, sizes.next()?)?.get_mut(..of_loose)?,
            work: take(rest, sizes.next()?)?,
            cells: take(rest, sizes.next()?)?,
            slots: take(rest, sizes.next()?)?,
            ids: take(rest, sizes.next()?)?,
            rest: take(rest, sizes.next()?)?,
            mobility: take(rest, sizes.next()?)?,
            factors: take(rest, sizes.next()?)?,
            entry: take(rest, sizes.next()?)?.get_mut(..if has_basis { cells } else { 0 })?,
            box_rows: take(rest, sizes.next()?)?,
            pairs: take(rest, sizes.next()?)?,
            weights: take(rest, sizes.next()?)?,
            triangles: halves(take(rest, sizes.next()?)?, model.triangles.len() + places(model))?,
            names: take(rest, sizes.next()?)?,
            numbers: take(rest, sizes.next()?)?,
            listed: take::<u32>(rest, sizes.next()?)?.first_chunk_mut()?,
            lip_cells: take(rest, sizes.next()?)?,
            lip_numbers: take(rest, sizes.next()?)?,
            lip_rows: take(rest, sizes.next()?)?,
            ends: take(rest, sizes.next()?)?,
            strengths: take(rest, sizes.next()?)?,
            turns: take(rest, sizes.next()?)?.get_mut(..sides)?,
            labels: take(rest, sizes.next()?)?.get_mut(..of_sides)?,
            side_rows: take(rest, sizes.next()?)?,
            side_cells: take(rest, sizes.next()?)?.get_mut(..of_sides)?,
            columns: take(rest, sizes.next()?)?,
            parents: take(rest, sizes.next()?)?.get_mut(..of_sides)?,
            lengths: take(rest, sizes.next()?)?,
            pushes: take(rest, sizes.next()?)?,
            roots: take(rest, sizes.next()?)?.get_mut(..of_loose)?,
            sizes: take(rest, sizes.next()?)?.get_mut(..of_loose)?,
            links: LinkArrays::take(rest, &mut sizes)?,
            bands: BandArrays {
                volumes: take(rest, sizes.next()?)?,
                lengths: take(rest, sizes.next()?)?,
            },
        })
    }
}

#[cfg(feature = "cut")]
impl<'a> LinkArrays<'a> {
    /// The arrays of these sizes from the front of the memory.
    fn take(memory: &mut &'a mut [u32], sizes: &mut impl Iterator<Item = usize>) -> Option<Self> {
        Some(Self {
            lengths: take(memory, sizes.next()?)?,
            weights: take(memory, sizes.next()?)?,
            alphas: take(memory, sizes.next()?)?,
            rows: take(memory, sizes.next()?)?,
            upper: take(memory, sizes.next()?)?,
            link_lengths: take(memory, sizes.next()?)?,
            link_weights: take(memory, sizes.next()?)?,
            link_alphas: take(memory, sizes.next()?)?,
            back_rows: take(memory, sizes.next()?)?,
            lower: take(memory, sizes.next()?)?,
            back_link: take(memory, sizes.next()?)?,
            young: take(memory, sizes.next()?)?,
            lip_areas: take(memory, sizes.next()?)?,
        })
    }
}

/// Copies an item of an array.
#[cfg(feature = "cut")]
pub(crate) fn inherit<T: Copy>(array: &mut [T], from: usize, to: usize) {
    if let Some(item) = array.get(from).copied()
        && let Some(slot) = array.get_mut(to)
    {
        *slot = item;
    }
}

/// The first `count` triples of half words.
#[cfg(feature = "cut")]
fn halves(of: &mut [u16], count: usize) -> Option<&mut [[u16; 3]]> {
    Some(of.as_chunks_mut().0).and_then(|triples| triples.get_mut(..count))
}
