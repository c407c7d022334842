//! Room for contact on surfaces in a tissue's storage: nine arrays, one after the other, each at a
//! multiple of [`ALIGN`] from the start of the room.
//!
//! ```text
//! tools      a `ToolState` each
//! coarse     the coarse level under the tools: one
//! state      what belongs to all tools: one
//! pulls      one a cell
//! mobility   one a cell
//! factors    one a cell
//! near       triangles in reach
//! anchors    samples that friction or grips hold: two each
//! pins       samples that pins hold
//! ```

use chaincell_kernel::{
    Anchor, Cell, CoarseTouch, EDGE_BYTES, NearTriangle, PINS_ARE_BUILT, PinSample, TOOLS_MAX,
    ToolState, TouchArrays, TouchRoom, TouchState,
};

use crate::code::{Code, Refusal};
use crate::memory::ALIGN;

/// Most triangles in reach: their numbers have 16 bits.
const TRIANGLES_MAX: u32 = 65_535;
/// Most samples that are held: of two lists in one.
const SAMPLES_MAX: u32 = 32_767;

/// Most samples that pins hold.
const PINNED_MAX: u32 = 65_535;

/// At most so many bytes the room for contact on surfaces takes beside those of the five numbers
/// below: what `CHAINCELL_TOUCH_BYTES` goes by.
pub const TOUCH_BYTES: usize = 20_480;
/// Bytes of that room for each cell of the model.
pub const CELL_BYTES_TOUCH: usize = 24;
/// Bytes for each triangle in reach.
pub const TRIANGLE_BYTES: usize = 28;
/// Bytes for each sample that friction or grips hold.
pub const SAMPLE_BYTES: usize = 104;
/// Bytes for each sample that pins hold.
pub const PIN_BYTES: usize = 48;
/// At most so many bytes for each tool; `CHAINCELL_CUT_BYTES` has what a blade takes more.
pub const TOOL_BYTES: usize = 1216;

/// How much a tissue has room for, beside the cells of its model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct Room {
    /// Contact cells, at most those of the model; tools on a surface need none.
    pub contacts: u32,
    /// Tools on a surface, at most 8; 0 for no contact on surfaces, and then the two below and `pins`
    /// are 0 too.
    pub tools: u32,
    /// Triangles in reach of tools at a time, 1 to 65,535; 1,024 are enough for most. A triangle
    /// counts once for each part of a tool. Where more are in reach those deepest in the tools are
    /// kept, with `CHAINCELL_FLAG_CONTACT_CAPACITY`.
    pub triangles: u32,
    /// Samples of triangles that friction or grips hold at a time, at most 32,767; 0 for neither.
    /// A triangle has at least four. Where more are in contact the others are free, with
    /// `CHAINCELL_FLAG_CONTACT_CAPACITY`.
    pub samples: u32,
    /// 1 for memory with which the model's body can be cut, 0 for a body that stays whole. A blade needs it, with
    /// room for its tool.
    pub cuts: u32,
    /// Samples of triangles that all pins together hold at a time, at most 65,535, in a library with the feature
    /// `pins`; 0 for no pins.
    pub pins: u32,
}

/// How much room there is; all 0 without contact on surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Touch {
    tools: u16,
    triangles: u16,
    samples: u16,
    pins: u16,
}

/// Where each array starts, and where the last one ends.
struct Places {
    coarse: usize,
    state: usize,
    pulls: usize,
    mobility: usize,
    factors: usize,
    near: usize,
    anchors: usize,
    pins: usize,
    end: usize,
}

/// Where an array ends that starts there.
const fn behind<T>(at: usize, count: usize) -> usize {
    (at + count * size_of::<T>()).next_multiple_of(ALIGN)
}

impl Touch {
    /// No room.
    pub(crate) const NONE: Self = Self { tools: 0, triangles: 0, samples: 0, pins: 0 };

    /// The room of a wish, where it can be.
    pub fn of(wish: &Room) -> Result<Self, Refusal> {
        let &Room { tools, triangles, samples, pins, .. } = wish;
        if (tools, triangles, samples, pins) == (0, 0, 0, 0) {
            return Ok(Self::NONE);
        }
        let within = |asked: u32, least: u32, most: u32| match u16::try_from(asked) {
            Ok(count) if (least..=most).contains(&asked) => Ok(count),
            _ => Err(Refusal::sizes(Code::Range, asked as usize, most as usize)),
        };
        Ok(Self {
            tools: within(tools, 1, TOOLS_MAX as u32)?,
            triangles: within(triangles, 1, TRIANGLES_MAX)?,
            samples: within(samples, 0, SAMPLES_MAX)?,
            pins: within(pins, 0, if PINS_ARE_BUILT { PINNED_MAX } else { 0 })?,
        })
    }

    /// Tools that there is room for.
    pub const fn tools(&self) -> usize {
        self.tools as usize
    }

    /// Whether friction and grips can hold anything.
    pub const fn holds(&self) -> bool {
        self.samples > 0
    }

    /// Triangles in reach, and slots of held samples.
    const fn lists(&self) -> (usize, usize) {
        (self.triangles as usize, 2 * self.samples as usize)
    }

    /// Samples that pins may hold.
    pub const fn pins(&self) -> usize {
        self.pins as usize
    }

    pub const fn is_none(&self) -> bool {
        self.tools == 0
    }

