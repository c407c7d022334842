//! The 1 kHz loops of both sides, how they wait, and what they keep and show.

pub mod control;
pub mod floor;
pub mod inject;
mod link;
mod outstanding;
pub mod peers;
mod playlist;
mod ramp;
pub mod realtime;
pub mod record;
pub mod serve;
mod shaper;
pub mod wait;
