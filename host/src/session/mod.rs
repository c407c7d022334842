//! Co-simulation: the tissue in one process, the controller in another, iceoryx2 between them.
//!
//! ```text
//! control  --ToolPoses-->  chaincell/tools  -->  serve -> tissue
//! control  <--ToolForces-- chaincell/forces <--  serve
//! ```
//!
//! Each module uses only those above it:
//!
//! - [`timing`]: the clock, latencies and their percentiles.
//! - [`ipc`]: the server's side of shared memory; messages, names and who may connect are those of
//!   [`chaincell_client`].
//! - [`loops`]: the two sides. `serve` makes each accepted pose one tick and one answer, in order
//!   of arrival; `control` sends poses on an absolute 1 kHz schedule and times the answers.
//! - [`supervise`]: both as child processes, with their reports collected.

pub mod ipc;
pub mod loops;
pub mod supervise;
pub mod timing;