    const fn places(&self, cells: usize) -> Places {
        let coarse = behind::<ToolState>(0, self.tools());
        let state = behind::<CoarseTouch>(coarse, 1);
        let pulls = behind::<TouchState>(state, 1);
        let mobility = behind::<Cell>(pulls, cells);
        let factors = behind::<f32>(mobility, cells);
        let near = behind::<f32>(factors, cells);
        let (triangles, slots) = self.lists();
        let anchors = behind::<NearTriangle>(near, triangles);
        let pins = behind::<Anchor>(anchors, slots);
        let end = behind::<PinSample>(pins, self.pins());
        Places { coarse, state, pulls, mobility, factors, near, anchors, pins, end }
    }

    /// Bytes, for a body of so many cells.
    pub const fn bytes(&self, cells: usize) -> usize {
        if self.is_none() { 0 } else { self.places(cells).end }
    }

    /// Writes empty arrays.
    ///
    /// # Safety
    /// `start` is aligned to [`ALIGN`], has [`Self::bytes`] bytes, and nobody else uses it.
    #[inline(never)] // Its elements stand on the stack.
    pub unsafe fn create(&self, start: *mut u8, cells: usize) {
        let (at, (triangles, slots)) = (self.places(cells), self.lists());
        // SAFETY: the arrays lie in the room, each at a multiple of its alignment. Zeros are valid
        // cells and numbers, and a coarse level under no tool, which is too large for the stack.
        unsafe {
            fill(start, ToolState::NONE, self.tools());
            start.add(at.coarse).write_bytes(0, at.state - at.coarse);
            fill(start.add(at.state), TouchState::AWAY, 1);
            start.add(at.pulls).write_bytes(0, at.near - at.pulls);
            fill(start.add(at.near), NearTriangle::NONE, triangles);
            fill(start.add(at.anchors), Anchor::NONE, slots);
            fill(start.add(at.pins), PinSample::NONE, self.pins());
        }
    }

    /// The arrays; none in a library without contact on surfaces.
    ///
    /// # Safety
    /// [`Self::create`] has written them there, and nobody else uses them for `'a`.
    pub unsafe fn room<'a>(&self, start: *mut u8, cells: usize) -> TouchRoom<'a> {
        if self.is_none() || !cfg!(feature = "surface") {
            return TouchRoom::none();
        }
        let (at, (triangles, slots)) = (self.places(cells), self.lists());
        // SAFETY: create() has written valid elements there; the arrays do not overlap.
        unsafe {
            TouchRoom::new(TouchArrays {
                tools: array(start, self.tools()),
                coarse: array(start.add(at.coarse), 1),
                state: array(start.add(at.state), 1),
                pulls: array(start.add(at.pulls), cells),
                mobility: array(start.add(at.mobility), cells),
                factors: array(start.add(at.factors), cells),
                near: array(start.add(at.near), triangles),
                anchors: array(start.add(at.anchors), slots),
                pins: array(start.add(at.pins), self.pins()),
            })
        }
    }
}

impl Touch {
    /// The state of the tools and the memory of pins, for reading; `None` without contact on surfaces.
    ///
    /// # Safety
    /// [`Self::create`] has written them there, and nobody writes them for `'a`.
    pub unsafe fn pinned<'a>(
        &self,
        start: *const u8,
        cells: usize,
    ) -> Option<(&'a TouchState, &'a [PinSample])> {
        if self.is_none() || !cfg!(feature = "surface") {
            return None;
        }
        let at = self.places(cells);
        // SAFETY: create() has written valid elements there.
        unsafe {
            let state = &*start.add(at.state).cast::<TouchState>();
            Some((state, core::slice::from_raw_parts(start.add(at.pins).cast(), self.pins())))
        }
    }
}

/// # Safety
/// There is room for `count` elements at this aligned address.
unsafe fn fill<T: Copy>(start: *mut u8, value: T, count: usize) {
    for at in 0..count {
        // SAFETY: the caller says that there is room.
        unsafe { start.cast::<T>().add(at).write(value) };
    }
}

/// # Safety
/// `count` valid elements stand at this aligned address, and nobody else uses them for `'a`.
unsafe fn array<'a, T>(start: *mut u8, count: usize) -> &'a mut [T] {
    // SAFETY: the caller's promises are handed on.
    unsafe { core::slice::from_raw_parts_mut(start.cast(), count) }
}

/// Roundings of the arrays' ends.
const ROUNDINGS: usize = 9 * ALIGN;

const _: () = assert!(align_of::<ToolState>() <= ALIGN && align_of::<CoarseTouch>() <= ALIGN);
const _: () = assert!(align_of::<TouchState>() <= ALIGN && align_of::<Cell>() <= ALIGN);
const _: () = assert!(align_of::<NearTriangle>() <= ALIGN && align_of::<Anchor>() <= ALIGN);
const _: () =
    assert!(size_of::<CoarseTouch>() + size_of::<TouchState>() + ROUNDINGS <= TOUCH_BYTES);
const _: () = assert!(size_of::<Cell>() + 2 * size_of::<f32>() == CELL_BYTES_TOUCH);
const _: () = assert!(size_of::<NearTriangle>() == TRIANGLE_BYTES);
const _: () = assert!(2 * size_of::<Anchor>() == SAMPLE_BYTES);
const _: () = assert!(size_of::<PinSample>() == PIN_BYTES && align_of::<PinSample>() <= ALIGN);
// A kernel that cuts has an edge in each tool, see `cut`.
const _: () = assert!(size_of::<ToolState>() - EDGE_BYTES <= TOOL_BYTES);
