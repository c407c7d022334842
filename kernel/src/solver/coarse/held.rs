//! Corrections of the inverse for cells that the tool holds.

use crate::energy::held::Contact;
use crate::model::Model;
use crate::model::coarse_basis::CoarseBasis;
use crate::number::Number;
use crate::number::sqrt::sqrt;
use crate::number::two_float::{Eight, LANES};

/// Memory that the coarse level needs for `functions` basis functions and up to `held` held cells \[blocks of
/// eight `f32`\].
///
/// ```
/// # use chaincell_kernel::{Model, Network, ResetError, Settings, Tissue, Track, include_model};
/// use chaincell_kernel::coarse_room;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/box5.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// assert_eq!(model.coarse_functions(), 27); // basis functions of this box
/// let mut tissue = Tissue::<128, Track<{ coarse_room(27, 2) }>>::new(); // up to two held cells
/// assert_eq!(tissue.reset(&network), Ok(()));
/// let refused = Tissue::<128, Track>::new().reset(&network);
/// assert!(matches!(refused, Err(ResetError::CoarseRoom { room: 0, .. })));
/// assert_eq!(32 * coarse_room(48, 2), 48 * 10 * 4); // [bytes]
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub const fn coarse_room(functions: usize, held: usize) -> usize {
    functions.div_ceil(LANES) * (6 + 2 * held)
}

/// Computes the corrections of the inverse for cells that the tool will hold, and stores them in the coarse
/// memory.
///
/// Cost: 2 n^2 per cell, and more with every further cell; outside the tick.
pub(crate) fn hold<N: Number>(
    model: &Model<'_>,
    basis: &CoarseBasis<'_>,
    room: &mut [Eight],
    held: &[Contact<N>],
) {
    let blocks = basis.blocks();
    let Some((scratch, rest)) = room.split_at_mut_checked(6 * blocks) else { return };
    for (index, contact) in held.iter().enumerate() {
        let Some((earlier, later)) = rest.split_at_mut_checked(2 * index * blocks) else { return };
        let Some((adding, taking)) = later.split_at_mut_checked(blocks) else { return };
        let Some(taking) = taking.get_mut(..blocks) else { return };
        let cell = contact.cell();
        let diagonal = 0.5 * model.cell_bound(cell);
        let Some(row) = scratch.get_mut(..blocks) else { return };
        row.fill([0.0; LANES]);
        // a = l p - h, the neighbours' share of h.
        let add = |to: &mut [Eight], function: usize, term: f32| {
            if let Some(slot) = to.as_flattened_mut().get_mut(function) {
                *slot += term;
            }
        };
        let mut couple = |other: usize, factor: f32| {
            let zeroed = held.iter().take(index).any(|contact| contact.cell() == other);
            for (function, weight) in basis.row_of(other).filter(|_| !zeroed) {
                add(row, function, factor * weight);
            }
        };
        for (link, other) in model.neighbours(cell) {
            couple(other, 0.5 * model.link_weight(link));
        }
        apply(basis, earlier, true, row, adding);
        scale(adding, f64::from(diagonal) + dot(row, adding));
        // h = l p - a.
        for slot in row.as_flattened_mut() {
            *slot = -*slot;
        }
        for (function, weight) in basis.row_of(cell) {
            add(row, function, diagonal * weight);
        }
        apply(basis, earlier, true, row, taking);
        let share = -dot(adding, row) as f32;
        for (slot, along) in taking.as_flattened_mut().iter_mut().zip(adding.as_flattened()) {
            *slot += share * along;
        }
        let left = f64::from(diagonal) - dot(row, taking);
        // Rounding must not make the matrix indefinite; a larger remainder is a shorter step.
        scale(taking, left.max(1.0e-6 * f64::from(diagonal)));
    }
}

/// v / sqrt(norm); 0 if the norm is not positive.
fn scale(vector: &mut [Eight], norm: f64) {
    let factor = if norm > 0.0 { 1.0 / sqrt(norm as f32) } else { 0.0 };
    for slot in vector.as_flattened_mut() {
        *slot *= factor;
    }
}

/// The inverse with `earlier` corrections, times a vector; in `pairs` every second correction is added.
pub(super) fn apply(
    basis: &CoarseBasis<'_>,
    earlier: &[Eight],
    pairs: bool,
    of: &[Eight],
    product: &mut [Eight],
) {
    let blocks = basis.row_blocks();
    product.fill([0.0; LANES]);
    for (row, &factor) in basis.inverse.chunks_exact(blocks).zip(of.as_flattened()) {
        if factor != 0.0 {
            for (slot, b) in product.as_flattened_mut().iter_mut().zip(row.as_flattened()) {
                *slot += factor * b;
            }
        }
    }
    for (index, along) in earlier.chunks_exact(blocks).enumerate() {
        let share = dot(along, of) as f32;
        let share = if pairs && index % 2 == 1 { share } else { -share };
        for (slot, along) in product.as_flattened_mut().iter_mut().zip(along.as_flattened()) {
            *slot += share * along;
        }
    }
}

pub(super) fn dot(a: &[Eight], b: &[Eight]) -> f64 {
    let terms = a.as_flattened().iter().zip(b.as_flattened());
    terms.fold(0.0, |sum, (&a, &b)| sum + f64::from(a) * f64::from(b))
}
