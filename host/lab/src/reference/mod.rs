//! Double-precision references of the link network: the energy minimum and the exact trajectory
//! under prescribed cells, computed by the project itself.
//!
//! Everything here reads the same links as the kernel: rest lengths, weights and bands are those
//! of the model, widened to `f64`. Lengths are in the unit of the positions given.

#[cfg(test)]
mod grouped;
mod links;
mod minimum;
mod npz;
pub mod profile;
mod trajectory;
pub mod vectors;

pub use links::{Held, Links};
pub use minimum::{Minimum, minimum};
pub use npz::Npz;
pub use trajectory::trajectory;
