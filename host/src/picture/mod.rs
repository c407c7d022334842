//! Pictures without a screen: bodies as shaded surfaces in PNG files, curves as charts in SVG documents.
//!
//! A body is triangles with a colour from a value at every point, seen by a parallel projection, so that a
//! scale bar holds anywhere. It is drawn with a z-buffer and smooth normals, supersampled: key light, fill
//! light and sky; corners darken (ambient occlusion from the depths around a pixel).

mod body;
mod camera;
pub mod chart;
mod curve;
mod eye;
mod frame;
mod legend;
mod letters;
mod moment;
pub mod palette;
mod png;
mod raster;
mod shade;
mod skin;
mod tool;

pub use body::{Body, Paint};
pub use camera::View;
pub use curve::ForceCurve;
pub use eye::front;
pub use legend::round_length;
pub use moment::{Largest, Moment};
pub use png::encode;
pub use raster::{Pixels, raster};
