//! Soft tissue as a cellular neural network with ChainMail links, for haptic firmware.
//!
//! Every mesh node is a cell; a link between two cells admits a band of lengths; the network's
//! dynamics deform the body (J. Zhang, Y. Zhong, J. Smith, C. Gu, "ChainMail based neural dynamics
//! modeling of soft tissue deformation for surgical simulation", 2017; equation numbers refer to
//! it). No `std`, no heap, no panic in the tick, a bounded number of link passes a tick, and the
//! same bits on every target.
//!
//! - [`Model`]: the body, read in place from its image in flash.
//! - [`Network`]: a model with [`Settings`] that fit it.
//! - [`Tissue`]: the state in RAM, under the scheme [`Track`], [`Predict`], [`Euler`] or
//!   [`Rkl2`].
//! - [`Number`]: what cells and links are computed in, a parameter of [`Track`] and [`Euler`]:
//!   `f32` or fixed point ([`I8F24`]).
//!
//! The modules, each of which uses only itself and those before it:
//!
//! - [`number`]: arithmetic with the same bits on every target.
//! - [`model`]: the model's image, its checks, what it tells.
//! - [`backend`]: vector units and the loops that run on them.
//! - [`energy`]: the terms of the energy.
//! - [`solver`]: the schemes.
//! - [`contact`]: tools that hold or load cells, and tools on the surface.
//! - [`cut`]: cells split where faces between tetrahedra open.
//! - [`tick`]: settings, samples, tissue, the tick, the state hash.
//! - [`stage`]: between the tissue's answer and a device: coupling, passivity, limits, ramp,
//!   watchdog.
//! - [`snapshot`]: saved states.
//! - [`trace`]: recorded sessions, to be played again bit for bit.
//!
//! ```
//! use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // In flash. From: chaincell bake plane:9x9x0.01 --diagonals --lean -o plane9.chaincell
//! static IMAGE: &[u8] =
//!     include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
//! let model = Model::from_bytes(IMAGE)?;
//! let network = Network::new(model, Settings::for_model(&model))?;
//! let mut tissue = Tissue::<128, Track>::new(); // all memory; a `static` can hold it
//! tissue.reset(&network)?;
//! let held = [model.cell_of_input(40).ok_or("no cell")?]; // the node in the middle
//! tissue.choose_contacts(&network, &held)?;
//!
//! let mut force_n = 0.0;
//! for tick in 0..=10 {
//!     let position_m = [0.0, 0.0, -0.001 * tick as f32].into(); // 1 m/s downwards
//!     let output = tissue.tick(&network, &[ToolPose::at(position_m, 1)], Budget::All);
//!     force_n = output.force_n.z;
//! }
//! assert!((0.05..0.07).contains(&force_n)); // [N], upwards, against the press of 10 mm
//! # Ok(())
//! # }
//! ```
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]

#[cfg(test)]
extern crate std;

pub mod backend;
pub mod contact;
pub mod cut;
pub mod energy;
pub mod model;
pub mod number;
#[cfg(feature = "relax")]
mod relax;
pub mod snapshot;
pub mod solver;
pub mod stage;
pub mod tick;
pub mod trace;

/// The cargo features that this build has.
pub const FEATURES: &[&str] = &[
    #[cfg(feature = "cut")]
    "cut",
    #[cfg(feature = "nodal")]
    "nodal",
    #[cfg(feature = "pins")]
    "pins",
    #[cfg(feature = "relax")]
    "relax",
    #[cfg(feature = "surface")]
    "surface",
];

pub use backend::VectorUnit;
pub use backend::team::{Job, Team, Workers};
pub use contact::error::{ContactError, PinError};
pub use contact::memory::{TouchArrays, TouchRoom, TouchState, TouchStore};
pub use contact::output::{PinOutput, ProxyPose, ToolOutput};
pub use contact::pose::{NOT_TURNED, OPENING_MAX, ToolPart, ToolPose};
pub use contact::tools::{ContactForce, FRICTION_MAX};
pub use cut::memory::{CutRoom, cut_state, cut_words, triangles_max};
pub use energy::held::Contact;
pub use energy::links::range::RangeError;
pub use energy::rounding::Rounding;
pub use energy::state::{TermState, TermStates, term_states};
pub use energy::stress::Stress;
pub use energy::surface::{
    Anchor, EDGE_BYTES, NearTriangle, PARTS_MAX, PINS_ARE_BUILT, PinSample, Scissors, TOOLS_MAX,
    ToolState,
};
pub use fixed::types::I8F24;
pub use model::branches::Branch;
pub use model::image::ModelError;
pub use model::loose::Loose;
pub use model::parts;
pub use model::tearing::{TEAR_EDGE_M, TEAR_SHARE, TEAR_STRETCH, TearLimit};
pub use model::{COORDINATE_MAX, Model, image};
pub use number::Number;
pub use number::cell::Cell;
pub use number::float_env::{self, FloatEnvironmentError};
pub use solver::coarse::{
    CoarseTouch, coarse_room, elastic_held_room, elastic_room, side_room, tool_room,
};
pub use solver::{Dynamics, Euler, NumberOf, Predict, Rkl2, Track};
pub use tick::budget::Budget;
pub use tick::choice::Choice;
pub use tick::choices::{Arithmetic, Cutting, Drive, Scheme, Unloading};
pub use tick::cut::{CutError, CutOutput};
pub use tick::error::{ResetError, StateError};
pub use tick::fit::array_bytes;
pub use tick::handover;
pub use tick::sample::{Flags, TickOutput};
pub use tick::settings::{
    Network, PlainSettings, SettingField, SettingKind, Settings, SettingsError,
};
pub use tick::tick::HELD_TICKS_MAX;
pub use tick::tissue::{Head, Tissue, TissueMut};
