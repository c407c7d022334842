//! Bodies that are cut: what is refused, the state of the cuts, a snapshot.

use chaincell_kernel::{CutOutput, EDGE_BYTES, Scissors, cut_words, include_model};

use super::{
    Made, call, hash, info_of, init, model_of, pose_at, settings_of, size_of_body, storage,
};
use crate::{CUT_TOOL_BYTES, Code, Cuts, Detail, Face, Room, Scheme, ToolPart, ToolPose, Triangle};
use std::vec::Vec;

/// `chaincell bake box:5x5x4x0.01 --young-pa 5000 --poisson 0.4 --coarse 2.5 --contact-surface yes --cuttable
/// --cut-spare 0.3 --toughness-j-per-m2 10`.
static BLADE: &[u8] = include_model!("../../../../tests/data/blade5.chaincell");

const ROOM: Room = Room { contacts: 0, tools: 1, triangles: 64, samples: 0, cuts: 1, pins: 0 };

/// A body at rest.
fn placed(room: &Room) -> Made {
    let (code, bytes, _) = size_of_body(BLADE, Scheme::Track as i32, room);
    assert_eq!(code, Code::Ok);
    let mut storage = storage(bytes);
    let there = (storage.as_mut_ptr(), bytes);
    let settings = settings_of(&model_of(BLADE), Scheme::Track);
    let (code, _, tissue) = init(there, BLADE, (Scheme::Track as i32, room), &settings);
    assert_eq!(code, Code::Ok);
    Made { storage, tissue }
}

/// Gives it a blade.
fn choose(made: &Made) -> Code {
    let edge = ToolPart {
        centre_m: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        half_m: [0.016, 0.0, 0.0],
        radius_m: 0.0,
    };
    let none = core::ptr::null_mut();
    call!(chaincell_choose_tools(made.tissue, &edge, &1, 1, 0.0, none))
}

/// Opens faces; what came of it, and the cuts.
fn cut(made: &Made, faces: &[Face]) -> (Code, u32, Cuts) {
    let (mut cuts, mut detail) = (Cuts::default(), Detail::default());
    let list = (faces.as_ptr(), faces.len());
    let code = call!(chaincell_cut(made.tissue, list.0, list.1, &mut cuts, &mut detail));
    (code, detail.position, cuts)
}

/// The blade goes down from one tick to another.
fn draw(made: &Made, ticks: core::ops::Range<u16>) {
    for tick in ticks {
        let height_m = 0.0305 - 0.0001 * f32::from(tick);
        super::tick(made.tissue, pose_at([0.001, -0.001, height_m], 1));
    }
}

#[test]
fn the_size_is_that_of_the_models_words() {
    let bytes = |cuts| size_of_body(BLADE, 0, &Room { cuts, ..ROOM }).1;
    let kernel = chaincell_kernel::Model::from_bytes(BLADE).unwrap();
    let words = info_of(&model_of(BLADE)).cut_words as usize;
    assert!(words > 1000 && words == cut_words(&kernel), "{words}");
    assert_eq!(bytes(1) - bytes(0), 4 * words);
    assert_eq!(info_of(&model_of(super::SHAPES)).cut_words, 0);
    assert!((0..64).contains(&(CUT_TOOL_BYTES - EDGE_BYTES)), "{EDGE_BYTES}");
}

