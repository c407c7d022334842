//! Sizes, storage that is too small, and arguments out of range.

use std::process::Command;
use std::string::String;
use std::vec::Vec;

use chaincell_kernel::{
    Dynamics, EDGE_BYTES, Euler, I8F24, Predict, Rkl2, Tissue, Track, coarse_room,
};

use super::tool_storage::{ROOM, SURFACE};
use super::{
    BLOCK, BOX, KINDS, PLANE, SHAPES, call, holding, info_of, init, is_nodal, make, model_of,
    schemes_of, settings_of, size_of_body, storage, try_make,
};
use crate::layout::{Sizes, by_scheme};
use crate::touch::Touch;
use crate::{ALIGN, Code, Detail, Scheme, Settings, TISSUE_BYTES, TISSUE_WORDS};

/// Bytes of a body of links.
pub(super) fn size(scheme: Scheme, cells: u32, contacts: u32, coarse_functions: u32) -> usize {
    let (cells, contacts, coarse_functions) =
        (cells as usize, contacts as usize, coarse_functions as usize);
    let room = match scheme {
        Scheme::Track | Scheme::Predict => coarse_room(coarse_functions, contacts),
        _ => 0,
    };
    let sizes = Sizes { cells, contacts, room, states: 0, touch: Touch::NONE, words: 0 };
    by_scheme!(scheme, D => sizes.bytes::<D>())
}

/// Where storage begins to be enough, and that one byte less is refused with both numbers.
// REQ-MOD-04, REQ-CIF-04
#[test]
fn the_size_is_exactly_what_a_body_needs() {
    let plain = [(BOX, 0), (BOX, 3), (BOX, 125), (PLANE, 9), (SHAPES, 0), (SHAPES, 9)];
    let plain = plain.map(|(image, contacts)| (image, holding(contacts)));
    for (image, room) in plain.into_iter().chain([(SURFACE, ROOM)]) {
        for scheme in schemes_of(image) {
            let model = model_of(image);
            let (info, settings) = (info_of(&model), settings_of(&model, scheme));
            let (_, bytes, _) = size_of_body(image, scheme as i32, &room);
            let of_links = || size(scheme, info.cells, room.contacts, info.coarse_functions);
            assert!(is_nodal(image) || bytes == of_links());
            let mut storage = storage(bytes);
            let mut init = |bytes: usize| {
                let there = (storage.as_mut_ptr(), bytes);
                let (code, detail, tissue) = init(there, image, (scheme as i32, &room), &settings);
                (code, (detail.needed, detail.available), tissue.is_null())
            };
            assert_eq!(init(bytes - 1), (Code::Storage, (bytes, bytes - 1), true));
            assert_eq!(init(0), (Code::Storage, (bytes, 0), true));
            assert_eq!(init(bytes), (Code::Ok, (0, 0), false));
        }
    }
}

/// The model of a kernel that cuts has twelve lists and a number more, of one that relaxes three lists and two numbers.
const CUT_LISTS: usize = if EDGE_BYTES > 0 { (25 + 8) * size_of::<usize>() } else { 0 };

/// The interface's own part of the memory stays within what the header's macro says.
#[test]
fn a_body_takes_what_the_kernels_own_takes_and_little_more() {
    fn check<D: Dynamics, const COARSE: usize>(scheme: Scheme) {
        let own = Tissue::<800, D, 8>::RAM_BYTES;
        let here = size(scheme, 800, 8, COARSE as u32);
        assert!(here > own && here - own < 1088 + CUT_LISTS, "{}: {own}, here {here}", D::NAME);
    }
    check::<Track<{ coarse_room(100, 8) }>, 100>(Scheme::Track);
    check::<Track, 0>(Scheme::Track);
    check::<Predict<{ coarse_room(100, 8) }>, 100>(Scheme::Predict);
    check::<Euler, 0>(Scheme::Euler);
    check::<Rkl2, 0>(Scheme::Rkl2);
    check::<Track<0, I8F24>, 0>(Scheme::TrackFixed);
    check::<Euler<I8F24>, 0>(Scheme::EulerFixed);
    let bound = TISSUE_BYTES + TISSUE_WORDS * size_of::<usize>();
    let most = Scheme::ALL.map(|scheme| size(scheme, 1, 0, 0)).into_iter().max().unwrap();
    assert!(most <= bound + 80, "{most} bytes of {bound}");
}

