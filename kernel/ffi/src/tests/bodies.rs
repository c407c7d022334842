//! Bodies through the interface are the kernel's, to the last bit, however many there are.

use core::ffi::c_void;
use core::ptr::{null, null_mut};
use core::sync::atomic::{AtomicU32, Ordering};
use std::vec::Vec;

use chaincell_kernel::{
    Dynamics, Euler, Flags, Model, Network, Predict, Rkl2, Track, coarse_room, elastic_room,
    term_states,
};

use super::{
    BLOCK, BOX, CELLS, KINDS, Made, NO_OUTPUT, PLANE, SHAPES, call, choose, hash, info_of, make,
    model_of, of_kernel, pose_at, sample, storage, tick,
};
use crate::{Budget, Code, Detail, Output, Scheme, Tissue, ToolPose};

const TICKS: u16 = 130;

/// Every output and hash of a run.
type Run = Vec<([u32; 8], u64)>;

fn bits(output: Output) -> [u32; 8] {
    let [x, y, z] = output.tool.force_n.map(f32::to_bits);
    let [energy, work, stiffness] =
        [output.energy_j, output.work_j, output.stiffness_n_per_m].map(f32::to_bits);
    [x, y, z, energy, work, stiffness, output.tool.contacts, output.tool.flags]
}

/// Presses and releases; bad poses of every kind on the way, few enough to be held and then too many.
fn pose(at: u16) -> ToolPose {
    let good = sample(at);
    match at {
        30 | 90..93 => pose_at([f32::NAN, 0.0, 0.0], 1),
        31 | 93..96 => ToolPose { engaged: 2, ..good },
        32 | 96..99 => ToolPose { orientation: [0.0; 4], ..good },
        99..104 => pose_at([0.0, 0.0, f32::INFINITY], 1),
        _ => good,
    }
}

/// What the kernel itself does.
fn kernels<D: Dynamics, const STATES: usize>(
    image: &'static [u8],
    ids: &[u32],
    sweeps: u16,
) -> Run {
    let model = Model::from_bytes(image).unwrap();
    let settings = chaincell_kernel::Settings {
        tick_time: if D::NAME.starts_with("rkl") {
            D::tick_time(&model, sweeps)
        } else {
            chaincell_kernel::Settings::for_model(&model).tick_time
        },
        sweeps,
        ..chaincell_kernel::Settings::for_model(&model)
    };
    let network = Network::new(model, settings).unwrap();
    let mut tissue = chaincell_kernel::Tissue::<144, D, 2, STATES>::new();
    tissue.reset(&network).unwrap();
    let mut held: Vec<u16> = ids.iter().map(|&id| model.cell_of_input(id).unwrap()).collect();
    held.sort_unstable();
    tissue.choose_contacts(&network, &held).unwrap();
    let run = (0..TICKS).map(|at| {
        let out = tissue.tick(&network, &[of_kernel(&pose(at))], chaincell_kernel::Budget::All);
        (bits(Output::of(&out)), tissue.view().state_hash(&model))
    });
    run.collect()
}

fn body(image: &'static [u8], scheme: Scheme, ids: &[u32]) -> Made {
    let made = make(image, scheme, 2);
    assert_eq!(choose(made.tissue, ids).0, Code::Ok);
    made
}

fn step(tissue: *mut Tissue, at: u16) -> ([u32; 8], u64) {
    let output = tick(tissue, pose(at));
    (bits(output), hash(tissue))
}

fn alone(image: &'static [u8], scheme: Scheme, ids: &[u32]) -> Run {
    let made = body(image, scheme, ids);
    (0..TICKS).map(|at| step(made.tissue, at)).collect()
}

