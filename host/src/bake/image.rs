//! Writes a model image in the layout of [`chaincell_kernel::image`].

use bytemuck::{NoUninit, cast_slice};
use chaincell_kernel::image::{
    ALIGNMENT, CHECKSUM_OFFSET, ENTRY_BYTES, FORMAT_VERSION, HEADER_BYTES, MAGIC, SECTION_VERSION,
    checksum,
};

/// An image in memory, at a multiple of 16 bytes as the kernel reads it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImageBytes {
    words: Vec<u128>,
    length: usize,
}

impl ImageBytes {
    /// Copies `bytes` to aligned memory.
    #[must_use]
    pub fn copy(bytes: &[u8]) -> Self {
        let mut words = vec![0_u128; bytes.len().div_ceil(ALIGNMENT)];
        bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
        Self { words, length: bytes.len() }
    }

    /// Returns the image.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        &cast_slice(&self.words)[..self.length]
    }
}

/// Sections collected for an image, in the order they are pushed.
#[derive(Default)]
pub(super) struct Sections {
    entries: Vec<(u32, Vec<u8>)>,
}

impl Sections {
    pub fn push<T: NoUninit>(&mut self, kind: u32, values: &[T]) {
        self.entries.push((kind, cast_slice(values).to_vec()));
    }

    /// Writes header, table, sections at multiples of 16, and checksum.
    pub fn finish(self) -> ImageBytes {
        let aligned = |bytes: usize| bytes.next_multiple_of(ALIGNMENT);
        let mut offset = aligned(HEADER_BYTES + ENTRY_BYTES * self.entries.len());
        let mut table = Vec::new();
        for (kind, bytes) in &self.entries {
            table.push([*kind, SECTION_VERSION, offset as u32, bytes.len() as u32]);
            offset = aligned(offset + bytes.len());
        }
        let mut image = Vec::with_capacity(offset);
        image.extend_from_slice(&MAGIC);
        for word in [FORMAT_VERSION, offset as u32, self.entries.len() as u32, 0, 0, 0] {
            image.extend_from_slice(&word.to_le_bytes());
        }
        image.extend_from_slice(cast_slice(table.as_flattened()));
        for (_, bytes) in &self.entries {
            image.resize(aligned(image.len()), 0);
            image.extend_from_slice(bytes);
        }
        image.resize(offset, 0);
        let sum = checksum(&image).to_le_bytes();
        image[CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4].copy_from_slice(&sum);
        ImageBytes::copy(&image)
    }
}
