//! Tissue as nodal shapes: Young's modulus and Poisson's ratio instead of links.
//!
//! Each cell i has a volume `V_i`, a quarter of its tetrahedra's, and the mean of their deformation gradients
//! (Bonet, Burton 1998; Dohrmann, Heinstein, Jung, Key, Witkowski 2000). With the displacement u = x - X
//!
//! ```text
//! F_i = I + (1 / V_i) sum_j (u_j - u_i) a_ij'
//! a_ij = sum over the tetrahedra with i and j of V_t / 4 times the gradient of j's hat function
//! ```
//!
//! The energy measures the distances of `F_i` to a rotation and to a shape of unit volume. Against modes that
//! the means do not see, it also measures the spread of the tetrahedra's gradients about `F_i` (Puso, Solberg
//! 2006), beta = 0.2:
//!
//! ```text
//! E   = sum_i V_i [ mu |F_i - R_i|^2 + (3 lambda / 2) |F_i - Q_i|^2 - beta mu |F_i - I|^2 ]
//!     + sum over links s_ij / 2 |u_j - u_i|^2,   s_ij = -2 beta sum_t mu V_t g_i . g_j
//! P_i = 2 mu (F - R) + 3 lambda (F - Q) - 2 beta mu (F - I)
//! f_i = sum_j s_ij (u_j - u_i) - P_i a_ii - sum_j P_j a_ji
//! ```
//!
//! **The band** adds b / 2 `V_i` dist^2 of `F_i` to the shapes that are nowhere shorter than a least stretch
//! ([`band`]), b = 8 mu: 0 in ordinary states, a barrier in deep presses.
//!
//! The terms with beta are the spread, beta mu sum over i and its tetrahedra of
//! `V_t` / 4 |`F_t` - `F_i`|^2. Small strain gives Hooke's law.
//!
//! **The bound.** For any rotations R and shapes Q of determinant 1, E is a sum of squared distances of
//! linear maps to convex sets, so L = 2 mu ((1 - beta) Ln + beta Lc) + (3 lambda + b) Ln bounds its
//! curvature; Ln and Lc are the Laplacians of the nodal and of the tetrahedra's gradients. W is at least the
//! sum of the magnitudes of a row of L. R and Q are states (`state`): before a pass each takes one
//! step that does not lead away from `F_i` ([`nearest`]), which lowers the energy; a discarded pass restores
//! them.
//!
//! **Rounding.** A pass first subtracts the rest positions from the positions, so that a body at rest has
//! exactly no displacement, no energy and no force.
//!
//! **Order.** A pass goes over the slices once: it gathers the displacements of a slice's neighbours, computes
//! its shapes, and takes P `a_ij` from the neighbours' forces, group by group and lane by lane, the same way
//! on every target. A sleeping slice has no stress and pushes no neighbour. A pass over some slices is right
//! at the cells all of whose neighbours are in them, if the displacements of all cells are those of the pass.
//!
//! Cost: per half-link the displacement of the other end is gathered and its force changed; a rotation and a
//! shape per cell. A sweep takes nine times as long as one over bare links. `f32` only, under `track` and `predict`.
//! For held cells one sweep a tick is enough up to nu 0.48; nearer to 0.5 W grows, steps get shorter and the
//! force lags.
//!
//! - `band`: the penalty below the least allowed stretch.
//! - `follow`: the memory of a body that relaxes follows its strain at the start of a tick; `memory`: what it adds to a
//!   pass.
//! - `gather`: the half-links of cells, their sums and forces.
//! - `jacobi`: eigenvectors of a symmetric matrix.
//! - `law`: stress and energy of a shape.
//! - `linear`: the elasticity of the rest shape.
//! - `load`: the load by which a body tears.
//! - [`nearest`]: the steps of R and Q.
//! - `scalar`: cell by cell, in a pass without a vector unit and at any positions for the few cells that the tool
//!   holds; `half_links_vfp` and `jacobi_vfp` are parts of it on the floating-point unit of Armv7E-M.
//! - `strain`: the strain of a cell that may remember, and the step of R.
//! - `stress`: strain and stress for reports.
//! - `sums`: sums over the half-links of a cell, and its material.

mod band;
#[cfg(feature = "relax")]
pub(crate) mod follow;
mod gather;
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
mod half_links_vfp;
mod jacobi;
#[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
mod jacobi_vfp;
mod law;
mod linear;
#[cfg(feature = "cut")]
mod load;
mod matrix;
mod memory;
pub(crate) mod nearest;
mod scalar;
mod state;
mod strain;
mod stress;
mod sums;
#[cfg(test)]
mod tests;

pub(crate) use gather::places;
#[cfg(feature = "cut")]
pub(crate) use load::{largest_stretch, stretch_bound};

use core::ops::Range;

use super::held::{Contact, Touched, is_among};
use super::links::number::LinkNumber;
use super::state::{Quads, SliceMemory, StatesOf};
use super::stress::Stress;
use super::term::{Here, Pass, Term};
use crate::backend::f32x8::{Chunk, F32x8};
use crate::backend::slices::cells_of;
use crate::model::nodal::Nodal;
use crate::number::cell::{Cell, single};
#[cfg(feature = "relax")]
use crate::number::two_float::TwoFloat;
use gather::{Ends, Offsets, memory_at, offset, own};
use sums::Gathered;

