//! One coarse level over the cells: hat functions whose Laplacian bound is inverted at the bake.
//!
//! A regular grid of trilinear hats lies over the rest shape; P holds their weights at the free
//! cells. With L the constant Laplacian of weight w / 2 that bounds the energy's curvature,
//! A = P' L P is one matrix for x, y and z. The bake stores B = (A + R)^-1 with a small positive
//! diagonal R, so that rounding has room. For a residual r the coarse direction is
//!
//! ```text
//! c = B P' r,   d = P c,   d' L d = c' A c <= r . d
//! ```
//!
//! which is the step that lowers the bound of the energy most among all moves of the hats, and
//! reaches at once what sweeps over links carry one ring of cells at a time.
//!
//! Cells held at run time must not move: their rows of P become zero. One held cell i, with p its
//! row of P, h its row of L P and l its diagonal of L, changes A by two matrices of rank one,
//!
//! ```text
//! A + (a a' - h h') / l,   a = l p - h
//! ```
//!
//! and B by the Sherman-Morrison-Woodbury formula: B - va va' + vh vh'. Both vectors are worked
//! out when the cells are chosen, never in a tick, first the one that adds, so every matrix on the
//! way is positive definite.
//!
//! Cost of a sweep: restriction and prolongation, 8 multiplications a cell and axis each; the
//! product, hats^2 for each axis; 4 hats a held cell and axis.

use crate::contact::Contact;
use crate::image::{HATS_MAX, ModelError, NO_HAT, Sections, kind};
use crate::model::Model;
use crate::number::Number;
use crate::simd::Work;
use crate::simd::octet::Octet;
use crate::take_out::without;
use crate::two_float::{LANES, Lanes, TwoFloat};

/// Eight values.
pub type Eight = [f32; LANES];

/// Room that the coarse level needs for `hats` hats and up to `held` held cells \[octets of f32\].
#[must_use]
pub const fn hats_room(hats: usize, held: usize) -> usize {
    hats.div_ceil(LANES) * (6 + 2 * held)
}

/// The hats of a model.
#[derive(Clone, Copy)]
pub(crate) struct Hats<'a> {
    pub count: usize,
    /// Starts of the boxes' pairs.
    pub rows: &'a [u32],
    /// Hats at the corners of each box.
    pub corners: &'a [[u16; LANES]],
    /// Cells of each pair.
    pub cells: &'a [[u16; 2]],
    /// Weights of each pair at the corners of its box: corner k of the first cell and of the
    /// second, in turn.
    pub weights: &'a [[Eight; 2]],
    /// Where each cell stands among the cells of the pairs.
    pub entry: &'a [u16],
    /// Rows of the inverse.
    pub inverse: &'a [Eight],
}

impl<'a> Hats<'a> {
    pub fn read(sections: &Sections<'a>, cells: usize) -> Result<Option<Self>, ModelError> {
        let Some(count) = sections.optional::<u32>(kind::HATS)? else { return Ok(None) };
        let count = match count {
            &[count] if (1..=HATS_MAX as u32).contains(&count) => count as usize,
            _ => return Err(ModelError::Value(kind::HATS, 0)),
        };
        let corners: &[[u16; LANES]] = sections.required(kind::HAT_CORNERS)?;
        let pairs: &[[u16; 2]] = sections.required(kind::HAT_CELLS)?;
        Ok(Some(Self {
            count,
            rows: sections.sized(kind::HAT_ROWS, corners.len() + 1)?,
            corners,
            cells: pairs,
            weights: sections.sized(kind::HAT_WEIGHTS, pairs.len())?,
            entry: sections.sized(kind::HAT_ENTRY, cells)?,
            inverse: sections.sized(kind::HAT_INVERSE, count * count.div_ceil(LANES))?,
        }))
    }

    /// Octets of a vector over the hats.
    #[inline(always)]
    pub fn octets(&self) -> usize {
        // A model has at least one hat; the compiler is to know it too.
        self.count.div_ceil(LANES).max(1)
    }

    /// Length of a row of the inverse with its padding.
    pub fn stride(&self) -> usize {
        self.octets() * LANES
    }

    /// One element of the inverse; 0 beyond it.
    pub fn inverse_at(&self, row: usize, column: usize) -> f32 {
        let octet = self.inverse.get(row * self.octets() + column / LANES);
        octet.and_then(|octet| octet.get(column % LANES)).copied().unwrap_or(0.0)
    }

    /// Weight of an entry at a corner of its box.
    pub fn weight(&self, entry: usize, corner: usize) -> f32 {
        let octet = self.weights.get(entry / 2).and_then(|pair| pair.get(corner / 4));
        octet.and_then(|octet| octet.get(corner % 4 * 2 + entry % 2)).copied().unwrap_or(0.0)
    }

