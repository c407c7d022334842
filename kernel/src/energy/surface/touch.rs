//! The tools' part in passes over the cells: the cells' bounds with the tools, and the tools' contribution to
//! the residuals.

use core::cell;

use super::BUILT;
use super::friction::Anchor;
use super::near::NearTriangle;
use super::press::at_corners;
use super::tool::Proxies;
use crate::backend::f32x8::Chunk;
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::number::cell::Cell;
use crate::number::two_float::LANES;

/// The tools and their triangles in a tick.
#[derive(Clone, Copy)]
pub(crate) struct Touching<'a> {
    pub tools: Proxies<'a>,
    pub near: &'a [NearTriangle],
    pub anchors: &'a [Anchor],
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
