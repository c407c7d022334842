//! Corrections of an elastic level for cells that the tool holds.
//!
//! Held cells do not follow their basis functions, so a direction P c is cut off at them. The cut is a
//! displacement of only the held cells, resisted by their local part D of K. The level that includes it is
//! ```text
//! (B^-1 + P_h' D P_h)^-1 = B - sum of v v',   P_h' D P_h = U U'
//! ```
//!
//! Each column u of U, one for a basis function at a held cell and an axis, gives one v: B u with the earlier
//! corrections over sqrt(1 + u . B u). They are computed when the cells are chosen.
//!
//! If few cells of a compact body are held, the resistance of the level exceeds that of the cut, and nothing
//! is corrected. A slender body yields so much at its end that a direction would meet the cut alone, more so
//! the less its volume yields: each pass would be discarded.

use super::elastic::elastic_room;
use super::held::{apply, dot};
use super::vector;
use crate::energy::held::Contact;
use crate::model::Model;
use crate::model::coarse_basis::CoarseBasis;
use crate::number::Number;
use crate::number::sqrt::sqrt;
use crate::number::two_float::{Eight, LANES};
use crate::solver::loops::scalar::track::factor;

/// Largest ratio of the cuts' energy at all held cells to that of the softest basis function without a
/// correction.
const BEARABLE: f32 = 20.0;
/// The local part of a direction, in mean diagonal elements of K, as in the bake.
const OWN_PART: f32 = 0.7;
/// Pivots of `P_h' D P_h` below this share of their element are 0.
const LEAST: f32 = 1.0e-4;
/// A cut that adds less than this share to the matrix is not corrected.
const SLIGHT: f64 = 0.1;

/// Memory that the coarse level of nodal shapes needs for `functions` basis functions if a tool holds up to
/// `held` cells whose cuts are corrected \[blocks of eight `f32`\].
///
/// ```
/// use chaincell_kernel::{Tissue, Track, elastic_held_room, elastic_room, term_states};
///
/// /// As with [`elastic_room`], and a tool may hold nine cells at the end of a slender body.
/// type Body = Tissue<512, Track<{ elastic_held_room(48, 9) }>, 9, { term_states(512) }>;
/// assert_eq!(32 * elastic_room(48), 1_728); // [bytes]
/// assert_eq!(32 * elastic_held_room(48, 9), 26_496); // [bytes]
/// ```
#[must_use]
pub const fn elastic_held_room(functions: usize, held: usize) -> usize {
    let (rank, rows) = (least(functions, held), least(functions, LANES * held));
    elastic_room(functions) + functions.div_ceil(LANES) * (9 * rank + rows)
}

const fn least(a: usize, b: usize) -> usize {
    if a < b { a } else { b }
}

/// D of a cell: its mean diagonal element of K.
fn own_part(model: &Model<'_>, factors: &[f32], cell: usize) -> f32 {
    let mobility = model.mobility.get(cell).copied().unwrap_or(0.0);
    let length = mobility * factor(factors, cell);
    if length > 0.0 { OWN_PART / length } else { 0.0 }
}

/// Returns true if the cuts at `held` held cells have to be corrected.
pub(crate) fn is_corrected(model: &Model<'_>, basis: &CoarseBasis<'_>, held: usize) -> bool {
    let Some(level) = basis.elastic().filter(|_| held > 0) else { return false };
    let (mut most, stride) = (0.0, basis.stride());
    for (function, &cell) in level.turns.iter().enumerate() {
        let cell = usize::from(cell);
        let weight = basis.row_of(cell).find(|(at, _)| *at == function).map_or(0.0, |(_, w)| w);
        let own = own_part(model, level.factors, cell) * weight * weight;
        for axis in 0..3 {
            let row = axis * stride + function;
            let moved = own * basis.inverse_at(row, row);
            most = if moved > most { moved } else { most };
        }
    }
    held as f32 * most > BEARABLE
}

