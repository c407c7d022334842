//! What this image plays, as `build.rs` found it in the environment.

use chaincell_kernel::{Dynamics, Model, Settings, Unloading};
// Each scheme's line needs one of these, and perhaps the room for coarse functions.
#[allow(unused_imports)]
use chaincell_kernel::{Euler, Predict, Rkl2, Track, coarse_room, elastic_room};
use chaincell_scenes::{Scene, Tools};

include!(concat!(env!("OUT_DIR"), "/scene.rs"));

/// The scene.
pub static SCENE: Scene = Scene {
    name: "firmware",
    scheme: <Scheme as Dynamics>::NAME,
    tiers: &[],
    image: IMAGE,
    cells: CELLS,
    held: &HELD,
    tools: TOOLS,
    reach_m: f32::from_bits(REACH_BITS),
    settings: |model| settings(model, SWEEPS),
};

/// Settings of the scene but for the number of sweeps.
pub fn settings(model: &Model<'_>, sweeps: u16) -> Settings {
    Settings {
        sweeps,
        tick_time: Scheme::tick_time(model, sweeps),
        unloading: UNLOADING,
        max_force_n: f32::from_bits(MAX_FORCE_BITS),
        ..Settings::for_model(model)
    }
}
