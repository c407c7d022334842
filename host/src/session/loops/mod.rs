//! The 1 kHz loops of both sides, with their waiting, their recordings and the force that they show.

pub use chaincell_client::wait;
use chaincell_client::{ramp, shaper};

pub mod control;
pub mod floor;
pub mod inject;
mod link;
pub mod load;
mod outstanding;
pub mod peers;
mod playlist;
pub mod realtime;
pub mod record;
pub mod serve;