/// Computes the corrections for cells that the tool will hold, and stores them after the level's vectors.
/// Returns their number.
///
/// Cost: 9 n^2 for a correction, and more with every further one; outside the tick.
pub(crate) fn hold<N: Number>(
    model: &Model<'_>,
    basis: &CoarseBasis<'_>,
    room: &mut [Eight],
    held: &[Contact<N>],
) -> usize {
    let blocks = basis.blocks();
    let Some(level) = basis.elastic().filter(|_| is_corrected(model, basis, held.len())) else {
        return 0;
    };
    // Divide the memory: scratch vectors, corrections, rows of the matrix.
    let most = 3 * least(basis.count, held.len());
    let Some((scratch, rest)) = room.split_at_mut_checked(9 * blocks) else { return 0 };
    let Some(rest) = rest.get_mut(3 * basis.side_blocks()..) else { return 0 };
    let Some((vectors, rows)) = rest.split_at_mut_checked(3 * most * blocks) else { return 0 };
    let Some((column, scratch)) = scratch.split_at_mut_checked(3 * blocks) else { return 0 };
    let Some((numbers, scratch)) = scratch.split_at_mut_checked(blocks) else { return 0 };
    let Some((marks, scratch)) = scratch.split_at_mut_checked(blocks) else { return 0 };
    let Some(diagonals) = scratch.get_mut(..blocks) else { return 0 };
    // Assemble `P_h' D P_h`.
    let touched = number(basis, held, numbers.as_flattened_mut(), marks.as_flattened_mut());
    let (numbers, marks) = (numbers.as_flattened(), marks.as_flattened());
    let diagonals = diagonals.as_flattened_mut();
    let mut matrix = Rows { rows, blocks, numbers, diagonals };
    matrix.rows.fill([0.0; LANES]);
    for cell in held.iter().map(Contact::cell) {
        let own = own_part(model, level.factors, cell);
        for (one, weight) in basis.row_of(cell).filter(|(_, weight)| *weight > 0.0) {
            let row = marks.get(one).map_or(0, |&row| row as usize);
            for (other, share) in basis.row_of(cell) {
                if let Some(slot) = matrix.row(row).get_mut(other) {
                    *slot += own * weight * share;
                }
            }
        }
    }
    matrix.note_diagonals(touched);
    // Factorise it row by row; each row gives up to three corrections.
    let mut count = 0;
    for row in 0..touched {
        if !matrix.reduce(row, touched) {
            continue;
        }
        for axis in 0..3 {
            column.fill([0.0; LANES]);
            let part = column.as_flattened_mut().iter_mut().skip(axis * basis.stride());
            part.zip(matrix.row(row)).for_each(|(slot, value)| *slot = *value);
            let Some((earlier, later)) = vectors.split_at_mut_checked(3 * count * blocks) else {
                return count;
            };
            let Some(new) = later.get_mut(..3 * blocks) else { return count };
            apply(basis, earlier, false, column, new);
            let rise = dot(column, new);
            if rise > SLIGHT {
                let share = 1.0 / sqrt((1.0 + rise) as f32);
                new.as_flattened_mut().iter_mut().for_each(|slot| *slot *= share);
                count += 1;
            }
        }
    }
    count
}

/// Indexes the basis functions at held cells: `numbers` lists them, `marks` has the index of each. Returns
/// their number.
fn number<N: Number>(
    basis: &CoarseBasis<'_>,
    held: &[Contact<N>],
    numbers: &mut [f32],
    marks: &mut [f32],
) -> usize {
    marks.fill(0.0);
    for (function, weight) in held.iter().flat_map(|contact| basis.row_of(contact.cell())) {
        if let Some(mark) = marks.get_mut(function).filter(|_| weight > 0.0) {
            *mark = 1.0;
        }
    }
    let mut count = 0;
    for (function, mark) in marks.iter_mut().enumerate().filter(|(_, mark)| **mark > 0.0) {
        if let Some(slot) = numbers.get_mut(count) {
            (*slot, *mark) = (function as f32, count as f32);
            count += 1;
        }
    }
    count
}

/// `P_h' D P_h`: a row for each basis function at a held cell; they become the rows of U'.
struct Rows<'a> {
    rows: &'a mut [Eight],
    blocks: usize,
    numbers: &'a [f32],
    /// The original diagonal elements.
    diagonals: &'a mut [f32],
}

impl Rows<'_> {
    fn row(&mut self, at: usize) -> &mut [f32] {
        let Self { rows, blocks, .. } = self;
        let row = rows.get_mut(at * *blocks..(at + 1) * *blocks);
        row.unwrap_or(&mut []).as_flattened_mut()
    }

    fn function(&self, at: usize) -> usize {
        self.numbers.get(at).map_or(0, |&function| function as usize)
    }

    fn note_diagonals(&mut self, count: usize) {
        for at in 0..count {
            let function = self.function(at);
            let own = self.row(at).get(function).copied().unwrap_or(0.0);
            if let Some(slot) = self.diagonals.get_mut(at) {
                *slot = own;
            }
        }
    }

    /// Turns a row into one of U' and subtracts it from the later ones. Returns false for a zero row.
    fn reduce(&mut self, at: usize, count: usize) -> bool {
        let own = self.function(at);
        let whole = self.diagonals.get(at).copied().unwrap_or(0.0);
        let row = self.row(at);
        let pivot = row.get(own).copied().unwrap_or(0.0);
        if pivot.is_nan() || pivot <= LEAST * whole {
            return false;
        }
        let root = 1.0 / sqrt(pivot);
        // The elements before the diagonal are rounding errors.
        row.iter_mut().take(own).for_each(|slot| *slot = 0.0);
        row.iter_mut().for_each(|slot| *slot *= root);
        let blocks = self.blocks;
        for later in at + 1..count {
            let function = self.function(later);
            let Some((above, below)) = self.rows.split_at_mut_checked(later * blocks) else {
                return true;
            };
            let row = vector(above, blocks, at).as_flattened();
            let share = row.get(function).copied().unwrap_or(0.0);
            let below = below.as_flattened_mut().iter_mut();
            below.zip(row).for_each(|(slot, value)| *slot -= share * value);
        }
        true
    }
}

