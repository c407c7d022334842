//! Shared memory: services, their names and owners, and what travels over them.

pub mod command;
pub(crate) mod complain;
pub mod contacts;
mod foreign;
mod memory;
pub mod names;
mod owner;
mod pace;
pub mod payload;
pub mod services;
pub mod serving;
pub mod state;
pub mod tools;
pub mod viewed;