// REQ-CIF-06, REQ-SMP-01
#[test]
fn every_scheme_gives_the_kernels_bits() {
    let ids = [69, 64];
    type Coarse = Track<{ coarse_room(27, 2) }>;
    let runs = [
        (Scheme::Track, kernels::<Coarse, 0>(BOX, &ids, 4)),
        (Scheme::Euler, kernels::<Euler, 0>(BOX, &ids, 4)),
        (Scheme::Rkl2, kernels::<Rkl2, 0>(BOX, &ids, 4)),
    ];
    let ends: std::collections::BTreeSet<u64> = runs.iter().map(|(_, run)| run[40].1).collect();
    assert_eq!(ends.len(), runs.len(), "two schemes do the same");
    for (scheme, run) in runs {
        let flags = [Flags::BAD_SAMPLE, Flags::SAFE_STATE];
        let is_said = |of: Flags| run.iter().any(|(output, _)| output[7] & of.0 != 0);
        assert!(run.iter().any(|(output, _)| output[2] != 0) && flags.into_iter().all(is_said));
        assert_eq!(alone(BOX, scheme, &ids), run, "{scheme:?}");
    }
    assert_eq!(alone(PLANE, Scheme::Track, &[40]), kernels::<Track, 0>(PLANE, &[40], 4));
    type Elastic = Track<{ elastic_room(64) }>;
    let shapes = kernels::<Elastic, { term_states(144) }>(SHAPES, &[59, 63], 4);
    assert_eq!(alone(SHAPES, Scheme::Track, &[59, 63]), shapes);
    // Without slack there is something to predict.
    let predicted = alone(CELLS, Scheme::Predict, &ids);
    assert_eq!(predicted, kernels::<Predict, 0>(CELLS, &ids, 4));
    assert_ne!(predicted, alone(CELLS, Scheme::Track, &ids));
}

/// No state but that in the storages.
// REQ-CIF-05
#[test]
fn bodies_that_take_turns_do_as_they_do_alone() {
    let kinds = [
        (BOX, Scheme::Track, &[64, 69][..]),
        (PLANE, Scheme::Track, &[40]),
        (BOX, Scheme::Euler, &[64]),
        (BOX, Scheme::Track, &[39]),
        (SHAPES, Scheme::Track, &[59, 63]),
        (SHAPES, Scheme::Predict, &[83]),
    ];
    let apart = kinds.map(|(image, scheme, ids)| alone(image, scheme, ids));
    let bodies = kinds.map(|(image, scheme, ids)| body(image, scheme, ids));
    for at in 0..TICKS {
        for (body, alone) in bodies.iter().zip(&apart) {
            assert_eq!(step(body.tissue, at), alone[usize::from(at)], "tick {at}");
        }
    }
}

/// Reentrant: bodies on threads of their own.
// REQ-CIF-05
#[test]
fn bodies_on_two_threads_do_as_they_do_alone() {
    for (image, [id, ..]) in KINDS {
        let apart = alone(image, Scheme::Track, &[id]);
        std::thread::scope(|scope| {
            let threads = [0, 1].map(|_| scope.spawn(|| alone(image, Scheme::Track, &[id])));
            for thread in threads {
                assert_eq!(thread.join().unwrap(), apart);
            }
        });
    }
}

#[test]
fn a_reset_body_is_a_new_one() {
    let made = body(BOX, Scheme::Track, &[64]);
    let rest = hash(make(BOX, Scheme::Track, 0).tissue);
    let first: Run = (0..TICKS).map(|at| step(made.tissue, at)).collect();
    assert_ne!(hash(made.tissue), rest);
    let mut detail = Detail { needed: 1, ..Detail::default() };
    assert_eq!(call!(chaincell_tissue_reset(made.tissue, &mut detail)), Code::Ok);
    assert_eq!((hash(made.tissue), detail), (rest, Detail::default()));
    assert_eq!(tick(made.tissue, sample(0)).tool.contacts, 0);
    tick(made.tissue, sample(59));
    call!(chaincell_tissue_reset(made.tissue, null_mut()));
    assert_eq!(choose(made.tissue, &[64]).0, Code::Ok);
    assert_eq!((0..TICKS).map(|at| step(made.tissue, at)).collect::<Run>(), first);
}

