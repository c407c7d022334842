//! Stiffening: sets of bands on the links of a body of nodal shapes.
//!
//! Tissue is soft at small strain and stiff beyond. A link of rest length l0 and length u is a spring outside
//! a band, and there may be several bands, one inside the other. A band may resist links that are too short alone, or
//! those that are too long alone. With `h_s` half the width of band s, `E_s` its modulus and V the volume of the
//! tetrahedra around the link
//!
//! ```text
//! d_s = u - (1 + h_s) l0 above the band, u - (1 - h_s) l0 below it, 0 inside
//! E   = sum over links and sets of w_s d_s^2 / 4,   w_s = 2 E_s V / l0^2
//! r_i = sum over links and sets of w_s d_s / 2 along the link
//! ```
//!
//! in the kernel's units. In a large even mesh set s adds Young's modulus `E_s` with Poisson's ratio 1/4 to
//! tissue strained beyond `h_s`.
//!
//! **The bound.** Each set is half the squared distance of a linear map to a shell, like the paper's link
//! (Eq. 5 to 13): L is the Laplacian of weights sum of `w_s` / 2, W the sum of the weights, in every state. Two bands
//! of one side each and one modulus are a band with two half-widths, so the sums are those of the side with more. A
//! link of zero length takes the direction of the rest shape.
//!
//! Cost: a gather and two comparisons for a link inside all of its bands; one root and two divisions for
//! others, for any number of sets. No state. `f32` only.

use super::held::{Contact, Touched, is_among};
use super::links::law::COINCIDENT;
use super::links::number::LinkNumber;
use super::nodal::places;
use super::state::StatesOf;
use super::stress::{Stress, bounded_volume};
use super::term::{Here, Pass, Term, change_lane};
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::lane::{Lane, Real};
use crate::model::range;
use crate::model::stiffening::Stiffening;
use crate::number::cell::{Cell, add, dot, scale, single, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::cross;
use crate::number::two_float::LANES;

/// Narrows the innermost band by the rounding error, so that a skipped link has no force.
const RIM: f32 = 1.0e-6;

/// Force of links: the factor of the vector between the ends, and the sum of w d^2.
struct Pull<V> {
    factor: Lane<V>,
    wd2: Lane<V>,
}

impl Stiffening<'_> {
    /// Links of these squared lengths, rest lengths and volumes; `None` if all are inside their bands.
    #[inline(always)]
    fn pull<V: Real>(self, u2: Lane<V>, l0: Lane<V>, volume: Lane<V>) -> Option<Pull<V>> {
        let (zero, one) = (Lane::of(0.0), Lane::of(1.0));
        let narrowest = Lane::of(self.sets().next()?.half_width);
        let (high, low, l02) = (one + narrowest, one - narrowest, l0 * l0);
        let is_long = u2.above(l02 * (high * high * Lane::of(1.0 - RIM)));
        let is_short = (l02 * (low * low * Lane::of(1.0 + RIM))).above(u2);
        let outside = Lane::select(is_long, one, Lane::select(is_short, one, zero));
        if !V::any(outside.above(zero)) {
            return None;
        }
        // Sum over the bands.
        let (u, mut wd, mut wd2) = (u2.root(), zero, zero);
        for set in self.sets() {
            let (half_width, moduli) = (Lane::of(set.half_width), set.moduli.map(Lane::of));
            let (over, under) = (u - l0 * (one + half_width), u - l0 * (one - half_width));
            let short = Lane::select(zero.above(under), under, zero);
            let d = Lane::select(over.above(zero), over, short);
            let modulus = Lane::select(over.above(zero), moduli[1], moduli[0]);
            wd = wd + modulus * d;
            wd2 = wd2 + modulus * d * d;
        }
        // A link of zero length takes the rest shape's vector, which is l0 long.
        let is_void = (l02 * Lane::of(COINCIDENT)).above(u2);
        let along = Lane::select(is_void, l0 + l0, u + u);
        let along = Lane::select(along.above(zero), along, one);
        Some(Pull { factor: volume * wd / along, wd2: volume * wd2 })
    }

    /// Force of one link on `cell`, and w d^2.
    fn force(
        self,
        (group, cell, other): (usize, usize, usize),
        at: &impl Fn(usize) -> [f32; 3],
    ) -> Option<([f32; 3], f32)> {
        let way = sub(at(other), at(cell));
        let (u2, l0) = (dot(way, way), Self::at(self.lengths, group, cell));
        let volume = Self::at(self.volumes, group, cell);
        let Pull { factor, wd2 } = self.pull(Lane(u2), Lane(l0), Lane(volume))?;
        let place = |cell: usize| self.rest.get(cell).copied().unwrap_or([0.0; 3]);
        let is_void = u2 < COINCIDENT * (l0 * l0);
        let way = if is_void { sub(place(other), place(cell)) } else { way };
        Some((scale(factor.0, way), wd2.0))
    }

    /// Adds the forces of a cell's links to its residual.
    fn residual(self, cell: usize, at: &impl Fn(usize) -> [f32; 3], sum: Cell) -> Cell {
        let slots = self.slots_of(cell);
        let forces = slots.filter_map(|(group, other)| self.force((group, cell, other), at));
        forces.fold(sum, |sum, ([x, y, z], wd2)| sum.plus(Cell([x, y, z, wd2])))
    }

    /// The same in a slice that has a link of zero length.
    #[cold]
    #[inline(never)]
    fn one_by_one(self, cell: usize, at: &[Cell], sum: Cell) -> Cell {
        self.residual(cell, &|cell| at.get(cell).map_or([0.0; 3], |cell| cell.xyz()), sum)
    }
}

