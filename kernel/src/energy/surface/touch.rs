//! The tools' part in passes over the cells: the cells' bounds with the tools, and the tools' contribution to
//! the residuals.

use core::cell;

use super::BUILT;
use super::friction::Anchor;
use super::near::NearTriangle;
use super::pins::{PINS_ARE_BUILT, PinSample};
use super::press::at_corners;
use super::tool::Proxies;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::energy::links::number::LinkNumber;
use crate::energy::state::StatesOf;
use crate::energy::term::{Here, Pass, Term};
use crate::model::terms::Keeps;
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// The tools, their triangles and the pins in a tick.
#[derive(Clone, Copy)]
pub(crate) struct Touching<'a> {
    pub tools: Proxies<'a>,
    pub near: &'a [NearTriangle],
    pub anchors: &'a [Anchor],
    pub pins: &'a [PinSample],
    /// The slices that contain corners of these triangles.
    pub slices: &'a SliceSet,
    /// 1 / W of every cell with the tools' part.
    pub mobility: &'a [f32],
    /// The local part of every cell's direction over r / W, with the tools; empty without an elastic level.
    pub factors: &'a [f32],
    /// The tools' contribution to the residuals, written anew in those slices for each pass.
    pub pulls: &'a [cell::Cell<Cell>],
}

impl Touching<'_> {
    /// Computes the tools' contribution to the residuals of a pass at these outputs.
    pub fn pull(&self, at: &impl Fn(usize) -> [f32; 3]) {
        for slice in self.slices.iter(self.pulls.len().div_ceil(LANES)) {
            let cells = self.pulls.get(cells_of(slice, self.pulls.len()));
            cells.unwrap_or(&[]).iter().for_each(|pull| pull.set(Cell::ZERO));
        }
        for near in self.near {
            let Some(solid) = self.tools.part(near.of) else { continue };
            let corners = near.corners.map(|cell| at(cell.into()));
            let Some(corners) = at_corners(solid, near, self.anchors, corners) else { continue };
            for (&cell, more) in near.corners.iter().zip(corners) {
                if let Some(pull) = self.pulls.get(usize::from(cell)) {
                    pull.set(pull.get().plus(Cell(more)));
                }
            }
        }
        self.pull_edges(at);
        if PINS_ARE_BUILT {
            self.pull_pins(at);
        }
    }

    /// Adds the pins.
    fn pull_pins(&self, at: &impl Fn(usize) -> [f32; 3]) {
        for pin in self.pins {
            let pulled = pin.pull(at);
            self.spread(pin.corners.iter().zip(pin.weights), pulled.force, pulled.energy);
        }
    }

    /// Adds a force and an energy to cells with these weights.
    #[inline(always)]
    fn spread<'c>(
        &self,
        cells: impl Iterator<Item = (&'c u16, f32)>,
        [x, y, z]: [f32; 3],
        energy: f32,
    ) {
        let all = Cell([x, y, z, 8.0 * energy]);
        for (&cell, weight) in cells {
            if let Some(pull) = self.pulls.get(usize::from(cell)) {
                pull.set(pull.get().plus(Cell(all.0.map(|part| weight * part))));
            }
        }
    }

    /// Adds the edges of blades.
    fn pull_edges(&self, at: &impl Fn(usize) -> [f32; 3]) {
        for edge in self.tools.edges() {
            for sample in edge.fronts() {
                let Some(pressed) = sample.press(edge.forward(), at) else { continue };
                let cells = sample.corners.iter().zip(sample.weights);
                self.spread(cells, pressed.force, pressed.energy);
            }
        }
    }

    /// Calls `add(residual, contribution)` for the cells of awake slices that have one.
    #[inline(always)]
    fn each<N>(
        &self,
        awake: &SliceSet,
        residual: &mut [Cell<N>],
        mut add: impl FnMut(&mut Cell<N>, Cell),
    ) {
        let count = residual.len();
        for slice in self.slices.iter(count.div_ceil(LANES)).filter(|&one| awake.contains(one)) {
            let cells = residual.get_mut(cells_of(slice, count)).unwrap_or_default();
            for (r, pull) in cells.iter_mut().zip(self.of_slice(slice).into_iter().flatten()) {
                add(r, pull);
            }
        }
    }

    /// The contribution to the residuals of a slice; `None` if there is none.
    #[inline(always)]
    pub fn of_slice(&self, slice: usize) -> Option<Chunk> {
        if !self.slices.contains(slice) {
            return None;
        }
        let mut chunk = [Cell::ZERO; LANES];
        let pulls = self.pulls.get(cells_of(slice, self.pulls.len())).unwrap_or(&[]);
        for (slot, pull) in chunk.iter_mut().zip(pulls) {
            *slot = pull.get();
        }
        Some(chunk)
    }
}

/// The tools in contact in this tick, if any; without size in a kernel without contact on surfaces.
#[derive(Clone, Copy)]
pub(crate) struct Touch<'a>([Option<Touching<'a>>; BUILT]);

impl<'a> Touch<'a> {
    /// No tool.
    pub const NONE: Self = Self([None; BUILT]);

    /// Tools.
    pub fn of(touching: Option<Touching<'a>>) -> Self {
        let mut touching = touching;
        Self([(); BUILT].map(|()| touching.take()))
    }

    #[inline(always)]
    pub fn get(&self) -> Option<&Touching<'a>> {
        self.0.first()?.as_ref()
    }
}

impl Keeps for Touch<'_> {}

impl<N: LinkNumber> Term<N> for Touch<'_> {
    #[inline(always)]
    fn prepare(self, at: &impl Fn(usize) -> [f32; 3]) {
        if let Some(touching) = self.get() {
            touching.pull(at);
        }
    }

    #[inline(always)]
    fn accumulate<const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        _: &mut N::Tally,
        _: StatesOf<'_>,
    ) {
        if let Some(touching) = self.get() {
            let add = |r: &mut Cell<N>, pull: Cell| *r = r.plus(Cell(pull.0.map(N::from_single)));
            touching.each(pass.awake, residual, add);
        }
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        _: StatesOf<'_>,
    ) {
        if let Some(pulls) = self.get().and_then(|touching| touching.of_slice(here.slice)) {
            add_to(sum, &pulls);
        }
    }
}

/// The tools' contribution to a pass of several threads, which stands in the residuals before the pass.
#[derive(Clone, Copy)]
pub(crate) struct Pulled<'a>(Option<&'a SliceSet>);

impl<'a> Pulled<'a> {
    /// Writes the contribution into the residuals of awake slices.
    pub fn put(touch: Touch<'a>, awake: &SliceSet, residual: &mut [Cell]) -> Self {
        let Some(touching) = touch.get() else { return Self(None) };
        touching.each(awake, residual, |r, pull| *r = pull);
        Self(Some(touching.slices))
    }
}

impl Keeps for Pulled<'_> {}

impl Term<f32> for Pulled<'_> {
    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        before: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        _: StatesOf<'_>,
    ) {
        if self.0.is_some_and(|slices| slices.contains(here.slice)) {
            add_to(sum, &before());
        }
    }
}

/// Adds to the residuals of a slice.
#[inline(always)]
fn add_to<V: F32x8>(sum: &mut [V; 4], more: &Chunk) {
    for (sum, more) in sum.iter_mut().zip(V::transposed(more)) {
        *sum = sum.plus(more);
    }
}
