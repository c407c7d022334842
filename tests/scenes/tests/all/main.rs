//! Golden scenes: their digests, their reports and traces, and states no body should come to.

mod adverse;
mod cuts;
mod goldens;
mod report;
mod snapshot;
mod touch;
mod trace;
