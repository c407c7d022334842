//! Shaded pictures of bodies: triangles with a colour from a value at every point, seen by a
//! parallel projection, so that a scale bar holds anywhere in a panel.
//!
//! A z-buffer with smooth normals, supersampled; key light, fill light and sky; corners darken
//! (ambient occlusion from the depths around a pixel). Texts, colour bar and scale bars are vectors
//! over the pixels.

mod body;
mod camera;
mod cut;
mod frame;
mod palette;
mod shade;
mod sheet;

pub use body::{Body, Paint};
pub use cut::cut;
pub use sheet::{ColourBar, Panel, Sheet};
