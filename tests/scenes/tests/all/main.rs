//! Golden scenes: their digests, their reports and traces, and states no body should come to.

mod adverse;
mod blade;
mod goldens;
mod report;
mod snapshot;
mod tear;
mod touch;
mod trace;
