//! A hand on the tissue of another machine, over a wired LAN: poses there and forces back in UDP datagrams.
//!
//! [`agent`] stands beside `chaincell serve` and is its only controller; [`hand`] is for the program beside the
//! device. A pose travels in four datagrams, so one that is lost loses no tick. The agent gives each pose the
//! send time of the hand by its own clock, so that `serve --delay-ticks auto` sees the way; it refuses a network
//! whose round trip, with the tissue's answer, takes more than six ticks at the p99.9. A broken link is a silence:
//! the server's watchdog lets the force fall there, and the hand's own one here.
//!
//! Each datagram has a code by a shared key. Who has no key is not answered and moves nothing; nothing is
//! encrypted. Each module uses only those above it:
//!
//! - [`key`], [`datagram`]: the key's file; the bytes.
//! - [`trips`]: the last round trips, and their verdict.
//! - [`agent`], [`controller`]: both sides as functions of datagrams and times.
//! - [`socket`], [`hand`]: UDP; what a program beside the device links.
//! - [`path`], [`report`], [`play`], [`run`]: a file of poses, reports, and the loops of both commands.

pub mod datagram;
pub mod key;

mod side;
pub mod trips;

pub mod agent;
pub mod controller;

pub mod hand;
pub mod socket;

pub mod path;
pub mod play;
pub mod report;
pub mod run;
