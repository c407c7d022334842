//! The experiments, one folder each.

pub mod identify;
pub mod page;
pub mod paper;
pub mod report;
pub mod stress;
