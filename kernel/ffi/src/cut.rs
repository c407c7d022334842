//! Cuts: memory for them, faces that are opened, and their state.

use chaincell_kernel::{CutError, CutOutput, EDGE_BYTES, Model, cut_words};

use crate::code::{Code, Detail, Refusal};
use crate::layout::{self, Parts, Tissue, by_touching_scheme};
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
    /// Work that it took to part it: toughness times area \[J\].
    pub work_j: f32,
    /// Number of open faces that tools do not touch, for want of places.
    pub untouched: u32,
    /// Number of cells at which a body that tears has torn by itself.
    pub torn: u32,
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