#[test]
fn hats_count_for_the_scheme_that_has_them() {
    assert_eq!(
        size(Scheme::Track, 500, 2, 400) - size(Scheme::Track, 500, 2, 0),
        coarse_room(400, 2) * 32
    );
    assert_eq!(size(Scheme::Euler, 500, 2, 400), size(Scheme::Euler, 500, 2, 0));
}

// REQ-CIF-04
#[test]
fn every_size_is_a_multiple_of_the_alignment() {
    for scheme in Scheme::ALL {
        assert!(size(scheme, 65_535, 65_535, 1024).is_multiple_of(ALIGN));
        assert!(size(scheme, 1, 1, 0) > 2000);
    }
}

/// `CHAINCELL_TISSUE_BYTES` is enough, and wastes little.
#[test]
fn the_headers_macros_bound_the_sizes() {
    let (folder, package) =
        (tempfile::tempdir().unwrap(), std::path::Path::new(env!("CARGO_MANIFEST_DIR")));
    let program = folder.path().join("sizes");
    let mut cc = Command::new("cc");
    cc.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-I"]);
    cc.arg(package.join("include")).arg(package.join("tests/c/sizes.c")).arg("-o").arg(&program);
    assert!(cc.status().unwrap().success());
    let said = String::from_utf8(Command::new(&program).output().unwrap().stdout).unwrap();
    assert_eq!(said.lines().count(), 40);
    for line in said.lines() {
        let numbers: Vec<u32> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        let [scheme, bound, cells, contacts, coarse] = numbers[..] else { panic!("{line}") };
        let scheme = Scheme::of(scheme as i32).unwrap();
        let (bound, size) = (bound as usize, size(scheme, cells, contacts, coarse));
        assert!((size..size + 512).contains(&bound), "{size} bytes of {line}");
    }
}

#[test]
fn schemes_and_contacts_that_do_not_fit_are_refused() {
    for scheme in [-1, 2, 4, 8, i32::MIN, i32::MAX] {
        let (code, _, made) = try_make(BOX, scheme, 1, |_| {});
        assert_eq!((code, made.tissue.is_null()), (Code::Scheme, true));
        let model = model_of(BOX);
        let mut settings = settings_of(&model, Scheme::Track);
        assert_eq!(call!(chaincell_settings_default(&model, scheme, &mut settings)), Code::Scheme);
    }
    let (code, detail, made) = try_make(BOX, 0, 126, |_| {});
    assert_eq!((code, detail.needed, detail.available), (Code::Range, 126, 125));
    assert!(made.tissue.is_null());
}

/// One storage for one body after the other, of any scheme that fits.
#[test]
fn storage_can_be_used_again() {
    let mut made = make(BOX, Scheme::Rkl2, 2);
    let settings = settings_of(&model_of(PLANE), Scheme::Euler);
    let there = (made.storage.as_mut_ptr(), made.storage.len() * BLOCK);
    let (code, _, tissue) = init(there, PLANE, (Scheme::Euler as i32, &holding(2)), &settings);
    assert_eq!(code, Code::Ok);
    assert_eq!(super::hash(tissue), super::hash(make(PLANE, Scheme::Track, 0).tissue));
}

/// A refused call leaves no body of before that could go on by mistake.
// REQ-CIF-02
#[test]
fn a_refused_call_takes_the_storage_too() {
    for (image, _) in KINDS {
        let mut made = make(image, Scheme::Track, 2);
        let settings = Settings { sweeps: 0, ..settings_of(&model_of(image), Scheme::Track) };
        let there = (made.storage.as_mut_ptr(), made.storage.len() * BLOCK);
        let (code, _, tissue) = init(there, image, (Scheme::Track as i32, &holding(2)), &settings);
        assert_eq!((code, tissue.is_null()), (Code::SettingsSweeps, true));
        let there = made.storage.as_mut_ptr().cast();
        let reset = call!(chaincell_tissue_reset(there, &mut Detail::default()));
        assert_eq!(reset, Code::NotInitialised);
    }
}
