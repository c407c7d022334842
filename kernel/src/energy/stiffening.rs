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

use super::half_links::{Groups, Law, Pull, Row};
use super::held::{Contact, Touched};
use super::links::number::LinkNumber;
use super::state::StatesOf;
use super::stress::{Stress, bounded_volume};
use super::term::{Here, Pass, Term};
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::lane::{Lane, Real};
use crate::model::stiffening::Stiffening;
use crate::number::cell::{Cell, add, dot, scale, single, sub};
#[cfg(feature = "cut")]
use crate::number::sqrt::sqrt;
use crate::number::turn::cross;

/// Narrows the innermost band by the rounding error, so that a skipped link has no force.
const RIM: f32 = 1.0e-6;

impl Law for Stiffening<'_> {
    #[inline(always)]
    fn is_there(self) -> bool {
        self.is_any()
    }

    #[inline(always)]
    fn groups(&self) -> Groups<'_> {
        Groups { rows: self.rows, ids: self.ids, rest: self.rest }
    }

    /// `None` if all links of the group are inside their bands.
    #[inline(always)]
    fn pull<V: Real>(
        self,
        group: usize,
        u2: Lane<V>,
        lanes: impl Fn(&Row) -> Lane<V>,
    ) -> Option<Pull<V>> {
        let (l0, zero, one) = (lanes(self.lengths.get(group)?), Lane::of(0.0), Lane::of(1.0));
        let narrowest = Lane::of(self.sets().next()?.half_width);
        let (high, low, l02) = (one + narrowest, one - narrowest, l0 * l0);
        let is_long = u2.above(l02 * (high * high * Lane::of(1.0 - RIM)));
        let is_short = (l02 * (low * low * Lane::of(1.0 + RIM))).above(u2);
        let outside = Lane::select(is_long, one, Lane::select(is_short, one, zero));
        if !V::any(outside.above(zero)) {
            return None;
        }
        // Sum over the bands.
        let (length, mut wd, mut wd2) = (u2.root(), zero, zero);
        for set in self.sets() {
            let (half_width, moduli) = (Lane::of(set.half_width), set.moduli.map(Lane::of));
            let (over, under) =
                (length - l0 * (one + half_width), length - l0 * (one - half_width));
            let short = Lane::select(zero.above(under), under, zero);
            let d = Lane::select(over.above(zero), over, short);
            let modulus = Lane::select(over.above(zero), moduli[1], moduli[0]);
            wd = wd + modulus * d;
            wd2 = wd2 + modulus * d * d;
        }
        let volume = lanes(self.volumes.get(group)?);
        Some(Pull { l0, length, wd: volume * wd, wd2: volume * wd2 })
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
            let Some((force, _)) = self.force(group, cell, other, at) else { continue };
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
        self.add_to_cells(pass, residual);
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        _: StatesOf<'_>,
    ) {
        self.add_to_slice(here, sum);
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
        self.add_touched(held, at, sums);
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
