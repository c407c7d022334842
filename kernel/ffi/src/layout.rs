//! What stands where in a tissue's storage:
//!
//! ```text
//! StoredHead<D>  tag, sizes, network, and the kernel's scalars
//! state          one cell each
//! residual       one cell each
//! own            D::ARRAYS cells each
//! room           blocks of eight `f32` for the coarse level
//! contacts       one slot for each contact cell
//! held           the cells of the contacts, ascending: room to sort them
//! states         what the energy's terms keep of each cell, for a body of nodal shapes
//! touch          room for contact on surfaces, see `touch`
//! cut            words of memory for cuts
//! ```
//!
//! Nothing in it points into it, so a tissue may be moved and copied byte by byte. The states start
//! at a multiple of [`SHAPE_ALIGN`] from the start of the storage, which then has that alignment;
//! so does the room for contact.

use chaincell_kernel::Cell;
use chaincell_kernel::Contact;
use chaincell_kernel::Team;
use chaincell_kernel::{
    CutRoom, Dynamics, Head, I8F24, Model, Network, Number, NumberOf, PinSample, TermState,
    TermStates, TissueMut, TouchRoom, TouchState, array_bytes, term_states,
};

use crate::code::Code;
use crate::memory::{self, ALIGN, SHAPE_ALIGN};
use crate::settings::Scheme;
use crate::touch::Touch;

/// At most so many bytes stand before a tissue's arrays, and so many words of the size of an
/// address (the next number): what `CHAINCELL_TISSUE_BYTES` goes by.
pub const TISSUE_BYTES: usize = 2496;
/// Those words.
pub const TISSUE_WORDS: usize = 142;
/// Bytes a cell under track.
pub const CELL_BYTES_TRACK: usize = 64;
/// Bytes a cell under euler.
pub const CELL_BYTES_EULER: usize = 32;
/// Bytes a cell under rkl2.
pub const CELL_BYTES_RKL2: usize = 80;
/// Bytes a cell under predict, the most of all schemes.
pub const CELL_BYTES_PREDICT: usize = 112;

/// Bytes a cell of nodal shapes takes more, the number of cells rounded up to a multiple of eight.
pub const CELL_BYTES_SHAPE: usize = 144;

/// "CHti": a tissue stands in the storage.
const TISSUE_TAG: u32 = u32::from_le_bytes(*b"CHti");

/// Does something with the scheme's type.
macro_rules! by_scheme {
    ($scheme:expr, $d:ident => $work:expr) => {{
        use chaincell_kernel::{Euler, I8F24, Rkl2, Track};
        match $scheme {
            crate::settings::Scheme::Track => {
                type $d = Track;
                $work
            }
            crate::settings::Scheme::Euler => {
                type $d = Euler;
                $work
            }
            crate::settings::Scheme::Rkl2 => {
                type $d = Rkl2;
                $work
            }
            crate::settings::Scheme::TrackFixed => {
                type $d = Track<0, I8F24>;
                $work
            }
            crate::settings::Scheme::EulerFixed => {
                type $d = Euler<I8F24>;
                $work
            }
            #[cfg(feature = "predict")]
            crate::settings::Scheme::Predict => {
                type $d = chaincell_kernel::Predict;
                $work
            }
            // `Scheme::of` knows no such scheme then.
            #[cfg(not(feature = "predict"))]
            crate::settings::Scheme::Predict => {
                type $d = Track;
                $work
            }
        }
    }};
}
pub(crate) use by_scheme;

/// The same for a tissue with room for contact on surfaces, which has one of these schemes.
macro_rules! by_touching_scheme {
    ($scheme:expr, $d:ident => $work:expr) => {
        match $scheme {
            crate::settings::Scheme::Track => {
                type $d = chaincell_kernel::Track;
                $work
            }
            #[cfg(feature = "predict")]
            crate::settings::Scheme::Predict => {
                type $d = chaincell_kernel::Predict;
                $work
            }
            _ => return Err(crate::code::Code::ContactRoom.into()),
        }
    };
}
pub(crate) use by_touching_scheme;

/// A body in storage of the caller's. It may be moved and copied byte by byte to storage of the
/// same alignment.
pub enum Tissue {}

