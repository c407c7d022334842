//! Memory for contact on surfaces, and the part of it that a snapshot holds.

use crate::backend::slice_set::SliceSet;
use crate::energy::surface::{
    Anchor, BUILT, NearTriangle, PINS_ARE_BUILT, PinSample, Proxies, TOOLS_MAX, ToolState, Touch,
    Touching,
};
use crate::model::Model;
use crate::model::surface::SUBDIVISIONS_MAX;
use crate::number::cell::Cell;
use crate::number::kept::{Kept, Pass, kept};
use crate::solver::coarse::CoarseTouch;

/// Arrays for contact on surfaces, in memory of the caller.
///
/// ```
/// use chaincell_kernel::{
///     Anchor, Cell, CoarseTouch, NearTriangle, PinSample, ToolState, TouchArrays, TouchRoom,
///     TouchState,
/// };
///
/// // Up to 160 cells, 64 triangles in reach, 16 held samples, 32 pinned ones and two tools, sized at run time.
/// let mut numbers = vec![[0.0; 160]; 2];
/// let [mobility, factors] = &mut numbers[..] else { unreachable!() };
/// let (mut pulls, mut near) = (vec![Cell::ZERO; 160], vec![NearTriangle::NONE; 64]);
/// let (mut anchors, mut pins) = (vec![Anchor::NONE; 2 * 16], vec![PinSample::NONE; 32]);
/// let mut tools = vec![ToolState::NONE; 2];
/// let memory = TouchRoom::new(TouchArrays {
///     mobility,
///     factors,
///     pulls: &mut pulls,
///     near: &mut near,
///     anchors: &mut anchors,
///     pins: &mut pins,
///     coarse: &mut [CoarseTouch::NONE],
///     tools: &mut tools,
///     state: &mut [TouchState::AWAY],
/// });
/// // `Tissue::touching(memory)` gives the tissue that takes tools.
/// ```
#[derive(Default)]
pub struct TouchArrays<'a> {
    /// Stability bounds of the cells, one per cell.
    pub mobility: &'a mut [f32],
    /// Factors of the cells' parts, one per cell.
    pub factors: &'a mut [f32],
    /// Effect of the tools on the residuals, one per cell.
    pub pulls: &'a mut [Cell],
    /// Triangles in reach; the length is the capacity. If more are in reach, those deepest in the tools are
    /// kept.
    pub near: &'a mut [NearTriangle],
    /// Anchors of friction and grips: two per sample; empty without friction and grips.
    pub anchors: &'a mut [Anchor],
    /// Samples that pins hold; the length is the capacity of all pins together. Empty without pins.
    pub pins: &'a mut [PinSample],
    /// The coarse level under the tools: one element.
    pub coarse: &'a mut [CoarseTouch],
    /// The tools; the length is the capacity, at most [`TOOLS_MAX`].
    pub tools: &'a mut [ToolState],
    /// State shared by all tools: one element.
    pub state: &'a mut [TouchState],
}

/// Statically sized arrays for contact on surfaces: of a body of up to `CELLS` cells, `NEAR`
/// triangles in reach, `HELD` samples that friction or grips hold, `TOOLS` tools, and `PINNED` samples that pins
/// hold.
///
/// `const` constructible, so it can be a `static`. [`Tissue::touching`](crate::Tissue::touching)
/// joins it with a tissue.
///
/// ```
/// # use chaincell_kernel::{Budget, FEATURES, Model, Network, Settings, Tissue, ToolPart, ToolPose, Track};
/// # use chaincell_kernel::{elastic_room, include_model, term_states};
/// use chaincell_kernel::TouchStore;
/// # if FEATURES != ["nodal", "surface"] {
/// #     return Ok(());
/// # }
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/touch6.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
///
/// let mut body = Tissue::<160, Track<{ elastic_room(32) }>, 4, { term_states(160) }>::new(); // a nodal body
/// let mut store = TouchStore::<160, 64>::new(); // 64 triangles in reach of one tool
/// let mut tissue = body.touching(store.room());
/// tissue.reset(&network)?;
/// tissue.choose_tools(&network, &[&[ToolPart::sphere(0.004)]], 0.0)?;
/// let mut force_n = 0.0;
/// for step in 0..=6 {
///     let height_m = 0.036 - 0.001 * step as f32; // from 2 mm above the surface
///     let pose = ToolPose::at([0.0, 0.0, height_m].into(), 1);
///     force_n = tissue.tick(&network, &[pose], Budget::All).force_n.z;
/// }
/// assert!(force_n > 0.05); // [N], upwards
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct TouchStore<
    const CELLS: usize,
    const NEAR: usize,
    const HELD: usize = 0,
    const TOOLS: usize = 1,
    const PINNED: usize = 0,
