//! What the ASCII and the binary files have in common for the code that collects a body from them.

use crate::error::{Error, Result};

/// A place in a file.
pub(super) trait Place {
    /// An error at the item read last.
    fn refuse(&self, why: &str) -> Error;
}

/// Where nodes and elements come from.
pub(super) trait Source: Place {
    /// The next node tag of an element.
    fn node_tag(&mut self) -> Result<u64>;
    /// A position in the file's unit, returned in metres.
    fn position_m(&mut self, unit_m: f64) -> Result<[f64; 3]>;
}
