//! Memory for contact on surfaces, and what a tissue keeps of its sphere.

use crate::backend::slice_set::SliceSet;
use crate::model::Model;
use crate::number::cell::Cell;
use crate::solver::coarse::CoarseTouch;
use crate::terms::surface::{BUILT, Ball, Meeting, NearTriangle, Touch, Touching};

/// Arrays for contact on surfaces, in memory of the caller.
pub struct TouchArrays<'a> {
    /// Bounds of the cells, one a cell.
    pub mobility: &'a mut [f32],
    /// Factors of the cells' own parts, one a cell.
    pub factors: &'a mut [f32],
    /// What the sphere does to the residuals, one a cell.
    pub pulls: &'a mut [Cell],
    /// Triangles in reach: the capacity. Where more are, the nearest ones are kept.
    pub near: &'a mut [NearTriangle],
    /// The coarse level under the sphere: one.
    pub coarse: &'a mut [CoarseTouch],
    /// The sphere: one.
    pub sphere: &'a mut [Sphere],
}

/// Room for contact on surfaces; without size in a kernel that is built without it.
pub struct TouchRoom<'a>([TouchArrays<'a>; BUILT]);

impl<'a> TouchRoom<'a> {
    /// Room in these arrays.
    #[must_use]
    pub fn new(arrays: TouchArrays<'a>) -> Self {
        let mut arrays = Some(arrays);
        Self([(); BUILT].map(|()| arrays.take().unwrap_or_else(TouchArrays::none)))
    }

    /// No room: a probe on a model with a contact surface is refused.
    #[must_use]
    pub fn none() -> Self {
        Self([(); BUILT].map(|()| TouchArrays::none()))
    }

    /// The same memory, for a shorter time.
    #[must_use]
    pub fn reborrow(&mut self) -> TouchRoom<'_> {
        TouchRoom(self.0.each_mut().map(|arrays| TouchArrays {
            mobility: arrays.mobility,
            factors: arrays.factors,
            pulls: arrays.pulls,
            near: arrays.near,
            coarse: arrays.coarse,
            sphere: arrays.sphere,
        }))
    }

    /// Cells that there is room for, where triangles have room too.
    pub(crate) fn capacity(&self) -> usize {
        let Some(arrays) = self.0.first() else { return 0 };
        if arrays.near.is_empty() || arrays.coarse.is_empty() || arrays.sphere.is_empty() {
            return 0;
        }
        arrays.mobility.len().min(arrays.factors.len()).min(arrays.pulls.len())
    }

    /// The sphere while it is engaged.
    pub(crate) fn sphere(&self) -> Option<&Sphere> {
        self.0.first()?.sphere.first().filter(|sphere| sphere.is_in)
    }

    /// The sphere is away, without a word to the body.
    pub(crate) fn leave(&mut self) {
        for arrays in &mut self.0 {
            arrays.sphere.fill(Sphere::AWAY);
        }
    }

    /// The arrays cut to a model's size.
    pub(crate) fn arrays(&mut self, cells: usize) -> Option<TouchArrays<'_>> {
        let arrays = self.0.first_mut()?;
        Some(TouchArrays {
            mobility: arrays.mobility.get_mut(..cells)?,
            factors: arrays.factors.get_mut(..cells)?,
            pulls: arrays.pulls.get_mut(..cells)?,
            near: arrays.near,
            coarse: arrays.coarse,
            sphere: arrays.sphere,
        })
    }
}

impl<'a> TouchArrays<'a> {
    fn none() -> Self {
        Self {
            mobility: &mut [],
            factors: &mut [],
            pulls: &mut [],
            near: &mut [],
            coarse: &mut [],
            sphere: &mut [],
        }
    }

    /// The sphere, while it is engaged, and what it does to a coarse level, for the sweeps of a tick.
    pub(crate) fn touching(&mut self, model: &Model<'_>) -> (Touch<'_>, Option<&CoarseTouch>) {
        let none = (Touch::NONE, None);
        let Some(sphere) = self.sphere.first().filter(|sphere| sphere.is_in) else { return none };
        let near = self.near.get(..sphere.count).unwrap_or(&[]);
        if near.is_empty() {
            return none;
        }
        let is_elastic = model.coarse_basis.is_some_and(|basis| basis.elastic().is_some());
        let touching = Touching {
            ball: sphere.ball,
            near,
            slices: &sphere.slices,
            mobility: self.mobility,
            factors: if is_elastic { self.factors } else { &[] },
            pulls: core::cell::Cell::from_mut(&mut *self.pulls).as_slice_of_cells(),
        };
        (Touch::of(Some(touching)), self.coarse.first())
    }
}

/// The sphere as the tissue meets it.
#[derive(Debug, Clone, Copy)]
pub struct Sphere {
    pub(crate) ball: Ball,
    /// Whether it is engaged.
    pub(crate) is_in: bool,
    /// Triangles in reach.
    pub(crate) count: usize,
    /// The slices that have corners of them.
    pub(crate) slices: SliceSet,
    /// What it met behind the last sweeps.
    pub(crate) met: Meeting,
    /// How far it went in this tick.
    pub(crate) way: [f32; 3],
}

impl Sphere {
    /// Not engaged.
    pub const AWAY: Self = Self {
        ball: Ball { centre: [0.0; 3], radius: 0.0, whole: 0.0 },
        is_in: false,
        count: 0,
        slices: SliceSet::EMPTY,
        met: Meeting::NONE,
        way: [0.0; 3],
    };
}
