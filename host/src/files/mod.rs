//! Files of a run: the output folder, traces and snapshots of sessions, tool paths.

mod lines;
pub mod output;
pub mod path;
pub mod recording;
pub mod snapshot;
pub mod whole;
