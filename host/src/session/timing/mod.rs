//! Time: the clock, spans and their percentiles, steps with cold caches.

pub mod clock;
pub mod cold;
pub mod histogram;
pub mod spans;
