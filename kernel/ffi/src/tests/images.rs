//! Images: what they hold, and what is no model.

use super::{BLOCK, BOX, call, info_of, model_of, storage};
use crate::{Code, Detail, Info, ModelStorage};

/// What the interface says of an image with another byte, read from `skip` bytes on.
fn read(skip: usize, bytes: usize, (at, byte): (usize, u8)) -> (Code, Detail) {
    let mut blocks = storage(BOX.len() + BLOCK);
    for (at, byte) in BOX.iter().copied().enumerate().chain([(at, byte)]) {
        blocks[at / BLOCK].0[at % BLOCK] = byte;
    }
    let mut model = model_of(BOX);
    let mut detail = Detail { needed: 1, ..Detail::default() };
    let image = blocks.as_ptr().cast::<u8>().wrapping_add(skip);
    let code = call!(chaincell_model_init(&mut model, image.cast(), bytes, &mut detail));
    let there = call!(chaincell_model_info(&model, &mut Info::default()));
    assert_eq!(there, if code == Code::Ok { Code::Ok } else { Code::NotInitialised });
    (code, detail)
}

#[test]
fn a_good_image_says_what_it_holds() {
    assert_eq!(read(0, BOX.len(), (0, BOX[0])), (Code::Ok, Detail::default()));
    let info = info_of(&model_of(BOX));
    assert_eq!((info.cells, info.links, info.coarse_functions), (125, 540, 27));
    assert_eq!((info.fixed, info.parts, info.input_nodes), (25, 1, 125));
    assert_eq!(info.checksum, chaincell_kernel::Model::from_bytes(BOX).unwrap().checksum());
    assert!((info.unit_m - 0.011_841).abs() < 1e-6 && info.centre_m == [0.0, 0.0, 0.02]);
    assert!((info.alpha, info.stiffness_n_per_m) == (0.02, 20.0));
    assert!((info.step_max - 0.11111).abs() < 1e-5 && (info.energy_max_j - 2.304).abs() < 1e-3);
}

/// What the kernel's tests name by its error has its code here, with the detail.
// REQ-MOD-02
#[test]
fn what_is_no_image_is_refused_by_its_code() {
    let (all, same) = (BOX.len(), (0, BOX[0]));
    assert_eq!(read(4, all, same).0, Code::ModelMisaligned);
    assert_eq!(read(0, all - 1, same).0, Code::ModelTruncated);
    assert_eq!(read(0, 0, same).0, Code::ModelTruncated);
    assert_eq!(read(0, all, (all - 1, !BOX[all - 1])).0, Code::ModelChecksum);
    let wanted = Detail { needed: 1, available: 2, ..Detail::default() };
    assert_eq!(read(0, all, (8, 2)), (Code::ModelVersion, wanted));
}

#[test]
fn every_cell_has_the_input_id_that_the_kernel_says() {
    let (model, own) = (model_of(BOX), chaincell_kernel::Model::from_bytes(BOX).unwrap());
    for (cell, &wanted) in own.input_id().iter().enumerate() {
        let mut id = 999;
        assert_eq!(call!(chaincell_model_input_id(&model, cell as u32, &mut id)), Code::Ok);
        assert_eq!(id, wanted);
    }
    let mut untouched = 999;
    assert_eq!(call!(chaincell_model_input_id(&model, 125, &mut untouched)), Code::Range);
    assert_eq!(call!(chaincell_model_input_id(&model, u32::MAX, &mut untouched)), Code::Range);
    assert_eq!(untouched, 999);
    let mut copy = ModelStorage::EMPTY;
    copy.clone_from(&model);
    assert_eq!(info_of(&copy), info_of(&model));
}
