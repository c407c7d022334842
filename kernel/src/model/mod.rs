//! The model: everything about a body that never changes, read in place from its image.
//!
//! - [`image`]: the format, a flat file of sections.
//! - `read`: [`Model`] and what it borrows from the image; `validate` checks all of it once.
//! - `query`: the properties of a model's body; `query_cut`: those of one that can be cut.
//! - `coarse_basis`: the basis of the coarse level, with the inverse of its matrix.
//! - `sides`: two-sided basis functions of a body that is cut.
//! - `parts`: the division of a large body among threads.
//! - `nodal`: the numbers of nodal shapes.
//! - `relaxing_links`: links that relax.
//! - `stiffening`: sets of bands on the links of nodal shapes.
//! - `branches`: the part of a body's stiffness that fades with time.
//! - `cuttable`: the tetrahedra that a blade may part, and the spare cells.
//! - `tearing`: the limit at which a body tears by itself.
//! - `surface`: the contact stiffness of the surface under tools; `opened`: faces that a cut has opened;
//!   `lips`: its sides where they lie on each other.
//! - `terms`: the static list of the energy terms besides the links, and the data of each.
//! - `embedded_mesh`: nodes of a finer mesh that move with the cells.

mod body;
pub(crate) mod branches;
pub(crate) mod coarse_basis;
#[cfg_attr(not(feature = "cut"), path = "uncuttable.rs")]
pub(crate) mod cuttable;
mod embedded_mesh;
pub mod image;
mod layout;
#[cfg(feature = "cut")]
pub(crate) mod lips;
pub(crate) mod loose;
#[cfg(feature = "nodal")]
pub(crate) mod nodal;
#[cfg_attr(not(feature = "cut"), path = "unopened.rs")]
pub(crate) mod opened;
pub(crate) mod others;
pub mod parts;
#[cfg(test)]
pub(crate) mod pin;
mod query;
mod query_cut;
mod read;
#[cfg(feature = "relax")]
pub(crate) mod relaxing_links;
pub(crate) mod sides;
#[cfg(feature = "nodal")]
pub(crate) mod stiffening;
pub(crate) mod surface;
pub(crate) mod tearing;
pub(crate) mod terms;
mod validate;

use core::ops::Range;

pub use body::Model;
pub(crate) use body::Slices;

use crate::number::cell::{dot, sub};
use crate::number::sqrt::sqrt;
#[cfg(feature = "nodal")]
use crate::number::two_float::LANES;

/// Largest coordinate of a position that a state may have [mean link lengths].
pub const COORDINATE_MAX: f32 = 1.0e6;

/// Returns the rest length of a link between two stored rest positions, computed as in the sweep.
#[must_use]
pub fn rest_length(a: [f32; 3], b: [f32; 3]) -> f32 {
    let difference = sub(b, a);
    sqrt(dot(difference, difference))
}

/// Returns `rows[at]..rows[at + 1]`, an empty range beyond the end.
#[inline]
pub(crate) fn range(rows: &[u32], at: usize) -> Range<usize> {
    match rows.get(at..).and_then(|rows| rows.first_chunk()) {
        Some(&[start, end]) => start as usize..end as usize,
        None => 0..0,
    }
}

/// Returns the half-links of a cell without padding: group and other end.
#[cfg(feature = "nodal")]
#[inline(always)]
pub(crate) fn slots_of<'a>(
    rows: &[u32],
    ids: &'a [[u16; LANES]],
    cell: usize,
) -> impl Iterator<Item = (usize, usize)> + use<'a> {
    range(rows, cell / LANES).filter_map(move |group| {
        let other = usize::from(*ids.get(group)?.get(cell % LANES)?);
        (other != cell).then_some((group, other))
    })
}

/// Links a model image into flash with the alignment that [`Model::from_bytes`] asks for.
///
/// The path is relative to the file that contains the macro. Returns a `&'static [u8]`.
///
/// ```
/// use chaincell_kernel::include_model;
///
/// static IMAGE: &[u8] =
///     include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// assert!(IMAGE.as_ptr().addr().is_multiple_of(16));
/// ```
#[macro_export]
macro_rules! include_model {
    ($path:expr $(,)?) => {{
        #[repr(C, align(16))]
        struct Aligned<Bytes: ?Sized>(Bytes);
        static IMAGE: &Aligned<[u8]> = &Aligned(*include_bytes!($path));
        &IMAGE.0
    }};
}
