//! Shared memory: services, their names and owners, and what travels over them.

pub use chaincell_client::{names, payload, services};

pub mod command;
pub(crate) mod complain;
pub mod contacts;
mod pace;
pub mod serving;
pub mod state;
pub mod tools;
pub mod viewed;
