//! Co-simulation: the tissue in one process, the controller in another, iceoryx2 between them.
//!
//! ```text
//! control  --ToolPose-->  chaincell/pose   -->  serve -> tissue
//! control  <--ToolForce-- chaincell/force  <--  serve
//! ```
//!
//! - [`serve`](mod@serve): each accepted pose is one tick and one answer, in order of arrival.
//! - [`control`](mod@control): sends poses on an absolute 1 kHz schedule and times the answers.
//! - [`orchestra`]: both as child processes, with their reports collected.
//! - [`floor`]: what the machine itself costs, measured with the same loops and no tissue.
//! - [`state`]: node positions for viewers. [`command`]: what another program may tell `serve`.
//! - [`motion`]: the built-in press. [`inject`]: faults on purpose.
//! - [`payload`], [`names`], [`services`]: what goes over shared memory, and under which names.
//! - [`tissue`]: what the loop needs of a tissue. [`record`]: poses as received, with answers.
//! - [`wait`], [`realtime`], [`clock`]: waiting, privileges, time.
//! - [`histogram`], [`spans`], [`peers`]: latencies, and what a peer's joining costs.

pub mod clock;
pub mod cold;
pub mod command;
mod complain;
pub mod control;
pub mod floor;
mod foreign;
mod hand;
pub mod histogram;
pub mod inject;
mod memory;
pub mod motion;
pub mod names;
pub mod orchestra;
mod outstanding;
mod owner;
pub mod payload;
pub mod peers;
mod playlist;
mod ramp;
pub mod realtime;
pub mod record;
pub mod serve;
pub mod services;
pub mod spans;
pub mod state;
pub mod tissue;
pub mod wait;
