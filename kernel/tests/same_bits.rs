//! The same trajectories on every target and every vector unit, to the last bit: each must give
//! the hash that stands here, whatever machine computes it.
//!
//! `.ci/aarch64` runs this on an emulated aarch64; `cargo test --release -p chaincell-kernel
//! --test same_bits` on this machine, fully optimised. Where a scheme's arithmetic changes on
//! purpose, the failing test prints the new hash; it has to be the same on all targets.
#![allow(clippy::unwrap_used)]

use chaincell_kernel::{
    Dynamics, Euler, Model, Network, Settings, Tissue, ToolSample, Track, hats_room, include_model,
};
use nalgebra::Vector3;

/// `chaincell bake plane:9x9x0.01 --diagonals --lean`: no slices, no hats.
static PLANE: &[u8] = include_model!("../../tests/data/plane9.chaincell");
/// `chaincell bake box:5x5x5x0.01 --hats 2 --alpha 0.02`: slices and hats.
static CUBE: &[u8] = include_model!("../../tests/data/box5.chaincell");

/// Room for the box's hats with two cells held.
type Coarse = Track<{ hats_room(64, 2) }>;

/// One press, drag and release after the other, the third far beyond the body's size.
fn sample(tick: u16) -> ToolSample {
    let (stroke, at) = (tick / 60, f32::from(tick % 60));
    let reach_m = if stroke == 2 { 0.2 } else { 0.0006 * at };
    let position_m = Vector3::new(0.3 * reach_m, 0.0002 * at, -reach_m);
    ToolSample { position_m, engaged: u32::from(tick % 60 < 45) }
}

/// FNV-1a over words.
fn absorb(hash: u64, word: u64) -> u64 {
    (hash ^ word).wrapping_mul(0x0100_0000_01b3)
}

/// Hash of all states, forces, energies and flags of 240 ticks.
fn trajectory<D: Dynamics>(image: &'static [u8], held: &[u32], scalar: bool) -> u64 {
    let model = Model::from_bytes(image).unwrap();
    let network = Network::new(model, Settings::for_model(&model)).unwrap();
    let cell = |id: &u32| model.input_id().iter().position(|other| other == id).unwrap() as u16;
    let mut contacts: Vec<u16> = held.iter().map(cell).collect();
    contacts.sort_unstable();
    let mut tissue: Tissue<128, D, 2> = Tissue::new();
    tissue.reset(&network).unwrap();
    tissue.choose_contacts(&network, &contacts).unwrap();
    if scalar {
        tissue.view().go_scalar();
    }
    (0..240).fold(0xcbf2_9ce4_8422_2325, |hash, tick| {
        let output = tissue.tick(&network, &sample(tick));
        let floats = output.force_n.iter().chain([&output.energy_j]).map(|x| x.to_bits());
        let words = floats.chain([output.contacts, output.flags.0]).map(u64::from);
        words.chain([tissue.view().state_hash(&model)]).fold(hash, absorb)
    })
}

#[track_caller]
fn check<D: Dynamics>(image: &'static [u8], held: &[u32], golden: u64) {
    for scalar in [false, true] {
        let hash = trajectory::<D>(image, held, scalar);
        assert_eq!(hash, golden, "{} without vectors: {scalar}: got {hash:#018x}", D::NAME);
    }
}

#[test]
fn the_images_are_of_both_kinds() {
    let [plane, cube] = [PLANE, CUBE].map(|image| Model::from_bytes(image).unwrap());
    assert!(!plane.is_sliced() && plane.hats() == 0);
    assert!(cube.is_sliced() && cube.hats() > 8);
}

#[test]
fn euler_on_a_plane() {
    check::<Euler>(PLANE, &[40], 0x128a_d29a_9093_b369);
}

#[test]
fn track_on_a_plane() {
    check::<Track>(PLANE, &[40, 41], 0x343d_403d_b971_fac3);
}

#[test]
fn euler_on_a_sliced_box() {
    check::<Euler>(CUBE, &[64], 0x65bb_c298_de2c_f41b);
}

#[test]
fn track_on_a_sliced_box_with_hats() {
    check::<Coarse>(CUBE, &[64, 69], 0xa106_235e_e736_6243);
}
