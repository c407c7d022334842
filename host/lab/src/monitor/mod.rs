//! What must hold in every tick, whatever is done to a body: the one list of checks that the stress
//! cases, the property tests and the fuzz targets use.
//!
//! - [`energy`]: the energy of a tissue in double precision, and what rounding leaves open of it.
//! - [`contact`]: the same with tools on a contact surface.
//! - [`checks`]: the checks on plain numbers.
//! - `acting`: what acts on a body from outside, and the force that it may give.
//! - [`engine`]: follows an engine tick by tick and hands its numbers to the checks.
//! - [`mod@play`]: plays steps on an engine and its twins.

mod acting;
pub mod checks;
pub mod contact;
pub mod energy;
pub mod engine;
pub mod play;

pub use checks::{Check, Failure, Worst};
pub use engine::Monitor;
pub use play::{Act, Step, play};
