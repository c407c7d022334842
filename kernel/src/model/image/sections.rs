//! Header and section table: from raw bytes to typed slices.

use bytemuck::AnyBitPattern;
use crc::{CRC_32_ISO_HDLC, Crc, Table};

use super::{
    ALIGNMENT, CHECKSUM_OFFSET, ENTRY_BYTES, FORMAT_VERSION, HEADER_BYTES, MAGIC, ModelError,
    SECTION_VERSION,
};

#[cfg(target_endian = "big")]
compile_error!("the model image is read in place and little-endian: big-endian targets are out");

static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// CRC-32 of an image: all bytes but the four of the checksum itself. Cost: one pass over them.
///
/// ```
/// use chaincell_kernel::image::{CHECKSUM_OFFSET, checksum};
/// # let image = chaincell_kernel::include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
///
/// let stored = &image[CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4];
/// assert_eq!(checksum(image).to_le_bytes(), stored);
/// ```
#[must_use]
pub fn checksum(image: &[u8]) -> u32 {
    checksum_but(image, CHECKSUM_OFFSET)
}

/// CRC-32 of all bytes but the four at a place.
pub(crate) fn checksum_but(bytes: &[u8], place: usize) -> u32 {
    let mut digest = CRC.digest();
    digest.update(bytes.get(..place).unwrap_or(bytes));
    digest.update(bytes.get(place + 4..).unwrap_or(&[]));
    digest.finalize()
}

/// An image whose header, checksum and section table are sound.
#[derive(Clone, Copy)]
pub(crate) struct Sections<'a> {
    image: &'a [u8],
    table: &'a [[u32; 4]],
    /// Checksum of the image, which also identifies it.
    pub checksum: u32,
}

impl<'a> Sections<'a> {
    /// Checks everything about `bytes` that does not depend on the meaning of the sections.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, ModelError> {
        if !bytes.as_ptr().addr().is_multiple_of(ALIGNMENT) {
            return Err(ModelError::Misaligned);
        }
        let header = bytes.get(..HEADER_BYTES).ok_or(ModelError::Truncated)?;
        if header.get(..8) != Some(&MAGIC) {
            return Err(ModelError::Magic);
        }
        let words: &[u32] = cast(header.get(8..).unwrap_or(&[])).ok_or(ModelError::Layout)?;
        let &[version, total, count, stored, 0, 0] = words else {
            return Err(ModelError::Layout);
        };
        if version != FORMAT_VERSION {
            return Err(ModelError::Version(version));
        }
        let image = bytes.get(..total as usize).ok_or(ModelError::Truncated)?;
        if image.len() != bytes.len() {
            return Err(ModelError::Layout);
        }
        if checksum(image) != stored {
            return Err(ModelError::Checksum);
        }
        let end = (count as usize)
            .checked_mul(ENTRY_BYTES)
            .and_then(|bytes| bytes.checked_add(HEADER_BYTES))
            .ok_or(ModelError::Layout)?;
        let table = image.get(HEADER_BYTES..end).and_then(cast).ok_or(ModelError::Layout)?;
        Ok(Self { image, table, checksum: stored })
    }

    /// Returns the section of a kind as a slice of `T`, `None` if the image has none.
    pub fn optional<T: AnyBitPattern>(&self, kind: u32) -> Result<Option<&'a [T]>, ModelError> {
        let mut entries = self.table.iter().filter(|entry| entry[0] == kind);
        let Some(&[_, version, offset, bytes]) = entries.next() else { return Ok(None) };
        if entries.next().is_some() || !(offset as usize).is_multiple_of(ALIGNMENT) {
            return Err(ModelError::Layout);
        }
        if version != SECTION_VERSION {
            return Err(ModelError::SectionVersion(kind));
        }
        let end = offset.checked_add(bytes).ok_or(ModelError::Layout)?;
        let section = self.image.get(offset as usize..end as usize).ok_or(ModelError::Layout)?;
        cast(section).map(Some).ok_or(ModelError::SectionSize(kind))
    }

    /// As [`Self::optional`], for a section that every model has.
    pub fn required<T: AnyBitPattern>(&self, kind: u32) -> Result<&'a [T], ModelError> {
        self.optional(kind)?.ok_or(ModelError::Missing(kind))
    }

    /// Returns a required section of exactly `length` elements.
    pub fn sized<T: AnyBitPattern>(&self, kind: u32, length: usize) -> Result<&'a [T], ModelError> {
        let section = self.required(kind)?;
        if section.len() == length { Ok(section) } else { Err(ModelError::SectionSize(kind)) }
    }
}

/// Reads `bytes` in place; `None` if size or alignment do not fit.
fn cast<T: AnyBitPattern>(bytes: &[u8]) -> Option<&[T]> {
    bytemuck::try_cast_slice(bytes).ok()
}
