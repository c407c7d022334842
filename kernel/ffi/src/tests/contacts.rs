//! Contact cells by input ids.

use super::{BOX, choose, hash, make, sample, tick};
use crate::{Code, Scheme};

/// A body that holds these ids, after a few ticks of a press.
fn pressed(ids: &[u32], and_then: &[u32]) -> (u64, u32) {
    let made = make(BOX, Scheme::Track, 4);
    assert_eq!(choose(made.tissue, ids).0, Code::Ok);
    if !and_then.is_empty() {
        assert_ne!(choose(made.tissue, and_then).0, Code::Ok);
    }
    let mut contacts = 0;
    for at in 0..20 {
        contacts = tick(made.tissue, sample(at)).contacts;
    }
    (hash(made.tissue), contacts)
}

#[test]
fn any_order_is_the_same_choice() {
    let [a, b] = [pressed(&[64, 69, 89, 39], &[]), pressed(&[39, 89, 64, 69], &[])];
    assert_eq!(a, b);
    assert_eq!(a.1, 4);
    assert_ne!(pressed(&[64, 69, 89], &[]).0, a.0);
}

#[test]
fn no_cell_is_a_choice_too() {
    assert_eq!(pressed(&[], &[]).1, 0);
}

#[test]
fn refused_ids_are_named_and_the_old_choice_stays() {
    let made = make(BOX, Scheme::Track, 4);
    let refused = |ids: &[u32]| {
        let (code, detail) = choose(made.tissue, ids);
        (code, detail.position, detail.needed, detail.available)
    };
    assert_eq!(refused(&[64, 69, 125]), (Code::UnknownId, 2, 0, 0));
    assert_eq!(refused(&[64, u32::MAX]), (Code::UnknownId, 1, 0, 0));
    assert_eq!(refused(&[64, 60, 69]), (Code::ContactFixed, 1, 0, 0));
    assert_eq!(refused(&[64, 69, 39, 64]), (Code::ContactRepeated, 3, 0, 0));
    assert_eq!(refused(&[69, 69]), (Code::ContactRepeated, 1, 0, 0));
    assert_eq!(refused(&[64, 69, 89, 39, 114]), (Code::ContactCapacity, 0, 5, 4));
    let plain = pressed(&[64, 69], &[]);
    for ids in [&[39, 125][..], &[39, 60], &[39, 39], &[14, 39, 64, 89, 114]] {
        assert_eq!(pressed(&[64, 69], ids), plain);
    }
}

#[test]
fn cells_change_hands_only_while_the_tool_is_released() {
    for scheme in Scheme::ALL {
        let made = make(BOX, scheme, 2);
        assert_eq!(choose(made.tissue, &[64]).0, Code::Ok);
        tick(made.tissue, sample(0));
        assert_eq!(choose(made.tissue, &[69]).0, Code::ContactEngaged);
        tick(made.tissue, sample(59));
        assert_eq!(choose(made.tissue, &[69, 64]).0, Code::Ok);
        assert_eq!(tick(made.tissue, sample(0)).contacts, 2);
    }
}