> {
    mobility: [f32; CELLS],
    factors: [f32; CELLS],
    pulls: [Cell; CELLS],
    near: [NearTriangle; NEAR],
    anchors: [[Anchor; HELD]; 2],
    pins: [PinSample; PINNED],
    coarse: [CoarseTouch; 1],
    tools: [ToolState; TOOLS],
    state: [TouchState; 1],
}

impl<
    const CELLS: usize,
    const NEAR: usize,
    const HELD: usize,
    const TOOLS: usize,
    const PINNED: usize,
> TouchStore<CELLS, NEAR, HELD, TOOLS, PINNED>
{
    /// RAM \[bytes\].
    pub const RAM_BYTES: usize = size_of::<Self>();

    /// Memory without tools: all bits 0.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(NEAR > 0 && NEAR <= 65_535, "between 1 and 65,535 triangles in reach") };
        const { assert!(HELD <= 32_767, "at most 32,767 samples that are held") };
        const { assert!(TOOLS > 0 && TOOLS <= TOOLS_MAX, "between 1 and 8 tools") };
        Self {
            mobility: [0.0; CELLS],
            factors: [0.0; CELLS],
            pulls: [Cell::ZERO; CELLS],
            near: [NearTriangle::NONE; NEAR],
            anchors: [[Anchor::EMPTY; HELD]; 2],
            pins: [PinSample::NONE; PINNED],
            coarse: [CoarseTouch::NONE],
            tools: [ToolState::EMPTY; TOOLS],
            state: [TouchState::AWAY],
        }
    }

    /// Borrows it as memory for a tissue.
    #[must_use]
    pub fn room(&mut self) -> TouchRoom<'_> {
        TouchRoom::new(TouchArrays {
            mobility: &mut self.mobility,
            factors: &mut self.factors,
            pulls: &mut self.pulls,
            near: &mut self.near,
            anchors: self.anchors.as_flattened_mut(),
            pins: &mut self.pins,
            coarse: &mut self.coarse,
            tools: &mut self.tools,
            state: &mut self.state,
        })
    }
}

impl<
    const CELLS: usize,
    const NEAR: usize,
    const HELD: usize,
    const TOOLS: usize,
    const PINNED: usize,
> Default for TouchStore<CELLS, NEAR, HELD, TOOLS, PINNED>
{
    fn default() -> Self {
        Self::new()
    }
}

/// Room for contact on surfaces; without size in a kernel that is built without it.
pub struct TouchRoom<'a>([TouchArrays<'a>; BUILT]);

impl<'a> TouchRoom<'a> {
    /// Memory in these arrays.
    #[must_use]
    pub fn new(arrays: TouchArrays<'a>) -> Self {
        let mut arrays = Some(arrays);
        Self([(); BUILT].map(|()| arrays.take().unwrap_or_default()))
    }

    /// No memory: tools are refused.
    #[must_use]
    pub fn none() -> Self {
        Self([(); BUILT].map(|()| TouchArrays::default()))
    }

