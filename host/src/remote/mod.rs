//! A session in another place: its records travel, and the same tissue is run there.
//!
//! A mirror reads the trace of a running session from its file; the force loop knows nothing of it. A follower
//! runs the tissue from the records, beside the session and never ahead of it, and compares every recorded
//! hash.
//!
//! - [`frame`]: the messages from mirror to follower, on any stream of bytes.
//! - [`pack`]: records packed for the wire.
//! - [`way`]: how a follower gets that stream: standard input, a program such as `ssh`, a TCP connection, or a
//!   file of the same machine.
//! - [`place`]: where a session is recorded.
//! - [`mirror`]: sends a trace while it grows.
//! - [`intake`]: receives it, and connects again after a cut.
//! - [`follow`]: runs the tissue from it.

pub mod follow;
pub mod frame;
pub mod intake;
pub mod mirror;
pub mod pack;
pub mod place;
pub mod way;