/// How much of everything.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Sizes {
    pub cells: usize,
    pub contacts: usize,
    /// Blocks of eight `f32` of room.
    pub room: usize,
    /// Cells that terms keep states of.
    pub states: usize,
    /// Room for contact on surfaces.
    pub touch: Touch,
    /// Words of memory for cuts.
    pub words: usize,
}

/// Room that a model can have.
#[derive(Clone, Copy)]
pub(crate) struct Admitted {
    pub contacts: usize,
    pub touch: Touch,
    /// Words of memory for cuts.
    pub words: usize,
}

impl Sizes {
    /// Sizes of a model under the scheme `D` with this room.
    pub fn of<D: Dynamics>(model: &Model<'_>, room: &Admitted) -> Self {
        let &Admitted { contacts, touch, words } = room;
        let held = D::room_blocks(model, contacts);
        let room = if touch.is_none() { held } else { held.max(D::tool_blocks(model)) };
        Self { cells: model.cells(), contacts, room, states: model.kept_states(), touch, words }
    }

    /// Bytes of a tissue of the scheme `D`.
    pub const fn bytes<D: Dynamics>(&self) -> usize {
        self.cut_at::<D>() + self.words * size_of::<u32>()
    }

    /// Where the memory for cuts starts, at a multiple of [`ALIGN`] as the room for contact ends.
    const fn cut_at<D: Dynamics>(&self) -> usize {
        self.touch_at::<D>() + self.touch.bytes(self.cells)
    }

    /// Where the room for contact starts; at a multiple of [`SHAPE_ALIGN`] as the states do.
    const fn touch_at<D: Dynamics>(&self) -> usize {
        self.states_at::<D>() + term_states(self.states) * size_of::<TermState>()
    }

    /// Where the states start.
    const fn states_at<D: Dynamics>(&self) -> usize {
        let arrays = array_bytes::<D>(self.cells, self.contacts, self.room);
        let held = self.contacts * size_of::<u16>();
        (size_of::<StoredHead<D>>() + arrays + held).next_multiple_of(self.align())
    }

    /// Alignment of the storage \[bytes\].
    pub const fn align(&self) -> usize {
        if self.states > 0 || !self.touch.is_none() { SHAPE_ALIGN } else { ALIGN }
    }
}

/// What is the same for every scheme.
#[derive(Clone, Copy)]
#[repr(C, align(16))]
pub(crate) struct Front {
    tag: u32,
    scheme: Scheme,
    sizes: Sizes,
    network: Network<'static>,
}

/// What stands before the arrays.
#[repr(C, align(16))]
pub(crate) struct StoredHead<D> {
    front: Front,
    head: Head<D>,
}

/// Whether what the header's macros say of a scheme holds.
const fn is_as_promised<D: Dynamics>(cell_bytes: usize) -> bool {
    let room = TISSUE_BYTES + TISSUE_WORDS * size_of::<usize>();
    align_of::<StoredHead<D>>() == ALIGN
        && size_of::<StoredHead<D>>() <= room
        && array_bytes::<D>(1, 0, 0) == cell_bytes
}

const _: () = assert!(is_as_promised::<chaincell_kernel::Track>(CELL_BYTES_TRACK));
const _: () = assert!(is_as_promised::<chaincell_kernel::Euler>(CELL_BYTES_EULER));
const _: () = assert!(is_as_promised::<chaincell_kernel::Rkl2>(CELL_BYTES_RKL2));
const _: () = assert!(is_as_promised::<chaincell_kernel::Predict>(CELL_BYTES_PREDICT));
const _: () = assert!(is_as_promised::<chaincell_kernel::Track<0, I8F24>>(CELL_BYTES_TRACK));
const _: () = assert!(is_as_promised::<chaincell_kernel::Euler<I8F24>>(CELL_BYTES_EULER));
const _: () = assert!(align_of::<Cell>() <= ALIGN && align_of::<Cell<I8F24>>() <= ALIGN);
const _: () = assert!(align_of::<Contact>() <= ALIGN && size_of::<Contact>().is_multiple_of(2));
const _: () = assert!(size_of::<Contact<I8F24>>() == size_of::<Contact>());
const _: () = assert!(matches!(term_states(8) * size_of::<TermState>() / 8, 0 | CELL_BYTES_SHAPE));
const _: () = assert!(align_of::<TermState>() <= SHAPE_ALIGN);
const _: () = assert!(size_of::<TermState>().is_multiple_of(SHAPE_ALIGN));

