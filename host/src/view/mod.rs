//! The page of `chaincell view`, which shows a body in a browser.
//!
//! - [`page`]: the page's text, from the sources in `host/view` and a configuration.
//! - [`session`]: a recorded session as the page plays it.

pub mod page;
pub mod session;
