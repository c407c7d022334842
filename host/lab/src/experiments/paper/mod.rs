//! `chaincell paper`: every result of the paper computed here, beside the method it improves on.
//!
//! An experiment is a file with a function from a [`Context`] to a [`Section`] and a row in
//! [`EXPERIMENTS`].

pub mod body;
pub mod choices;
mod html;
pub mod identified;
pub mod liver;
pub mod mechanics;
pub mod methods;
mod overview;
pub mod plane;
mod press;
pub mod scaling;
pub mod section;
pub mod write;

use chaincell_host::error::Result;
use section::{Context, Section};

/// What computes a section of the report.
pub type Experiment = fn(&Context) -> Result<Section>;

/// Every experiment, in the order of the report.
pub const EXPERIMENTS: &[Experiment] = &[
    plane::section,
    mechanics::section,
    liver::section,
    methods::section,
    choices::section,
    scaling::section,
    identified::section,
];
