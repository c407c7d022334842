//! Bakes pins into images; the bound of the curvature as a dense matrix.

use std::vec;
use std::vec::Vec;

use super::held::Contact;
use crate::model::Model;
use crate::model::coarse_basis::CoarseBasis;
use crate::model::image::{
    ALIGNMENT, CHECKSUM_OFFSET, ENTRY_BYTES, FORMAT_VERSION, HEADER_BYTES, MAGIC, SECTION_VERSION,
    checksum, kind, params,
};
use crate::model::pin::{PINS, Pin};
use crate::number::two_float::LANES;

/// The bake's share of the diagonal, over the root of the number of basis functions.
pub(crate) const ROUNDING_ROOM: f64 = 1.0e-3;

/// P' L P in double precision, the rows of `held` cells zeroed.
pub(crate) fn matrix(
    model: &Model<'_>,
    pins: impl Iterator<Item = Pin>,
    basis: &CoarseBasis<'_>,
    held: &[Contact],
) -> Vec<Vec<f64>> {
    let row = |cell: usize| -> Vec<(usize, f64)> {
        let is_held = held.iter().any(|contact| contact.cell() == cell);
        let row = basis.row_of(cell).filter(|_| !is_held);
        row.map(|(function, weight)| (function, f64::from(weight))).collect()
    };
    let mut matrix = vec![vec![0.0; basis.count]; basis.count];
    let mut add = |map: &[(usize, f64)], weight: f32| {
        for &(a, x) in map {
            for &(b, y) in map {
                matrix[a][b] += 0.5 * f64::from(weight) * x * y;
            }
        }
    };
    for i in 0..model.cells() {
        for link in model.row(i) {
            let mut difference = row(i);
            let j = usize::from(model.upper[link]);
            difference.extend(row(j).into_iter().map(|(function, weight)| (function, -weight)));
            add(&difference, model.link_weight(link));
        }
    }
    for pin in pins {
        add(&row(pin.cell), pin.weight);
    }
    matrix
}

/// The inverse of a positive definite matrix, by Gauss and Jordan.
fn inverse(mut matrix: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let n = matrix.len();
    for (i, row) in matrix.iter_mut().enumerate() {
        row.extend((0..n).map(|j| f64::from(u8::from(i == j))));
    }
    for pivot in 0..n {
        let own: Vec<f64> = matrix[pivot].iter().map(|x| x / matrix[pivot][pivot]).collect();
        for (i, row) in matrix.iter_mut().enumerate() {
            let factor = row[pivot];
            for (x, own) in row.iter_mut().zip(&own) {
                *x = if i == pivot { *own } else { *x - factor * own };
            }
        }
    }
    matrix.into_iter().map(|row| row[n..].to_vec()).collect()
}

/// Kinds and contents of the sections of an image.
type Contents = Vec<(u32, Vec<u8>)>;

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

fn contents(image: &[u8]) -> Contents {
    let entry = |n: usize| HEADER_BYTES + n * ENTRY_BYTES;
    let section = |n: usize| {
        let (start, length) = (word(image, entry(n) + 8), word(image, entry(n) + 12));
        let bytes = &image[start as usize..][..length as usize];
        (word(image, entry(n)), bytes.to_vec())
    };
    (0..word(image, 16) as usize).map(section).collect()
}

