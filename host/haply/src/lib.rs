//! Drives a Haply Inverse3 by a running `chaincell serve`: positions of the device to the tissue, forces of the
//! tissue to the device, over the WebSocket of Haply's service.
//!
//! Force off on any doubt: [`guard`] decides, and [`drive`] ends every session with a force of zero. Each module
//! uses only those above it:
//!
//! - [`doubt`], [`frame`]: causes for force off; device to scene and back.
//! - [`message`]: the service's JSON, with its sources and what is unsure.
//! - [`guard`]: the force on the hand, a function of states, answers and times.
//! - [`drive`]: the loop, over traits for service, tissue and clock.
//! - [`report`], [`link`], [`scene`]: printing, the socket, the client.

pub mod doubt;
pub mod frame;
pub mod message;

pub mod guard;

pub mod drive;

pub mod link;
pub mod report;
pub mod scene;
