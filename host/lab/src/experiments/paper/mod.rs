//! `chaincell paper`: every result of the paper computed here, beside the method it improves on.
//!
//! | experiment | result of the paper | files, `paper_` in front |
//! |---|---|---|
//! | [`plane`] | Fig. 4: the shape of a plane whose centre is displaced | `plane`, `profile_4`, `profile_8` |
//! | [`mechanics`] | Fig. 5: force over displacement, unloading, stress relaxation | one picture and one CSV file a curve and body |
//! | [`liver`] | Fig. 6: the liver under a probe | `liver`, `liver_force`, `liver_press` |
//! | [`scaling`] | left open there: many elements to one cell | `scaling` |
//! | [`identified`] | left open there: the material parameters | `identified*` |
//!
//! `paper.html` begins with a table of the paper's results, each with what was computed here. Every
//! section then says on which body, with which tool and settings. `paper.json` holds the figures of
//! each section under its key, with units in the names; the CSV files hold the numbers of the
//! pictures. Only the times of ticks depend on the machine. The other method is
//! traditional `ChainMail` (Gibson's lattice form, Li and Brodlie's generalised form). Without
//! reference data the generated organ stands in for the liver.
//!
//! An experiment is a file with a function from a [`Context`] to a [`Section`] and a row in
//! [`EXPERIMENTS`].

pub mod body;
mod html;
pub mod identified;
pub mod liver;
pub mod mechanics;
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
pub const EXPERIMENTS: &[Experiment] =
    &[plane::section, mechanics::section, liver::section, scaling::section, identified::section];
