//! A body of nodal shapes: its storage, and the schemes that move it.

use std::vec::Vec;

use super::sizes::size as links_size;
use super::{
    BLOCK, BOX, Block, SHAPES, call, hash, holding, info_of, init, make, model_of, settings_of,
    size_of_body, storage,
};
use crate::{ALIGN, Code, SHAPE_ALIGN, Scheme, Tissue};

/// Bytes and alignment of a tissue for an image.
fn size(image: &[u8], scheme: Scheme) -> (usize, usize) {
    let (_, bytes, align) = size_of_body(image, scheme as i32, &holding(2));
    (bytes, align)
}

/// A body in storage that starts `skip` bytes behind a multiple of 64.
fn place(storage: &mut [Block], skip: usize, scheme: Scheme) -> (Code, *mut Tissue) {
    let settings = settings_of(&model_of(SHAPES), Scheme::Track);
    let there = storage.as_mut_ptr().wrapping_byte_add(skip);
    let bytes = size_of_val(storage) - skip;
    let (code, _, tissue) = init((there, bytes), SHAPES, (scheme as i32, &holding(2)), &settings);
    (code, tissue)
}

fn lines(scheme: Scheme) -> Vec<Block> {
    storage(size(SHAPES, scheme).0 + BLOCK)
}

#[test]
fn the_size_counts_the_states() {
    let cells = info_of(&model_of(SHAPES)).cells;
    for scheme in Scheme::ALL {
        let (bytes, align) = size(SHAPES, scheme);
        let links = links_size(scheme, cells, 2, 0);
        assert!(align == SHAPE_ALIGN && bytes - links >= 144 * cells as usize);
        let info = info_of(&model_of(BOX));
        let whole = links_size(scheme, info.cells, 2, info.coarse_functions);
        assert_eq!(size(BOX, scheme), (whole, ALIGN));
    }
    let model = model_of(SHAPES);
    let null = core::ptr::null_mut();
    let (room, most) = (holding(2), holding(cells + 1));
    assert_eq!(call!(chaincell_model_size(&model, 0, &room, null, null)), Code::Ok);
    assert_eq!(call!(chaincell_model_size(&model, 8, &room, null, null)), Code::Scheme);
    assert_eq!(call!(chaincell_model_size(&model, 0, &most, null, null)), Code::Range);
    let none = core::ptr::null();
    assert_eq!(call!(chaincell_model_size(none, 0, &room, null, null)), Code::Null);
}

/// Every byte may be moved, to storage of the same alignment.
// REQ-MOD-04
#[test]
fn storage_that_is_not_aligned_is_refused() {
    let mut storage = lines(Scheme::Predict);
    for skip in [16, 32, 48] {
        let (code, tissue) = place(&mut storage, skip, Scheme::Predict);
        assert_eq!((code, tissue.is_null()), (Code::Misaligned, true));
    }
    let (code, tissue) = place(&mut storage, 0, Scheme::Predict);
    assert_eq!(code, Code::Ok);
    let (before, moved) = (hash(tissue), storage.clone());
    assert_eq!(hash(moved.as_ptr().cast()), before);
    // The same 16 bytes further on.
    let mut bytes = std::vec![0; 16];
    bytes.extend(storage.iter().flat_map(|line| line.0));
    let mut shifted = std::vec![Block([0; BLOCK]); storage.len() + 1];
    for (at, byte) in bytes.into_iter().enumerate() {
        shifted[at / BLOCK].0[at % BLOCK] = byte;
    }
    let there = shifted.as_ptr().cast::<u8>().wrapping_add(16).cast::<Tissue>();
    assert_eq!(call!(chaincell_state_hash(there, &mut 0)), Code::Misaligned);
}

// REQ-MOD-04
#[test]
fn schemes_that_move_no_shapes_say_so() {
    for scheme in Scheme::ALL {
        let (code, tissue) = place(&mut lines(scheme), 0, scheme);
        let moves = matches!(scheme, Scheme::Track | Scheme::Predict);
        let wanted = match scheme {
            _ if moves => Code::Ok,
            Scheme::TrackFixed | Scheme::EulerFixed => code,
            _ => Code::ResetShapes,
        };
        assert_eq!((code, tissue.is_null()), (wanted, !moves), "{scheme:?}");
    }
    // A body of links goes into storage of any alignment, as ever.
    make(BOX, Scheme::Euler, 1);
}
