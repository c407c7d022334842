//! One coarse level over the cells: hat functions whose Laplacian bound is inverted at the bake.
//!
//! A regular grid of trilinear basis functions covers the rest shape; P holds their weights at the free
//! cells. With L the constant Laplacian of weight w / 2 that bounds the energy's curvature, A = P' L P is one
//! matrix for x, y and z. The bake stores B = (A + R)^-1 with a small positive diagonal R as a margin for
//! rounding. For a residual r the coarse direction is
//!
//! ```text
//! c = B P' r,   d = P c,   d' L d = c' A c <= r . d
//! ```
//!
//! This step lowers the bound of the energy most among all combinations of the basis functions. It moves the
//! whole body at once, while sweeps over links spread a motion by one ring of cells at a time.
//!
//! Cells held at run time must not move: their rows of P become zero. One held cell i, with p its
//! row of P, h its row of L P and l its diagonal of L, changes A by two matrices of rank one,
//!
//! ```text
//! A + (a a' - h h') / l,   a = l p - h
//! ```
//!
//! and B by the Sherman-Morrison-Woodbury formula: B - va va' + vh vh'. Both vectors are computed when the
//! cells are chosen, never in a tick. The adding one comes first, so every intermediate matrix is positive
//! definite.
//!
//! The bake chooses the spacing of the grid (`--coarse SPACING|none|auto`). `auto` takes at most 400 basis
//! functions, at least 2.5 mean link lengths apart. It takes none if every cell is within four links of a
//! fixed one, or if they would be more than 8 mean link lengths apart.
//!
//! A body of nodal shapes has an elastic level instead, for all three axes together; there `auto` takes at
//! most 160 basis functions, at least 4.5 mean link lengths apart.
//!
//! Memory with n basis functions: 4 n^2 bytes of the image for B and about 38 bytes per free cell for P; in
//! RAM 24 bytes per basis function, and 8 bytes per basis function for each held cell ([`coarse_room`],
//! [`tool_room`]). Only [`Track`](crate::Track) in `f32` uses it.
//!
//! Cost of a sweep: restriction and prolongation, 8 multiplications per cell and axis each; the product, n^2
//! for each axis with n basis functions; 4 n per held cell and axis.
//!
//! - `solve`: c = B g.
//! - `held`: the corrections for chosen cells.
//! - `resistance`: the level of links under tools.
//! - `elastic`: the level of nodal shapes, which couples the axes.
//! - `elastic_held`: its corrections for chosen cells.
//! - `touched`: the elastic level under tools; `under`: the samples of a triangle as one; `square`: Cholesky
//!   factors; `turns`: rotations of the basis functions.
//! - `sides`: the two-sided functions of a body that is cut.
//! - `scalar`, `sliced`: restriction and prolongation, cell by cell and two cells side by side.

pub(crate) mod elastic;
pub(crate) mod elastic_held;
pub(crate) mod held;
pub(crate) mod resistance;
pub(crate) mod scalar;
pub(crate) mod sides;
pub(crate) mod sliced;
mod solve;
mod square;
#[cfg(test)]
pub(crate) mod tests;
pub(crate) mod touched;
pub(crate) mod turns;
mod under;

pub use elastic::{elastic_room, side_room};
pub use elastic_held::elastic_held_room;
pub use held::coarse_room;
pub use resistance::tool_room;
pub(crate) use solve::{Coarse, Solve};
pub use touched::CoarseTouch;
pub(crate) use under::Under;

use crate::number::two_float::Eight;

/// The vectors of one axis or of one correction in the coarse memory.
#[inline(always)]
pub(crate) fn vector(room: &[Eight], blocks: usize, index: usize) -> &[Eight] {
    room.get(index * blocks..(index + 1) * blocks).unwrap_or(&[])
}
