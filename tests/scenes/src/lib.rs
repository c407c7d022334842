//! Golden scenes: bodies, motions and digests that every target must reproduce to the last bit.
//!
//! A [`Scene`] is a body linked into the program, the cells that the tool holds, settings and a
//! motion in plain `f32` arithmetic. [`Run`] plays it tick by tick and absorbs all that each tick
//! answers into a [`Digest`]; [`GOLDENS`] holds what must come out. No `std`, no heap: firmware
//! plays one scene in a static tissue of the scene's own size.
//!
//! ```
//! use chaincell_scenes::{Run, Tier, golden, plane4_euler as scene};
//!
//! let mut tissue = scene::Body::new(); // in firmware a static, 17 kB
//! let mut run = Run::new(&scene::SCENE, tissue.view()).unwrap();
//! run.play(100, |_tick, _state_hash| {});
//! let golden = golden(&scene::SCENE, Tier::F32, 100).unwrap();
//! assert_eq!(run.digest(), golden.digest);
//! ```
//!
//! Where a target differs, [`first_difference`] finds the first tick and the first cell of two
//! runs on one machine; for a foreign target, [`report`] writes what a workstation needs for that:
//! `cargo run --release -p chaincell-scenes --example golden`.
#![no_std]

pub mod adverse;
mod digest;
mod goldens;
mod list;
mod motion;
pub mod report;
mod run;
mod tools;

pub use digest::{Digest, TICK_BYTES};
pub use goldens::{GOLDENS, Golden, TICKS, golden};
pub use list::*;
pub use motion::sample;
pub use run::{Act, Difference, FAULT, NO_ID, Run, RunError, Stepper, first_difference};
pub use tools::{TOOLS_MAX, Tools};

/// Number type that a scheme computes in.
pub use chaincell_kernel::Arithmetic as Tier;

use chaincell_kernel::{Model, Settings, ToolPose};

/// What is played.
#[derive(Debug, Clone, Copy)]
pub struct Scene {
    /// Name, `body_scheme`.
    pub name: &'static str,
    /// The scheme's name.
    pub scheme: &'static str,
    /// Number types that the scene is played in.
    pub tiers: &'static [Tier],
    /// Model image, aligned as the kernel reads it.
    pub image: &'static [u8],
    /// Cells of the body.
    pub cells: usize,
    /// Input ids of the cells that the tool holds.
    pub held: &'static [u32],
    /// Tools that meet the body's surface; then no cells are held.
    pub tools: Option<Tools>,
    /// Depth of a press \[m\].
    pub reach_m: f32,
    /// Settings for the body.
    pub settings: fn(&Model<'_>) -> Settings,
}

impl Scene {
    /// The sample of a tick.
    #[must_use]
    pub fn sample(&self, tick: u32) -> ToolPose {
        match self.tools() {
            Some(Tools { start_m: [start_m, _], .. }) => {
                motion::press(*start_m, self.reach_m, tick)
            }
            None => sample(self.reach_m, tick),
        }
    }

    /// The tools; none in a program that is built without contact on surfaces.
    #[must_use]
    pub fn tools(&self) -> Option<&Tools> {
        self.tools.as_ref().filter(|_| cfg!(feature = "surface"))
    }
}