/// A tissue under the scheme `D`, cut into its parts.
pub(crate) struct Parts<'a, D: Dynamics> {
    pub network: &'a mut Network<'static>,
    pub tissue: TissueMut<'a, D>,
    /// Room to sort the contact cells.
    pub held: &'a mut [u16],
}

/// Writes an empty tissue into storage.
///
/// # Safety
/// `storage` is aligned to [`Sizes::align`], has [`Sizes::bytes`] bytes, and nobody else uses it.
pub(crate) unsafe fn create<D: Dynamics>(
    storage: *mut u8,
    scheme: Scheme,
    sizes: Sizes,
    network: Network<'static>,
) {
    // SAFETY: all bytes of the tissue are the caller's; zeros are valid cells, blocks, contacts,
    // and states of the terms.
    unsafe { storage.write_bytes(0, sizes.bytes::<D>()) };
    let front = Front { tag: TISSUE_TAG, scheme, sizes, network };
    // SAFETY: the body stands first, and its alignment is that of the storage.
    unsafe { storage.cast::<StoredHead<D>>().write(StoredHead { front, head: Head::NEW }) };
    if cfg!(feature = "surface") && D::TAKES_SURFACES && !sizes.touch.is_none() {
        // SAFETY: the room is part of the storage.
        unsafe { sizes.touch.create(storage.add(sizes.touch_at::<D>()), sizes.cells) };
    }
}

/// Bytes that [`clear`] needs.
pub(crate) const FRONT_BYTES: usize = size_of::<Front>();

/// Makes sure that storage is taken for no tissue.
///
/// # Safety
/// `storage` is aligned to [`ALIGN`] and has room for a [`Front`].
pub(crate) unsafe fn clear(storage: *mut u8) {
    // SAFETY: the tag is a plain word in that room.
    unsafe { (&raw mut (*storage.cast::<Front>()).tag).write(0) };
}

/// What is the same for every scheme, if a tissue stands there.
///
/// # Safety
/// A pointer that is not null and aligned points to storage in which a tissue was created or
/// whose first words are readable.
pub(crate) unsafe fn front(tissue: *const Tissue) -> Result<(Scheme, Sizes), Code> {
    memory::check_to(tissue.cast(), ALIGN)?;
    let front = tissue.cast::<Front>();
    // SAFETY: the tag is a plain word at the start of the storage.
    if unsafe { (&raw const (*front).tag).read() } != TISSUE_TAG {
        return Err(Code::NotInitialised);
    }
    // SAFETY: the tag was written with the rest of the front.
    let found =
        unsafe { ((&raw const (*front).scheme).read(), (&raw const (*front).sizes).read()) };
    // It may have been moved since.
    memory::check_to(tissue.cast(), found.1.align())?;
    Ok(found)
}

/// The model of a tissue, whatever its scheme.
///
/// # Safety
/// A tissue stands there, and nobody writes it.
pub(crate) unsafe fn model(tissue: *const Tissue) -> Model<'static> {
    // SAFETY: the front stands first, and was written with the tag.
    unsafe { *(*tissue.cast::<Front>()).network.model() }
}

/// Where the states of the terms start; for a body without any, an aligned address of nothing.
///
/// # Safety
/// A tissue of the scheme `D` and of these sizes stands there.
unsafe fn states<D: Dynamics>(storage: *const u8, sizes: Sizes) -> *const TermState {
    if sizes.states == 0 {
        return core::ptr::dangling();
    }
    // SAFETY: they are part of the storage.
    unsafe { storage.add(sizes.states_at::<D>()) }.cast()
}

