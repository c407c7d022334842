//! Contact on surfaces: a sphere meets points of the surface's triangles, not cells.
//!
//! Sample points q stand on each triangle at rest: the centres of n^2 equal parts, at fixed weights
//! `A_q` of the triangle's corners, each with the share `a_q` of its area. With dist their depth in
//! the sphere, 0 outside, the term is
//!
//! ```text
//! E_c = sum over q of k_q dist^2 / 2,   k_q = c E a_q / h,   c = 8 R / h within 6 and 20
//! ```
//!
//! with R the radius, h the mean length of the triangle's edges and E Young's modulus there. Contact
//! is about as stiff as tissue as deep as an edge is long. A harder one is no more accurate: a coarse
//! mesh is too stiff under a small sphere, and soft contact makes up for it. n is such that samples
//! stand half a radius apart at most, and at least 2.
//!
//! **The theorem.** Half the squared distance to a set, here the outside of the sphere, curves
//! upwards by at most 1. E_c therefore curves by at most sum of `k_q` `A_q'` `A_q`, whose row sums are `k_q` `A_q`: the cells' bounds W grow by
//! a third of the stiffness of each of their triangles in reach, and every certificate of a scheme
//! holds with that W.
//!
//! **Candidates.** The triangles in reach are found once a tick and stay the same in all its passes,
//! so E_c is one function in a tick. Over the capacity the nearest ones are kept.
//!
//! **The force** on the sphere is the sum over the samples of `k_q` dist along the way to the centre,
//! minus the gradient of E_c by the centre: no sample enters or leaves with a jump, since its force
//! is 0 at the surface of the sphere.
//!
//! - `samples`: the points of a triangle.
//! - `search`: the triangles in reach.
//! - `meeting`: energy, force and stiffness of a sphere between them.
//! - `touch`: what passes over the cells need of it.

mod meeting;
mod samples;
mod search;
mod touch;

pub(crate) use meeting::{Ball, Meeting, Press};
pub use search::NearTriangle;
pub(crate) use search::{Near, search};
pub(crate) use touch::{Touch, Touching};

/// 1 where this kernel is built with contact on surfaces, else 0: arrays of what only that needs
/// have this length.
pub(crate) const BUILT: usize = cfg!(feature = "surface") as usize;
