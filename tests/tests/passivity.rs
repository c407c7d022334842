//! The output stage in closed loop with a modelled handle and hand: no energy is made.
//!
//! What is counted is the continuous motion in double precision: the work of the device's force on
//! the handle less what the handle's own damping takes. Starting from rest that sum is what hand
//! and handle have got out of nothing; it must stay at 0 but for the work of the force in use over
//! one count of the encoder.
//!
//! 1,000,000 ticks in all; with `CHAINCELL_SLOW=1` as many for each case.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, ImageBytes, bake};
use chaincell_host::mesh::Mesh;
use chaincell_kernel::stage::{Device, Stage, StageSettings};
use chaincell_kernel::{Model, Network, Settings, Tissue, ToolSample, Track, Unloading};
use chaincell_tests::handle::{Hand, Handle, Moving};
use nalgebra::Vector3;

/// Ticks of all cases together, and of each in the slow suite.
const TICKS: u32 = 1_000_000;
/// A press, a hold, taps, a drag along the surface, a hold, the hand off and on again.
const CYCLE: u32 = 5_000;

type Body = Tissue<16, Track>;

/// A column of 12 cells of 1 cm whose links have this stiffness.
fn column(stiffness_n_per_m: f32) -> ImageBytes {
    todo(stiffness_n_per_m)
}

/// Handles as they are published or measured: mass, and the step of the encoder.
const DEVICES: [(Device, f64, f64); 5] = [
    (Device::Touch, 0.05, 55.0e-6),
    (Device::Premium, 0.1, 30.0e-6),
    (Device::Falcon, 0.2, 60.0e-6),
    (Device::Omega, 0.2, 10.0e-6),
    (Device::Sigma, 0.3, 2.0e-6),
];
