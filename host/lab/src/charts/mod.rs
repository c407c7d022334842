//! Pictures: curves as charts, bodies as shaded surfaces.

pub(crate) mod pen;
pub mod plot;
pub mod render;