#[test]
fn memory_and_faces_that_cannot_be_are_refused() {
    let size = |image, cuts| size_of_body(image, 0, &Room { cuts, ..ROOM }).0;
    assert_eq!(size(super::SHAPES, 1), Code::CutModel);
    assert_eq!(size(BLADE, 2), Code::Range);
    let whole = placed(&Room { cuts: 0, ..ROOM });
    assert_eq!((choose(&whole), cut(&whole, &[]).0), (Code::CutRoom, Code::CutRoom));
    let made = placed(&ROOM);
    assert_eq!(choose(&made), Code::Ok);
    let face = |tetrahedron, corner| Face { tetrahedron, corner };
    assert_eq!(cut(&made, &[]), (Code::Ok, 0, Cuts::default()));
    for bad in [face(240, 0), face(0, 4), face(u32::MAX, u32::MAX)] {
        assert_eq!(cut(&made, &[bad]), (Code::CutFace, 0, Cuts::default()));
    }
    // The one before it is open.
    assert_eq!(cut(&made, &[face(0, 0), face(240, 0)]).1, 1);
    let (code, _, cuts) = cut(&made, &[face(0, 0)]);
    assert_eq!((code, cuts.opened_faces), (Code::Ok, 1));
    let none = core::ptr::null_mut();
    assert_eq!(call!(chaincell_tissue_reset(made.tissue, none)), Code::Ok);
    assert_eq!(cut(&made, &[]).2, Cuts::default());
}

/// A copy of the storage, and a snapshot, go on with the same cuts.
#[test]
fn a_cut_body_is_copied_and_saved() {
    let made = placed(&ROOM);
    assert_eq!(choose(&made), Code::Ok);
    draw(&made, 0..120);
    let (_, _, before) = cut(&made, &[]);
    assert!(before.opened_faces > 4 && before.copies > 1, "{before:?}");
    let mut copy = made.storage.clone();
    let copy = Made { tissue: copy.as_mut_ptr().cast(), storage: copy };
    let mut bytes = std::vec![0; 1 << 20];
    let (mut written, none) = (0, core::ptr::null_mut());
    let saved = call!(chaincell_tissue_save(
        made.tissue,
        bytes.as_mut_ptr(),
        bytes.len(),
        &mut written,
        none
    ));
    assert_eq!(saved, Code::Ok);
    let other = placed(&ROOM);
    assert_eq!(choose(&other), Code::Ok);
    let restored = call!(chaincell_tissue_restore(other.tissue, bytes.as_ptr(), written, none));
    assert_eq!(restored, Code::Ok);
    for made in [&made, &copy, &other] {
        draw(made, 120..160);
    }
    let (_, _, after) = cut(&made, &[]);
    assert!(after.copies > before.copies && after.area_m2 > before.area_m2, "{after:?}");
    for made_of in [&copy, &other] {
        assert_eq!((hash(made_of.tissue), cut(made_of, &[]).2), (hash(made.tissue), after));
    }
}

/// Torque on the handles \[N m\].
fn torque_n_m(made: &Made) -> f32 {
    let mut torque_n_m = f32::NAN;
    assert_eq!(call!(chaincell_opening_torque(made.tissue, 0, &mut torque_n_m)), Code::Ok);
    torque_n_m
}

/// Scissors above the body cut down as the openings of their poses close them.
#[test]
fn scissors_cut_and_have_a_torque() {
    let made = placed(&ROOM);
    assert_eq!(choose(&made), Code::Ok);
    assert_eq!(torque_n_m(&made), 0.0);
    let blades = Scissors { length_m: 0.04, offset_m: 0.004 };
    let scissors = ToolPart {
        centre_m: [0.0; 3],
        orientation: [0.0, 0.0, 0.0, 1.0],
        half_m: [0.025, 0.0, blades.length_m],
        radius_m: -blades.offset_m,
    };
    let none = core::ptr::null_mut();
    let code = call!(chaincell_choose_tools(made.tissue, &scissors, &1, 1, 0.0, none));
    assert_eq!(code, Code::Ok);
    let pose = pose_at([0.001, -0.001, 0.0455], 1);
    let mut last = 0.0;
    for tick in 0..120_u16 {
        let crossing_m = 0.015 + 0.0001 * f32::from(tick);
        let half_rad = (blades.offset_m / crossing_m).asin();
        let opening_turns_q16 = (half_rad / core::f32::consts::PI * 65536.0).round() as u16;
        let output = super::tick(made.tissue, ToolPose { opening_turns_q16, ..pose });
        let forward_n = -output.tool.force_n[2];
        last = torque_n_m(&made);
        let wanted = blades.opening_torque_n_m(forward_n, 2.0 * half_rad);
        assert!((last - wanted).abs() <= 3e-3 * wanted.abs(), "{tick}: {last} {wanted}");
    }
    let (_, _, cuts) = cut(&made, &[]);
    assert!(last > 1e-3 && cuts.opened_faces > 4 && cuts.copies > 1, "{last} {cuts:?}");
}

