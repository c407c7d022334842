//! Tools on a surface through the interface: the kernel's bits, and what is refused.

use core::ptr::{null, null_mut};
use std::vec::Vec;

use chaincell_kernel::{
    Flags, Model, NOT_TURNED, Network, Predict, Settings as KernelSettings, TickOutput,
    Tissue as Own, ToolOutput as KernelOutput, ToolPart as KernelPart, TouchStore, elastic_room,
    term_states,
};

use super::tool_storage::{ROOM, SURFACE, placed};
use super::{BOX, NO_OUTPUT, call, hash, make, of_kernel};
use crate::{
    Budget, Code, ContactForce, Detail, Output, Room, Scheme, Tissue, ToolOutput, ToolPart,
    ToolPose,
};

const BALL: ToolPart =
    ToolPart { centre_m: [0.0; 3], orientation: NOT_TURNED, half_m: [0.0; 3], radius_m: 0.008 };
const CAPSULE: ToolPart =
    ToolPart { centre_m: [0.0, 0.004, 0.0], half_m: [0.0, 0.0, 0.003], radius_m: 0.006, ..BALL };

/// A ball, and a ball with a capsule beside it.
const PARTS: [ToolPart; 3] = [BALL, CAPSULE, ToolPart { radius_m: 0.009, ..BALL }];
const COUNTS: [u32; 2] = [1, 2];

/// What a tool feels that touches nothing.
const NOTHING: ToolOutput =
    ToolOutput { force_n: [0.0; 3], torque_n_m: [0.0; 3], contacts: 0, flags: 0 };

pub(super) fn choose(tissue: *mut Tissue, friction: f32) -> Code {
    let (parts, counts) = (PARTS.as_ptr(), COUNTS.as_ptr());
    call!(chaincell_choose_tools(tissue, parts, counts, 2, friction, null_mut()))
}

/// Both go down from above the top at 30 mm, then aside, the second one turning.
fn poses(at: u16) -> [ToolPose; 2] {
    let down = 0.0001 * f32::from(at.min(50));
    let aside = 0.0001 * f32::from(at.saturating_sub(50).min(40));
    let (sin, cos) = (0.002 * f32::from(at)).sin_cos();
    let first = ToolPose {
        position_m: [-0.01 - aside, 0.001, 0.039 - down],
        orientation: NOT_TURNED,
        engaged: u16::from(at < 80),
        opening_turns_q16: 0,
    };
    let position_m = [0.012 + aside, -0.003, 0.039 - down];
    let orientation = [0.0, sin, 0.0, cos];
    [first, ToolPose { position_m, orientation, engaged: 1, ..first }]
}

pub(super) fn tick(tissue: *mut Tissue, at: u16) -> [Output; 2] {
    let mut outputs = [NO_OUTPUT; 2];
    let (poses, there) = (poses(at), outputs.as_mut_ptr());
    assert_eq!(call!(chaincell_tick(tissue, poses.as_ptr(), 2, null(), there)), Code::Ok);
    outputs
}

/// Ticks up to one of this number; what that gave.
pub(super) fn play(tissue: *mut Tissue, ticks: u16) -> [Output; 2] {
    for at in 0..ticks - 1 {
        tick(tissue, at);
    }
    tick(tissue, ticks - 1)
}

/// All contacts, and how many there are.
fn contacts(tissue: *mut Tissue, room: usize) -> (Vec<ContactForce>, usize) {
    let none = ContactForce {
        position_m: [7.0; 3],
        normal_n: [7.0; 3],
        tangential_n: [7.0; 3],
        area_m2: 7.0,
        triangle: 7,
        cell: 7,
        origin: 7,
        tool: 7,
        part: 7,
    };
    let (mut all, mut count) = (std::vec![none; room + 1], usize::MAX);
    let there = all.as_mut_ptr();
    assert_eq!(call!(chaincell_contact_forces(tissue, there, room, &mut count)), Code::Ok);
    assert_eq!(all.last(), Some(&none), "written beyond its room");
    all.truncate(count.min(room));
    (all, count)
}

