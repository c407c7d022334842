//! A tissue in the caller's storage: sizes, creation, reset, contacts.

use chaincell_kernel::{Dynamics, Model};

use crate::code::{Code, Detail, Refusal};
use crate::cut;
use crate::layout::{self, Admitted, Parts, Sizes, Tissue, by_scheme};
use crate::memory::{self, ALIGN};
use crate::model::{ModelStorage, load};
use crate::settings::{Scheme, Settings, network};
use crate::touch::{Room, Touch};

/// Bytes of a tissue for this model with this room, and what multiple of bytes its storage starts at:
/// `CHAINCELL_ALIGN`, or `CHAINCELL_SHAPE_ALIGN` for a body of nodal shapes and with room for tools on a
/// surface. `bytes` or `align` may be null.
///
/// # Safety
/// `model` is storage for a model, `room` is a room; `bytes` and `align` are null or storage for the
/// answers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_model_size(
    model: *const ModelStorage,
    scheme: i32,
    room: *const Room,
    bytes: *mut usize,
    align: *mut usize,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { load(model) }.and_then(|model| {
        let scheme = Scheme::of(scheme)?;
        // SAFETY: the caller's promises are handed on.
        let room = unsafe { memory::read(room) }?;
        let room = admitted(&room, &model, scheme).map_err(|why| why.code)?;
        let (size, multiple) = by_scheme!(scheme, D => {
            let sizes = Sizes::of::<D>(&model, &room);
            (sizes.bytes::<D>(), sizes.align())
        });
        // SAFETY: the caller's promises are handed on.
        unsafe {
            memory::write_if_asked(bytes, size)?;
            memory::write_if_asked(align, multiple)
        }
    }))
}

/// The room of a wish, where all of it can be.
fn admitted(room: &Room, model: &Model<'_>, scheme: Scheme) -> Result<Admitted, Refusal> {
    let (contacts, cells) = (room.contacts as usize, model.cells());
    if contacts > cells {
        return Err(Refusal::sizes(Code::Range, contacts, cells));
    }
    let touch = Touch::of(room)?;
    let takes = cfg!(feature = "surface") && matches!(scheme, Scheme::Track | Scheme::Predict);
    if !touch.is_none() && !takes {
        return Err(Code::ContactScheme.into());
    }
    Ok(Admitted { contacts, touch, words: cut::words(room.cuts, model)? })
}

/// What the caller of `chaincell_tissue_init` gives.
struct Wish {
    storage: *mut u8,
    bytes: usize,
    model: *const ModelStorage,
    scheme: i32,
    room: *const Room,
    settings: *const Settings,
}

/// # Safety
/// As [`chaincell_tissue_init`].
unsafe fn init(wish: &Wish) -> Result<*mut Tissue, Refusal> {
    memory::check_to(wish.storage, ALIGN)?;
    if wish.bytes >= layout::FRONT_BYTES {
        // SAFETY: aligned and large enough, and the caller says that the storage is ours.
        unsafe { layout::clear(wish.storage) };
    }
    // SAFETY: the caller's promises are handed on.
    let (model, settings, room) =
        unsafe { (load(wish.model)?, memory::read(wish.settings)?, memory::read(wish.room)?) };
    let scheme = Scheme::of(wish.scheme)?;
    let room = admitted(&room, &model, scheme)?;
    let network = network(&settings, model)?;
    by_scheme!(scheme, D => {
        let sizes = Sizes::of::<D>(&model, &room);
        memory::check_to(wish.storage, sizes.align())?;
        let needed = sizes.bytes::<D>();
        if needed > wish.bytes {
            return Err(Refusal::sizes(Code::Storage, needed, wish.bytes));
        }
        let tissue = wish.storage.cast();
        // SAFETY: aligned and large enough, and the caller says that the storage is ours.
        let Parts { network, tissue: mut body, .. } = unsafe {
            layout::create::<D>(wish.storage, scheme, sizes, network);
            layout::parts::<D>(tissue, sizes)
        };
        if let Err(why) = body.reset(network) {
            // SAFETY: a tissue was created there just now.
            unsafe { layout::clear(wish.storage) };
            return Err(why.into());
        }
        Ok(tissue)
    })
}

/// Puts a body at rest into storage, with this room, and no contacts chosen yet; room for tools under track
/// and predict alone.
///
/// `storage` starts at a multiple of what `chaincell_model_size` says, and has `bytes` bytes, at least as
/// many as it says; what stood there is lost, also where the call is refused. `scheme` is one of
/// `chaincell_scheme`. The answer in `tissue` is the address of the storage, or null. Model and settings
/// are copied; the model's image is not. `detail` may be null. Cost: clears the storage.
///
/// # Safety
/// `storage` has `bytes` bytes which nobody else uses as long as the tissue is in use, nor do they
/// overlap the other arguments or the image; `model` is storage for a model, `room` is a room, `settings`
/// are settings, `tissue` is storage for an address, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_tissue_init(
    storage: *mut core::ffi::c_void,
    bytes: usize,
    model: *const ModelStorage,
    scheme: i32,
    room: *const Room,
    settings: *const Settings,
    tissue: *mut *mut Tissue,
    detail: *mut Detail,
) -> Code {
    let wish = Wish { storage: storage.cast(), bytes, model, scheme, room, settings };
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            memory::write(tissue, core::ptr::null_mut())?;
            Ok(memory::write(tissue, init(&wish)?)?)
        })
    }
}

