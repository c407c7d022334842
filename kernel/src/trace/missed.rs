//! Ticks without a sample: they move the output stage and no cell.
//!
//! In a record of kind 3 the eight bytes from 0 hold the number of the last tick before, 8 how many
//! ticks passed (not 0), the others to 32 zero.

/// Ticks that passed without a sample, at their place between the ticks: calls of
/// [`Stage::missed`](crate::stage::Stage::missed).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Missed {
    /// Number of the last tick before them, 0 before the first.
    pub tick: u64,
    /// How many.
    pub ticks: u32,
}
