//! PNG files.

use miniz_oxide::deflate::compress_to_vec_zlib;

use super::raster::Pixels;
use crate::checksum::CRC_32;

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";
/// Bytes of a pixel: red, green, blue.
const DEPTH: usize = 3;
/// Level of the compression, at most 10.
const LEVEL: u8 = 6;

/// Returns the pixels as a PNG file, 8 bits a colour, sRGB. About a tenth of a second for a million pixels.
#[must_use]
pub fn encode(pixels: &Pixels) -> Vec<u8> {
    let (width, height) = pixels.size_px;
    let mut head = Vec::new();
    head.extend(width.to_be_bytes());
    head.extend(height.to_be_bytes());
    // 8 bits a colour, three colours, the only compression and filter method, not interlaced.
    head.extend([8, 2, 0, 0, 0]);
    let mut file = SIGNATURE.to_vec();
    chunk(&mut file, *b"IHDR", &head);
    chunk(&mut file, *b"sRGB", &[0]);
    chunk(&mut file, *b"IDAT", &packed(pixels.rgb.as_flattened(), width as usize * DEPTH));
    chunk(&mut file, *b"IEND", &[]);
    file
}

/// Adds a chunk: its length, name, content and checksum.
fn chunk(file: &mut Vec<u8>, name: [u8; 4], content: &[u8]) {
    file.extend((content.len() as u32).to_be_bytes());
    let start = file.len();
    file.extend(name);
    file.extend(content);
    let sum = CRC_32.checksum(&file[start..]);
    file.extend(sum.to_be_bytes());
}

/// The rows, each filtered and after the number of its filter, compressed.
fn packed(bytes: &[u8], row_bytes: usize) -> Vec<u8> {
    let mut rows = Vec::with_capacity(bytes.len() + bytes.len() / row_bytes.max(1));
    let none = vec![0; row_bytes];
    let mut above = none.as_slice();
    for row in bytes.chunks_exact(row_bytes.max(1)) {
        rows.extend(filtered(row, above));
        above = row;
    }
    compress_to_vec_zlib(&rows, LEVEL)
}

/// The row after the filter whose differences are smallest in sum: none, the left, the upper, or Paeth's
/// neighbour. A row that is the upper one again takes no search.
fn filtered(row: &[u8], above: &[u8]) -> Vec<u8> {
    let guess = |filter: u8, at: usize| {
        let left = if at < DEPTH { 0 } else { row[at - DEPTH] };
        match filter {
            1 => left,
            2 => above[at],
            4 => paeth(left, above[at], if at < DEPTH { 0 } else { above[at - DEPTH] }),
            _ => 0,
        }
    };
    let size = |filter: u8| -> u64 {
        let differences = (0..row.len()).map(|at| row[at].wrapping_sub(guess(filter, at)) as i8);
        differences.map(|x| u64::from(x.unsigned_abs())).sum()
    };
    let best = if row == above {
        2
    } else {
        [0, 1, 2, 4].into_iter().min_by_key(|x| size(*x)).unwrap_or(0)
    };
    let differences = (0..row.len()).map(|at| row[at].wrapping_sub(guess(best, at)));
    std::iter::once(best).chain(differences).collect()
}

/// Of three neighbours the one nearest to left + upper - corner.
fn paeth(left: u8, upper: u8, corner: u8) -> u8 {
    let guess = i32::from(left) + i32::from(upper) - i32::from(corner);
    let far = |of: u8| (guess - i32::from(of)).abs();
    if far(left) <= far(upper) && far(left) <= far(corner) {
        left
    } else if far(upper) <= far(corner) {
        upper
    } else {
        corner
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// A decoder of others reads the same pixels: an even ground, a ramp, noise.
    #[test]
    fn a_decoder_reads_the_same_pixels() {
        let size_px = (37, 21);
        let rgb: Vec<[u8; 3]> = (0..37 * 21_u32)
            .map(|at| match at % 37 {
                0..12 => [255; 3],
                x @ 12..24 => [(7 * x) as u8, (at / 37) as u8, 9],
                _ => [at, at >> 3, at >> 5].map(|x| (x.wrapping_mul(2_654_435_761) >> 24) as u8),
            })
            .collect();
        let file = encode(&Pixels { size_px, rgb: rgb.clone() });
        let mut reader = png::Decoder::new(Cursor::new(&file)).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        let info = reader.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height, info.color_type), (37, 21, png::ColorType::Rgb));
        assert_eq!(bytes, rgb.as_flattened());
    }
}
