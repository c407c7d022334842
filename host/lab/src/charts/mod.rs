//! Pictures of a report: charts and sheets of bodies, each as SVG and PNG.

mod cut;
pub mod plot;
mod raster;
mod sheet;
#[cfg(test)]
mod tests;

pub use cut::cut;
pub use sheet::{ColourBar, Panel, Sheet};
