//! Images that are not a model: each refused with its code, section and position.

use std::vec::Vec;

use chaincell_kernel::image::{CHECKSUM_OFFSET, checksum, kind};

use super::{BLOCK, BOX, Block, call, info_of, model_of, storage};
use crate::{Code, Detail, Info, ModelStorage};

/// An image to change, in aligned memory.
struct Image {
    blocks: Vec<Block>,
    bytes: usize,
}

impl Image {
    fn good() -> Self {
        let mut image = Self { blocks: storage(BOX.len() + 16), bytes: BOX.len() };
        for (at, &byte) in BOX.iter().enumerate() {
            image.put(at, &[byte]);
        }
        image
    }

    fn put(&mut self, at: usize, bytes: &[u8]) {
        for (at, &byte) in (at..).zip(bytes) {
            self.blocks[at / BLOCK].0[at % BLOCK] = byte;
        }
    }

    fn word(&self, at: usize) -> u32 {
        let byte = |at: usize| self.blocks[at / BLOCK].0[at % BLOCK];
        u32::from_le_bytes(core::array::from_fn(|i| byte(at + i)))
    }

    /// Entry of a section in the table.
    fn entry(&self, kind: u32) -> usize {
        (32..).step_by(16).take(self.word(16) as usize).find(|&at| self.word(at) == kind).unwrap()
    }

    /// Start of a section.
    fn section(&self, kind: u32) -> usize {
        self.word(self.entry(kind) + 8) as usize
    }

    /// Makes the checksum right again.
    fn sign(&mut self) {
        let bytes: Vec<u8> = self.blocks.iter().flat_map(|block| block.0).collect();
        let sum = checksum(&bytes[..self.bytes]);
        self.put(CHECKSUM_OFFSET, &sum.to_le_bytes());
    }

    /// What the interface says, read from `skip` bytes on.
    fn read(&self, skip: usize) -> (Code, Detail) {
        let mut model = model_of(BOX);
        let mut detail = Detail { needed: 1, ..Detail::default() };
        let image = self.blocks.as_ptr().cast::<u8>().wrapping_add(skip);
        let code = call!(chaincell_model_init(&mut model, image.cast(), self.bytes, &mut detail));
        let there = call!(chaincell_model_info(&model, &mut Info::default()));
        assert_eq!(there, if code == Code::Ok { Code::Ok } else { Code::NotInitialised });
        (code, detail)
    }
}

#[track_caller]
fn refused(change: impl FnOnce(&mut Image), wanted: Code, section: u32, position: u32) {
    let mut image = Image::good();
    change(&mut image);
    image.sign();
    let (code, detail) = image.read(0);
    assert_eq!((code, detail.section, detail.position), (wanted, section, position));
}

#[test]
fn a_good_image_says_what_it_holds() {
    assert_eq!(Image::good().read(0), (Code::Ok, Detail::default()));
    let info = info_of(&model_of(BOX));
    assert_eq!((info.cells, info.links, info.coarse_functions), (125, 540, 27));
    assert_eq!((info.fixed, info.parts, info.input_nodes), (25, 1, 125));
    assert_eq!(info.checksum, chaincell_kernel::Model::from_bytes(BOX).unwrap().checksum());
    assert!((info.unit_m - 0.011_841).abs() < 1e-6 && info.centre_m == [0.0, 0.0, 0.02]);
    assert!((info.alpha, info.stiffness_n_per_m) == (0.02, 20.0));
    assert!((info.step_max - 0.11111).abs() < 1e-5 && (info.energy_max_j - 2.304).abs() < 1e-3);
}

// REQ-MOD-02
#[test]
fn what_stands_in_the_header_is_checked() {
    assert_eq!(Image::good().read(4).0, Code::ModelMisaligned);
    let mut image = Image::good();
    image.bytes -= 1;
    assert_eq!(image.read(0).0, Code::ModelTruncated);
    image.bytes = 0;
    assert_eq!(image.read(0).0, Code::ModelTruncated);
    refused(|image| image.put(0, b"chaincel"), Code::ModelMagic, 0, 0);
    refused(|image| image.put(24, &[1]), Code::ModelLayout, 0, 0);
    let mut image = Image::good();
    image.put(8, &2_u32.to_le_bytes());
    let wanted = Detail { needed: 1, available: 2, ..Detail::default() };
    assert_eq!(image.read(0), (Code::ModelVersion, wanted));
    let mut image = Image::good();
    image.put(image.section(kind::REST), &[0x55]);
    assert_eq!(image.read(0).0, Code::ModelChecksum);
}

// REQ-MOD-02
#[test]
fn sections_and_positions_are_named() {
    let none = 999_u32.to_le_bytes();
    refused(|i| i.put(i.entry(kind::UPPER), &none), Code::ModelMissing, kind::UPPER, 0);
    let version = |i: &mut Image| i.put(i.entry(kind::REST) + 4, &none);
    refused(version, Code::ModelSectionVersion, kind::REST, 0);
    let size = |i: &mut Image| i.put(i.entry(kind::MOBILITY) + 12, &4_u32.to_le_bytes());
    refused(size, Code::ModelSectionSize, kind::MOBILITY, 0);
    let parameter = |i: &mut Image| i.put(i.section(kind::PARAMS) + 32, &2.0_f32.to_le_bytes());
    refused(parameter, Code::ModelParameter, kind::PARAMS, 8);
    let index = |i: &mut Image| i.put(i.section(kind::UPPER) + 2 * 7, &[0, 0]);
    refused(index, Code::ModelIndex, kind::UPPER, 7);
    let value = |i: &mut Image| i.put(i.section(kind::REST) + 12 * 11, &f32::NAN.to_le_bytes());
    refused(value, Code::ModelValue, kind::REST, 11);
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
