//! Pictures: curves and bars as charts, bodies as shaded surfaces.

pub mod plot;
pub mod render;
