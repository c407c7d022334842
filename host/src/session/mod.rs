//! Co-simulation: the tissue and the controller run in two processes, connected by iceoryx2.
//!
//! ```text
//! control  --ToolPoses-->  chaincell/tools  -->  serve -> tissue
//! control  <--ToolForces-- chaincell/forces <--  serve
//! ```
//!
//! Each module uses only those above it:
//!
//! - [`timing`]: the clock, latencies and their percentiles.
//! - [`ipc`]: the server's side of shared memory; messages, names and access rules are those of
//!   [`chaincell_client`].
//! - [`loops`]: the two sides. `serve` makes each accepted pose one tick and one answer, in order
//!   of arrival; `control` sends poses on an absolute 1 kHz schedule and times the answers.
//! - [`supervise`]: runs both as child processes and collects their reports.

pub mod ipc;
pub mod loops;
pub mod supervise;
pub mod timing;