/// Energy of the bands of a cell, for cuts and tears.
#[cfg(feature = "cut")]
impl Stiffening<'_> {
    /// Energy that the bands at a cell store for each volume of its links, half of each link's, in the unit of the
    /// moduli; `volume` is that of the cell.
    pub(crate) fn energy_density(
        self,
        cell: usize,
        volume: f32,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> f32 {
        self.residual(cell, at, Cell::ZERO).w() / (8.0 * volume)
    }

    /// Four times the energy that the links at a cell store at most, also with closed bands.
    pub(crate) fn stored_at_most(self, cell: usize, at: &impl Fn(usize) -> [f32; 3]) -> f32 {
        let stored = self.slots_of(cell).map(|(group, other)| {
            let way = sub(at(other), at(cell));
            let d = sqrt(dot(way, way)) - Self::at(self.lengths, group, cell);
            Self::at(self.volumes, group, cell) * d * d
        });
        self.modulus() * stored.fold(0.0, |sum, stored| sum + stored)
    }
}

/// Volumes at a link that a cell's own one makes up: each of its tetrahedra gives it a quarter, and three of its
/// links the whole.
const VOLUMES_EACH: f32 = 12.0;

/// Stress of the bands, for reports.
impl Stiffening<'_> {
    /// Volume at rest of a cell.
    fn volume(self, cell: usize) -> f32 {
        let of_links = self.slots_of(cell).map(|(group, _)| {
            let length = Self::at(self.lengths, group, cell);
            0.5 * Self::at(self.volumes, group, cell) * length * length
        });
        of_links.fold(0.0, |sum, volume| sum + volume) / VOLUMES_EACH
    }

    /// Adds the stress of a cell's links: V sigma is the sum of the forces on the cell times the vectors to the other
    /// ends (the virial of R. Clausius), of each link the part of the cell's volume V in those of its two ends, so that
    /// cells with few links have the stress of their neighbours.
    fn add_stress(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [f32; 3],
        unit_pa: f32,
        sum: Stress,
    ) -> Stress {
        // The links' stress, as by volume of both ends.
        let (volume, mut links) = (self.volume(cell), [[0.0; 3]; 3]);
        for (group, other) in self.slots_of(cell) {
            let Some((force, _)) = self.force((group, cell, other), at) else { continue };
            let (way, both) = (sub(at(other), at(cell)), volume + self.volume(other));
            for (row, force) in links.iter_mut().zip(force) {
                *row = add(*row, scale(force / both, way));
            }
        }
        // The volume is that of now: times det F.
        let [first, second, third] = sum.gradient;
        let unit_pa = unit_pa / bounded_volume(dot(first, cross(second, third)));
        let mut cauchy_pa = sum.cauchy_pa;
        for (row, links) in cauchy_pa.iter_mut().zip(links) {
            *row = add(*row, scale(unit_pa, links));
        }
        Stress { cauchy_pa, ..sum }
    }
}

