//! What this image plays, as `build.rs` found it in the environment.

// Each scheme's line needs some of these.
#[allow(unused_imports)]
use chaincell_kernel::{Euler, Track, hats_room};
use chaincell_kernel::{Model, Settings};

include!(concat!(env!("OUT_DIR"), "/scene.rs"));

/// Defaults but for the number of sweeps.
pub fn settings(model: &Model<'_>, sweeps: u16) -> Settings {
    Settings { sweeps, ..Settings::for_model(model) }
}