/// The output of one of several tools in a tick.
fn of_tool(tick: &TickOutput, felt: &KernelOutput, errors: [Option<f32>; 2]) -> Output {
    let wanted = Output::of(&TickOutput {
        force_n: felt.force_n,
        work_j: felt.work_j,
        stiffness_n_per_m: felt.stiffness_n_per_m,
        contacts: felt.contacts,
        ..*tick
    });
    let tool = ToolOutput { torque_n_m: felt.torque_n_m.into(), ..wanted.tool };
    let [force_error_n, torque_error_n_m] = errors.map(|error| error.unwrap_or(-1.0));
    Output { tool, force_error_n, torque_error_n_m, ..wanted }
}

/// Two tools, one of two parts, with friction and a grip; now and then a bad pose, and too many at the end.
#[test]
fn tools_are_the_kernels_to_the_last_bit() {
    let made = placed(Scheme::Predict, &ROOM);
    assert_eq!(choose(made.tissue, 0.3), Code::Ok);
    let model = Model::from_bytes(SURFACE).unwrap();
    let settings = KernelSettings { max_tool_step_m: 0.01, ..KernelSettings::for_model(&model) };
    let network = Network::new(model, settings).unwrap();
    let mut own = Own::<144, Predict<{ elastic_room(24) }>, 2, { term_states(144) }>::new();
    let mut store = TouchStore::<144, 256, 300, 2>::new();
    own.touching(store.room()).reset(&network).unwrap();
    let [a, b, c] = PARTS.map(|of| KernelPart {
        centre_m: of.centre_m,
        orientation: of.orientation,
        half_m: of.half_m,
        radius_m: of.radius_m,
    });
    own.touching(store.room()).choose_tools(&network, &[&[a], &[b, c]], 0.3).unwrap();
    let (mut pressed, mut told_ticks) = (0, 0);
    for at in 0..115 {
        if at == 60 {
            let mut samples = 0;
            assert_eq!(call!(chaincell_grip(made.tissue, 1, &mut samples)), Code::Ok);
            assert_eq!(samples, own.touching(store.room()).grip(&network, 1));
            assert!(samples > 3, "{samples}");
        }
        if at == 85 {
            assert_eq!(call!(chaincell_let_go(made.tissue, 1, 10)), Code::Ok);
            own.touching(store.room()).let_go(1, 10);
        }
        let (mut poses, mut outputs) = (poses(at), [NO_OUTPUT; 2]);
        if at % 30 == 29 || at >= 100 {
            poses[1].orientation = [0.0; 4];
        }
        let to = outputs.as_mut_ptr();
        assert_eq!(call!(chaincell_tick(made.tissue, poses.as_ptr(), 2, null(), to)), Code::Ok);
        let there = own.touching(store.room()).tick(
            &network,
            &poses.map(|pose| of_kernel(&pose)),
            chaincell_kernel::Budget::All,
        );
        let is_safe = outputs.map(|of| of.tool.flags & Flags::SAFE_STATE.0 != 0);
        assert_eq!(is_safe, [at >= 110; 2], "tick {at}");
        let first = outputs[0].tool;
        assert_eq!((first.force_n, first.contacts), (there.force_n.into(), there.contacts));
        for (tool, output) in outputs.iter().enumerate() {
            if is_safe[tool] {
                assert_eq!(*output, Output::of(&there));
                continue;
            }
            let body = own.touching(store.room());
            let errors =
                [body.force_error_n(&network, tool), body.torque_error_n_m(&network, tool)];
            told_ticks += u32::from(errors.iter().all(|of| of.is_some_and(|error| error > 0.0)));
            let felt = own.touching(store.room()).tool_output(&network, tool);
            assert_eq!(*output, of_tool(&there, &felt, errors), "tick {at}");
        }
        let mut samples = 0;
        assert_eq!(call!(chaincell_gripped(made.tissue, 1, &mut samples)), Code::Ok);
        assert_eq!(samples, own.touching(store.room()).gripped(&network, 1));
        let [first, second] = outputs.map(|of| ToolOutput { flags: 0, ..of.tool });
        pressed +=
            u32::from([first, second].iter().all(|of| of.contacts > 0 && of.force_n[2] > 0.0));
        assert!(at < 20 || (first == NOTHING) == (at >= 80), "tick {at}");
    }
    assert!(pressed > 40 && told_ticks > 40, "{pressed} {told_ticks}");
    assert_eq!(hash(made.tissue), own.touching(store.room()).state_hash(&model));
}

