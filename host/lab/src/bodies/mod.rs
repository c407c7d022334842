//! The bodies of experiments and tests, and the ways to compute them.
//!
//! - [`shape`]: meshes with their fixed and held nodes.
//! - [`body`]: the baked body, with and without a coarse level.
//! - [`variant`]: schemes in number types, and their engines.

pub mod body;
pub mod shape;
pub mod variant;

pub use body::Body;
pub use shape::Shape;
pub use variant::Variant;
