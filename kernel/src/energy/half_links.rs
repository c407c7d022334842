//! One walk over half-links, with a law for each term that has them.
//!
//! A half-link is a link as one of its ends has it: both ends compute the same bits. A [`Law`] says how much the
//! half-links of a group pull, for one of them and for eight side by side; the walk gathers the ends, adds forces and
//! energies, and gives a link of zero length the direction of the rest shape.
//!
//! A body without the term pays for one test in a slice: the walk is a function of its own, so that its loop takes no
//! register of the other terms.

use super::held::{Contact, Touched, is_among};
use super::links::law::COINCIDENT;
use super::links::number::LinkNumber;
use super::nodal::places;
use super::term::{Here, Pass, change_lane};
use crate::backend::Work;
use crate::backend::f32x8::F32x8;
use crate::backend::lane::{Lane, Real};
use crate::model::{range, slots_of};
use crate::number::cell::{Cell, dot, scale, single, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::LANES;

/// A number of each half-link of a group.
pub(crate) type Row = [f32; LANES];

/// The half-links of a body, in groups of eight.
#[derive(Clone, Copy)]
pub(crate) struct Groups<'a> {
    /// Groups of each slice, slices + 1.
    pub rows: &'a [u32],
    /// Other ends, by group and lane.
    pub ids: &'a [[u16; LANES]],
    /// Rest positions of the cells.
    pub rest: &'a [[f32; 3]],
}

/// The pull of half-links.
pub(crate) struct Pull<V> {
    /// Rest length, and length.
    pub l0: Lane<V>,
    pub length: Lane<V>,
    /// Twice the force along the link, and the sum of w d^2.
    pub wd: Lane<V>,
    pub wd2: Lane<V>,
}

impl<V: Real> Pull<V> {
    /// True where a link of this squared length has zero length.
    #[inline(always)]
    fn is_void(&self, u2: Lane<V>) -> V::Mask {
        (Lane::of(COINCIDENT) * (self.l0 * self.l0)).above(u2)
    }

    /// Factor of the vector between the ends. A link of zero length takes the rest shape's vector, which is l0 long;
    /// padding has no vector.
    #[inline(always)]
    fn factor(&self, u2: Lane<V>) -> Lane<V> {
        let double = Lane::select(self.is_void(u2), self.l0 + self.l0, self.length + self.length);
        self.wd / Lane::select(double.above(Lane::of(0.0)), double, Lane::of(1.0))
    }
}

/// The law of a term of half-links, and the walk over them.
pub(crate) trait Law: Copy {
    /// Returns true if the body has the term.
    fn is_there(self) -> bool;

    /// Returns the body's half-links.
    fn groups(&self) -> Groups<'_>;

    /// Returns how much the half-links of a group pull at these squared lengths, `None` if none of them does; `lanes`
    /// returns the numbers of a row.
    fn pull<V: Real>(
        self,
        group: usize,
        u2: Lane<V>,
        lanes: impl Fn(&Row) -> Lane<V>,
    ) -> Option<Pull<V>>;

    /// Returns the force of one link on `cell`, and w d^2.
    fn force(
        self,
        group: usize,
        cell: usize,
        other: usize,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<([f32; 3], f32)> {
        let way = sub(at(other), at(cell));
        let u2 = Lane(dot(way, way));
        let lane = |row: &Row| Lane(row.get(cell % LANES).copied().unwrap_or(0.0));
        let pull = self.pull(group, u2, lane)?;
        let place = |cell: usize| self.groups().rest.get(cell).copied().unwrap_or([0.0; 3]);
        let way = if pull.is_void(u2) { sub(place(other), place(cell)) } else { way };
        Some((scale(pull.factor(u2).0, way), pull.wd2.0))
    }

    /// Adds the forces of a cell's half-links to its residual.
    fn residual(self, cell: usize, at: &impl Fn(usize) -> [f32; 3], sum: Cell) -> Cell {
        let Groups { rows, ids, .. } = self.groups();
        let forces = slots_of(rows, ids, cell);
        let forces = forces.filter_map(|(group, other)| self.force(group, cell, other, at));
        forces.fold(sum, |sum, ([x, y, z], wd2)| sum.plus(Cell([x, y, z, wd2])))
    }

    /// The same in a slice that has a link of zero length.
    #[cold]
    #[inline(never)]
    fn one_by_one(self, cell: usize, at: &[Cell], sum: Cell) -> Cell {
        self.residual(cell, &|cell| at.get(cell).map_or([0.0; 3], |cell| cell.xyz()), sum)
    }

    /// Adds the forces to the residuals of awake slices, cell by cell.
    fn add_to_cells<N: LinkNumber, const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
    ) {
        if !self.is_there() {
            return;
        }
        let place = |cell: usize| single(pass.at(cell));
        for cell in pass.cells() {
            let Some(r) = residual.get_mut(cell) else { continue };
            let before = Cell(r.0.map(N::single));
            *r = Cell(self.residual(cell, &place, before).0.map(N::from_single));
        }
    }

