//! One link pass: the residual of every cell and the energy of the whole body.
//!
//! Residual r of cell i = sum over its links of w mu (`P_j` - `P_i`) (Eq. 12), the negative gradient of
//! E = sum of w d^2 / 4. The fourth lane of a residual is the cell's sum of w d^2; adding it over
//! all cells counts each link at both ends, so E is an eighth of that sum.

use crate::access::accumulate;
use crate::awake::SliceSet;
use crate::cell::{Cell, dot, output, sub};
use crate::contact::Contact;
use crate::link::{Band, Pull, pull};
use crate::model::Model;
use crate::simd::octet::{Lanes8, Octet};
use crate::simd::sliced::SlicedPass;
use crate::simd::{VectorUnit, Work, run};
use crate::slice::eight;
use crate::sqrt::sqrt;
use crate::two_float::{LANES, Lanes, TwoFloat};

/// What a pass needs besides positions: the body and whether its bands are closed (unloading).
#[derive(Clone, Copy)]
pub(crate) struct Links<'a, 'm> {
    pub model: &'a Model<'m>,
    pub closed: bool,
    /// The vector unit to use.
    pub vectors: Option<VectorUnit>,
}

/// What a pass sums over the cells beside their residuals, eight cells at a time.
pub(crate) trait Reduce {
    /// Adds the terms of a slice: where its cells are, and their residuals with held cells masked.
    fn slice<V: Octet>(&mut self, slice: usize, at: [V; 3], residual: [V; 4]);
}

/// The energy alone.
#[derive(Default)]
pub(crate) struct Energy(Lanes);

impl Reduce for Energy {
    #[inline(always)]
    fn slice<V: Octet>(&mut self, _slice: usize, _at: [V; 3], [_, _, _, wd2]: [V; 4]) {
        self.0.add(wd2);
    }
}

impl Energy {
    /// E in internal units.
    pub fn total(&self) -> TwoFloat {
        self.0.total().times_power_of_two(0.125)
    }
}

/// Held cells, ascending, met slice by slice.
pub(crate) struct Held<'a> {
    contacts: &'a [Contact],
    /// Those before this one lie in earlier slices.
    next: usize,
}

impl<'a> Held<'a> {
    pub fn new(contacts: &'a [Contact]) -> Self {
        Self { contacts, next: 0 }
    }

    /// Which cells of a slice are free, where some are held. Slices are to be asked for ascending.
    #[inline(always)]
    pub fn mask<V: Octet>(&mut self, slice: usize) -> Option<V::Mask> {
        let (first, mut held, mut any) = (slice * LANES, [0.0; LANES], false);
        while let Some(contact) = self.contacts.get(self.next) {
            if contact.cell() >= first + LANES {
                break;
            }
            if let Some(lane) = held.get_mut(contact.cell().wrapping_sub(first)) {
                *lane = 1.0;
                any = true;
            }
            self.next += 1;
        }
        if any { Some(V::load(&held).below(V::splat(0.5))) } else { None }
    }
}

impl Links<'_, '_> {
    /// The band of a link in force.
    #[inline]
    pub fn band(&self, link: usize) -> Band {
        Band::new(if self.closed { 0.0 } else { self.model.link_alpha(link) })
    }

    #[inline(always)]
    fn rest_difference(&self, i: usize, j: usize) -> [f32; 3] {
        sub(self.model.rest_position(j), self.model.rest_position(i))
    }

    /// Residuals and energy terms of the states `v`, into `residual`, held cells masked; and what
    /// `reduce` sums on the way. Both only of awake slices: in all others links are slack and
    /// residuals 0.
    ///
    /// The states must lie within K.
    pub fn pass(
        self,
        awake: &SliceSet,
        v: &[Cell],
        residual: &mut [Cell],
        held: &[Contact],
        reduce: &mut impl Reduce,
    ) {
        if let (Some(_), Some(slices)) = (self.vectors, self.model.slices) {
            let held = Held::new(held);
            let pass = SlicedPass { links: self, slices, awake, at: v, residual, held, reduce };
            return run(self.vectors, pass);
        }
        self.accumulate(awake, v, residual, |v| v);
        mask(residual, held);
        run(self.vectors, Reduction { model: self.model, awake, at: v, residual, reduce });
    }

    /// Residuals and energy terms of the outputs of all states, held cells masked; every slice has
    /// to be awake.
    pub fn saturated_pass(
        self,
        awake: &SliceSet,
        v: &[Cell],
        residual: &mut [Cell],
        held: &[Contact],
    ) {
        let k = self.model.saturation();
        self.accumulate(awake, v, residual, |v| output(v, k));
        mask(residual, held);
    }

    fn accumulate(
        self,
        awake: &SliceSet,
        v: &[Cell],
        residual: &mut [Cell],
        y: impl Fn([f32; 3]) -> [f32; 3],
    ) {
        let model = self.model;
        if model.link_weights.is_none() && (self.closed || model.link_alphas.is_none()) {
            let band = self.band(0);
            accumulate(model, awake, v, residual, |_, i, j, pi, pj, l0| {
                pull(y(pi), y(pj), l0, 1.0, band, || self.rest_difference(i, j))
            });
        } else {
            accumulate(model, awake, v, residual, |link, i, j, pi, pj, l0| {
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

/// The sums of a pass from residuals that are there.
struct Reduction<'a, 'm, R> {
    model: &'a Model<'m>,
    awake: &'a SliceSet,
    at: &'a [Cell],
    residual: &'a [Cell],
    reduce: &'a mut R,
}

impl<R: Reduce> Work for Reduction<'_, '_, R> {
    type Output = ();

    #[inline(always)]
    fn run<V: Octet>(self) {
        let cells = self.model.cells();
        for slice in self.awake.iter(self.model.slice_count()) {
            let (mut here, mut there) = ([Cell::ZERO; LANES], [Cell::ZERO; LANES]);
            let [x, y, z, _] = V::transposed(eight(self.at, slice, &mut here));
            let mut residual = *eight(self.residual, slice, &mut there);
            // Beyond the last cell there is nothing to sum.
            for beyond in residual.iter_mut().skip(cells.saturating_sub(slice * LANES)) {
                *beyond = Cell::ZERO;
            }
            self.reduce.slice(slice, [x, y, z], V::transposed(&residual));
        }
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
        lanes.add(Lanes8(*block));
        *block = [0.0; LANES];
    }
}
