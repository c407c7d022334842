//! What must hold in every tick, whatever is done to a body: the one list of checks that the stress
//! cases, the fuzz targets and the tests use.
//!
//! - [`energy`]: the links' energy in double precision, and what rounding leaves open of it.
//! - [`contact`]: the same of nodal shapes under tools on a contact surface.
//! - [`checks`]: the checks themselves, on plain numbers.
//! - [`engine`]: follows an engine tick by tick and hands its numbers to the checks.
//! - [`tools`]: the same under tools on a contact surface.

pub mod checks;
pub mod contact;
pub mod energy;
pub mod engine;
pub mod tools;

pub use checks::{Check, Failure, Worst};
pub use engine::Monitor;
pub use tools::ToolMonitor;
