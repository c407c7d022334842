//! Snapshots through the interface: every scheme goes on, and every refusal.

use core::ptr::{null, null_mut};
use std::vec::Vec;

use super::{BOX, KINDS, Made, PLANE, call, choose, hash, make, sample, schemes_of, tick};
use crate::{Code, Detail, Scheme, StageStorage, Tissue};

fn size(tissue: *mut Tissue) -> usize {
    let (mut bytes, none) = (0, null_mut());
    assert_eq!(call!(chaincell_tissue_save(tissue, none, 0, &mut bytes, null_mut())), Code::Ok);
    bytes
}

fn save(tissue: *mut Tissue) -> Vec<u8> {
    let mut bytes = std::vec![0; size(tissue)];
    let mut written = 0;
    let (to, length) = (bytes.as_mut_ptr(), bytes.len());
    let code = call!(chaincell_tissue_save(tissue, to, length, &mut written, null_mut()));
    assert_eq!((code, written), (Code::Ok, length));
    bytes
}

fn restore(tissue: *mut Tissue, bytes: &[u8]) -> (Code, Detail) {
    let mut detail = Detail::default();
    let (from, length) = (bytes.as_ptr(), bytes.len());
    (call!(chaincell_tissue_restore(tissue, from, length, &mut detail)), detail)
}

/// Pressed for so many ticks.
fn pressed(scheme: Scheme, ticks: u16) -> Made {
    pressed_of(BOX, 64, scheme, ticks)
}

fn pressed_of(image: &'static [u8], id: u32, scheme: Scheme, ticks: u16) -> Made {
    let made = make(image, scheme, 1);
    choose(made.tissue, &[id]);
    (0..ticks).for_each(|at| {
        tick(made.tissue, sample(at));
    });
    made
}

#[test]
fn every_scheme_goes_on_to_the_same_bits() {
    let bodies = KINDS
        .into_iter()
        .flat_map(|(image, ids)| schemes_of(image).map(move |scheme| (image, ids, scheme)));
    for (image, [id, ..], scheme) in bodies {
        let (first, second) = (pressed_of(image, id, scheme, 20), make(image, scheme, 1));
        assert_eq!(restore(second.tissue, &save(first.tissue)).0, Code::Ok);
        for at in 20..300 {
            assert_eq!(tick(first.tissue, sample(at)), tick(second.tissue, sample(at)), "{at}");
            assert_eq!(hash(first.tissue), hash(second.tissue), "{at}");
        }
    }
}

// REQ-BIT-10
#[test]
fn a_snapshot_that_does_not_fit_changes_nothing() {
    let made = pressed(Scheme::Track, 20);
    let (bytes, before) = (save(made.tissue), hash(made.tissue));
    let damaged = |at: usize| {
        let mut bytes = bytes.clone();
        bytes[at] ^= 1;
        restore(made.tissue, &bytes).0
    };
    assert_eq!(damaged(0), Code::SnapshotMagic);
    assert_eq!(damaged(8), Code::SnapshotVersion);
    assert_eq!(damaged(20), Code::SnapshotLength);
    assert_eq!(damaged(12), Code::SnapshotChecksum);
    assert_eq!(damaged(bytes.len() - 1), Code::SnapshotChecksum);
    assert_eq!(restore(made.tissue, &bytes[..40]).0, Code::SnapshotLength);
    assert_eq!(restore(made.tissue, &[]).0, Code::SnapshotMagic);
    assert_eq!(restore(make(PLANE, Scheme::Track, 1).tissue, &bytes).0, Code::SnapshotModel);
    assert_eq!(restore(make(BOX, Scheme::Rkl2, 1).tissue, &bytes).0, Code::SnapshotLayout);
    let (code, detail) = restore(make(BOX, Scheme::Track, 0).tissue, &bytes);
    assert_eq!(code, Code::SnapshotRoom);
    assert!(detail.needed > detail.available, "{detail:?}");
    assert_eq!(hash(made.tissue), before);
    assert_eq!(save(made.tissue), bytes);
}

#[test]
fn a_buffer_that_is_too_short_is_told_by_how_much() {
    let made = pressed(Scheme::Track, 20);
    let needed = size(made.tissue);
    let (mut bytes, mut detail, mut written) = (std::vec![7; needed], Detail::default(), 9);
    let to = bytes.as_mut_ptr();
    let short =
        call!(chaincell_tissue_save(made.tissue, to, needed - 1, &mut written, &mut detail));
    assert_eq!((short, written), (Code::SnapshotBuffer, 9));
    assert_eq!((detail.needed, detail.available), (needed, needed - 1));
    assert!(bytes.iter().all(|&byte| byte == 7));
    let nowhere =
        call!(chaincell_tissue_save(made.tissue, null_mut(), needed, null_mut(), null_mut()));
    assert_eq!(nowhere, Code::Null);
    let none = call!(chaincell_tissue_restore(made.tissue, null(), needed, null_mut()));
    assert_eq!(none, Code::Null);
    let nobody = call!(chaincell_tissue_save(null_mut(), null_mut(), 0, null_mut(), null_mut()));
    assert_eq!(nobody, Code::Null);
}

#[test]
fn a_stage_goes_on_to_the_same_forces() {
    let settings = super::stage::settings(chaincell_kernel::stage::Device::Touch);
    let made = || {
        let (code, stage) = super::stage::make(&settings);
        assert_eq!(code, Code::Ok);
        stage
    };
    let (mut first, mut second) = (made(), made());
    (0..30).for_each(|at| {
        super::stage::pass(&mut first, sample(at));
    });
    let mut save = |to: *mut u8, bytes: usize| {
        let mut written = 0;
        (call!(chaincell_stage_save(&mut first, to, bytes, &mut written)), written)
    };
    let (asked, bytes) = save(null_mut(), 0);
    let mut saved = std::vec![0; bytes];
    assert_eq!(asked, Code::Ok);
    assert_eq!(save(saved.as_mut_ptr(), bytes - 1).0, Code::SnapshotBuffer);
    assert_eq!(save(null_mut(), bytes).0, Code::Null);
    assert_eq!(save(saved.as_mut_ptr(), bytes), (Code::Ok, bytes));
    assert_eq!(call!(chaincell_stage_restore(&mut second, saved.as_ptr(), bytes)), Code::Ok);
    for at in 30..300 {
        let both = [&mut first, &mut second].map(|of| super::stage::pass(of, sample(at)));
        assert_eq!(both[0], both[1], "{at}");
    }
    saved[bytes - 1] ^= 1;
    let damaged = call!(chaincell_stage_restore(&mut second, saved.as_ptr(), bytes));
    assert_eq!(damaged, Code::SnapshotChecksum);
    let mut nothing = StageStorage::EMPTY;
    let none = call!(chaincell_stage_save(&mut nothing, null_mut(), 0, null_mut()));
    assert_eq!(none, Code::NotInitialised);
}