#[test]
fn contacts_add_up_to_what_their_tools_feel() {
    let made = placed(Scheme::Predict, &ROOM);
    assert_eq!(choose(made.tissue, 0.3), Code::Ok);
    assert_eq!(contacts(made.tissue, 0).1, 0);
    let felt = play(made.tissue, 75).map(|of| of.tool);
    let (all, count) = contacts(made.tissue, 200);
    assert!(all.len() == count && count > 3, "{count}");
    for (tool, felt) in felt.iter().enumerate() {
        let own = || all.iter().filter(|of| of.tool as usize == tool);
        assert_eq!(own().count(), felt.contacts as usize);
        for axis in 0..3 {
            let sum: f32 = own().map(|of| of.normal_n[axis] + of.tangential_n[axis]).sum();
            assert!((sum - felt.force_n[axis]).abs() < 1e-4 * felt.force_n[2], "{sum} {felt:?}");
        }
        let across: f32 = own().map(|of| of.tangential_n[0].abs()).sum();
        assert!(across > 0.1 * felt.force_n[2], "{across}");
        // The top is at 30 mm; a part's radius at most above and a tool's depth below.
        for of in own() {
            assert!((0.02..0.035).contains(&of.position_m[2]), "{of:?}");
            assert!(of.area_m2 > 0.0 && of.area_m2 < 1.0e-4 && of.cell < 144 && of.part < 2);
        }
    }
    assert!(all.iter().any(|of| of.part == 1 && of.tool == 1));
    // Less room: the first ones, and how many there are.
    let (some, whole) = contacts(made.tissue, 3);
    assert_eq!((some.as_slice(), whole), (&all[..3], count));
    let mut only = 0;
    assert_eq!(call!(chaincell_contact_forces(made.tissue, null_mut(), 0, &mut only)), Code::Ok);
    assert_eq!(only, count);
}

#[test]
fn a_late_tick_and_one_that_ends_early_take_poses() {
    let made = placed(Scheme::Track, &ROOM);
    assert_eq!(choose(made.tissue, 0.0), Code::Ok);
    let before = play(made.tissue, 40);
    let (mut poses, mut outputs) = (poses(40), [NO_OUTPUT; 2]);
    let mut tick = |poses: &[ToolPose; 2], budget: &Budget| {
        let there = outputs.as_mut_ptr();
        let code = call!(chaincell_tick(made.tissue, poses.as_ptr(), 2, budget, there));
        assert_eq!(code, Code::Ok);
        outputs
    };
    let all = Budget { sweeps: 4, more: None, context: null_mut(), force_error_share: 0.0 };
    let late = Budget { sweeps: 0, ..all };
    for (output, before) in tick(&poses, &late).iter().zip(&before) {
        let tool = ToolOutput { flags: before.tool.flags, ..output.tool };
        assert_eq!((output.sweeps, output.work_j, tool), (0, 0.0, before.tool));
        assert_ne!(output.tool.flags & Flags::LATE.0, 0);
    }
    extern "C" fn one(_: u32, context: *mut core::ffi::c_void) -> i32 {
        i32::from(!context.is_null())
    }
    let budget = Budget { more: Some(one), ..all };
    assert_eq!(tick(&poses, &budget).map(|of| of.sweeps), [1; 2]);
    assert_eq!(tick(&poses, &all).map(|of| of.sweeps), [4; 2]);
    // One that lets go in a late tick feels nothing from then on.
    poses[1].engaged = 0;
    let [first, second] = tick(&poses, &late).map(|of| of.tool);
    assert!(first.force_n[2] > 0.0 && second.force_n == [0.0; 3] && second.torque_n_m == [0.0; 3]);
}

