//! The 1 kHz loops of both sides, how they wait, and what they keep and show.

pub use chaincell_client::wait;
use chaincell_client::{ramp, shaper};

pub mod control;
pub mod floor;
pub mod inject;
mod link;
mod outstanding;
pub mod peers;
mod playlist;
pub mod realtime;
pub mod record;
pub mod serve;
