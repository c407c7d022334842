//! The terms of the energy, and one pass over all of them.
//!
//! The energy is a sum of (w / 2) dist^2(G x, S): the distances of linear maps G of a few cells to sets S.
//! Half the squared distance to a set curves upwards by at most one, so L = sum of w G'G bounds the curvature
//! of the energy in every state; all proofs of the schemes rely on that.
//!
//! - `term`: the interface of a term, and lists of terms.
//! - [`links`]: the links' bands (Eq. 5 to 13).
//! - `nodal`: shapes of the tissue around each cell, instead of links.
//! - `half_links`: one walk over links for all terms that add to them, with a law for each.
//! - `stiffening`: bands on the links of such a body, which resist large strain.
//! - `lips`: sides of a cut that press on each other, while a body is cut.
//! - `surface`: tools in contact with the triangles of the surface; [`contact`](crate::contact) moves them.
//! - [`stress`]: strain and stress at a cell, for reports.
//! - `following`: memory in branches that forget, of shapes and of links.
//! - `current`: a load, the current into the contact cells.
//! - [`state`]: the terms' state of each cell.
//! - `residual`, `sliced`: the list of the terms, and one pass over it, cell by cell and eight cells side by
//!   side.
//! - [`held`]: the cells that a tool holds or loads.
//! - [`rounding`]: bound of the energy's rounding error.
//!
//! **Adding a term** takes a file here, a file in [`model`](crate::model), and an entry in the list of
//! `model::others`; a term that comes and goes with a tool, as surface and load, stands in the list of
//! `residual`. Pins, a term of the tests, are the example. What a term leaves out is 0:
//!
//! | what | where |
//! |---|---|
//! | its sections in the image, checked | `TermData::read`, `check` |
//! | its part of the bound L: at a cell, which enters the cell's mobility, and by element | `add_bound`, `each_of_row` |
//! | true if its energy is 0 in the rest shape | `rests` |
//! | whether it keeps states of this body's cells, and replaces the links | `keeps`, `replaces_links` |
//! | rows of numbers that last from pass to pass | `Keeps` |
//! | a correction of its states for a tick, and the change of the energy | `begin_tick` |
//! | a first pass: what it needs of the whole body, its displacements, then states slice by slice | `prepare`, `displace`, `update`, `update_slice` |
//! | a second pass: residual and energy of awake slices, cell by cell and eight side by side | `accumulate`, `slice` |
//! | energy that no residual carries | `potential` |
//! | force on held cells, and the energy that their displacement changes | `cell`, `touched` |
//! | strain and stress at a cell, for reports | `stress` |
//! | its part of the coarse level: the energy's second derivative at rest, and a cell's rotation | `resist`, `turn` |
//!
//! The bake adds the term's part of L to the mobilities, to the largest step and to the matrix of the coarse
//! level; the kernel checks the first two. A slice sleeps if the term leaves the fourth lanes of its
//! residuals 0. The tissue stores the term's states next to the cells' positions; a reset clears them, a
//! discarded pass restores them, and the state hash and a saved state contain their words. The list is
//! resolved when the kernel is compiled: there is no dynamic dispatch, and a term that is not in the list, or
//! that has no state, takes no memory and no time.

pub(crate) mod current;
#[cfg(feature = "relax")]
pub(crate) mod following;
#[cfg(feature = "nodal")]
pub(crate) mod half_links;
pub mod held;
pub mod links;
#[cfg(feature = "cut")]
pub(crate) mod lips;
#[cfg(feature = "nodal")]
pub(crate) mod nodal;
pub(crate) mod number;
#[cfg(test)]
pub(crate) mod pin;
pub(crate) mod residual;
pub mod rounding;
pub(crate) mod sliced;
pub mod state;
#[cfg(feature = "nodal")]
mod stiffening;
pub mod stress;
pub(crate) mod surface;
pub(crate) mod term;
#[cfg(test)]
pub(crate) mod tests;
