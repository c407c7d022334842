//! Storage of a tissue with room for tools on its surface.

use chaincell_kernel::{CoarseTouch, EDGE_BYTES, TouchStore, include_model};

use super::{
    BLOCK, BOX, Block, Made, call, hash, holding, init, model_of, settings_of, size_of_body,
    storage,
};
use crate::{Code, Room, SHAPE_ALIGN, Scheme, Settings, TOOL_BYTES, TOUCH_BYTES};

/// `chaincell bake box:6x6x4x0.01 --young-pa 5000 --poisson 0.4 --coarse 2.5 --contact-surface yes`.
pub(super) static SURFACE: &[u8] = include_model!("../../../../tests/data/touch6.chaincell");

/// What the tests of tools have room for.
pub(super) const ROOM: Room =
    Room { contacts: 2, tools: 2, triangles: 256, samples: 300, cuts: 0, pins: 0 };

/// Bytes of a tool.
const TOOL: usize = TOOL_BYTES + EDGE_BYTES;

/// Settings whose step limit is that of these tests.
pub(super) fn settings() -> Settings {
    Settings { max_tool_step_m: 0.01, ..settings_of(&model_of(SURFACE), Scheme::Track) }
}

/// A body with a surface at rest.
pub(super) fn placed(scheme: Scheme, room: &Room) -> Made {
    let (code, bytes, _) = size_of_body(SURFACE, scheme as i32, room);
    assert_eq!(code, Code::Ok);
    let mut storage = storage(bytes);
    let there = (storage.as_mut_ptr(), bytes);
    let (code, _, tissue) = init(there, SURFACE, (scheme as i32, room), &settings());
    assert_eq!(code, Code::Ok);
    Made { storage, tissue }
}

/// The header's macro goes by these numbers.
#[test]
fn every_count_takes_its_bytes() {
    let of = |room: Room| size_of_body(SURFACE, Scheme::Track as i32, &room).1;
    let plain = of(holding(2));
    let one = Room { contacts: 2, tools: 1, triangles: 4, samples: 4, cuts: 0, pins: 0 };
    let fixed = of(one) - plain - 144 * 24 - TOOL - 4 * (28 + 104);
    assert!(fixed <= TOUCH_BYTES && TOUCH_BYTES - fixed < 512, "{fixed}");
    // Sizes are rounded to multiples of 16.
    let seven = of(Room { tools: 8, ..one }) - of(one);
    assert!(seven.abs_diff(7 * TOOL) < 16, "{seven}");
    assert_eq!(of(Room { triangles: 1028, ..one }) - of(one), 1024 * 28);
    assert_eq!(of(Room { samples: 1028, ..one }) - of(one), 1024 * 104);
    // The kernel's own, less its roundings.
    type Store = TouchStore<144, 256, 300, 2>;
    let here = of(ROOM) - plain;
    assert!(here.abs_diff(Store::RAM_BYTES) < 256, "{here} {}", Store::RAM_BYTES);
}

#[test]
fn room_that_cannot_be_is_refused() {
    let room = |tools, triangles, samples| Room {
        contacts: 2,
        tools,
        triangles,
        samples,
        cuts: 0,
        pins: 0,
    };
    let mut storage = std::vec![Block([0; BLOCK]); 4096];
    let mut code = |scheme: Scheme, room: Room| {
        let there = (storage.as_mut_ptr(), 4096 * 64);
        let (code, detail, tissue) = init(there, SURFACE, (scheme as i32, &room), &settings());
        assert_eq!(size_of_body(SURFACE, scheme as i32, &room).0, code);
        assert_eq!(tissue.is_null(), code != Code::Ok);
        (code, detail.needed, detail.available)
    };
    let track = Scheme::Track;
    assert_eq!(code(track, room(9, 8, 0)), (Code::Range, 9, 8));
    assert_eq!(code(track, room(u32::MAX, 8, 0)), (Code::Range, u32::MAX as usize, 8));
    assert_eq!(code(track, room(0, 8, 0)), (Code::Range, 0, 8));
    assert_eq!(code(track, room(1, 0, 0)), (Code::Range, 0, 65_535));
    assert_eq!(code(track, room(1, 65_536, 0)), (Code::Range, 65_536, 65_535));
    assert_eq!(code(track, room(1, 8, 32_768)), (Code::Range, 32_768, 32_767));
    assert_eq!(code(track, Room { contacts: 145, ..ROOM }), (Code::Range, 145, 144));
    assert_eq!(code(track, room(1, 8, 0)), (Code::Ok, 0, 0));
    for scheme in [Scheme::TrackFixed, Scheme::Euler] {
        assert_eq!(code(scheme, room(1, 8, 0)).0, Code::ContactScheme);
    }
    let (code, ..) = size_of_body(SURFACE, 8, &ROOM);
    assert_eq!(code, Code::Scheme);
}

#[test]
fn storage_with_room_for_tools_has_its_alignment() {
    // Links need no more than 16; with this room they do.
    assert_eq!(size_of_body(BOX, 0, &ROOM).2, SHAPE_ALIGN);
    assert_eq!(size_of_body(BOX, 0, &Room::default()).2, crate::ALIGN);
    let mut storage = std::vec![Block([0xA5; BLOCK]); 4096];
    let beyond = storage.as_mut_ptr().wrapping_byte_add(16);
    let there = (beyond, 4095 * 64);
    let (code, _, tissue) = init(there, SURFACE, (0, &ROOM), &settings());
    assert_eq!((code, tissue.is_null()), (Code::Misaligned, true));
}

/// Zeros stand for it: one is too large for a firmware's stack.
#[test]
fn a_coarse_level_under_no_tool_is_zeros() {
    // SAFETY: it has no padding: an address-sized number and a multiple of eight bytes behind it.
    let bytes: [u8; size_of::<CoarseTouch>()] = unsafe { core::mem::transmute(CoarseTouch::NONE) };
    assert!(bytes.iter().all(|&byte| byte == 0));
}

/// A tissue without tools: room beside it changes no bit.
#[test]
fn a_body_without_tools_is_the_body_of_before() {
    let without = placed(Scheme::Track, &holding(2));
    let with = placed(Scheme::Track, &ROOM);
    let ids = [41_u32, 89];
    for tissue in [without.tissue, with.tissue] {
        assert_eq!(super::choose(tissue, &ids).0, Code::Ok);
    }
    for at in 0..60 {
        let outputs = [&with, &without].map(|of| super::tick(of.tissue, super::sample(at)));
        assert_eq!(outputs[0], outputs[1]);
    }
    assert_eq!(hash(with.tissue), hash(without.tissue));
}

/// Nothing in a tissue points into it, its tools neither.
#[test]
fn a_copied_body_goes_on_with_its_tools() {
    let made = placed(Scheme::Predict, &ROOM);
    assert_eq!(super::tools::choose(made.tissue, 0.3), Code::Ok);
    super::tools::play(made.tissue, 40);
    let mut samples = 0;
    assert_eq!(call!(chaincell_grip(made.tissue, 1, &mut samples)), Code::Ok);
    assert!(samples > 0);
    let mut other = made.storage.clone();
    let copy = other.as_mut_ptr().cast();
    for at in 40..90 {
        assert_eq!(super::tools::tick(copy, at), super::tools::tick(made.tissue, at));
    }
    assert_eq!(hash(copy), hash(made.tissue));
}