#[cfg(all(test, feature = "nodal"))]
mod tests {
    use super::*;
    use crate::backend::VectorUnit;
    use crate::backend::team::Team;
    use crate::solver::coarse::elastic::ElasticSolve;
    use std::vec;
    use std::vec::Vec;

    /// `chaincell bake box:6x6x4x0.01 --young-pa 5000` and so on.
    static TISSUE: &[u8] = crate::include_model!("../../../../tests/data/tissue6.chaincell");

    fn held(model: &Model<'_>, count: usize) -> Vec<Contact> {
        let free = (0..model.cells() as u16).rev().filter(|&cell| !model.is_fixed(cell));
        free.take(count).map(Contact::new).collect()
    }

    /// With `c = (B^-1 + P_h' D P_h)^-1 g`, `c + B P_h' D P_h c` is B g.
    #[test]
    fn held_cells_are_corrected_for() {
        let model = Model::from_bytes(TISSUE).unwrap();
        let basis = model.coarse_basis.unwrap();
        let factors = basis.elastic().unwrap().factors;
        let held = held(&model, 36);
        let (blocks, stride) = (basis.blocks(), basis.stride());
        let mut room = vec![[0.0_f32; LANES]; elastic_held_room(basis.count, held.len())];
        let corrections = hold(&model, &basis, &mut room, &held);
        assert!(corrections > 12 && corrections <= 3 * basis.count, "{corrections}");
        for axis in 0..3 {
            for function in 0..basis.count {
                let seed = (7 * function + 3 * axis) as f32 * 0.618_034;
                room.as_flattened_mut()[axis * stride + function] = seed % 1.0 - 0.5;
            }
        }
        let solved = |room: &mut [Eight], corrections| {
            let solve = ElasticSolve { basis, room, corrections, touch: None };
            solve.solve(VectorUnit::find(), Team::ALONE, 1);
            room[3 * blocks..6 * blocks].as_flattened().to_vec()
        };
        let plain = solved(&mut room, 0);
        let c = solved(&mut room, corrections);
        let mut resisted = vec![0.0; 3 * stride];
        for cell in held.iter().map(Contact::cell) {
            for (axis, (one, weight)) in
                (0..3).flat_map(|axis| basis.row_of(cell).map(move |row| (axis, row)))
            {
                let moved: f32 = basis.row_of(cell).map(|(at, w)| w * c[axis * stride + at]).sum();
                resisted[axis * stride + one] += own_part(&model, factors, cell) * weight * moved;
            }
        }
        room[..3 * blocks].as_flattened_mut().copy_from_slice(&resisted);
        let back = solved(&mut room, 0);
        let largest = plain.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        for (at, ((c, back), plain)) in c.iter().zip(&back).zip(&plain).enumerate() {
            assert!((c + back - plain).abs() < 0.1 * largest, "{at}: {c} + {back}, {plain}");
        }
        let resisted = |c: &[f32]| c.iter().map(|x| x * x).sum::<f32>();
        assert!(resisted(&c) < 0.9 * resisted(&plain));
    }

    #[test]
    fn few_cells_of_a_compact_body_need_no_correction() {
        let model = Model::from_bytes(TISSUE).unwrap();
        let basis = model.coarse_basis.unwrap();
        for count in [0, 1, 3, 7] {
            assert!(!is_corrected(&model, &basis, count), "{count}");
            let mut room = vec![[0.0_f32; LANES]; elastic_room(basis.count)];
            assert_eq!(hold(&model, &basis, &mut room, &held(&model, count)), 0);
        }
        assert!(is_corrected(&model, &basis, 36));
    }

    #[test]
    fn the_room_is_what_the_page_says() {
        assert_eq!(elastic_held_room(20, 0), elastic_room(20));
        assert_eq!(elastic_held_room(20, 2), elastic_room(20) + 3 * (18 + 16));
        assert_eq!(elastic_held_room(20, 25), elastic_room(20) + 3 * (180 + 20));
    }
}