    /// Adds the forces to the residuals of a slice, eight cells side by side; the same bits.
    #[inline(always)]
    fn add_to_slice<V: F32x8>(self, here: Here<'_, V>, sum: &mut [V; 4]) {
        if self.is_there() {
            // By way of memory: the walk is apart, and the sums stay in registers where there is none.
            let Here { slice, cells, at } = here;
            let work = Slice { law: self, slice, at, cells: stored(cells), sum: stored(*sum) };
            *sum = V::apart(work).each_ref().map(V::load);
        }
    }

    /// Adds the energy at held cells.
    fn add_touched<N: LinkNumber>(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        sums: &mut Touched,
    ) {
        if !self.is_there() {
            return;
        }
        let (at, Groups { rows, ids, .. }) = (|cell: usize| single(at(cell)), self.groups());
        for cell in held.iter().map(Contact::cell) {
            for (group, other) in slots_of(rows, ids, cell) {
                // A link between two held cells counts once.
                let counted = other < cell && is_among(held, other);
                if !counted && let Some((force, wd2)) = self.force(group, cell, other, &at) {
                    let (wd, way) = (2.0 * sqrt(dot(force, force)), sub(at(other), at(cell)));
                    sums.wd2 = sums.wd2.plus(wd2.into());
                    sums.scale += wd2.abs() + wd * sqrt(dot(way, way));
                }
            }
        }
    }
}

/// Eight numbers of each of some vectors.
#[inline(always)]
fn stored<V: F32x8, const COUNT: usize>(vectors: [V; COUNT]) -> [Row; COUNT] {
    vectors.map(|vector| {
        let mut row = [0.0; LANES];
        vector.store(&mut row);
        row
    })
}

/// The walk over the groups of a slice, in a function of its own.
struct Slice<'a, L> {
    law: L,
    slice: usize,
    /// Positions of all cells, and of those of the slice.
    at: &'a [Cell],
    cells: [Row; 3],
    /// Their residuals.
    sum: [Row; 4],
}

impl<L: Law> Work for Slice<'_, L> {
    type Output = [Row; 4];

    #[inline(always)]
    fn run<V: F32x8>(self) -> [Row; 4] {
        let Self { law, slice, at, cells, sum: before } = self;
        let (place, groups) =
            (|cell: usize| at.get(cell).map_or([0.0; 4], |cell| cell.0), law.groups());
        let here = cells.each_ref().map(|row| Lane(V::load(row)));
        let mut sum = before.each_ref().map(V::load);
        let mut is_void = V::splat(0.0).below(V::splat(0.0));
        // Add the groups of links.
        for group in range(groups.rows, slice) {
            let Some(ids) = groups.ids.get(group) else { continue };
            let there = places::<V>(|lane| place(ids.get(lane).copied().map_or(0, usize::from)));
            let ([a, b, c], [p, q, r]) = (here, there);
            let [x, y, z] = [p - a, q - b, r - c];
            let u2 = x * x + y * y + z * z;
            let Some(pull) = law.pull(group, u2, |row| Lane(V::load(row))) else { continue };
            is_void = V::either(is_void, pull.is_void(u2));
            let (factor, [sx, sy, sz, wd2]) = (pull.factor(u2), sum);
            let [fx, fy, fz] = [factor * x, factor * y, factor * z];
            sum = [sx.plus(fx.0), sy.plus(fy.0), sz.plus(fz.0), wd2.plus(pull.wd2.0)];
        }
        // A link of zero length: compute the slice cell by cell.
        if V::any(is_void) {
            sum = before.each_ref().map(V::load);
            let cells = slice * LANES..groups.rest.len();
            for (lane, cell) in cells.take(LANES).enumerate() {
                change_lane(&mut sum, lane, |r| law.one_by_one(cell, at, r));
            }
        }
        stored(sum)
    }
}