/// An image of these sections, aligned; it is never freed.
fn image(contents: &Contents) -> &'static [u8] {
    let mut bytes = MAGIC.to_vec();
    let count = contents.len() as u32;
    bytes.extend([FORMAT_VERSION, 0, count, 0, 0, 0].map(u32::to_le_bytes).as_flattened());
    let mut offset = HEADER_BYTES + contents.len() * ENTRY_BYTES;
    for (kind, section) in contents {
        let entry = [*kind, SECTION_VERSION, offset as u32, section.len() as u32];
        bytes.extend(entry.map(u32::to_le_bytes).as_flattened());
        offset += section.len().next_multiple_of(ALIGNMENT);
    }
    for (_, section) in contents {
        bytes.extend(section);
        bytes.resize(bytes.len().next_multiple_of(ALIGNMENT), 0);
    }
    let total = (bytes.len() as u32).to_le_bytes();
    bytes[12..16].copy_from_slice(&total);
    let sum = checksum(&bytes).to_le_bytes();
    bytes[CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4].copy_from_slice(&sum);
    let room = vec![0; bytes.len() + ALIGNMENT].leak();
    let start = room.as_ptr().align_offset(ALIGNMENT);
    let aligned = &mut room[start..start + bytes.len()];
    aligned.copy_from_slice(&bytes);
    aligned
}

/// The image with another word in a section.
pub(crate) fn with_word(from: &[u8], kind: u32, at: usize, word: u32) -> &'static [u8] {
    let mut contents = contents(from);
    for (_, section) in contents.iter_mut().filter(|(of, _)| *of == kind) {
        section[4 * at..4 * at + 4].copy_from_slice(&word.to_le_bytes());
    }
    image(&contents)
}

/// Bakes pins into an image: their section, and their part in the bounds of the curvature: the cells'
/// mobilities, the largest step, the inverse of the coarse level. A body that is set `afloat` loses its fixed
/// cells and its coarse level.
pub(crate) fn pinned(from: &[u8], pins: &[Pin], afloat: bool) -> &'static [u8] {
    let model = Model::from_bytes(from).unwrap();
    let pin_of = |cell: usize| pins.iter().find(|pin| pin.cell == cell).map_or(0.0, |p| p.weight);
    let bound = |cell: usize| model.cell_weight(cell) + pin_of(cell);
    let is_fixed = |cell: usize| !afloat && model.is_fixed(cell as u16);
    let mobility = |cell| if is_fixed(cell) { 0.0 } else { 1.0 / bound(cell) };
    let links = (0..model.cells()).flat_map(|i| model.neighbours(i).map(move |(_, j)| [i, j]));
    let of_links = links.map(|[i, j]| 0.5 * (bound(i) + bound(j)));
    let of_pins = pins.iter().map(|pin| 0.5 * (bound(pin.cell) + pin.weight));
    let degree_bound = of_links.chain(of_pins).fold(0.0, f32::max);
    let mut contents = contents(from);
    let words: Vec<u8> = pins.iter().flat_map(Pin::words).flat_map(u32::to_le_bytes).collect();
    contents.push((PINS, words));
    if afloat {
        contents.retain(|&(kind, _)| !(kind::COARSE..=kind::COARSE_INVERSE).contains(&kind));
    }
    for (kind, section) in &mut contents {
        match *kind {
            kind::PARAMS => {
                let at = 4 * params::DEGREE_BOUND;
                section[at..at + 4].copy_from_slice(&degree_bound.to_le_bytes());
            }
            kind::MOBILITY => {
                *section = (0..model.cells()).map(mobility).flat_map(f32::to_le_bytes).collect();
            }
            kind::FIXED if afloat => section.clear(),
            kind::COARSE_INVERSE => {
                let basis = model.coarse_basis.unwrap();
                let mut bound = matrix(&model, pins.iter().copied(), &basis, &[]);
                for (function, row) in bound.iter_mut().enumerate() {
                    row[function] *= 1.0 + ROUNDING_ROOM * (basis.count as f64).sqrt();
                }
                let inverse = inverse(bound);
                let at = |i: usize, j: usize| {
                    if j < basis.count { inverse[i.max(j)][i.min(j)] as f32 } else { 0.0 }
                };
                let rows = (0..basis.count)
                    .flat_map(|i| (0..basis.blocks() * LANES).map(move |j| at(i, j)));
                *section = rows.flat_map(f32::to_le_bytes).collect();
            }
            _ => {}
        }
    }
    image(&contents)
}
