//! Model images that no bake writes: sections of a good one changed at will, sealed like another.
#![allow(clippy::indexing_slicing, clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::ops::Range;

use bytemuck::{AnyBitPattern, NoUninit, pod_collect_to_vec};
use chaincell_host::bake::ImageBytes;
use chaincell_kernel::image::{
    ALIGNMENT, CHECKSUM_OFFSET, ENTRY_BYTES, HEADER_BYTES, SECTION_VERSION, checksum,
};

/// An image with its checksum right, whatever stands in it.
#[must_use]
pub fn resealed(mut image: Vec<u8>) -> ImageBytes {
    let sum = checksum(&image).to_le_bytes();
    image[CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4].copy_from_slice(&sum);
    ImageBytes::copy(&image)
}

/// Where a section of a good image stands.
#[must_use]
pub fn section(image: &[u8], kind: u32) -> Range<usize> {
    table(image).find(|of| of.0 == kind).unwrap().1
}

/// Kinds and places of the sections of a good image.
fn table(image: &[u8]) -> impl Iterator<Item = (u32, Range<usize>)> {
    let word = |at: usize| u32::from_le_bytes(*image[at..].first_chunk().unwrap());
    let entries = (0..word(16) as usize).map(|entry| HEADER_BYTES + ENTRY_BYTES * entry);
    entries.map(move |at| {
        let (start, bytes) = (word(at + 8) as usize, word(at + 12) as usize);
        (word(at), start..start + bytes)
    })
}

/// The sections of an image.
#[derive(Debug, Clone)]
pub struct Forged {
    header: Vec<u8>,
    sections: Vec<(u32, Vec<u8>)>,
}

impl Forged {
    /// Those of a good image.
    #[must_use]
    pub fn of(image: &[u8]) -> Self {
        let sections = table(image).map(|(kind, at)| (kind, image[at].to_vec()));
        Self { header: image[..HEADER_BYTES].to_vec(), sections: sections.collect() }
    }

    /// The numbers of a section.
    #[must_use]
    pub fn get<T: NoUninit + AnyBitPattern>(&self, kind: u32) -> Vec<T> {
        pod_collect_to_vec(&self.sections.iter().find(|of| of.0 == kind).unwrap().1)
    }

    /// Other numbers in a section.
    pub fn change<T: NoUninit + AnyBitPattern>(
        &mut self,
        kind: u32,
        change: impl FnOnce(&mut Vec<T>),
    ) {
        let mut values = self.get(kind);
        change(&mut values);
        let bytes = bytemuck::cast_slice(&values).to_vec();
        self.sections.iter_mut().find(|of| of.0 == kind).unwrap().1 = bytes;
    }

    /// Takes a section out.
    pub fn remove(&mut self, kind: u32) {
        self.sections.retain(|of| of.0 != kind);
    }

    /// The image, with its length, its table and its checksum right.
    #[must_use]
    pub fn sealed(&self) -> ImageBytes {
        let mut image = self.header.clone();
        let mut offset = HEADER_BYTES + ENTRY_BYTES * self.sections.len();
        for (kind, bytes) in &self.sections {
            offset = offset.next_multiple_of(ALIGNMENT);
            for word in [*kind, SECTION_VERSION, offset as u32, bytes.len() as u32] {
                image.extend(word.to_le_bytes());
            }
            offset += bytes.len();
        }
        for (_, bytes) in &self.sections {
            image.resize(image.len().next_multiple_of(ALIGNMENT), 0);
            image.extend(bytes);
        }
        image.resize(image.len().next_multiple_of(ALIGNMENT), 0);
        for (at, number) in [(12, image.len()), (16, self.sections.len())] {
            image[at..at + 4].copy_from_slice(&(number as u32).to_le_bytes());
        }
        resealed(image)
    }
}
