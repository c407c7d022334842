//! A validated model in the caller's storage.

use chaincell_kernel::Model;

use crate::code::{Code, Detail, Refusal};
use crate::memory;

/// Words of a `chaincell_model`.
pub const MODEL_WORDS: usize = 168;

/// Storage of a validated model. Its content is nobody's business; it may be copied.
///
/// The model refers to its image, which stays where it is, unchanged, for as long as the model or
/// a tissue made from it is in use.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct ModelStorage {
    /// Not for use.
    pub opaque: [usize; MODEL_WORDS],
}

impl ModelStorage {
    /// Storage without a model.
    pub const EMPTY: Self = Self { opaque: [0; MODEL_WORDS] };
}

/// What a model says of itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct Info {
    /// Number of cells.
    pub cells: u32,
    /// Number of links.
    pub links: u32,
    /// Number of coarse functions of the coarse level, 0 without one.
    pub coarse_functions: u32,
    /// Number of fixed cells.
    pub fixed: u32,
    /// Number of connected parts.
    pub parts: u32,
    /// Number of nodes of the input's numbering: input ids lie below it.
    pub input_nodes: u32,
    /// Checksum of the image; it tells models apart.
    pub checksum: u32,
    /// Mean link length, the unit of internal positions \[m\].
    pub unit_m: f32,
    /// The body's centre, origin of internal positions \[m\].
    pub centre_m: [f32; 3],
    /// Stiffness of a link of weight 1 \[N/m\].
    pub stiffness_n_per_m: f32,
    /// Half-width of the links' band \[rest lengths\]; the mean where links differ.
    pub alpha: f32,
    /// Largest proven step of euler \[dimensionless time\].
    pub step_max: f32,
    /// Largest energy that a tool may load into the body \[J\].
    pub energy_max_j: f32,
    /// Words of memory for cuts or for the strain of a body that relaxes, 0 for another one: for `CHAINCELL_CUT_BYTES`.
    pub cut_words: u32,
}

/// "CHmo": a model stands in the storage.
const MODEL_TAG: u32 = u32::from_le_bytes(*b"CHmo");

/// What stands in a [`ModelStorage`].
#[repr(C)]
struct Slot {
    tag: u32,
    model: Model<'static>,
}

const _: () = assert!(size_of::<Slot>() <= size_of::<ModelStorage>());
const _: () = assert!(align_of::<Slot>() <= align_of::<ModelStorage>());

/// Copies the model out of its storage.
///
/// # Safety
/// A pointer that is not null and aligned points to a `ModelStorage`.
pub(crate) unsafe fn load(storage: *const ModelStorage) -> Result<Model<'static>, Code> {
    memory::check(storage)?;
    let slot = storage.cast::<Slot>();
    // SAFETY: a slot fits into the storage by size and alignment, and its tag is a plain word.
    if unsafe { (&raw const (*slot).tag).read() } != MODEL_TAG {
        return Err(Code::NotInitialised);
    }
    // SAFETY: the tag was written behind a whole model, which nobody but this library writes.
    Ok(unsafe { (&raw const (*slot).model).read() })
}

/// Validates an image and puts the model into the storage.
///
/// # Safety
/// As [`chaincell_model_init`].
unsafe fn init(storage: *mut ModelStorage, image: *const u8, bytes: usize) -> Result<(), Refusal> {
    memory::check(storage)?;
    // SAFETY: checked just now, and the caller says that it is storage; no model stands there yet.
    unsafe { storage.write(ModelStorage::EMPTY) };
    memory::check(image)?;
    if bytes == 0 {
        return Err(Code::ModelTruncated.into());
    }
    // SAFETY: the caller says that the image has that many bytes and outlives the model.
    let image: &'static [u8] = unsafe { memory::slice(image, bytes) }?;
    let model = Model::from_bytes(image)?;
    // SAFETY: a slot fits into the storage by size and alignment.
    unsafe { storage.cast::<Slot>().write(Slot { tag: MODEL_TAG, model }) };
    Ok(())
}

/// Validates a model image in place. Cost: a checksum and about two sweeps, once; no memory.
///
/// `image` starts at a multiple of 16, has `bytes` bytes, and stays there unchanged for as long as
/// the model or a tissue made from it is in use. Unless the answer is 0 the storage holds no model
/// afterwards. `detail` may be null.
///
/// # Safety
/// `model` is storage for a model, `image` has `bytes` bytes, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_model_init(
    model: *mut ModelStorage,
    image: *const core::ffi::c_void,
    bytes: usize,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe { crate::answer(detail, || init(model, image.cast(), bytes)) }
}

/// What the model says of itself.
///
/// # Safety
/// `model` is storage for a model, `info` storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_model_info(model: *const ModelStorage, info: *mut Info) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { load(model) }.and_then(|model| {
        let count = |count: usize| u32::try_from(count).unwrap_or(u32::MAX);
        let value = Info {
            cells: count(model.cells()),
            links: count(model.links()),
            coarse_functions: count(model.coarse_functions()),
            fixed: count(model.fixed().len()),
            parts: model.parts(),
            input_nodes: model.input_nodes(),
            checksum: model.checksum(),
            unit_m: model.unit_m(),
            centre_m: model.centre_m(),
            stiffness_n_per_m: model.stiffness_n_per_m(),
            alpha: model.alpha(),
            step_max: model.step_max(),
            energy_max_j: model.energy_max() * model.energy_unit_j(),
            cut_words: count(chaincell_kernel::cut_words(&model)),
        };
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(info, value) }
    }))
}

/// The input id of a cell, by its place in arrays of positions.
///
/// # Safety
/// `model` is storage for a model, `input_id` storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_model_input_id(
    model: *const ModelStorage,
    cell: u32,
    input_id: *mut u32,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { load(model) }.and_then(|model| {
        memory::check(input_id)?;
        let &found = model.input_id().get(cell as usize).ok_or(Code::Range)?;
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(input_id, found) }
    }))
}