impl<N: LinkNumber> Term<N> for Stiffening<'_> {
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
        let place = |cell: usize| single(pass.at(cell));
        for cell in pass.cells() {
            let Some(r) = residual.get_mut(cell) else { continue };
            let before = Cell(r.0.map(N::single));
            *r = Cell(self.residual(cell, &place, before).0.map(N::from_single));
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
        if !self.is_any() {
            return;
        }
        let (before, Here { slice, at, .. }) = (*sum, here);
        let place = |cell: usize| at.get(cell).map_or([0.0; 4], |cell| cell.0);
        let here = here.cells.map(Lane);
        let mut is_void = V::splat(0.0).below(V::splat(0.0));
        // Add the groups of links.
        for group in range(self.rows, slice) {
            let slots = self.ids.get(group).zip(self.lengths.get(group));
            let Some(((ids, lengths), volumes)) = slots.zip(self.volumes.get(group)) else {
                continue;
            };
            let there = places::<V>(|lane| place(ids.get(lane).copied().map_or(0, usize::from)));
            let ([a, b, c], [p, q, r]) = (here, there);
            let [x, y, z] = [p - a, q - b, r - c];
            let (u2, l0) = (x * x + y * y + z * z, Lane(V::load(lengths)));
            let Some(pull) = self.pull(u2, l0, Lane(V::load(volumes))) else { continue };
            let void = (Lane::of(COINCIDENT) * (l0 * l0)).above(u2);
            is_void = V::either(is_void, void);
            let [sx, sy, sz, wd2] = *sum;
            let [fx, fy, fz] = [pull.factor * x, pull.factor * y, pull.factor * z];
            *sum = [sx.plus(fx.0), sy.plus(fy.0), sz.plus(fz.0), wd2.plus(pull.wd2.0)];
        }
        // A link of zero length: compute the slice cell by cell.
        if V::any(is_void) {
            *sum = before;
            for lane in 0..LANES {
                change_lane(sum, lane, |r| self.one_by_one(slice * LANES + lane, at, r));
            }
        }
    }

    fn cell(
        self,
        cell: usize,
        _: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sum: [f32; 3],
    ) -> [f32; 3] {
        add(sum, self.residual(cell, &|cell| single(at(cell)), Cell::ZERO).xyz())
    }

    fn touched(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        let at = |cell: usize| single(at(cell));
        for cell in held.iter().map(Contact::cell) {
            for (group, other) in self.slots_of(cell) {
                let counted = other < cell && is_among(held, other);
                if !counted && let Some((force, wd2)) = self.force((group, cell, other), &at) {
                    let (wd, way) = (2.0 * sqrt(dot(force, force)), sub(at(other), at(cell)));
                    sums.wd2 = sums.wd2.plus(wd2.into());
                    sums.scale += wd2 + wd * sqrt(dot(way, way));
                }
            }
        }
    }

    fn stress(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [N; 3],
        _: StatesOf<'_>,
        unit_pa: f32,
        _: &mut [f32],
        sum: Option<Stress>,
    ) -> Option<Stress> {
        let stress = sum?;
        if !self.is_any() {
            return sum;
        }
        Some(self.add_stress(cell, &|cell| single(at(cell)), unit_pa, stress))
    }
}
