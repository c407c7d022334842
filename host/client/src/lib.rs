//! The other side of `chaincell serve`: opens a scene by name, sends the poses of up to eight tools and
//! receives forces and torques, over shared memory on one machine.
//!
//! Each module uses only those above it:
//!
//! - [`error`], [`clock`]: refusals with their kinds; monotonic time.
//! - [`payload`], [`tools`]: the messages, byte for byte.
//! - [`names`], [`services`]: scenes and the services of one, who may connect.
//! - [`viewed`], [`state`], [`contacts`], [`command`]: what is beside the loop.
//! - [`ramp`], [`shaper`], [`wait`]: what is shown of a force, and how to wait for it.
//! - [`ToolPose`], [`Answer`], [`Client`]: what most programs need.

mod client;
pub mod clock;
pub mod command;
pub mod contacts;
mod domain;
pub mod error;
mod foreign;
mod hearing;
mod leftovers;
mod limits;
mod memory;
pub mod names;
mod opening;
mod owner;
pub mod payload;
mod pose;
pub mod ramp;
pub mod services;
pub mod shaper;
pub mod state;
pub mod tools;
pub mod viewed;
pub mod wait;

pub use chaincell_kernel::trace::Command;
pub use chaincell_kernel::{Flags, ToolPose};
pub use client::{Client, MS_MAX, Options, Outcome, Role};
pub use error::{Error, Kind, Result};
pub use hearing::{Answer, Felt, Notes};
