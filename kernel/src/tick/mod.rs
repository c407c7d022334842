//! The tick: what goes in, what comes out, and what happens in between.
//!
//! - [`choice`], [`choices`]: a choice among named values, and the choices of a run.
//! - [`settings`], [`sample`]: a run's parameters, a tick's input and output.
//! - [`tissue`], `error`: the state in RAM, and why it refuses a model or a state.
//! - [`order`]: one tick; `tool`, `probe`, `current`, `unloading`, `output`: its parts.
//! - [`hash`]: the state hash.
//! - [`handover`]: samples from an interrupt to the tick.

pub mod choice;
pub mod choices;
mod current;
pub mod error;
pub mod handover;
pub mod hash;
pub mod order;
mod output;
mod probe;
pub mod sample;
pub mod settings;
#[cfg(test)]
mod tests;
pub mod tissue;
mod tool;
mod unloading;