/// Back to rest: the tool released, no contact cells chosen.
///
/// Refused where the calling thread's arithmetic is not IEEE 754 to nearest; the body then stays
/// as it is. `detail` may be null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `detail` is null or
/// storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_tissue_reset(tissue: *mut Tissue, detail: *mut Detail) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            let (scheme, sizes) = layout::front(tissue)?;
            by_scheme!(scheme, D => {
                let Parts { network, tissue: mut body, .. } = layout::parts::<D>(tissue, sizes);
                Ok(body.reset(network)?)
            })
        })
    }
}

/// Saves all that the tissue knows but its settings, between two ticks, into `bytes` bytes at `snapshot`;
/// `written` says how many it took and may be null. The tissue does not change. Cost: that of copying the
/// tissue, twice over, and a checksum.
///
/// A null `snapshot` of 0 bytes asks how many it would take now, which depends on the model, on what was
/// chosen to touch it, and on the triangles in reach. `detail` may be null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `snapshot` is storage of
/// `bytes` bytes, `written` is null or storage for the answer, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_tissue_save(
    tissue: *mut Tissue,
    snapshot: *mut u8,
    bytes: usize,
    written: *mut usize,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            let (scheme, sizes) = layout::front(tissue)?;
            let asks = snapshot.is_null() && bytes == 0;
            let snapshot = memory::slice_mut(snapshot, bytes)?;
            let size = by_scheme!(scheme, D => {
                let Parts { network, tissue: mut body, .. } = layout::parts::<D>(tissue, sizes);
                if asks { body.snapshot_bytes(network)? } else { body.save(network, snapshot)? }
            });
            Ok(memory::write_if_asked(written, size)?)
        })
    }
}

/// Goes on from a snapshot of the same model under the same scheme: with the same settings and samples
/// to the same hashes and forces, whatever the processor. The tissue has room for what the saved one
/// had in use. A snapshot that is refused changes nothing. `detail` may be null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `snapshot` points to `bytes`
/// bytes, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_tissue_restore(
    tissue: *mut Tissue,
    snapshot: *const u8,
    bytes: usize,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            let (scheme, sizes) = layout::front(tissue)?;
            let snapshot = memory::slice(snapshot, bytes)?;
            by_scheme!(scheme, D => {
                let Parts { network, tissue: mut body, .. } = layout::parts::<D>(tissue, sizes);
                Ok(body.restore(network, snapshot)?)
            })
        })
    }
}

/// Changes the settings from the next tick on; the body stays as it is. `detail` may be null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `settings` are
/// settings, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_change_settings(
    tissue: *mut Tissue,
    settings: *const Settings,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            let (scheme, sizes) = layout::front(tissue)?;
            let settings = memory::read(settings)?;
            by_scheme!(scheme, D => {
                let Parts { network, .. } = layout::parts::<D>(tissue, sizes);
                *network = crate::settings::network(&settings, *network.model())?;
            });
            Ok(())
        })
    }
}

/// Finds the cells of input ids and chooses them.
fn choose<D: Dynamics>(parts: Parts<'_, D>, input_ids: &[u32]) -> Result<(), Refusal> {
    let Parts { network, tissue: mut body, held } = parts;
    let (needed, room) = (input_ids.len(), held.len());
    if needed > room {
        return Err(Refusal::sizes(Code::ContactCapacity, needed, room));
    }
    let model = network.model();
    for (at, &id) in input_ids.iter().enumerate() {
        let Some(cell) = model.cell_of_input(id) else {
            return Err(Refusal::position(Code::UnknownId, at));
        };
        if model.is_fixed(cell) {
            return Err(Refusal::position(Code::ContactFixed, at));
        }
        let slot = held.iter().take(at).position(|&other| other >= cell).unwrap_or(at);
        if slot < at && held.get(slot) == Some(&cell) {
            return Err(Refusal::position(Code::ContactRepeated, at));
        }
        let mut displaced = cell;
        for place in held.iter_mut().take(at + 1).skip(slot) {
            core::mem::swap(place, &mut displaced);
        }
    }
    Ok(body.choose_contacts(network, held.get(..needed).unwrap_or(&[]))?)
}

/// Chooses the cells that the tool holds while engaged: `count` input ids in any order, none
/// fixed, none twice. None at all is a choice too. A refused choice leaves the old one. Of a model
/// baked with --cells an id stands for the cell of its group: two of one group are one twice.
///
/// Looks through all cells for each id: not for a tick. `detail` may be null.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `input_ids` are
/// `count` ids, `detail` is null or storage.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_choose_contacts(
    tissue: *mut Tissue,
    input_ids: *const u32,
    count: usize,
    detail: *mut Detail,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    unsafe {
        crate::answer(detail, || {
            let (scheme, sizes) = layout::front(tissue)?;
            let ids = memory::slice(input_ids, count)?;
            by_scheme!(scheme, D => choose(layout::parts::<D>(tissue, sizes), ids))
        })
    }
}
