//! The clock, spans and their percentiles, steps with cold caches, the memory of a process, and the machine.

pub use chaincell_client::clock;

pub mod cold;
pub mod histogram;
pub mod machine;
pub mod memory;
pub mod spans;