    /// Row of P of a cell: its hats with their weights.
    pub fn row_of(self, cell: usize) -> impl Iterator<Item = (usize, f32)> + use<'a> {
        let entry = self.entry.get(cell).copied().filter(|&entry| entry != NO_HAT);
        let parts = entry.and_then(|entry| {
            let entry = usize::from(entry);
            let at_box = self.rows.partition_point(|&start| start as usize <= entry / 2);
            Some((self.corners.get(at_box.checked_sub(1)?)?, entry))
        });
        parts.into_iter().flat_map(move |(corners, entry)| {
            let hats = corners.iter().enumerate().filter(|&(_, &hat)| hat != NO_HAT);
            hats.map(move |(corner, &hat)| (usize::from(hat), self.weight(entry, corner)))
        })
    }
}

/// The vectors of one axis or of one correction, cut from the room.
#[inline(always)]
pub(crate) fn vector(room: &[Eight], octets: usize, index: usize) -> &[Eight] {
    room.get(index * octets..(index + 1) * octets).unwrap_or(&[])
}

/// How a solution leaves the held cells alone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Coarse {
    /// By the corrections of so many held cells, which stand in the room.
    Corrected(usize),
    /// Without so many hats, whose factor stands in the room.
    Without(u16),
}

/// c = B g, so that the held cells are left alone; gives g . c.
pub(crate) struct Solve<'a, 'm> {
    pub hats: Hats<'m>,
    pub room: &'a mut [Eight],
    pub coarse: Coarse,
}

impl Work for Solve<'_, '_> {
    type Output = TwoFloat;

    #[inline(always)]
    fn run<V: Octet>(self) -> TwoFloat {
        let octets = self.hats.octets();
        let Some((g, rest)) = self.room.split_at_mut_checked(3 * octets) else {
            return TwoFloat::ZERO;
        };
        let Some((c, corrections)) = rest.split_at_mut_checked(3 * octets) else {
            return TwoFloat::ZERO;
        };
        let mut block = 0;
        while block + 2 <= octets {
            columns::<V, 2>(self.hats.inverse, octets, block, g, c);
            block += 2;
        }
        if block < octets {
            columns::<V, 1>(self.hats.inverse, octets, block, g, c);
        }
        match self.coarse {
            Coarse::Corrected(held) => {
                let vectors = corrections.chunks_exact(octets).take(2 * held);
                for (index, along) in vectors.enumerate() {
                    correct::<V>(along, octets, if index % 2 == 0 { -1.0 } else { 1.0 }, g, c);
                }
            }
            Coarse::Without(hats) if !without::<V>(&self.hats, corrections, hats.into(), c) => {
                return TwoFloat::ZERO;
            }
            Coarse::Without(_) => {}
        }
        let mut product = Lanes::ZERO;
        for octet in 0..octets {
            let mut term = V::splat(0.0);
            for axis in 0..3 {
                let at = axis * octets + octet;
                if let (Some(g), Some(c)) = (g.get(at), c.get(at)) {
                    term = term.plus(V::load(g).times(V::load(c)));
                }
            }
            product.add(term);
        }
        product.total()
    }
}

/// N octets of c = B g on all axes, summed over the hats in ascending order.
#[inline(always)]
fn columns<V: Octet, const N: usize>(
    inverse: &[Eight],
    octets: usize,
    block: usize,
    g: &[Eight],
    c: &mut [Eight],
) {
    let mut sums = [[V::splat(0.0); 3]; N];
    let axis = |axis: usize| vector(g, octets, axis).as_flattened();
    let g = axis(0).iter().zip(axis(1)).zip(axis(2));
    for (row, ((&x, &y), &z)) in inverse.chunks_exact(octets).zip(g) {
        let here = row.get(block..).and_then(|row| row.first_chunk::<N>());
        let Some(here) = here else { continue };
        let (x, y, z) = (V::splat(x), V::splat(y), V::splat(z));
        for ([sum_x, sum_y, sum_z], b) in sums.iter_mut().zip(here) {
            let b = V::load(b);
            *sum_x = sum_x.plus(b.times(x));
            *sum_y = sum_y.plus(b.times(y));
            *sum_z = sum_z.plus(b.times(z));
        }
    }
    for (at, sums) in sums.into_iter().enumerate() {
        for (axis, sum) in sums.into_iter().enumerate() {
            if let Some(slot) = c.get_mut(axis * octets + block + at) {
                sum.store(slot);
            }
        }
    }
}

