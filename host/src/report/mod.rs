//! `chaincell report`: speed against error, measured and written down.

pub mod exact;
pub mod scene;
