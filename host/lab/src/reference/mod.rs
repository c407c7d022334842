//! Double-precision references: the energy minimum of links and of nodal tissue under prescribed
//! cells, and the exact trajectory of links, computed by the project itself.
//!
//! [`Links`] are those of the kernel: rest lengths, weights and bands are those of the model,
//! widened to `f64`, lengths in the unit of the positions given. [`Nodal`] tissue is made of a
//! mesh, in metres and newtons. Both are [`Elastic`], which is what [`minimum`] needs.

mod elastic;
#[cfg(test)]
mod grouped;
mod links;
mod loaded;
mod minimum;
pub mod nodal;
mod npz;
pub mod profile;
pub mod prony;
mod stiffening;
mod tetrahedra;
mod trajectory;
pub mod vectors;

pub use elastic::{Elastic, Held};
pub use links::Links;
pub use loaded::Loaded;
pub use minimum::{Minimum, minimum};
pub use nodal::Nodal;
pub use npz::Npz;
pub use stiffening::Stiffening;
pub use tetrahedra::Tetrahedra;
pub use trajectory::trajectory;
