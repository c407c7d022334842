//! The links of a body in a tick, with their bands or with closed ones.

use super::law::LinkForce;
use super::number::LinkNumber;
use super::scalar::accumulate;
use crate::backend::slice_set::SliceSet;
use crate::model::Model;
use crate::number::cell::{Cell, dot, output, single, sub};
use crate::number::sqrt::sqrt;

/// The links, and whether their bands are closed (unloading).
#[derive(Clone, Copy)]
pub(crate) struct Links<'a, 'm> {
    pub model: &'a Model<'m>,
    pub closed: bool,
}

impl Links<'_, '_> {
    /// Alpha of a link, 0 while the bands are closed.
    #[inline]
    pub fn alpha(&self, link: usize) -> f32 {
        if self.closed { 0.0 } else { self.model.link_alpha(link) }
    }

    /// Returns true if links differ in weight, or in band while bands are open.
    #[inline(always)]
    pub fn differ(&self) -> bool {
        self.model.link_weights.is_some() || !self.closed && self.model.link_alphas.is_some()
    }

    /// `P_j` - `P_i` of the rest shape. Not inlined: ends rarely coincide, and the loop over the links has no
    /// registers to spare for the rest shape.
    #[cold]
    #[inline(never)]
    fn rest_difference(self, i: usize, j: usize) -> [f32; 3] {
        sub(self.model.rest_position(j), self.model.rest_position(i))
    }

    /// Residuals and energies of awake slices link by link, at the outputs `y` of the states.
    #[inline(always)]
    pub fn accumulate<N: LinkNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        y: impl Fn([N; 3]) -> [N; 3],
    ) -> N::Tally {
        let model = self.model;
        let mut tally = N::Tally::default();
        if self.differ() {
            accumulate(model, awake, v, residual, |link, i, j, pi, pj, l0| {
                let (w, band) = (model.link_weight(link), N::band(self.alpha(link)));
                let rest = || self.rest_difference(i, j);
                let force = N::link_force(y(pi), y(pj), l0, w, band, rest)?;
                N::count(&mut tally, force.wd2);
                Some(force)
            });
        } else {
            let band = N::band(self.alpha(0));
            accumulate(model, awake, v, residual, |_, i, j, pi, pj, l0| {
                let rest = || self.rest_difference(i, j);
                let force = N::link_force(y(pi), y(pj), l0, 1.0, band, rest)?;
                N::count(&mut tally, force.wd2);
                Some(force)
            });
        }
        N::mend(self, awake, v, residual, y);
        tally
    }

    /// Output of the state of one cell.
    pub fn published<N: LinkNumber>(&self, v: &[Cell<N>], cell: usize) -> [N; 3] {
        let k = N::from_single(self.model.saturation());
        v.get(cell).map_or([N::ZERO; 3], |state| output(state.xyz(), k))
    }

    /// Distance of two cells' outputs, in single precision.
    pub fn length<N: LinkNumber>(&self, v: &[Cell<N>], cell: usize, other: usize) -> f32 {
        let way = single(sub(self.published(v, cell), self.published(v, other)));
        sqrt(dot(way, way))
    }

    /// The force of one link on its end `cell`, in single precision; the other end is `other`.
    pub fn force_on<N: LinkNumber>(
        &self,
        v: &[Cell<N>],
        link: usize,
        cell: usize,
        other: usize,
    ) -> Option<LinkForce> {
        self.force_at(|cell| self.published(v, cell), link, cell, other)
    }

    /// The same with the cells at the positions `at`.
    pub fn force_at<N: LinkNumber>(
        &self,
        at: impl Fn(usize) -> [N; 3],
        link: usize,
        cell: usize,
        other: usize,
    ) -> Option<LinkForce> {
        let (i, j) = if cell < other { (cell, other) } else { (other, cell) };
        let (yi, yj) = (at(i), at(j));
        let l0 = self.model.rest_length.get(link).copied()?;
        let (w, band) = (self.model.link_weight(link), N::band(self.alpha(link)));
        let on_i = N::link_force_single(yi, yj, l0, w, band, || self.rest_difference(i, j))?;
        Some(if cell == i { on_i } else { LinkForce { force: on_i.force.map(|f| -f), ..on_i } })
    }
}
