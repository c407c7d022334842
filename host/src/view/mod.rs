//! The page of `chaincell view`, which shows a body in a browser.
//!
//! - [`page`]: the page's text, from the sources in `host/view` and a configuration.
//! - [`server`]: a web server for this user's browser.
//! - [`live`]: the frame of a running scene.
//! - [`bridge`]: follows a running scene.
//! - [`session`]: a recorded session as the page plays it.

pub mod bridge;
pub mod live;
pub mod page;
pub mod server;
pub mod session;