/// A tick that ends by its error ends where the kernel's own does.
#[test]
fn a_tick_ends_at_its_share_of_the_force() {
    let sweeps = [0.0, 1.0e-6, 0.05, f32::NAN].map(|force_error_share| {
        let made = placed(Scheme::Predict, &ROOM);
        assert_eq!(choose(made.tissue, 0.0), Code::Ok);
        let budget = Budget { sweeps: 4, more: None, context: null_mut(), force_error_share };
        let mut outputs = [NO_OUTPUT; 2];
        let mut all = [0; 60];
        for (at, sweeps) in (0..).zip(all.iter_mut()) {
            let (poses, there) = (poses(at), outputs.as_mut_ptr());
            let code =
                call!(chaincell_tick(made.tissue, poses.as_ptr(), 2, &raw const budget, there));
            assert_eq!(code, Code::Ok);
            *sweeps = outputs[0].sweeps;
        }
        all
    });
    // No share, or one that is never reached or no number, leaves all sweeps.
    assert!([0, 1, 3].iter().all(|&of| sweeps[of] == [4; 60]), "{sweeps:?}");
    assert!(sweeps[2].contains(&4) && sweeps[2].iter().any(|made| *made < 4), "{sweeps:?}");
}

/// Held cells are the first tool's, whatever poses there are besides.
#[test]
fn cells_that_are_held_are_the_first_tools() {
    let [one, two] = [placed(Scheme::Track, &ROOM), placed(Scheme::Track, &ROOM)];
    for tissue in [one.tissue, two.tissue] {
        assert_eq!(super::choose(tissue, &[41, 89]).0, Code::Ok);
    }
    for at in 0..60 {
        let wanted = super::tick(one.tissue, super::sample(at));
        let (poses, mut outputs) = ([super::sample(at); 2], [NO_OUTPUT; 2]);
        let there = outputs.as_mut_ptr();
        assert_eq!(call!(chaincell_tick(two.tissue, poses.as_ptr(), 2, null(), there)), Code::Ok);
        assert_eq!(outputs[0], wanted);
        assert_eq!((outputs[1].tool.force_n, outputs[1].tool.contacts), ([0.0; 3], 0));
    }
}

/// What a choice of tools came to.
fn chosen(
    tissue: *mut Tissue,
    (parts, counts): (&[ToolPart], &[u32]),
    friction: f32,
) -> (Code, [usize; 3], f32) {
    let (parts, tools, mut detail) = (parts.as_ptr(), counts.len(), Detail::default());
    let counts = counts.as_ptr();
    let code = call!(chaincell_choose_tools(tissue, parts, counts, tools, friction, &mut detail));
    (code, [detail.position as usize, detail.needed, detail.available], detail.limit)
}

#[test]
fn tools_that_cannot_be_are_refused_and_the_old_ones_stay() {
    let made = placed(Scheme::Track, &ROOM);
    assert_eq!(choose(made.tissue, 0.3), Code::Ok);
    let why = |parts: &[ToolPart], counts: &[u32], friction| {
        chosen(made.tissue, (parts, counts), friction)
    };
    assert_eq!(why(&[], &[], 0.0), (Code::ContactTools, [0, 0, 2], 0.0));
    assert_eq!(why(&PARTS, &[1, 1, 1], 0.0), (Code::ContactTools, [0, 3, 2], 0.0));
    assert_eq!(why(&PARTS, &[1, 0], 0.0), (Code::ContactParts, [1, 0, 8], 0.0));
    assert_eq!(why(&PARTS, &[9], 0.0), (Code::ContactParts, [0, 9, 8], 0.0));
    assert_eq!(
        why(&PARTS, &[1, u32::MAX], 0.0),
        (Code::ContactParts, [1, u32::MAX as usize, 8], 0.0)
    );
    for bad in [
        ToolPart { radius_m: 0.0, ..BALL },
        ToolPart { radius_m: f32::NAN, ..BALL },
        ToolPart { half_m: [0.0, -0.001, 0.0], ..BALL },
        ToolPart { orientation: [0.0; 4], ..BALL },
        ToolPart { centre_m: [f32::INFINITY, 0.0, 0.0], ..BALL },
    ] {
        assert_eq!(why(&[BALL, BALL, bad], &[1, 2], 0.0), (Code::ContactPart, [2, 0, 0], 0.0));
    }
    for friction in [-0.1, 10.1, f32::NAN, f32::INFINITY] {
        assert_eq!(why(&PARTS, &COUNTS, friction), (Code::ContactFriction, [0; 3], 10.0));
    }
    let tiny = ToolPart { radius_m: 1.0e-5, ..BALL };
    let (code, _, limit) = why(&[tiny], &[1], 0.0);
    assert!(code == Code::ContactRadiusMin && limit > 1.0e-4);
    // Nothing was chosen by any of them.
    let other = placed(Scheme::Track, &ROOM);
    assert_eq!(choose(other.tissue, 0.3), Code::Ok);
    for at in 0..60 {
        assert_eq!(tick(made.tissue, at), tick(other.tissue, at));
    }
    assert_eq!(choose(made.tissue, 0.3), Code::ContactEngaged);
}

