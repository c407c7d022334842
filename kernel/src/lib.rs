//! Soft tissue as a cellular neural network with ChainMail links, for haptic firmware.
//!
//! Every mesh node is a cell; links between cells carry a band of admitted lengths; the network's
//! dynamics deform the body (J. Zhang, Y. Zhong, J. Smith, C. Gu, "ChainMail based neural dynamics
//! modeling of soft tissue deformation for surgical simulation", 2017; equation numbers refer to
//! it). No `std`, no heap, no panic in the tick, a constant number of link passes a tick, and the
//! same bits on every target.
//!
//! - [`Model`]: the body, read in place from its image in flash.
//! - [`Network`]: a model with [`Settings`] that fit it.
//! - [`Tissue`]: the state in RAM, under the scheme [`Track`], [`Euler`], [`Rkl1`], [`Rkl2`] or
//!   [`GaussSeidel`].
//! - [`trace`]: a session's samples and state hashes, to be played again bit for bit.
//! - [`Number`]: what cells and links are computed in, a parameter of [`Track`] and [`Euler`]:
//!   `f32`, fixed point ([`I8F24`]) or `f64`.
//! - [`stage`]: between an answer and a hand: coupling, passivity, limits, ramp, watchdog.
//! - [`trace`]: recorded sessions, the same bytes on every target.
//!
//! ```
//! use chaincell_kernel::{Model, ModelError, Network, Settings, Tissue, ToolSample, Track};
//! use nalgebra::Vector3;
//!
//! fn press(image: &[u8]) -> Result<Vector3<f32>, ModelError> {
//!     let model = Model::from_bytes(image)?;
//!     let settings = Settings::for_model(&model);
//!     let (Ok(network), mut tissue) =
//!         (Network::new(model, settings), Tissue::<512, Track>::new())
//!     else {
//!         return Err(ModelError::Layout);
//!     };
//!     if tissue.reset(&network).is_err() || tissue.choose_contacts(&network, &[7]).is_err() {
//!         return Ok(Vector3::zeros());
//!     }
//!     let sample = ToolSample { position_m: Vector3::new(0.0, 0.0, -0.001), engaged: 1 };
//!     Ok(tissue.tick(&network, &sample).force_n)
//! }
//! assert!(press(&[0; 64]).is_err()); // not a model image
//! ```
#![no_std]
#![cfg_attr(
    not(test),
    deny(clippy::indexing_slicing, clippy::unwrap_used, clippy::expect_used, clippy::panic)
)]

#[cfg(test)]
extern crate std;

mod access;
mod awake;
pub mod cell;
pub mod contact;
mod current;
pub mod dynamics;
mod fine;
pub mod float_env;
pub mod handover;
pub mod hash;
mod hats;
pub mod image;
pub mod link;
mod model;
pub mod number;
mod pass;
mod probe;
pub mod sample;
mod scalar;
mod settings;
pub mod simd;
mod slice;
#[allow(unsafe_code)]
pub mod sqrt;
pub mod stage;
mod take_out;
mod tick;
mod tissue;
pub mod trace;
pub mod two_float;

pub use dynamics::{Dynamics, Euler, GaussSeidel, NumberOf, Rkl1, Rkl2, Track};
pub use fixed::types::I8F24;
pub use hats::hats_room;
pub use image::ModelError;
pub use model::Model;
pub use number::{Number, RangeError};
pub use sample::{Flags, TickOutput, ToolSample};
pub use settings::{Drive, Network, Settings, SettingsError, Unloading};
pub use take_out::probe_room;
pub use tick::HELD_TICKS_MAX;
pub use tissue::{COORDINATE_MAX, Head, ResetError, StateError, Tissue, TissueMut, array_bytes};
