//! The other side of `chaincell serve`: opens a scene by name, sends the poses of up to eight tools and
//! receives forces and torques, over shared memory on one machine.
//!
//! Each module uses only those above it:
//!
//! - [`error`], [`clock`]: refusals with their kinds; monotonic time.
//! - [`payload`], [`tools`]: the messages, byte for byte.
//! - [`names`], [`services`]: scenes and the services of one, access rights.
//! - [`viewed`], [`state`], [`contacts`], [`command`]: services besides the control loop.
//! - [`ramp`], [`shaper`], [`wait`]: shaping of the force that is shown, and waiting for answers.
//! - [`Exchange`]: a controller's poses and answers, message by message.
//! - [`ToolPose`], [`Answer`], [`Client`]: all that most programs need.
//!
//! ```no_run
//! # fn press() -> chaincell_client::Result<()> {
//! use chaincell_client::clock::{PERIOD_NS, now_ns, sleep_until_ns};
//! use chaincell_client::{Client, Options, ToolPose};
//!
//! // chaincell serve plane.chaincell --contact 40 --scene left
//! let mut client = Client::open(&Options { scene: Some("left".into()), ..Options::default() })?;
//! let start_ns = now_ns();
//! for tick in 0..1000 {
//!     sleep_until_ns(start_ns + tick * PERIOD_NS); // 1 kHz
//!     let position_m = [0.0, 0.0, -1e-5 * tick as f32]; // 10 mm/s
//!     let pose = ToolPose::at(position_m.into(), u32::from(tick > 0)); // first released
//!     let (_outcome, answer) = client.step(&[pose], 900_000)?; // waits at most 0.9 ms
//!     println!("{:?} N", answer.tools[0].force_n);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Without a server, programs can check what they would send:
//!
//! ```
//! use chaincell_client::{Options, ToolPose, tools};
//!
//! let pose = ToolPose::at([0.0, 0.0, 0.01].into(), 1);
//! let turned = ToolPose { orientation: [0.0, 0.0, 1.0, 0.0], ..pose };
//! assert!(turned.is_good()); // [m]; the orientation is x, y, z, w: half a turn about z
//! let options = Options::default();
//! assert_eq!((options.watchdog_ms, options.ramp_ms), (20, 20)); // the force falls after 20 ms
//! assert_eq!(size_of::<tools::ToolPoses>(), 344); // [bytes], as other programs declare it
//! assert_eq!(tools::ToolPoses::default().each.len(), 8); // tools in one message
//! ```

mod client;
pub mod clock;
pub mod command;
pub mod contacts;
mod domain;
pub mod error;
mod exchange;
mod foreign;
mod hearing;
mod leftovers;
mod limits;
mod memory;
pub mod names;
mod opening;
mod options;
mod owner;
pub mod payload;
mod pose;
pub mod ramp;
pub mod recording;
pub mod services;
pub mod shaper;
pub mod state;
pub mod stress;
pub mod surface;
pub mod tools;
pub mod viewed;
pub mod wait;

pub use chaincell_kernel::trace::Command;
pub use chaincell_kernel::{Flags, Scissors, ToolPose};
pub use client::{Client, Outcome};
pub use error::{Error, Kind, Result};
pub use exchange::Exchange;
pub use hearing::{Answer, Hearing, Notes, ToolOutput};
pub use options::{MS_MAX, Options, Role};
