//! Tools around the chaincell kernel: the library behind the `chaincell` command.

pub mod bake;
pub mod baseline;
pub mod cli;
pub mod contact;
pub mod cosim;
pub mod engine;
pub mod error;
pub mod identify;
pub mod interrupt;
pub mod mesh;
pub mod output;
pub mod paper;
pub mod path;
pub mod plot;
pub mod recording;
pub mod reference;
pub mod render;
pub mod report;
pub mod soak;
pub mod staged;
pub mod stress;
pub mod terminal;
