//! The links' part in a pass, and at the cells of a tool. Links of a body of nodal shapes carry no force.

use super::bands::{Links, rest_difference};
use super::number::LinkNumber;
use super::scalar::accumulate;
use crate::backend::f32x8::{Chunk, F32x8};
use crate::energy::held::{Contact, Touched, is_among};
use crate::energy::state::StatesOf;
use crate::energy::term::{Here, Pass, Term};
use crate::number::cell::{Cell, add, dot, scale, single, sub};
use crate::number::sqrt::sqrt;

impl<N: LinkNumber> Term<N> for Links<'_, '_> {
    #[inline(always)]
    fn accumulate<const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        tally: &mut N::Tally,
        _: StatesOf<'_>,
    ) {
        let Pass { awake, v, .. } = *pass;
        let (model, y) = (self.model, |v| pass.output(v));
        if model.is_nodal() || !CLAMPED && N::accumulate(self, awake, v, residual) {
            return;
        }
        if self.differ() {
            accumulate(model, awake, v, residual, |link, i, j, pi, pj, l0| {
                let (w, band) = (model.link_weight(link), N::band(self.alpha(link)));
                let rest = || rest_difference(model, i, j);
                let force = N::link_force(y(pi), y(pj), l0, w, band, rest)?;
                N::count(tally, force.wd2);
                Some(force)
            });
        } else {
            let band = N::band(self.alpha(0));
            accumulate(model, awake, v, residual, |_, i, j, pi, pj, l0| {
                let rest = || rest_difference(model, i, j);
                let force = N::link_force(y(pi), y(pj), l0, 1.0, band, rest)?;
                N::count(tally, force.wd2);
                Some(force)
            });
        }
        N::mend(self, awake, v, residual, y);
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        _: StatesOf<'_>,
    ) {
        if let Some(of_links) = self.of_slice(here.slice, here.cells, here.at) {
            *sum = of_links;
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
        if self.model.is_nodal() {
            return sum;
        }
        // Links between two held cells cancel.
        let outer = self.model.neighbours(cell).filter(|&(_, other)| !is_among(held, other));
        let forces = outer.filter_map(|(link, other)| self.force_at(at, link, cell, other));
        forces.fold(sum, |sum, on| add(sum, on.force))
    }

    fn touched(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        if self.model.is_nodal() {
            return;
        }
        for cell in held.iter().map(Contact::cell) {
            for (link, other) in self.model.neighbours(cell) {
                // A link between two held cells counts once.
                let counted = other < cell && is_among(held, other);
                if !counted && let Some(on) = self.force_at(at, link, cell, other) {
                    let (wd, way) = (2.0 * sqrt(dot(on.force, on.force)), sub(at(cell), at(other)));
                    let way = single(way);
                    sums.wd2 = sums.wd2.plus(on.wd2.into());
                    sums.scale += on.wd2 + wd * (sqrt(dot(way, way)) + N::GRAIN);
                }
            }
        }
    }

    fn resist(self, field: &[Cell], product: &mut [Cell]) {
        if self.model.is_nodal() {
            return;
        }
        let at = |cell: usize| field.get(cell).map_or([0.0; 3], |field| field.xyz());
        for (cell, product) in product.iter_mut().enumerate() {
            let (rest, here, mut sum) = (self.model.rest_position(cell), at(cell), product.xyz());
            for (link, other) in self.model.neighbours(cell) {
                let along = sub(self.model.rest_position(other), rest);
                let squared = dot(along, along);
                if squared > 0.0 {
                    let stretch = dot(along, sub(here, at(other)));
                    let factor = 0.5 * self.model.link_weight(link) * stretch / squared;
                    sum = add(sum, scale(factor, along));
                }
            }
            *product = Cell::at(sum);
        }
    }
}
