//! A body of nodal shapes: its storage, the schemes that move it, and the kernel's own bits.

use std::vec::Vec;

use chaincell_kernel::{
    Budget, Model, Network, Settings as KernelSettings, Tissue as Own, Track, elastic_room,
    term_states,
};

use super::sizes::size as links_size;
use super::{
    BLOCK, BOX, Block, SHAPES, call, choose, hash, info_of, make, model_of, sample, settings_of,
    size_of_body, storage, tick,
};
use crate::{ALIGN, Code, Detail, Room, SHAPE_ALIGN, Scheme, Tissue};

/// Bytes and alignment of a tissue for an image.
fn size(image: &[u8], scheme: Scheme, contacts: u32) -> (usize, usize) {
    size_of_body(&model_of(image), scheme as i32, contacts)
}

/// A body in storage that starts `skip` bytes behind a multiple of 64.
fn place(storage: &mut [Block], skip: usize, scheme: Scheme) -> (Code, *mut Tissue) {
    let model = model_of(SHAPES);
    let settings = settings_of(&model, Scheme::Track);
    let there = storage.as_mut_ptr().cast::<u8>().wrapping_add(skip);
    let bytes = size_of_val(storage) - skip;
    let (mut tissue, mut detail) = (core::ptr::null_mut(), Detail::default());
    let room = Room { contacts: 2, ..Room::default() };
    let code = call!(chaincell_tissue_init(
        there.cast(),
        bytes,
        &model,
        scheme as i32,
        &room,
        &settings,
        &mut tissue,
        &mut detail,
    ));
    (code, tissue)
}

fn lines(scheme: Scheme) -> Vec<Block> {
    storage(size(SHAPES, scheme, 2).0 + BLOCK)
}

#[test]
fn the_size_counts_the_states() {
    let cells = info_of(&model_of(SHAPES)).cells;
    for scheme in Scheme::ALL {
        let (bytes, align) = size(SHAPES, scheme, 2);
        let links = links_size(scheme, cells, 2, 0);
        assert!(align == SHAPE_ALIGN && bytes - links >= 144 * cells as usize);
        let info = info_of(&model_of(BOX));
        let whole = links_size(scheme, info.cells, 2, info.coarse_functions);
        assert_eq!(size(BOX, scheme, 2), (whole, ALIGN));
    }
    let model = model_of(SHAPES);
    let null = core::ptr::null_mut();
    let room = Room { contacts: 2, ..Room::default() };
    let most = Room { contacts: cells + 1, ..room };
    assert_eq!(call!(chaincell_model_size(&model, 0, &room, null, null)), Code::Ok);
    assert_eq!(call!(chaincell_model_size(&model, 8, &room, null, null)), Code::Scheme);
    assert_eq!(call!(chaincell_model_size(&model, 0, &most, null, null)), Code::Range);
    let none = core::ptr::null();
    assert_eq!(call!(chaincell_model_size(none, 0, &room, null, null)), Code::Null);
}

// REQ-CIF-06
#[test]
fn it_is_the_kernels_body_to_the_last_bit() {
    let model = Model::from_bytes(SHAPES).unwrap();
    let network = Network::new(model, KernelSettings::for_model(&model)).unwrap();
    let mut own = Own::<144, Track<{ elastic_room(64) }>, 2, { term_states(144) }>::new();
    let mut storage = lines(Scheme::Track);
    let (code, tissue) = place(&mut storage, 0, Scheme::Track);
    assert_eq!(code, Code::Ok);
    let mut held: Vec<u16> =
        model.surface().iter().copied().filter(|&cell| !model.is_fixed(cell)).take(2).collect();
    held.sort_unstable();
    let ids: Vec<u32> = held.iter().map(|&cell| model.input_id()[usize::from(cell)]).collect();
    own.reset(&network).unwrap();
    own.choose_contacts(&network, &held).unwrap();
    assert_eq!(choose(tissue, &ids).0, Code::Ok);
    for at in 0..90 {
        let sample = sample(at);
        let here = tick(tissue, sample);
        let there = own.tick(&network, &[super::of_kernel(&sample)], Budget::All);
        assert_eq!(
            here.tool.force_n.map(f32::to_bits),
            <[f32; 3]>::from(there.force_n).map(f32::to_bits)
        );
        assert_eq!(hash(tissue), own.view().state_hash(&model), "tick {at}");
    }
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
