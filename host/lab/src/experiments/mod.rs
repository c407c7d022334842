//! The experiments, one folder each.

pub(crate) mod identify;
pub(crate) mod page;
pub(crate) mod paper;
pub(crate) mod relaxation;
pub mod report;
pub mod stress;

pub use identify::target;
