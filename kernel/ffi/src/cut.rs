//! Cuts: memory for them, faces that are opened, and their state.

use chaincell_kernel::{
    CutError, CutOutput, Dynamics, EDGE_BYTES, Model, Network, TissueMut, cut_words,
};

use crate::code::{Code, Detail, Refusal};
use crate::layout::{self, Parts, Tissue, by_scheme, by_touching_scheme};
use crate::memory;

/// Bytes that a blade takes in each tool, in a library that cuts.
pub const CUT_TOOL_BYTES: usize = 1296;

const _: () = assert!(EDGE_BYTES <= CUT_TOOL_BYTES);

/// A face of a tetrahedron.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct Face {
    /// The tetrahedron, by its place in the input mesh.
    pub tetrahedron: u32,
    /// The corner that lies opposite to the face, 0 to 3.
    pub corner: u32,
}

/// State of the cuts of a body since its reset; all 0 for one that is whole.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Cuts {
    /// Number of faces between tetrahedra that are open.
    pub opened_faces: u32,
    /// Number of spare cells in use: copies of split cells.
    pub copies: u32,
    /// Number of cells that wait for the start of a tick.
    pub waiting: u32,
    /// Number of splits for which there was no spare cell or half-link: bake with more, `--cut-spare`.
    pub refused: u32,
    /// Area that the edges of blades have swept \[m2\].
    pub area_m2: f32,
    /// Work that it took to part it: toughness times area, each area by the toughness there \[J\].
    pub work_j: f32,
    /// Number of open faces that tools do not touch, for want of places.
    pub untouched: u32,
    /// Number of cells at which a body that tears has torn by itself.
    pub torn: u32,
}

/// A triangle of the surface of a body as it is cut now, outward.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct Triangle {
    /// Its three cells, as `chaincell_positions` numbers them; a cell behind those of the body is a copy that a split
    /// has made.
    pub cells: [u32; 3],
    /// The cells of the whole body that these are or were made from: for colours, textures and positions at rest.
    pub origins: [u32; 3],
}

/// Words of memory for a wish, 0 or 1; a body that relaxes has its memory unasked.
pub(crate) fn words(wish: u32, model: &Model<'_>) -> Result<usize, Refusal> {
    match wish {
        0 if !model.relaxes() => Ok(0),
        0 => Ok(cut_words(model)),
        1 if model.tetrahedra_to_cut() == 0 => Err(Code::CutModel.into()),
        1 => Ok(cut_words(model)),
        _ => Err(Refusal::sizes(Code::Range, wish as usize, 1)),
    }
}

impl From<CutError> for Code {
    fn from(why: CutError) -> Self {
        match why {
            CutError::Model => Self::ContactModel,
            CutError::NotCuttable => Self::CutModel,
            CutError::Room => Self::CutRoom,
            CutError::Unknown(..) => Self::CutFace,
        }
    }
}

impl From<CutOutput> for Cuts {
    fn from(of: CutOutput) -> Self {
        Self {
            opened_faces: of.opened_faces,
            copies: of.copies,
            waiting: of.waiting,
            refused: of.refused,
            area_m2: of.area_m2,
            work_j: of.work_j,
            untouched: of.untouched,
            torn: of.torn,
        }
    }
}

/// # Safety
/// As [`chaincell_cut`].
unsafe fn cut(
    tissue: *mut Tissue,
    faces: *const Face,
    count: usize,
    cuts: *mut Cuts,
) -> Result<(), Refusal> {
    // SAFETY: the caller's promises are handed on.
    let ((scheme, sizes), faces) =
        unsafe { (layout::front(tissue)?, memory::slice(faces, count)?) };
    if !cuts.is_null() {
        memory::check(cuts)?;
    }
    if sizes.words == 0 {
        return Err(Code::CutRoom.into());
    }
    let output = by_touching_scheme!(scheme, D => {
        // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
        let Parts { network, tissue: mut body, .. } = unsafe { layout::parts::<D>(tissue, sizes) };
        for (at, face) in faces.iter().enumerate() {
            let opened = body.open_face(network, face.tetrahedron as usize, face.corner as usize);
            opened.map_err(|why| Refusal::position(why.into(), at))?;
        }
        body.cut_output(network)
    });
    // SAFETY: the caller's promises are handed on.
    Ok(unsafe { memory::write_if_asked(cuts, output.into()) }?)
}

/// Opens `count` faces between tetrahedra, each on both sides, and writes the state of the cuts; `cuts` may be
/// null, and so may `faces` where `count` is 0. The tissue parts there in the next ticks that are not late. An outer
/// face, and one that is open, is left as it is.
///
/// The tissue was initialised with `cuts` in its room. Between two ticks. Where a face is refused, those before it in
/// the list are open. `detail` may be null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `faces` are `count` faces, `cuts` is
/// null or storage for the answer, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_cut(
    tissue: *mut Tissue,
    faces: *const Face,
    count: usize,
    cuts: *mut Cuts,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe { crate::answer(detail, || cut(tissue, faces, count, cuts)) }
}

/// The triangles of the surface as it is now: those of the model in its order, at split cells with the copies on which
/// they hang, and behind them the sides of open faces that can part. A triangle of a piece that is gone has three times
/// the same cell. Writes the first `room` of them and says in `count` how many there are; `triangles` may be null where
/// `room` is 0. They change in ticks that open a face or split a cell, and by a restore or a reset.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `triangles` has room for `room` of them,
/// `count` is storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_triangles(
    tissue: *mut Tissue,
    triangles: *mut Triangle,
    room: usize,
    count: *mut usize,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { layout::front(tissue) }.and_then(|(scheme, sizes)| {
        memory::check(count)?;
        if room > 0 {
            memory::check(triangles)?;
        }
        let found = by_scheme!(scheme, D => {
            // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
            let Parts { network, tissue: mut body, .. } =
                unsafe { layout::parts::<D>(tissue, sizes) };
            for at in 0..room {
                let Some(cells) = body.triangles(network).nth(at) else { break };
                let origins = cells.map(|cell| u32::from(origin(&mut body, network, cell)));
                let triangle = Triangle { cells: cells.map(u32::from), origins };
                // SAFETY: checked above, and the caller says that there is room for it.
                unsafe { triangles.add(at).write(triangle) };
            }
            body.triangles(network).len()
        });
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(count, found) }
    }))
}

/// The cell of the whole body that a cell is or was made from.
fn origin<D: Dynamics>(body: &mut TissueMut<'_, D>, network: &Network<'_>, cell: u16) -> u16 {
    let copy = usize::from(cell).checked_sub(network.model().body_cells());
    copy.and_then(|copy| body.origin_of_copy(network, copy)).unwrap_or(cell)
}
