//! Records packed for the wire: each by what differs from an earlier one like it, then deflated.

use std::array;
use std::ops::Range;

use chaincell_kernel::trace::RECORD_BYTES;
use miniz_oxide::deflate::compress_to_vec;
use miniz_oxide::inflate::decompress_to_vec_with_limit;

/// Most records that are unpacked at once.
pub const RECORDS_MAX: usize = 1 << 16;
/// How hard packing tries, of 10.
const LEVEL: u8 = 6;
/// Bytes of a record that tell its kind.
const KIND: Range<usize> = 32..34;

/// Packs whole records: one byte, the distance to the record that each is compared with, then the differences. The
/// first ones are compared with zeros.
#[must_use]
pub fn pack(records: &[u8]) -> Vec<u8> {
    let (rows, _) = records.as_chunks::<RECORD_BYTES>();
    let distance = period(rows);
    let differs = rows.iter().enumerate().flat_map(|(at, row)| {
        let before = at.checked_sub(distance).map_or(&[0; RECORD_BYTES], |before| &rows[before]);
        array::from_fn::<u8, RECORD_BYTES, _>(|byte| row[byte] ^ before[byte])
    });
    let mut packed = vec![distance as u8];
    packed.extend(compress_to_vec(&differs.collect::<Vec<u8>>(), LEVEL));
    packed
}

/// Distance of the last two records of the last one's kind: a tick has a record, and one before it for each tool.
fn period(rows: &[[u8; RECORD_BYTES]]) -> usize {
    let Some((last, before)) = rows.split_last() else { return 1 };
    let like = before.iter().rev().position(|row| row[KIND] == last[KIND]);
    like.map_or(1, |between| between + 1).min(usize::from(u8::MAX))
}

/// The records that [`pack`] packed; `None` for bytes that are none of its own, and for more than [`RECORDS_MAX`].
#[must_use]
pub fn unpack(packed: &[u8]) -> Option<Vec<u8>> {
    let (&distance, deflated) = packed.split_first()?;
    let mut bytes = decompress_to_vec_with_limit(deflated, RECORDS_MAX * RECORD_BYTES).ok()?;
    if !bytes.len().is_multiple_of(RECORD_BYTES) {
        return None;
    }
    let distance = usize::from(distance).max(1) * RECORD_BYTES;
    for at in distance..bytes.len() {
        bytes[at] ^= bytes[at - distance];
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_unpacked_as_they_were_packed() {
        // Three kinds in turn, as two poses and a tick.
        let row = |at: u8| {
            let mut row: [u8; RECORD_BYTES] = array::from_fn(|byte| at.wrapping_mul(byte as u8));
            row[KIND].copy_from_slice(&[at % 3, 0]);
            row
        };
        for (count, distance) in [(0, 1), (1, 1), (2, 1), (7, 3), (200, 3)] {
            let records: Vec<u8> = (0..count).flat_map(row).collect();
            let packed = pack(&records);
            assert_eq!(packed[0], distance, "{count}");
            assert_eq!(unpack(&packed), Some(records), "{count}");
        }
    }

    #[test]
    fn what_is_none_is_refused() {
        let bomb =
            [&[1][..], &compress_to_vec(&vec![0; RECORDS_MAX * RECORD_BYTES + 1], LEVEL)].concat();
        let part = [&[1][..], &compress_to_vec(&[7; RECORD_BYTES + 1], LEVEL)].concat();
        for bad in [&[][..], &[1], &[1, 0xff, 0xff], &bomb, &part] {
            assert_eq!(unpack(bad), None, "{} bytes", bad.len());
        }
    }
}