#[test]
fn what_there_is_no_room_for_is_refused() {
    let sphere = (&[BALL][..], &[1][..]);
    let made = placed(Scheme::Track, &Room { samples: 0, ..ROOM });
    assert_eq!(chosen(made.tissue, sphere, 0.3).0, Code::ContactSamples);
    assert_eq!(chosen(made.tissue, sphere, 0.0).0, Code::Ok);
    assert_eq!(call!(chaincell_grip(made.tissue, 0, null_mut())), Code::ContactSamples);
    let without = placed(Scheme::Track, &Room { contacts: 2, ..Room::default() });
    assert_eq!(chosen(without.tissue, sphere, 0.0), (Code::ContactRoom, [0, 144, 0], 0.0));
    let links = make(BOX, Scheme::Track, 1);
    assert_eq!(chosen(links.tissue, sphere, 0.0).0, Code::ContactNoSurface);
    for tissue in [without.tissue, links.tissue] {
        let (poses, mut outputs, mut count) = (poses(0), [NO_OUTPUT; 2], 0);
        let there = outputs.as_mut_ptr();
        let code = call!(chaincell_tick(tissue, poses.as_ptr(), 2, null(), there));
        assert_eq!(
            (code, outputs.map(|of| of.tool.flags)),
            (Code::Range, [Flags::SAFE_STATE.0; 2])
        );
        let code = call!(chaincell_contact_forces(tissue, null_mut(), 0, &mut count));
        assert_eq!(code, Code::ContactRoom);
        assert_eq!(call!(chaincell_grip(tissue, 0, &mut count)), Code::ContactRoom);
        assert_eq!(call!(chaincell_gripped(tissue, 0, &mut count)), Code::ContactRoom);
        let code = call!(chaincell_opening_torque(tissue, 0, &mut 0.0));
        assert_eq!(code, Code::ContactRoom);
        assert_eq!(call!(chaincell_let_go(tissue, 0, 1)), Code::ContactRoom);
    }
}

#[test]
fn numbers_out_of_their_range_are_refused() {
    let made = placed(Scheme::Track, &ROOM);
    assert_eq!(chosen(made.tissue, (&[BALL], &[1]), 0.3).0, Code::Ok);
    let (poses, mut outputs, mut count) = (poses(0), [NO_OUTPUT; 9], 0);
    // No more are written than there can be tools.
    for (wrong, written) in [(0, 0), (3, 3), (9, 8), (usize::MAX, 8)] {
        outputs.fill(NO_OUTPUT);
        let there = outputs.as_mut_ptr();
        let code = call!(chaincell_tick(made.tissue, poses.as_ptr(), wrong, null(), there));
        assert_eq!(code, Code::Range);
        assert!(outputs[..written].iter().all(|of| of.tool.flags == Flags::SAFE_STATE.0));
        assert!(outputs[written..].iter().all(|of| of.tool.flags == 99));
    }
    for wrong in [2, u32::MAX] {
        assert_eq!(call!(chaincell_grip(made.tissue, wrong, &mut count)), Code::Range);
        assert_eq!(call!(chaincell_gripped(made.tissue, wrong, &mut count)), Code::Range);
        let code = call!(chaincell_opening_torque(made.tissue, wrong, &mut 0.0));
        assert_eq!(code, Code::Range);
        assert_eq!(call!(chaincell_let_go(made.tissue, wrong, 1)), Code::Range);
    }
    assert_eq!(call!(chaincell_let_go(made.tissue, 0, 65_536)), Code::Range);
    assert_eq!(call!(chaincell_let_go(made.tissue, 0, 65_535)), Code::Ok);
    // There is room for a second tool, and none was chosen: it feels and grips nothing.
    assert_eq!(tick(made.tissue, 0)[1].tool, NOTHING);
    assert_eq!((call!(chaincell_grip(made.tissue, 1, &mut count)), count), (Code::Ok, 0));
}

