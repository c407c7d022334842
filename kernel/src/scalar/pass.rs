//! The link pass link by link, and the energy.

use super::part;
use crate::awake::SliceSet;
use crate::cell::Cell;
use crate::contact::Contact;
use crate::number::{Number, Sum};
use crate::pass::Links;
use crate::slice::cells_of;
use crate::two_float::TwoFloat;

/// See `Loops::pass`.
pub(crate) fn energy<N: Number>(
    links: Links<'_, '_>,
    awake: &SliceSet,
    v: &[Cell<N>],
    residual: &mut [Cell<N>],
    contacts: &[Contact<N>],
) -> TwoFloat {
    let tally = N::accumulate(links, awake, v, residual);
    links.drive(residual, contacts);
    let mut lanes = N::Energy::default();
    for slice in awake.iter(links.model.slice_count()) {
        for (lane, r) in part(residual, &cells_of(slice, links.model.cells())).enumerate() {
            lanes.add(lane, N::energy_term(r.w()));
        }
    }
    N::energy(&lanes, tally).times_power_of_two(0.125)
}
