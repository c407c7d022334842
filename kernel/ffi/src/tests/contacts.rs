//! Contact cells by input ids.

use super::{BOX, KINDS, choose, hash, info_of, make, model_of, sample, schemes_of, tick};
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

// REQ-CON-01
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

// REQ-CON-02
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