#[test]
fn every_pointer_of_tools_is_checked() {
    let made = placed(Scheme::Track, &ROOM);
    assert_eq!(choose(made.tissue, 0.3), Code::Ok);
    let before = hash(made.tissue);
    let (poses, count, mut outputs) = (poses(0), 0_usize, [NO_OUTPUT; 2]);
    let (output, contact) = (outputs.as_mut_ptr(), [0_u64; 8]);
    for (skip, code) in [(0, Code::Null), (1, Code::Misaligned)] {
        fn bad<T>(good: *const T, skip: usize) -> *mut T {
            if skip == 0 { null_mut() } else { good.cast_mut().wrapping_byte_add(1) }
        }
        let tissue = bad(made.tissue, skip);
        let (parts, counts) = (PARTS.as_ptr(), COUNTS.as_ptr());
        let got = [
            call!(chaincell_choose_tools(tissue, parts, counts, 2, 0.0, null_mut())),
            call!(chaincell_choose_tools(
                made.tissue,
                bad(parts, skip),
                counts,
                2,
                0.0,
                null_mut()
            )),
            call!(chaincell_choose_tools(
                made.tissue,
                parts,
                bad(counts, skip),
                2,
                0.0,
                null_mut()
            )),
            call!(chaincell_tick(tissue, poses.as_ptr(), 2, null(), output)),
            call!(chaincell_tick(made.tissue, bad(poses.as_ptr(), skip), 2, null(), output)),
            call!(chaincell_tick(made.tissue, poses.as_ptr(), 2, null(), bad(output, skip))),
            call!(chaincell_contact_forces(
                made.tissue,
                bad(contact.as_ptr(), skip).cast(),
                1,
                (&raw const count).cast_mut()
            )),
            call!(chaincell_contact_forces(made.tissue, null_mut(), 0, bad(&count, skip))),
            call!(chaincell_grip(tissue, 0, null_mut())),
            call!(chaincell_gripped(made.tissue, 0, bad(&count, skip))),
            call!(chaincell_opening_torque(made.tissue, 0, bad(&count, skip).cast())),
            call!(chaincell_let_go(tissue, 0, 1)),
        ];
        assert_eq!(got, [code; 12]);
    }
    let misaligned = (&raw const count).cast_mut().wrapping_byte_add(1);
    assert_eq!(call!(chaincell_grip(made.tissue, 0, misaligned)), Code::Misaligned);
    let (model, room) = (super::model_of(SURFACE), ROOM);
    let sizes =
        |room: *const Room| call!(chaincell_model_size(&model, 0, room, null_mut(), null_mut()));
    assert_eq!(sizes(null()), Code::Null);
    assert_eq!(sizes((&raw const room).wrapping_byte_add(1)), Code::Misaligned);
    assert_eq!(sizes(&room), Code::Ok);
    assert_eq!(hash(made.tissue), before);
}

/// A reset body has no tools, and a released one no contacts.
#[test]
fn released_tools_touch_nothing() {
    let made = placed(Scheme::Track, &ROOM);
    assert_eq!(choose(made.tissue, 0.3), Code::Ok);
    play(made.tissue, 60);
    assert!(contacts(made.tissue, 100).1 > 0);
    let (mut away, mut outputs) = (poses(60), [NO_OUTPUT; 2]);
    for pose in &mut away {
        pose.engaged = 0;
    }
    let there = outputs.as_mut_ptr();
    assert_eq!(call!(chaincell_tick(made.tissue, away.as_ptr(), 2, null(), there)), Code::Ok);
    assert_eq!(outputs.map(|of| ToolOutput { flags: 0, ..of.tool }), [NOTHING; 2]);
    assert_eq!(contacts(made.tissue, 100).1, 0);
    assert_eq!(call!(chaincell_tissue_reset(made.tissue, null_mut())), Code::Ok);
    assert_eq!(tick(made.tissue, 55)[0].tool.contacts, 0);
}