    /// The same memory, for a shorter lifetime.
    #[must_use]
    pub fn reborrow(&mut self) -> TouchRoom<'_> {
        TouchRoom(self.0.each_mut().map(|arrays| TouchArrays {
            mobility: arrays.mobility,
            factors: arrays.factors,
            pulls: arrays.pulls,
            near: arrays.near,
            anchors: arrays.anchors,
            pins: arrays.pins,
            coarse: arrays.coarse,
            tools: arrays.tools,
            state: arrays.state,
        }))
    }

    /// Number of cells that the memory holds, 0 if it holds no triangles.
    pub(crate) fn capacity(&self) -> usize {
        let Some(arrays) = self.0.first() else { return 0 };
        if arrays.near.is_empty() || arrays.coarse.is_empty() || arrays.state.is_empty() {
            return 0;
        }
        arrays.mobility.len().min(arrays.factors.len()).min(arrays.pulls.len())
    }

    /// Number of tools that the memory holds, and of anchors.
    pub(crate) fn tool_capacity(&self) -> (usize, usize) {
        self.0.first().map_or((0, 0), |arrays| (arrays.tools.len(), arrays.anchors.len() / 2))
    }

    /// The chosen tools.
    pub(crate) fn tools(&self) -> &[ToolState] {
        let Some(arrays) = self.0.first() else { return &[] };
        let count = arrays.state.first().map_or(0, |state| state.tools);
        arrays.tools.get(..count).unwrap_or(&[])
    }

    /// A tool, if it is engaged.
    pub(crate) fn tool(&self, index: usize) -> Option<&ToolState> {
        self.tools().get(index).filter(|tool| tool.is_in)
    }

    /// Disengages all tools; level and wake flags are not touched.
    pub(crate) fn leave(&mut self) {
        for arrays in &mut self.0 {
            arrays.tools.iter_mut().for_each(ToolState::leave);
            for state in &mut *arrays.state {
                *state =
                    TouchState { tools: state.tools, friction: state.friction, ..TouchState::AWAY };
            }
        }
    }

    /// Makes the next tick take the bounds of all cells from the model.
    #[cfg(feature = "cut")]
    pub(crate) fn forget_bounds(&mut self) {
        self.0.iter_mut().flat_map(|arrays| &mut *arrays.state).for_each(|state| {
            state.is_filled = false;
        });
    }

    /// One pass over the part that a snapshot holds.
    pub(crate) fn keep(&mut self, cells: usize, pass: &mut Pass<'_>) {
        let Some(arrays) = self.0.first_mut() else { return };
        let mut state = arrays.state.first().copied().unwrap_or(TouchState::AWAY);
        state.keep(pass);
        let cells = if state.tools > 0 { cells } else { 0 };
        pass.slice(arrays.mobility, cells);
        pass.slice(arrays.factors, cells);
        pass.slice(arrays.pulls, cells);
        match arrays.near.get_mut(..state.count) {
            // More subdivisions would be more samples than a tick can look at.
            Some(near) => pass.slice_if(near, |_, near| near.parts <= SUBDIVISIONS_MAX),
            None => pass.slice(arrays.near, state.count),
        }
        let (first, second) = arrays.anchors.split_at_mut(arrays.anchors.len() / 2);
        pass.slice(if state.is_second { second } else { first }, state.anchors);
        pass.slice(arrays.tools, state.tools);
        if state.tools > 0
            && let [coarse, ..] = arrays.coarse
        {
            coarse.keep(pass);
        }
        if let Some(slot) = arrays.state.first_mut().filter(|_| pass.is_reading()) {
            *slot = state;
        }
    }

    /// One pass over the edges of blades, which a snapshot of a body holds that can be cut.
    #[cfg(feature = "cut")]
    pub(crate) fn keep_edges(&mut self, pass: &mut Pass<'_>) {
        let Some(arrays) = self.0.first_mut() else { return };
        let mut count = arrays.state.first().map_or(0, |state| state.tools);
        count.keep(pass);
        let Some(tools) = arrays.tools.get_mut(..count) else { return pass.refuse() };
        for tool in tools {
            let mut edge = tool.proxy.edge;
            edge.keep(pass);
            if pass.is_reading() {
                tool.proxy.edge = edge;
            }
        }
    }

    /// One pass over the pins: a snapshot of a body without pins has no words of them.
    pub(crate) fn keep_pins(&mut self, pass: &mut Pass<'_>) {
        let Some(arrays) = self.0.first_mut() else { return };
        let Some(state) = arrays.state.first_mut() else { return };
        let (mut count, mut changed) = (state.pins, state.pins_changed);
        if pass.has_more(count > 0 || changed) {
            if pass.word(PinSample::LAYOUT) != PinSample::LAYOUT {
                pass.refuse();
            }
            count.keep(pass);
            changed.keep(pass);
        } else {
            (count, changed) = (0, false);
        }
        pass.slice(arrays.pins, count);
        if pass.is_reading() {
            (state.pins, state.pins_changed) = (count, changed);
        }
    }

    /// Makes the next tick with a sweep find bounds and coarse level anew, if there are pins.
    pub(crate) fn note_pins(&mut self) {
        for arrays in &mut self.0 {
            let holds = !arrays.pins().is_empty();
            arrays.state.iter_mut().for_each(|state| state.pins_changed |= holds);
        }
    }

    /// Drops all pins.
    pub(crate) fn drop_pins(&mut self) {
        self.note_pins();
        self.0.iter_mut().flat_map(|arrays| &mut *arrays.state).for_each(|state| state.pins = 0);
    }

    /// The state shared by all tools, and the memory of pins.
    pub(crate) fn state(&self) -> Option<(&TouchState, &[PinSample])> {
        let arrays = self.0.first()?;
        Some((arrays.state.first()?, arrays.pins))
    }

    /// The pinned samples.
    pub(crate) fn pins(&self) -> &[PinSample] {
        self.0.first().map_or(&[], TouchArrays::pins)
    }

    /// The whole arrays.
    pub(crate) fn whole(&mut self) -> Option<&mut TouchArrays<'a>> {
        self.0.first_mut()
    }

    /// The arrays cut to a model's size and to the chosen tools.
    pub(crate) fn arrays(&mut self, cells: usize) -> Option<TouchArrays<'_>> {
        let arrays = self.0.first_mut()?;
        let count = arrays.state.first()?.tools;
        Some(TouchArrays {
            mobility: arrays.mobility.get_mut(..cells)?,
            factors: arrays.factors.get_mut(..cells)?,
            pulls: arrays.pulls.get_mut(..cells)?,
            near: arrays.near,
            anchors: arrays.anchors,
            pins: arrays.pins,
            coarse: arrays.coarse,
            tools: arrays.tools.get_mut(..count)?,
            state: arrays.state,
        })
    }
}

