//! One coarse level over the cells: hat functions whose Laplacian bound is inverted at the bake.
//!
//! A regular grid of trilinear basis functions lies over the rest shape; P holds their weights at
//! the free cells. With L the constant Laplacian of weight w / 2 that bounds the energy's
//! curvature, A = P' L P is one matrix for x, y and z. The bake stores B = (A + R)^-1 with a small
//! positive diagonal R, so that rounding has room. For a residual r the coarse direction is
//!
//! ```text
//! c = B P' r,   d = P c,   d' L d = c' A c <= r . d
//! ```
//!
//! which is the step that lowers the bound of the energy most among all moves of the basis
//! functions, and moves the whole body at once, while sweeps over links spread a motion by one ring
//! of cells at a time.
//!
//! Cells held at run time must not move: their rows of P become zero. One held cell i, with p its
//! row of P, h its row of L P and l its diagonal of L, changes A by two matrices of rank one,
//!
//! ```text
//! A + (a a' - h h') / l,   a = l p - h
//! ```
//!
//! and B by the Sherman-Morrison-Woodbury formula: B - va va' + vh vh'. Both vectors are worked
//! out when the cells are chosen, never in a tick, first the one that adds, so every matrix on the
//! way is positive definite.
//!
//! The bake chooses the spacing of the grid (`--hats SPACING|none|auto`). `auto` takes at most 400
//! basis functions, at least 2.5 mean link lengths apart. It takes none where every cell is within
//! four links of a fixed one, or where they would stand more than 8 mean link lengths apart.
//!
//! A body of nodal shapes has an elastic level instead, in all three axes together; there
//! `auto` takes at most 160 basis functions, at least 4.5 mean link lengths apart.
//!
//! Memory with n basis functions: 4 n^2 bytes of the image for B and about 38 bytes a free cell for
//! P; in RAM 24 bytes a basis function, and 8 bytes a basis function for each held cell
//! ([`coarse_room`], [`probe_room`]). Only [`Track`](crate::Track) in `f32` uses it.
//!
//! Cost of a sweep: restriction and prolongation, 8 multiplications a cell and axis each; the
//! product, n^2 for each axis with n basis functions; 4 basis functions a held cell and axis.
//!
//! - `solve`: c = B g.
//! - `held`: the corrections for chosen cells.
//! - `deflation`: without the basis functions at a probe's contacts, or as tools on a surface resist
//!   them.
//! - `elastic`: the level of nodal shapes, which couples the axes.
//! - `elastic_held`: its corrections for chosen cells.
//! - `touched`: that level under tools.
//! - `scalar`, `sliced`: restriction and prolongation, cell by cell and two cells side by side.

pub(crate) mod deflation;
pub(crate) mod elastic;
pub(crate) mod elastic_held;
pub(crate) mod held;
pub(crate) mod scalar;
pub(crate) mod sliced;
mod solve;
#[cfg(test)]
pub(crate) mod tests;
pub(crate) mod touched;

pub use deflation::probe_room;
pub use elastic::elastic_room;
pub use elastic_held::elastic_held_room;
pub use held::coarse_room;
pub(crate) use solve::{Coarse, Solve};
pub use touched::CoarseTouch;
pub(crate) use touched::Under;

use crate::number::two_float::Eight;

/// The vectors of one axis or of one correction, cut from the room.
#[inline(always)]
pub(crate) fn vector(room: &[Eight], blocks: usize, index: usize) -> &[Eight] {
    room.get(index * blocks..(index + 1) * blocks).unwrap_or(&[])
}