/// c += sign v (v . g) on all axes.
#[inline(always)]
fn correct<V: Octet>(along: &[Eight], octets: usize, sign: f32, g: &[Eight], c: &mut [Eight]) {
    for axis in 0..3 {
        let mut lanes = V::splat(0.0);
        for (v, g) in along.iter().zip(vector(g, octets, axis)) {
            lanes = lanes.plus(V::load(v).times(V::load(g)));
        }
        let mut sums = [0.0; LANES];
        lanes.store(&mut sums);
        let [a, b, c0, d, e, f, h, i] = sums;
        let factor = V::splat(sign * (((a + e) + (c0 + h)) + ((b + f) + (d + i))));
        let c = c.get_mut(axis * octets..(axis + 1) * octets).unwrap_or(&mut []);
        for (v, c) in along.iter().zip(c) {
            V::load(c).plus(V::load(v).times(factor)).store(c);
        }
    }
}

/// Works out the corrections of the inverse for cells that the tool will hold, into the room.
///
/// Cost: 2 hats^2 a cell and more with every cell; outside the tick.
pub(crate) fn hold<N: Number>(
    model: &Model<'_>,
    hats: &Hats<'_>,
    room: &mut [Eight],
    held: &[Contact<N>],
) {
    let octets = hats.octets();
    let Some((scratch, rest)) = room.split_at_mut_checked(6 * octets) else { return };
    for (index, contact) in held.iter().enumerate() {
        let Some((earlier, later)) = rest.split_at_mut_checked(2 * index * octets) else { return };
        let Some((adding, taking)) = later.split_at_mut_checked(octets) else { return };
        let Some(taking) = taking.get_mut(..octets) else { return };
        let cell = contact.cell();
        let diagonal = 0.5 * model.cell_weight(cell);
        let Some(row) = scratch.get_mut(..octets) else { return };
        row.fill([0.0; LANES]);
        // a = l p - h, which is the neighbours' share of h.
        let add = |to: &mut [Eight], hat: usize, term: f32| {
            if let Some(slot) = to.as_flattened_mut().get_mut(hat) {
                *slot += term;
            }
        };
        for (link, other) in model.neighbours(cell) {
            let zeroed = held.iter().take(index).any(|contact| contact.cell() == other);
            for (hat, weight) in hats.row_of(other).filter(|_| !zeroed) {
                add(row, hat, 0.5 * model.link_weight(link) * weight);
            }
        }
        apply(hats, earlier, row, adding);
        scale(adding, f64::from(diagonal) + dot(row, adding));
        // h = l p - a.
        for slot in row.as_flattened_mut() {
            *slot = -*slot;
        }
        for (hat, weight) in hats.row_of(cell) {
            add(row, hat, diagonal * weight);
        }
        apply(hats, earlier, row, taking);
        let share = -dot(adding, row) as f32;
        for (slot, along) in taking.as_flattened_mut().iter_mut().zip(adding.as_flattened()) {
            *slot += share * along;
        }
        let left = f64::from(diagonal) - dot(row, taking);
        // Rounding must not make the matrix indefinite; a larger rest is a shorter step.
        scale(taking, left.max(1.0e-6 * f64::from(diagonal)));
    }
}

/// v / sqrt(norm); nothing where the norm is not positive.
fn scale(vector: &mut [Eight], norm: f64) {
    let factor = if norm > 0.0 { 1.0 / crate::sqrt::sqrt(norm as f32) } else { 0.0 };
    for slot in vector.as_flattened_mut() {
        *slot *= factor;
    }
}

/// The inverse with the corrections of `earlier` cells, times a vector.
fn apply(hats: &Hats<'_>, earlier: &[Eight], of: &[Eight], product: &mut [Eight]) {
    let octets = hats.octets();
    product.fill([0.0; LANES]);
    for (row, &factor) in hats.inverse.chunks_exact(octets).zip(of.as_flattened()) {
        if factor != 0.0 {
            for (slot, b) in product.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
                *slot += factor * b;
            }
        }
    }
    for (index, along) in earlier.chunks_exact(octets).enumerate() {
        let share = dot(along, of) as f32;
        let share = if index % 2 == 0 { -share } else { share };
        for (slot, along) in product.as_flattened_mut().iter_mut().zip(along.as_flattened()) {
            *slot += share * along;
        }
    }
}