/// Nothing in a tissue points into it.
// REQ-CIF-05
#[test]
fn a_copied_body_goes_on_where_it_was() {
    for (image, [one, two, _]) in KINDS {
        let made = body(image, Scheme::Track, &[one, two]);
        for at in 0..30 {
            step(made.tissue, at);
        }
        let mut other = storage(made.storage.len() * BLOCK);
        other.copy_from_slice(&made.storage);
        let copy = other.as_mut_ptr().cast();
        for at in 30..TICKS {
            assert_eq!(step(copy, at), step(made.tissue, at));
        }
    }
}

#[test]
fn positions_are_the_kernels_and_go_back() {
    let made = body(BOX, Scheme::Track, &[64]);
    for at in 0..20 {
        step(made.tissue, at);
    }
    let model = Model::from_bytes(BOX).unwrap();
    let mut all = std::vec![0.0; 375];
    assert_eq!(call!(chaincell_positions(made.tissue, all.as_mut_ptr(), 125)), Code::Ok);
    for id in 0..125 {
        let mut there = [0.0; 3];
        assert_eq!(call!(chaincell_position(made.tissue, id, &mut there)), Code::Ok);
        let cell = usize::from(model.cell_of_input(id).unwrap());
        for axis in 0..3 {
            let wanted = model.centre_m()[axis] + all[3 * cell + axis] * model.unit_m();
            assert_eq!(there[axis].to_bits(), wanted.to_bits());
        }
    }
    let mut held = [0.0; 3];
    call!(chaincell_position(made.tissue, 64, &mut held));
    // The tool took hold of it at the rest shape and has it 19 samples further now.
    assert!((held[2] - (0.04 - 19.0 * 0.0006)).abs() < 1e-6, "{held:?}");
    let other = make(BOX, Scheme::Track, 0);
    assert_ne!(hash(other.tissue), hash(made.tissue));
    let none = null_mut();
    assert_eq!(call!(chaincell_set_positions(other.tissue, all.as_ptr(), 125, none)), Code::Ok);
    assert_eq!(hash(other.tissue), hash(made.tissue));
}

// REQ-CIF-07
#[test]
fn positions_that_cannot_be_are_refused() {
    for (image, [id, ..]) in KINDS {
        let made = body(image, Scheme::Track, &[id]);
        let (before, cells) = (hash(made.tissue), info_of(&model_of(image)).cells as usize);
        let mut all = std::vec![0.25; 3 * (cells + 1)];
        for wrong in [0, cells - 1, cells + 1, usize::MAX] {
            let mut detail = Detail::default();
            let code =
                call!(chaincell_set_positions(made.tissue, all.as_ptr(), wrong, &mut detail));
            assert_eq!((code, detail.needed, detail.available), (Code::StateCount, cells, wrong));
            let code = call!(chaincell_positions(made.tissue, all.as_mut_ptr(), wrong));
            assert_eq!(code, Code::StateCount);
        }
        for value in [f32::NAN, f32::NEG_INFINITY, 1.1e6] {
            all[3 * 77 + 1] = value;
            let mut detail = Detail::default();
            let code =
                call!(chaincell_set_positions(made.tissue, all.as_ptr(), cells, &mut detail));
            assert_eq!((code, detail.position), (Code::StatePosition, 77));
        }
        assert_eq!(hash(made.tissue), before);
        let mut untouched = [7.0; 3];
        let code = call!(chaincell_position(made.tissue, cells as u32, &mut untouched));
        assert_eq!((code, untouched), (Code::UnknownId, [7.0; 3]));
        let code =
            call!(chaincell_tick(made.tissue, &sample(0), 1, null(), &mut NO_OUTPUT.clone()));
        assert_eq!(code, Code::Ok);
    }
}