/// Every number of the kernel stands in its field.
#[test]
fn the_state_of_the_cuts_is_the_kernels() {
    let [opened_faces, copies, waiting, refused, untouched, torn] = [1, 2, 3, 4, 5, 6];
    let [area_m2, work_j] = [0.5, 0.25];
    let counted =
        CutOutput { opened_faces, copies, waiting, refused, untouched, torn, area_m2, work_j };
    let given = Cuts { opened_faces, copies, waiting, refused, untouched, torn, area_m2, work_j };
    assert_eq!(Cuts::from(counted), given);
}

/// The triangles of the surface, and how many there are.
fn triangles(made: &Made, room: usize) -> (Vec<Triangle>, usize) {
    let (mut list, mut count) = (std::vec![Triangle::default(); room], 0);
    let code = call!(chaincell_triangles(made.tissue, list.as_mut_ptr(), room, &mut count));
    assert_eq!(code, Code::Ok);
    list.truncate(count);
    (list, count)
}

/// The surface stays closed while a blade opens it: each edge of two triangles runs once in each direction.
#[test]
fn the_surface_of_a_cut_body_is_closed() {
    let kernel = chaincell_kernel::Model::from_bytes(BLADE).unwrap();
    let made = placed(&ROOM);
    assert_eq!(choose(&made), Code::Ok);
    let whole = kernel.triangles().iter().map(|cells| {
        let cells = cells.map(u32::from);
        Triangle { cells, origins: cells }
    });
    let whole: Vec<_> = whole.collect();
    assert_eq!(triangles(&made, 400), (whole.clone(), whole.len()));
    draw(&made, 0..160);
    let (_, _, cuts) = cut(&made, &[]);
    let (now, count) = triangles(&made, 400);
    assert!(count > whole.len() && cuts.copies > 2, "{count} {cuts:?}");
    // A list that is too short says how long it has to be.
    assert_eq!(triangles(&made, 3), (now[..3].to_vec(), count));
    assert_eq!(triangles(&made, 0), (Vec::new(), count));
    // The model's triangles are where they were, some at a copy.
    let origins = |of: &Triangle| of.origins;
    assert_eq!(
        now[..whole.len()].iter().map(origins).collect::<Vec<_>>(),
        whole.iter().map(origins).collect::<Vec<_>>()
    );
    let copies = kernel.body_cells() as u32..kernel.body_cells() as u32 + cuts.copies;
    let is_copy = |cell: &u32| copies.contains(cell);
    assert!(now[..whole.len()].iter().any(|of| of.cells.iter().any(is_copy)));
    for of in &now {
        for (cell, origin) in of.cells.iter().zip(of.origins) {
            assert!(*cell == origin || is_copy(cell) && !is_copy(&origin), "{of:?}");
        }
    }
    let mut edges = std::collections::BTreeMap::new();
    for [a, b, c] in now.iter().map(|of| of.cells) {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from, to)).or_insert(0) += 1;
        }
    }
    let is_paired = |&(from, to): &(u32, u32)| edges.get(&(to, from)) == edges.get(&(from, to));
    assert!(edges.keys().all(is_paired), "{edges:?}");
    // At rest again it is that of the model.
    let none = core::ptr::null_mut();
    assert_eq!(call!(chaincell_tissue_reset(made.tissue, none)), Code::Ok);
    assert_eq!(triangles(&made, 400).0, whole);
}