impl<N: LinkNumber> Term<N> for Nodal<'_> {
    #[inline(always)]
    fn displace(self, slice: usize, here: &Chunk, states: StatesOf<'_>) {
        let quads = states.quads();
        if let Some(ends) = Ends::of(self, quads.displacements).filter(|_| self.is_any()) {
            ends.displace(slice, here);
            let forces = quads.on_slice(slice).flatten();
            forces.for_each(|force| force.set(Cell::ZERO));
        }
    }

    fn update(
        self,
        cells: Range<usize>,
        _: &impl Fn(usize) -> [f32; 3],
        from: SliceMemory<'_>,
        to: SliceMemory<'_>,
    ) {
        if self.is_any() {
            self.stepped(cells, from, to);
        }
    }

    #[inline(always)]
    fn update_slice<V: F32x8>(
        self,
        slice: usize,
        _: &[Cell],
        from: SliceMemory<'_>,
        to: SliceMemory<'_>,
    ) {
        let Quads { displacements, .. } = from.quads;
        let forces = Ends::of(self, from.quads.by_slice(slice));
        let ends = Ends::of(self, displacements).zip(forces);
        let (Some(numbers), Some((displacements, forces))) = (self.cells.get(slice), ends) else {
            return;
        };
        let Some((turn, unit)) = state::load::<V>(from) else { return };
        let (cells, mut memory) = (cells_of(slice, self.count), Offsets::NONE);
        // The same one cell at a time.
        let Some(groups) = displacements.groups(slice, &mut memory) else {
            return self.stepped(cells, from, to);
        };
        let Some(sums) = Gathered::<V>::of_slice(displacements, slice, groups) else { return };
        // Initialised where they are: an option that owns them would be copied.
        let (stored_offset, stored_memory);
        let mut own = own(numbers);
        if let Some(numbers) = self.offset_of(slice) {
            stored_offset = offset(numbers);
            own.offset = Some(&stored_offset);
        }
        let memory = self.memory_of(slice).zip(displacements.own(slice));
        if let Some(((numbers, part, proof), here)) = memory {
            stored_memory = memory_at(numbers, part, proof, here);
            own = own.remembering(&stored_memory);
        }
        let step = law::step(self.stretch_min, &sums, &own, turn, unit);
        state::store(&step, to, cells.len());
        forces.push(slice, step.stress, step.pull, groups);
    }

    fn accumulate<const CLAMPED: bool>(
        self,
        pass: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        _: &mut N::Tally,
        states: StatesOf<'_>,
    ) {
        if !self.is_any() {
            return;
        }
        let quads = states.quads();
        for slice in pass.slices() {
            let cells = residual.get_mut(cells_of(slice, self.count)).unwrap_or_default();
            // The parts' forces in their order, as [`Quads::force`] adds them.
            let mut parts = quads.on_slice(slice);
            let first = parts.next().into_iter().flatten();
            for (lane, (r, force)) in cells.iter_mut().zip(first).enumerate() {
                let others = parts.clone().filter_map(|part| part.get(lane));
                let force = others.fold(force.get(), |sum, more| sum.plus(more.get()));
                *r = r.plus(Cell(force.0.map(N::from_single)));
            }
        }
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        states: StatesOf<'_>,
    ) {
        if self.is_any()
            && let Some(forces) = states.quads().force(here.slice)
        {
            let ([x, y, z, wd2], [a, b, c, d]) = (*sum, V::transposed(&forces));
            *sum = [x.plus(a), y.plus(b), z.plus(c), wd2.plus(d)];
        }
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    fn potential(self, energy: TwoFloat, _: &impl Fn(usize) -> [N; 3]) -> TwoFloat {
        energy.plus(self.memory.energy)
    }

    fn touched(
        self,
        held: &[Contact<N>],
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_>,
        sums: &mut Touched,
    ) {
        if self.is_any() {
            let (cells, is_held) = (held.iter().map(Contact::cell), |cell| is_among(held, cell));
            self.stored_around(cells, &is_held, &|cell| single(at(cell)), states, sums);
        }
    }

    fn resist(self, field: &[Cell], product: &mut [Cell]) {
        self.add_resistance(field, product);
    }

    #[inline(always)]
    fn turn(self, cell: usize, states: StatesOf<'_>) -> Option<[f32; 4]> {
        self.is_any().then(|| states.shape(cell).turn)
    }

    fn stress(
        self,
        cell: usize,
        at: &impl Fn(usize) -> [N; 3],
        states: StatesOf<'_>,
        unit_pa: f32,
        means_pa: &mut [f32],
        sum: Option<Stress>,
    ) -> Option<Stress> {
        if cell >= self.count {
            return sum;
        }
        let at = |cell| single(at(cell));
        Some(self.stressed(cell, &at, &|cell| states.shape(cell).turn, unit_pa, means_pa))
    }
}