impl<'a> TouchArrays<'a> {
    /// The triangles in reach.
    pub(crate) fn near(&self) -> &[NearTriangle] {
        let count = self.state.first().map_or(0, |state| state.count);
        self.near.get(..count).unwrap_or(&[])
    }

    /// The anchors of this tick.
    pub(crate) fn anchors(&self) -> &[Anchor] {
        self.state.first().map_or(&[][..], |state| state.present(self.anchors))
    }

    /// The pinned samples.
    pub(crate) fn pins(&self) -> &[PinSample] {
        self.pins.get(..self.pinned()).unwrap_or(&[])
    }

    /// The same to be changed.
    pub(crate) fn pins_mut(&mut self) -> &mut [PinSample] {
        let count = self.pinned();
        self.pins.get_mut(..count).unwrap_or_default()
    }

    /// Number of pinned samples: none in a kernel that is built without pins.
    fn pinned(&self) -> usize {
        if !PINS_ARE_BUILT {
            return 0;
        }
        self.state.first().map_or(0, |state| state.pins)
    }

    /// The tools and their effect on a coarse level, for the sweeps of a tick; nothing while no tool is
    /// engaged and no pin holds.
    pub(crate) fn touching(self, model: &Model<'_>) -> (Touch<'a>, Option<&'a CoarseTouch>) {
        let none = (Touch::NONE, None);
        let Some(state) = self.state.first() else { return none };
        let cuts = Proxies(self.tools).fronts().next().is_some();
        let pins = self.pins.get(..self.pinned()).unwrap_or(&[]);
        if !cuts
            && pins.is_empty()
            && (state.count == 0 || !self.tools.iter().any(|tool| tool.is_in))
        {
            return none;
        }
        let is_elastic = model.coarse_basis.is_some_and(|basis| basis.elastic().is_some());
        let touching = Touching {
            tools: Proxies(self.tools),
            near: self.near.get(..state.count).unwrap_or(&[]),
            anchors: state.present(self.anchors),
            pins,
            slices: &state.slices,
            mobility: self.mobility,
            factors: if is_elastic { self.factors } else { &[] },
            pulls: core::cell::Cell::from_mut(self.pulls).as_slice_of_cells(),
        };
        (Touch::of(Some(touching)), self.coarse.first())
    }
}

kept! {
    /// State shared by all tools.
    #[derive(Debug, Clone, Copy)]
    pub struct TouchState {
        /// Number of chosen tools.
        pub(crate) tools: usize,
        /// Coefficient of friction.
        pub(crate) friction: f32,
        /// Number of triangles in reach.
        pub(crate) count: usize,
        /// The slices that contain corners of those triangles.
        pub(crate) slices: SliceSet,
        /// True if the bounds of all other cells are those of this model.
        pub(crate) is_filled: bool,
        /// Number of held samples, in one half of the list.
        pub(crate) anchors: usize,
        /// True if that is the second half.
        pub(crate) is_second: bool,
    } not stored {
        /// Number of pinned samples; snapshots of bodies with pins have it.
        pub(crate) pins: usize = 0,
        /// True if pins changed, so that bounds and coarse level have to be found anew.
        pub(crate) pins_changed: bool = false,
    }
}

impl TouchState {
    /// No tool is engaged.
    pub const AWAY: Self = Self {
        tools: 0,
        friction: 0.0,
        count: 0,
        slices: SliceSet::EMPTY,
        is_filled: false,
        anchors: 0,
        is_second: false,
        pins: 0,
        pins_changed: false,
    };

    /// The anchors of this tick among those in both halves of the list.
    pub(crate) fn present<'a>(&self, anchors: &'a [Anchor]) -> &'a [Anchor] {
        let first = if self.is_second { anchors.len() / 2 } else { 0 };
        anchors.get(first..first + self.anchors).unwrap_or(&[])
    }
}
