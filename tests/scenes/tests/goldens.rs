//! Every scene gives its golden digest, on the vector unit and without it.
//!
//! Plain `cargo test` runs the debug build, `cargo test --release` the optimised one;
//! `.ci/same-bits` this machine's full instruction set and WebAssembly, `.ci/aarch64` NEON, where
//! `CHAINCELL_QUICK` leaves it at 100 ticks: emulated, all 2,000 take four minutes.
#![allow(clippy::unwrap_used, clippy::panic)]

use chaincell_kernel::{Dynamics, Flags, TissueMut};
use chaincell_scenes::{
    Act, Difference, GOLDENS, Run, SCENES, Scene, Stepper, TICKS, Tier, first_difference, golden,
    stage,
};

/// Runs of one scene in two tissues of their own.
fn twins<T>(name: &str, then: impl FnOnce(&mut dyn Stepper, &mut dyn Stepper) -> T) -> T {
    struct First<'n, F>(&'n str, F);
    struct Second<'r, F>(&'r mut dyn Stepper, F);
    impl<T, F: FnOnce(&mut dyn Stepper, &mut dyn Stepper) -> T> Act for First<'_, F> {
        type Output = T;
        fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> T {
            let mut run = Run::new(scene, tissue).unwrap();
            stage(self.0, Tier::F32, Second(&mut run, self.1)).unwrap()
        }
    }
    impl<T, F: FnOnce(&mut dyn Stepper, &mut dyn Stepper) -> T> Act for Second<'_, F> {
        type Output = T;
        fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> T {
            (self.1)(self.0, &mut Run::new(scene, tissue).unwrap())
        }
    }
    stage(name, Tier::F32, First(name, then)).unwrap()
}

/// How far to play.
fn ticks() -> &'static [u32] {
    if std::env::var_os("CHAINCELL_QUICK").is_some() { &TICKS[..1] } else { &TICKS }
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

#[test]
fn every_scene_gives_its_goldens() {
    let mut table = String::new();
    let mut all_right = true;
    for (scene, tier) in SCENES.iter().flat_map(|scene| Tier::ALL.map(|tier| (scene, tier))) {
        for scalar in [false, true] {
            let digests = stage(scene.name, tier, Digests { scalar }).unwrap();
            for (ticks, digest, bytes) in digests {
                let line = format!(
                    "    of({:?}, Tier::{tier:?}, {ticks}, {digest:#018x}, {bytes}),\n",
                    scene.name
                );
                let here = golden(scene, tier, ticks);
                if here.is_none_or(|golden| (golden.digest, golden.bytes) != (digest, bytes)) {
                    println!("{} after {ticks} ticks, scalar {scalar}: not {here:x?}", scene.name);
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
    assert_eq!(GOLDENS.len(), SCENES.len() * Tier::ALL.len() * TICKS.len());
}

#[test]
fn the_vector_unit_and_plain_arithmetic_agree_tick_by_tick() {
    for scene in SCENES {
        let difference = twins(scene.name, |one, other| {
            other.go_scalar();
            first_difference(one, other, most())
        });
        if let Some(difference) = difference {
            panic!("{}, vector unit and without: {difference}", scene.name);
        }
    }
}

#[test]
fn a_fault_is_found_in_its_tick_and_cell() {
    for scene in SCENES {
        for cell in [0, 100, scene.cells - 1] {
            let found = twins(scene.name, |one, other| {
                assert_eq!(first_difference(one, other, 20), None);
                one.fault(37, cell);
                first_difference(one, other, 100)
            });
            let Some(Difference { tick: 37, cell: Some((at, id, [faulty, right])) }) = found else {
                panic!("{} cell {cell}: {found:?}", scene.name);
            };
            assert_eq!((at, faulty), (cell, [right[0] ^ 1, right[1], right[2]]), "{}", scene.name);
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
    for scene in SCENES {
        let (flags, states, peak_n) = stage(scene.name, Tier::F32, Watch).unwrap();
        println!("{}: flags {flags}, {states} states, up to {peak_n} N", scene.name);
        let must = Flags::MOTION_CLAMPED.0 | Flags::BAD_SAMPLE.0 | Flags::SAFE_STATE.0;
        assert_eq!(flags & must, must, "{}", scene.name);
        assert!(states > most() as usize * 9 / 10, "{}: the body hardly moves", scene.name);
        assert!(peak_n > 0.1, "{}: {peak_n} N", scene.name);
        all |= flags;
    }
    let must = Flags::BAND_CLOSED.0 | Flags::FORCE_CLAMPED.0 | Flags::ROLLED_BACK.0;
    assert_eq!(all & must, must);
}
