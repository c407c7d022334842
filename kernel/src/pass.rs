//! One link pass: the residual of every cell and the energy of the whole body.
//!
//! Residual r of cell i = sum over its links of w mu (`P_j` - `P_i`) (Eq. 12), the negative gradient of
//! E = sum of w d^2 / 4. The fourth lane of a residual is the cell's sum of w d^2; adding it over
//! all cells counts each link at both ends, so E is an eighth of that sum.

use crate::access::accumulate;
use crate::awake::SliceSet;
use crate::cell::{Cell, add, dot, from_single, output, single, sub};
use crate::contact::Contact;
use crate::link::Pull;
use crate::model::Model;
use crate::number::{Number, Sum};
use crate::simd::VectorUnit;
use crate::sqrt::sqrt;
use crate::two_float::{LANES, TwoFloat};

/// What a pass needs besides positions: the body, whether its bands are closed (unloading), and how
/// the tool acts on its contact cells.
#[derive(Clone, Copy)]
pub(crate) struct Links<'a, 'm> {
    pub model: &'a Model<'m>,
    pub closed: bool,
    /// The vector unit to use.
    pub vectors: Option<VectorUnit>,
    /// The current into each contact cell; `None` where the tool holds them.
    pub current: Option<[f32; 3]>,
}

impl Links<'_, '_> {
    /// Alpha of a link, 0 while the bands are closed.
    #[inline]
    pub fn alpha(&self, link: usize) -> f32 {
        if self.closed { 0.0 } else { self.model.link_alpha(link) }
    }

    #[inline(always)]
    fn rest_difference(&self, i: usize, j: usize) -> [f32; 3] {
        sub(self.model.rest_position(j), self.model.rest_position(i))
    }

    /// Residuals and energy terms of the outputs of all states, contact cells driven; every slice
    /// has to be awake. Gives the sum of w d^2 over the cells.
    pub fn saturated_pass<N: Number>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        contacts: &[Contact<N>],
    ) -> TwoFloat {
        let k = N::from_single(self.model.saturation());
        let tally = self.accumulate(awake, v, residual, |v| output(v, k));
        self.drive(residual, contacts);
        let mut lanes = N::Energy::default();
        for (cell, r) in residual.iter().enumerate() {
            lanes.add(cell % LANES, N::energy_term(r.w()));
        }
        N::energy(&lanes, tally)
    }

    /// Residuals and energy terms link by link, at what `y` makes of the states.
    #[inline(always)]
    pub fn accumulate<N: Number>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        y: impl Fn([N; 3]) -> [N; 3],
    ) -> N::Tally {
        let model = self.model;
        let mut tally = N::Tally::default();
        if model.link_weights.is_none() && (self.closed || model.link_alphas.is_none()) {
            let band = N::band(self.alpha(0));
            accumulate(model, awake, v, residual, |_, i, j, pi, pj, l0| {
                let rest = || self.rest_difference(i, j);
                let pull = N::pull(y(pi), y(pj), l0, 1.0, band, rest)?;
                N::count(&mut tally, pull.wd2);
                Some(pull)
            });
        } else {
            accumulate(model, awake, v, residual, |link, i, j, pi, pj, l0| {
                let (w, band) = (model.link_weight(link), N::band(self.alpha(link)));
                let rest = || self.rest_difference(i, j);
                let pull = N::pull(y(pi), y(pj), l0, w, band, rest)?;
                N::count(&mut tally, pull.wd2);
                Some(pull)
            });
        }
        N::mend(self, awake, v, residual, y);
        tally
    }

    /// Takes held cells out of the residual, or adds the current to that of the contact cells;
    /// energy terms stay.
    pub fn drive<N: Number>(self, residual: &mut [Cell<N>], contacts: &[Contact<N>]) {
        for contact in contacts {
            if let Some(r) = residual.get_mut(contact.cell()) {
                let [x, y, z] = match self.current {
                    Some(current) => add(r.xyz(), from_single(current)),
                    None => [N::ZERO; 3],
                };
                *r = Cell([x, y, z, r.w()]);
            }
        }
    }

    /// Output of the state of one cell.
    fn published<N: Number>(&self, v: &[Cell<N>], cell: usize) -> [N; 3] {
        let k = N::from_single(self.model.saturation());
        v.get(cell).map_or([N::ZERO; 3], |state| output(state.xyz(), k))
    }

    /// Distance of two cells' outputs, in single precision.
    pub fn length<N: Number>(&self, v: &[Cell<N>], cell: usize, other: usize) -> f32 {
        let way = single(sub(self.published(v, cell), self.published(v, other)));
        sqrt(dot(way, way))
    }

    /// The pull, in single precision, of one link on its end `cell`, the other end being `other`.
    pub fn pull_on<N: Number>(
        &self,
        v: &[Cell<N>],
        link: usize,
        cell: usize,
        other: usize,
    ) -> Option<Pull> {
        let (i, j) = if cell < other { (cell, other) } else { (other, cell) };
        let (yi, yj) = (self.published(v, i), self.published(v, j));
        let l0 = self.model.rest_length.get(link).copied()?;
        let (w, band) = (self.model.link_weight(link), N::band(self.alpha(link)));
        let pull = N::pull_single(yi, yj, l0, w, band, || self.rest_difference(i, j))?;
        Some(if cell == i { pull } else { Pull { force: pull.force.map(|f| -f), ..pull } })
    }
}
