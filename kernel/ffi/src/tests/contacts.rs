//! Contact cells by input ids.

use super::{BOX, KINDS, call, choose, hash, info_of, make, model_of, sample, schemes_of, tick};
use crate::{Code, Scheme};

/// A body that holds these ids, after a few ticks of a press.
fn pressed(image: &'static [u8], ids: &[u32], and_then: &[u32]) -> (u64, u32) {
    let made = make(image, Scheme::Track, 4);
    assert_eq!(choose(made.tissue, ids).0, Code::Ok);
    if !and_then.is_empty() {
        assert_ne!(choose(made.tissue, and_then).0, Code::Ok);
    }
    let mut contacts = 0;
    for at in 0..20 {
        contacts = tick(made.tissue, sample(at)).tool.contacts;
    }
    (hash(made.tissue), contacts)
}

#[test]
fn any_order_is_the_same_choice() {
    let [a, b] = [pressed(BOX, &[64, 69, 89, 39], &[]), pressed(BOX, &[39, 89, 64, 69], &[])];
    assert_eq!(a, b);
    assert_eq!(a.1, 4);
    assert_ne!(pressed(BOX, &[64, 69, 89], &[]).0, a.0);
}

#[test]
fn no_cell_is_a_choice_too() {
    assert_eq!(pressed(BOX, &[], &[]).1, 0);
}

#[test]
fn refused_ids_are_named_and_the_old_choice_stays() {
    for (image, [a, b, c]) in KINDS {
        let made = make(image, Scheme::Track, 4);
        let refused = |ids: &[u32]| {
            let (code, detail) = choose(made.tissue, ids);
            (code, detail.position, detail.needed, detail.available)
        };
        let cells = info_of(&model_of(image)).cells;
        // The first node of the row that is fixed, in the box and in the block of shapes.
        let (none, fixed, others) = (cells, 60, [39, 114]);
        assert_eq!(refused(&[a, b, none]), (Code::UnknownId, 2, 0, 0));
        assert_eq!(refused(&[a, u32::MAX]), (Code::UnknownId, 1, 0, 0));
        assert_eq!(refused(&[a, fixed, b]), (Code::ContactFixed, 1, 0, 0));
        assert_eq!(refused(&[a, b, c, a]), (Code::ContactRepeated, 3, 0, 0));
        assert_eq!(refused(&[b, b]), (Code::ContactRepeated, 1, 0, 0));
        let many = [a, b, c, others[0], others[1]];
        assert_eq!(refused(&many), (Code::ContactCapacity, 0, 5, 4));
        let plain = pressed(image, &[a, b], &[]);
        for ids in [&[c, none][..], &[c, fixed], &[c, c], &many] {
            assert_eq!(pressed(image, &[a, b], ids), plain);
        }
    }
}

#[test]
fn cells_change_hands_only_while_the_tool_is_released() {
    let bodies = KINDS
        .into_iter()
        .flat_map(|(image, ids)| schemes_of(image).map(move |scheme| (image, ids, scheme)));
    for (image, [a, b, _], scheme) in bodies {
        let made = make(image, scheme, 2);
        assert_eq!(choose(made.tissue, &[a]).0, Code::Ok);
        tick(made.tissue, sample(0));
        assert_eq!(choose(made.tissue, &[b]).0, Code::ContactEngaged);
        tick(made.tissue, sample(59));
        assert_eq!(choose(made.tissue, &[b, a]).0, Code::Ok);
        assert_eq!(tick(made.tissue, sample(0)).tool.contacts, 2);
    }
}

fn probe(tissue: *mut crate::Tissue, radius_m: f32) -> (Code, crate::Detail) {
    let mut detail = crate::Detail::default();
    (call!(chaincell_choose_probe(tissue, radius_m, &mut detail)), detail)
}

/// Down on the top of the box, from where the sphere touches it.
fn press(at: u16) -> crate::ToolPose {
    let down = 0.0002 * f32::from(at.min(60));
    super::pose_at([0.0, 0.0, 0.055 - down], u32::from(at < 80))
}

#[test]
fn a_probe_touches_cells_and_lets_go() {
    for scheme in Scheme::ALL {
        let made = make(BOX, scheme, 34);
        assert_eq!(probe(made.tissue, 0.015).0, Code::Ok);
        let mut most = 0;
        for at in 0..100 {
            let output = tick(made.tissue, press(at)).tool;
            most = most.max(output.contacts);
            if at == 60 {
                assert!(output.contacts > 0 && output.force_n[2] > 0.0, "{scheme:?} {output:?}");
            }
            if at >= 80 {
                assert_eq!((output.contacts, output.force_n), (0, [0.0; 3]), "{scheme:?}");
            }
            assert_eq!(output.flags & crate::FLAG_CONTACT_CAPACITY, 0);
        }
        assert!(most > 1, "{scheme:?}");
    }
}

#[test]
fn a_probe_that_cannot_be_is_refused() {
    let made = make(BOX, Scheme::Track, 34);
    for radius_m in [0.0, -0.01, f32::NAN, f32::INFINITY, 1e9] {
        let (code, detail) = probe(made.tissue, radius_m);
        assert_eq!(code, Code::ContactRadius, "{radius_m}");
        assert!(detail.limit > 1.0 && detail.limit.is_finite());
    }
    assert_eq!(probe(made.tissue, 0.01).0, Code::Ok);
    tick(made.tissue, press(0));
    assert_eq!(probe(made.tissue, 0.02).0, Code::ContactEngaged);
    let small = make(BOX, Scheme::Track, 2);
    let (code, detail) = probe(small.tissue, 0.01);
    assert_eq!(code, Code::ContactProbeCoarse);
    assert!(detail.needed > detail.available && detail.available > 0, "{detail:?}");
    assert_eq!(probe(make(BOX, Scheme::Euler, 2).tissue, 0.01).0, Code::Ok);
    // Over the capacity the flag is set.
    let few = make(BOX, Scheme::Euler, 2);
    assert_eq!(probe(few.tissue, 0.03).0, Code::Ok);
    let deep = super::pose_at([0.0, 0.0, 0.05], 1);
    // It grows from nothing where it is engaged in contact.
    for _ in 0..100 {
        tick(few.tissue, deep);
    }
    let output = tick(few.tissue, deep).tool;
    assert_eq!(output.contacts, 2);
    assert_ne!(output.flags & crate::FLAG_CONTACT_CAPACITY, 0);
}