#[test]
fn fine_nodes_are_carried_as_the_kernel_carries_them() {
    let model = Model::from_bytes(CELLS).unwrap();
    let id = (0..125).find(|&id| !model.is_fixed(model.cell_of_input(id).unwrap())).unwrap();
    let made = make(CELLS, Scheme::Euler, 1);
    assert_eq!(choose(made.tissue, &[id]).0, Code::Ok);
    let network = Network::new(model, chaincell_kernel::Settings::for_model(&model)).unwrap();
    let mut tissue = chaincell_kernel::Tissue::<30, Euler, 1>::new();
    tissue.reset(&network).unwrap();
    tissue.choose_contacts(&network, &[model.cell_of_input(id).unwrap()]).unwrap();
    for at in 0..20 {
        tissue.tick(&network, &[of_kernel(&sample(at))], chaincell_kernel::Budget::All);
        step(made.tissue, at);
    }
    let mut moved = false;
    for node in 0..125_u32 {
        let mut there = [0.0; 3];
        assert_eq!(call!(chaincell_position(made.tissue, node, &mut there)), Code::Ok);
        let wanted = tissue.view().fine_position_m(&model, node as usize).unwrap();
        assert_eq!(there.map(f32::to_bits), [wanted.x, wanted.y, wanted.z].map(f32::to_bits));
        let rest = model.fine_rest(node as usize).unwrap();
        moved |= (there[2] - (model.centre_m()[2] + rest[2] * model.unit_m())).abs() > 1e-3;
    }
    assert!(moved);
    let mut untouched = [7.0; 3];
    let code = call!(chaincell_position(made.tissue, 125, &mut untouched));
    assert_eq!((code, untouched), (Code::UnknownId, [7.0; 3]));
}

/// How often [`two`] was asked.
static ASKED: AtomicU32 = AtomicU32::new(0);

/// Says no from the second sweep on.
extern "C" fn two(done: u32, context: *mut c_void) -> i32 {
    assert!(context.is_null());
    ASKED.fetch_add(1, Ordering::Relaxed);
    i32::from(done < 2)
}

// REQ-TCK-06
#[test]
fn a_tick_ends_where_the_callback_says_and_a_late_one_repeats_the_force() {
    for (image, [id, ..]) in KINDS {
        let bodies = [(); 2].map(|()| body(image, Scheme::Track, &[id]));
        let [some, none] = [0, 1].map(|one: usize| bodies[one].tissue);
        let (mut output, mut wanted) = (NO_OUTPUT, NO_OUTPUT);
        let without_end =
            Budget { sweeps: u32::MAX, more: None, context: null_mut(), force_error_share: 0.0 };
        let as_asked = Budget { more: Some(two), ..without_end };
        let late = Budget { sweeps: 0, ..as_asked };
        ASKED.store(0, Ordering::Relaxed);
        for at in 1..40 {
            let sample = sample(at);
            let code = call!(chaincell_tick(some, &sample, 1, &as_asked, &mut output));
            let asked = ASKED.load(Ordering::Relaxed);
            assert_eq!((code, output.sweeps, asked), (Code::Ok, 2, 2 * u32::from(at)));
            let code = call!(chaincell_tick(none, &sample, 1, &without_end, &mut wanted));
            assert_eq!((code, wanted.sweeps), (Code::Ok, 4));
        }
        let counted = Budget { sweeps: 3, ..without_end };
        assert_eq!(call!(chaincell_tick(none, &sample(39), 1, &counted, &mut wanted)), Code::Ok);
        assert_eq!(wanted.sweeps, 3);
        let before = output.tool.force_n;
        assert!(before != [0.0; 3] && hash(some) != hash(none));
        assert_eq!(call!(chaincell_tick(some, &sample(40), 1, &late, &mut output)), Code::Ok);
        assert_eq!((output.tool.force_n, output.sweeps), (before, 0));
        assert_ne!(output.tool.flags & Flags::LATE.0, 0);
        let none: *mut Tissue = null_mut();
        assert_eq!(call!(chaincell_tick(none, &sample(40), 1, &late, &mut output)), Code::Null);
        assert_eq!((output.tool.force_n, output.tool.flags), ([0.0; 3], Flags::SAFE_STATE.0));
    }
}
