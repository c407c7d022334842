//! Time: the clock, spans and their percentiles, and steps with cold caches.

pub use chaincell_client::clock;

pub mod cold;
pub mod histogram;
pub mod spans;
