//! One link pass: the residual of every cell and the energy of the whole body.
//!
//! Residual r of cell i = sum over its links of w mu (`P_j` - `P_i`) (Eq. 12), the negative gradient of
//! E = sum of w d^2 / 4. The fourth lane of a residual is the cell's sum of w d^2; adding it over
//! all cells counts each link at both ends, so E is an eighth of that sum.

use crate::access::accumulate;
use crate::cell::{Cell, dot, output, sub};
use crate::contact::Contact;
use crate::link::{Band, Pull, pull};
use crate::model::Model;
use crate::simd::VectorUnit;
use crate::sqrt::sqrt;
use crate::two_float::{LANES, Lanes, TwoFloat};

/// What a pass needs besides positions: the body and whether its bands are closed (unloading).
#[derive(Clone, Copy)]
pub(crate) struct Links<'a, 'm> {
    pub model: &'a Model<'m>,
    pub closed: bool,
    /// The vector unit to use on sliced links.
    pub vectors: Option<VectorUnit>,
}

impl Links<'_, '_> {
    /// The band of a link in force.
    #[inline]
    fn band(&self, link: usize) -> Band {
        Band::new(if self.closed { 0.0 } else { self.model.link_alpha(link) })
    }

    #[inline(always)]
    fn rest_difference(&self, i: usize, j: usize) -> [f32; 3] {
        sub(self.model.rest_position(j), self.model.rest_position(i))
    }

    /// Residuals and energy terms of the output of the states `v`, into `residual`.
    ///
    /// `SATURATED` clamps each state on the way in; without it the states must lie within K.
    pub fn pass<const SATURATED: bool>(&self, v: &[Cell], residual: &mut [Cell]) {
        let model = self.model;
        let k = model.saturation();
        let y = |v| if SATURATED { output(v, k) } else { v };
        let uniform = model.link_weights.is_none() && (self.closed || model.link_alphas.is_none());
        if uniform {
            let band = self.band(0);
            if let (false, Some(unit), Some(slices)) = (SATURATED, self.vectors, &model.slices) {
                let coincident = |i: usize, j: usize, l0: f32| {
                    let at = |cell: usize| v.get(cell).map_or([0.0; 3], |v| v.xyz());
                    pull(at(i), at(j), l0, 1.0, band, || self.rest_difference(i, j))
                };
                unit.pass(model, slices, band, v, residual, coincident);
                return;
            }
            accumulate(model, v, residual, |_, i, j, pi, pj, l0| {
                pull(y(pi), y(pj), l0, 1.0, band, || self.rest_difference(i, j))
            });
        } else {
            accumulate(model, v, residual, |link, i, j, pi, pj, l0| {
                let (w, band) = (model.link_weight(link), self.band(link));
                pull(y(pi), y(pj), l0, w, band, || self.rest_difference(i, j))
            });
        }
    }

    /// Output of the state of one cell.
    fn published(&self, v: &[Cell], cell: usize) -> [f32; 3] {
        v.get(cell).map_or([0.0; 3], |state| output(state.xyz(), self.model.saturation()))
    }

    /// Distance of two cells' outputs.
    pub fn length(&self, v: &[Cell], cell: usize, other: usize) -> f32 {
        let way = sub(self.published(v, cell), self.published(v, other));
        sqrt(dot(way, way))
    }

    /// The pull of one link on its end `cell`, the other end being `other`.
    pub fn pull_on(&self, v: &[Cell], link: usize, cell: usize, other: usize) -> Option<Pull> {
        let (i, j) = if cell < other { (cell, other) } else { (other, cell) };
        let (yi, yj) = (self.published(v, i), self.published(v, j));
        let l0 = self.model.rest_length.get(link).copied()?;
        let (w, band) = (self.model.link_weight(link), self.band(link));
        let pull = pull(yi, yj, l0, w, band, || self.rest_difference(i, j))?;
        Some(if cell == i { pull } else { Pull { force: pull.force.map(|f| -f), ..pull } })
    }
}

/// Takes the held cells out of the residual; their energy terms stay.
pub(crate) fn mask(residual: &mut [Cell], held: &[Contact]) {
    for contact in held {
        if let Some(r) = residual.get_mut(contact.cell()) {
            *r = Cell([0.0, 0.0, 0.0, r.w()]);
        }
    }
}

/// Adds per-cell terms in the order that defines the bits: cell i into lane i mod 8, ascending.
#[inline(always)]
pub(crate) fn totals<const N: usize>(terms: impl Iterator<Item = [f32; N]>) -> [TwoFloat; N] {
    let mut lanes = [Lanes::ZERO; N];
    let mut block = [[0.0; LANES]; N];
    let mut lane = 0;
    for term in terms {
        for (block, value) in block.iter_mut().zip(term) {
            if let Some(slot) = block.get_mut(lane) {
                *slot = value;
            }
        }
        lane += 1;
        if lane == LANES {
            flush(&mut lanes, &mut block);
            lane = 0;
        }
    }
    flush(&mut lanes, &mut block);
    lanes.map(|lanes| lanes.total())
}

#[inline(always)]
fn flush<const N: usize>(lanes: &mut [Lanes; N], block: &mut [[f32; LANES]; N]) {
    for (lanes, block) in lanes.iter_mut().zip(block) {
        lanes.add(block);
        *block = [0.0; LANES];
    }
}
