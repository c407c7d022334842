//! Tools around the chaincell kernel: the library behind the `chaincell` command.

pub mod cosim;
pub mod error;
pub mod interrupt;
pub mod terminal;
