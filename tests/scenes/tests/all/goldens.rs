//! Every scene gives its golden digest, on the vector unit and without it.
//!
//! Plain `cargo test` plays 100 ticks in the debug build, all 2,000 with `CHAINCELL_SLOW=1`;
//! `cargo test --release` all of them in the optimised one; `.ci/same-bits` this machine's full
//! instruction set and WebAssembly, `.ci/emulated` NEON and the FPU of Thumb-2.
#![allow(clippy::unwrap_used, clippy::panic)]

use chaincell_kernel::tick::hash::REVISION;
use chaincell_kernel::{Dynamics, Flags, TissueMut};
use chaincell_scenes::{
    Act, Difference, GOLDENS, Run, SCENES, Scene, Stepper, TICKS, Tier, first_difference, golden,
    stage,
};
use crc::{CRC_32_ISO_HDLC, Crc};

const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// All scenes in all their number types.
fn played() -> impl Iterator<Item = (&'static Scene, Tier)> {
    SCENES.into_iter().flat_map(|scene| scene.tiers.iter().map(move |&tier| (scene, tier)))
}

/// Runs of one scene in two tissues of their own.
fn twins<T>(
    name: &str,
    tier: Tier,
    then: impl FnOnce(&mut dyn Stepper, &mut dyn Stepper) -> T,
) -> T {
    struct First<'n, F>(&'n str, Tier, F);
    struct Second<'r, F>(&'r mut dyn Stepper, F);
    impl<T, F: FnOnce(&mut dyn Stepper, &mut dyn Stepper) -> T> Act for First<'_, F> {
        type Output = T;
        fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> T {
            let mut run = Run::new(scene, tissue).unwrap();
            stage(self.0, self.1, Second(&mut run, self.2)).unwrap()
        }
    }
    impl<T, F: FnOnce(&mut dyn Stepper, &mut dyn Stepper) -> T> Act for Second<'_, F> {
        type Output = T;
        fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> T {
            (self.1)(self.0, &mut Run::new(scene, tissue).unwrap())
        }
    }
    stage(name, tier, First(name, tier, then)).unwrap()
}

/// How far to play.
fn ticks() -> &'static [u32] {
    let quick = cfg!(debug_assertions) && std::env::var_os("CHAINCELL_SLOW").is_none();
    if quick { &TICKS[..1] } else { &TICKS }
}

/// The most of them.
fn most() -> u32 {
    ticks()[ticks().len() - 1]
}

/// Digests after each of `TICKS`, as the lines of the table; also without the vector unit.
struct Digests {
    scalar: bool,
}

impl Act for Digests {
    type Output = Vec<(u32, u64, u64)>;

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).unwrap();
        if self.scalar {
            run.go_scalar();
        }
        let mut after = |ticks: u32| {
            run.play(ticks - run.ticks(), |_, _| {});
            (ticks, run.digest(), run.bytes())
        };
        ticks().iter().map(|&ticks| after(ticks)).collect()
    }
}

// REQ-BIT-01
#[test]
fn every_scene_gives_its_goldens() {
    let mut table = String::new();
    let mut all_right = true;
    for (scene, tier) in played() {
        for scalar in [false, true] {
            let digests = stage(scene.name, tier, Digests { scalar }).unwrap();
            for (ticks, digest, bytes) in digests {
                let line = format!(
                    "    of({:?}, Tier::{tier:?}, {ticks}, {digest:#018x}, {bytes}),\n",
                    scene.name
                );
                let here = golden(scene, tier, ticks);
                if here.is_none_or(|golden| (golden.digest, golden.bytes) != (digest, bytes)) {
                    println!(
                        "{} {tier:?} after {ticks} ticks, scalar {scalar}: not {here:x?}",
                        scene.name
                    );
                    all_right = false;
                }
                if !scalar {
                    table += &line;
                }
            }
        }
    }
    assert!(
        all_right,
        "if this change of bits is meant, on every target, tests/scenes/src/goldens.rs gets:\n{table}"
    );
    assert_eq!(GOLDENS.len(), played().count() * TICKS.len());
}

#[test]
fn the_vector_unit_and_plain_arithmetic_agree_tick_by_tick() {
    for (scene, tier) in played() {
        let difference = twins(scene.name, tier, |one, other| {
            other.go_scalar();
            first_difference(one, other, most())
        });
        if let Some(difference) = difference {
            panic!("{} {tier:?}, vector unit and without: {difference}", scene.name);
        }
    }
}

// REQ-BIT-07
#[test]
fn a_fault_is_found_in_its_tick_and_cell() {
    for (scene, tier) in played() {
        for cell in [0, 100, scene.cells - 1] {
            let found = twins(scene.name, tier, |one, other| {
                assert_eq!(first_difference(one, other, 20), None);
                one.fault(37, cell);
                first_difference(one, other, 100)
            });
            let Some(Difference { tick: 37, cell: Some((at, id, [faulty, right])) }) = found else {
                panic!("{} cell {cell}: {found:?}", scene.name);
            };
            assert_eq!(at, cell, "{}", scene.name);
            assert!(faulty[0] != right[0] && faulty[1..] == right[1..], "{faulty:x?} {right:x?}");
            let text = found.unwrap().to_string();
            let begin = format!("first difference at tick 37: cell {cell} (node {id}) is [");
            assert!(text.starts_with(&begin), "{text}");
        }
    }
}

/// What the scenes are there for: flags seen, and how far the body went.
struct Watch;

impl Act for Watch {
    type Output = (u32, usize, f32);

    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output {
        let mut run = Run::new(scene, tissue).unwrap();
        let (mut flags, mut hashes, mut peak_n) = (0, Vec::new(), 0.0_f32);
        for _ in 0..most() {
            let (output, state_hash) = run.tick();
            flags |= output.flags.0;
            hashes.push(state_hash);
            peak_n = output.force_n.iter().fold(peak_n, |peak, x| peak.max(x.abs()));
        }
        hashes.sort_unstable();
        hashes.dedup();
        (flags, hashes.len(), peak_n)
    }
}

#[test]
fn scenes_press_clamp_close_and_reach_the_safe_state() {
    let mut all = 0;
    for (scene, tier) in played() {
        let (flags, states, peak_n) = stage(scene.name, tier, Watch).unwrap();
        println!("{} {tier:?}: flags {flags}, {states} states, up to {peak_n} N", scene.name);
        let must = Flags::MOTION_CLAMPED.0 | Flags::BAD_SAMPLE.0 | Flags::SAFE_STATE.0;
        assert_eq!(flags & must, must, "{}", scene.name);
        assert!(states > most() as usize * 9 / 10, "{}: the body hardly moves", scene.name);
        assert!(peak_n > 0.1, "{}: {peak_n} N", scene.name);
        all |= flags;
    }
    let must = Flags::BAND_CLOSED.0 | Flags::FORCE_CLAMPED.0 | Flags::ROLLED_BACK.0;
    assert_eq!(all & must, must);
}

/// Traces name the revision: a change of any golden raises it, once between two releases. A new scene
/// changes the second alone, and so does one that is gone or whose old image the kernel refuses.
#[test]
fn the_goldens_are_those_of_the_revision() {
    let mut digest = CRC.digest();
    GOLDENS.iter().for_each(|golden| digest.update(&golden.digest.to_le_bytes()));
    assert_eq!((REVISION, digest.finalize()), (5, 0x1b81_0901));
}