fn dot(a: &[Eight], b: &[Eight]) -> f64 {
    let terms = a.as_flattened().iter().zip(b.as_flattened());
    terms.fold(0.0, |sum, (&a, &b)| sum + f64::from(a) * f64::from(b))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::simd::{VectorUnit, run};
    use std::vec;
    use std::vec::Vec;

    /// `chaincell bake box:7x7x5x0.01 --alpha 0.03 --hats 2.5`.
    pub(crate) static CUBE: &[u8] = crate::include_model!("../../tests/data/box7.chaincell");
    /// The bake's share of the diagonal, over the root of the number of hats.
    pub(crate) const ROUNDING_ROOM: f64 = 1.0e-3;

    /// P' L P in double precision, the rows of `held` cells zeroed.
    pub(crate) fn matrix(model: &Model<'_>, hats: &Hats<'_>, held: &[Contact]) -> Vec<Vec<f64>> {
        let row = |cell: usize| -> Vec<(usize, f64)> {
            let is_held = held.iter().any(|contact| contact.cell() == cell);
            let row = hats.row_of(cell).filter(|_| !is_held);
            row.map(|(hat, weight)| (hat, f64::from(weight))).collect()
        };
        let mut matrix = vec![vec![0.0; hats.count]; hats.count];
        for i in 0..model.cells() {
            for link in model.row(i) {
                let mut difference = row(i);
                let j = usize::from(model.upper[link]);
                difference.extend(row(j).into_iter().map(|(hat, weight)| (hat, -weight)));
                for &(a, x) in &difference {
                    for &(b, y) in &difference {
                        matrix[a][b] += 0.5 * f64::from(model.link_weight(link)) * x * y;
                    }
                }
            }
        }
        matrix
    }

    /// Solves for a right-hand side in the room; returns both sides, axis by axis.
    fn solved(model: &Model<'_>, held: &[Contact]) -> (Vec<[f64; 3]>, Vec<[f64; 3]>, f64) {
        let hats = model.hats.unwrap();
        let octets = hats.octets();
        let mut room = vec![[0.0_f32; LANES]; hats_room(hats.count, held.len())];
        hold(model, &hats, &mut room, held);
        for axis in 0..3 {
            for hat in 0..hats.count {
                let seed = (7 * hat + 3 * axis) as f32 * 0.618_034;
                room[axis * octets + hat / LANES][hat % LANES] = seed % 1.0 - 0.5;
            }
        }
        let solve = Solve { hats, room: &mut room, coarse: Coarse::Corrected(held.len()) };
        let product = run(VectorUnit::find(), solve);
        let side = |from: usize| -> Vec<[f64; 3]> {
            let at = |hat: usize, axis: usize| {
                f64::from(room[(from + axis) * octets + hat / LANES][hat % LANES])
            };
            (0..hats.count).map(|hat| [0, 1, 2].map(|axis| at(hat, axis))).collect()
        };
        (side(0), side(3), f64::from(product.hi))
    }

    #[test]
    fn held_cells_are_corrected_for_exactly() {
        let model = Model::from_bytes(CUBE).unwrap();
        let hats = model.hats.unwrap();
        let whole = matrix(&model, &hats, &[]);
        let free: Vec<u16> = (0..model.cells() as u16).filter(|&c| !model.is_fixed(c)).collect();
        for count in [0, 1, 2, 7, 30, free.len()] {
            let held: Vec<Contact> = free
                .iter()
                .step_by((free.len() / count.max(1)).max(1))
                .take(count)
                .copied()
                .map(Contact::new)
                .collect();
            let (g, c, product) = solved(&model, &held);
            let masked = matrix(&model, &hats, &held);
            let mut exact = 0.0;
            for hat in 0..hats.count {
                for axis in 0..3 {
                    let room = ROUNDING_ROOM * (hats.count as f64).sqrt();
                    let own = room * whole[hat][hat] * c[hat][axis];
                    let sum: f64 =
                        (0..hats.count).map(|other| masked[hat][other] * c[other][axis]).sum();
                    assert!(
                        (sum + own - g[hat][axis]).abs() < 2e-3,
                        "{count} held, hat {hat}: {sum} and {own} for {}",
                        g[hat][axis]
                    );
                    exact += g[hat][axis] * c[hat][axis];
                    // The bound behind the guard: c' A c <= g . c.
                    assert!(own * c[hat][axis] >= 0.0);
                }
            }
            let curved: f64 = (0..hats.count * hats.count)
                .map(|at| (at / hats.count, at % hats.count))
                .flat_map(|(a, b)| (0..3).map(move |axis| (a, b, axis)))
                .map(|(a, b, axis)| c[a][axis] * masked[a][b] * c[b][axis])
                .sum();
            assert!(curved <= product, "{count} held: {curved} above {product}");
            assert!((product - exact).abs() <= 1e-5 * exact, "{product} {exact}");
        }
    }
}
