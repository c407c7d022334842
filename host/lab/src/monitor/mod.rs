//! What must hold in every tick, whatever is done to a body: the one list of checks that the stress
//! cases, the fuzz targets and the tests use.
//!
//! - [`energy`]: the links' energy in double precision, and what rounding leaves open of it.
//! - [`checks`]: the checks themselves, on plain numbers.
//! - [`engine`]: follows an engine tick by tick and hands its numbers to the checks.

pub mod checks;
pub mod energy;
pub mod engine;

pub use checks::{Check, Failure, Worst};
pub use engine::Monitor;
