//! A body in a browser.
//!
//! - [`server`]: a web server for this user's browser.
//! - [`live`]: the frame of a running scene.
//! - [`bridge`]: follows a running scene.

pub mod bridge;
pub mod live;
pub mod server;