/// The memory for cuts.
///
/// # Safety
/// A tissue of the scheme `D` and of these sizes stands there, and nobody else uses it for `'a`.
unsafe fn cuts<'a, D: Dynamics>(storage: *mut u8, sizes: Sizes) -> CutRoom<'a> {
    if sizes.words == 0 {
        return CutRoom::none();
    }
    // SAFETY: the words are part of the storage, zeros at first, and overlap nothing else.
    let words = unsafe {
        core::slice::from_raw_parts_mut(storage.add(sizes.cut_at::<D>()).cast(), sizes.words)
    };
    CutRoom::new(words)
}

/// Cuts a tissue into its parts.
///
/// # Safety
/// A tissue of the scheme `D` and of these sizes stands there, and nobody else uses it for `'a`.
pub(crate) unsafe fn parts<'a, D: Dynamics>(tissue: *mut Tissue, sizes: Sizes) -> Parts<'a, D> {
    let Sizes { cells, contacts, room, states: kept, touch, .. } = sizes;
    let body = tissue.cast::<StoredHead<D>>();
    // SAFETY: create() has laid the arrays out one after the other, each at a multiple of its
    // alignment, with valid elements; they do not overlap.
    unsafe {
        let state = body.add(1).cast::<Cell<NumberOf<D>>>();
        let residual = state.add(cells);
        let own = residual.add(cells);
        let blocks = own.add(D::ARRAYS * cells).cast::<[f32; 8]>();
        let slots = blocks.add(room).cast::<Contact<NumberOf<D>>>();
        let held = slots.add(contacts).cast::<u16>();
        let states = states::<D>(tissue.cast(), sizes).cast_mut();
        Parts {
            network: &mut (*body).front.network,
            tissue: TissueMut {
                head: &mut (*body).head,
                state: core::slice::from_raw_parts_mut(state, cells),
                residual: core::slice::from_raw_parts_mut(residual, cells),
                own: core::slice::from_raw_parts_mut(own, D::ARRAYS * cells),
                room: core::slice::from_raw_parts_mut(blocks, room),
                contacts: core::slice::from_raw_parts_mut(slots, contacts),
                states: TermStates::new(core::slice::from_raw_parts_mut(states, term_states(kept))),
                touch: match D::TAKES_SURFACES {
                    true => touch.room(tissue.cast::<u8>().add(sizes.touch_at::<D>()), cells),
                    false => TouchRoom::none(),
                },
                cut: cuts::<D>(tissue.cast(), sizes),
                team: Team::ALONE,
            },
            held: core::slice::from_raw_parts_mut(held, contacts),
        }
    }
}

/// What a tissue publishes, for reading.
pub(crate) struct Published<'a, N: Number> {
    pub network: &'a Network<'static>,
    /// States of the cells.
    pub state: &'a [Cell<N>],
    /// What the terms keep of them.
    pub terms: &'a [TermState],
    /// Memory for cuts.
    pub words: &'a [u32],
    /// State of the tools and memory of pins; `None` without contact on surfaces.
    pub pins: Option<(&'a TouchState, &'a [PinSample])>,
}

/// Network and states of a tissue, for reading.
///
/// # Safety
/// A tissue of the scheme `D` and of these sizes stands there, and nobody writes it for `'a`.
pub(crate) unsafe fn published<'a, D: Dynamics>(
    tissue: *const Tissue,
    sizes: Sizes,
) -> Published<'a, NumberOf<D>> {
    let body = tissue.cast::<StoredHead<D>>();
    // SAFETY: as in parts(); the cells follow the body.
    unsafe {
        let terms = states::<D>(tissue.cast(), sizes);
        Published {
            network: &(*body).front.network,
            state: core::slice::from_raw_parts(body.add(1).cast(), sizes.cells),
            terms: core::slice::from_raw_parts(terms, term_states(sizes.states)),
            words: match sizes.words {
                0 => &[],
                words => {
                    let start = tissue.cast::<u8>().add(sizes.cut_at::<D>());
                    core::slice::from_raw_parts(start.cast(), words)
                }
            },
            pins: match D::TAKES_SURFACES {
                true => {
                    sizes.touch.pinned(tissue.cast::<u8>().add(sizes.touch_at::<D>()), sizes.cells)
                }
                false => None,
            },
        }
    }
}
