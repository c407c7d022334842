//! Sides of a cut that press on each other.
//!
//! A cell that is split has copies on both sides of the cut, at the same place at first. A copy may move away from
//! the other one, and along the cut, but not through it. With n the normal of the opened faces there, from x to x'
//!
//! ```text
//! E = K / 2 min(0, n . (x' - x))^2,   K = 6 / h times Young's modulus times the area of the faces
//! ```
//!
//! h the mean edge of a face. n turns with the tissue, once a tick, see `cut::lips`; within a tick it is constant. So
//! E is half the squared distance of a linear map to a half space: the bound is K (e - e')(e - e')', 2 K at either
//! cell. In the coarse level both cells have the same weights, so the term has no part in it; that of the functions on
//! one side, and of a cell that a tool holds, is left out, and the guard judges the sweep.
//!
//! Cost: some 60 instructions for each cell of a lip and pass, more where the sides press.

use super::held::{Contact, Touched, is_among};
use super::links::number::LinkNumber;
use super::state::StatesOf;
use super::term::{Here, Pass, Term, change_lane};
use crate::backend::f32x8::{Chunk, F32x8};
use crate::model::lips::{End, Lip, Lips};
use crate::number::cell::{Cell, add, dot, scale, single, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

/// Depth to which the sides of a lip overlap along its normal, the cells at these places; at least 0.
pub(crate) fn depth(normal: [f32; 3], places: [[f32; 3]; 2]) -> f32 {
    let [first, second] = places;
    let depth = dot(normal, sub(first, second));
    if depth > 0.0 { depth } else { 0.0 }
}

impl End {
    /// Force on the cell, and w times the squared depth; `None` where the sides do not press.
    fn force(&self, at: &impl Fn(usize) -> [f32; 3]) -> Option<([f32; 3], f32)> {
        let Lip { cells, weight, .. } = self.lip;
        let depth = depth(self.normal, cells.map(|cell| at(cell.into())));
        if depth <= 0.0 {
            return None;
        }
        let pressed = weight * depth;
        let along = if self.is_second { 0.5 * pressed } else { -0.5 * pressed };
        Some((scale(along, self.normal), pressed * depth))
    }
}

impl Lips<'_> {
    /// The lips at a cell.
    fn at_cell(self, cell: usize) -> impl Iterator<Item = End> {
        self.of_slice(cell / LANES).filter(move |end| end.cell() == cell)
    }
}

/// A residual with a lip's force.
fn with_force<N: LinkNumber>(residual: Cell<N>, force: [f32; 3], wd2: f32) -> Cell<N> {
    let [x, y, z] = force;
    residual.plus(Cell([x, y, z, wd2].map(N::from_single)))
}

impl<N: LinkNumber> Term<N> for Lips<'_> {
    fn accumulate<const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        _: &mut N::Tally,
        _: StatesOf<'_>,
    ) {
        if !self.is_any() {
            return;
        }
        let at = |cell: usize| single(pass.at(cell));
        for end in pass.slices().flat_map(|slice| self.of_slice(slice)) {
            if let Some((force, wd2)) = end.force(&at)
                && let Some(r) = residual.get_mut(end.cell())
            {
                *r = with_force(*r, force, wd2);
            }
        }
    }

    /// Lane by lane, since few slices have a lip.
    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        _: StatesOf<'_>,
    ) {
        if !self.is_any() {
            return;
        }
        let at = |cell: usize| here.at.get(cell).map_or([0.0; 3], |cell| cell.xyz());
        for end in self.of_slice(here.slice) {
            if let Some((force, wd2)) = end.force(&at) {
                change_lane(sum, end.cell() % LANES, |r| with_force(r, force, wd2));
            }
        }
    }

    fn cell(
        self,
        cell: usize,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sum: [f32; 3],
    ) -> [f32; 3] {
        // Lips between two held cells cancel.
        let outer = self.at_cell(cell).filter(|end| !is_among(held, end.other()));
        let forces = outer.filter_map(|end| end.force(&|cell| single(at(cell))));
        forces.fold(sum, |sum, (force, _)| add(sum, force))
    }

    fn touched(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        for end in held.iter().flat_map(|contact| self.at_cell(contact.cell())) {
            // A lip between two held cells counts once.
            let counted = end.is_second && is_among(held, end.other());
            let at = |cell: usize| single(at(cell));
            if let Some((force, wd2)) = end.force(&at).filter(|_| !counted) {
                let (way, wd) =
                    (sub(at(end.other()), at(end.cell())), 2.0 * sqrt(dot(force, force)));
                sums.wd2 = sums.wd2.plus(wd2.into());
                sums.scale += 4.0 * (wd2 + wd * sqrt(dot(way, way)));
            }
        }
    }
}
