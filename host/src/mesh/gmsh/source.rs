//! The common interface of ASCII and binary files for the code that collects a body from them.

use crate::error::{Error, Result};

/// A position in a file.
pub(super) trait Place {
    /// Makes an error at the item read last.
    fn refuse(&self, why: &str) -> Error;
}

/// Source of nodes and elements.
pub(super) trait Source: Place {
    /// Reads the next node tag of an element.
    fn node_tag(&mut self) -> Result<u64>;
    /// Reads a position in the file's unit, returned in metres.
    fn position_m(&mut self, unit_m: f64) -> Result<[f64; 3]>;
}
