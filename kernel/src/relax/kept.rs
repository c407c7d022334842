//! Parts of a body that relaxes that a snapshot contains: clock and memory.

use super::body::RelaxingBody;
use super::memory::sizes;
use crate::model::Model;
use crate::model::image::BRANCHES_MAX;
use crate::number::kept::Pass;
use crate::number::words::{Double, number};

/// Passes over the memory of a body that relaxes; `model` is such a one.
pub(crate) fn keep(words: &mut [u32], model: &Model<'_>, pass: &mut Pass<'_>) {
    let room = words.len();
    let Some(mut body) = RelaxingBody::of(words, model) else {
        let needed = sizes(model).map_or(0, |sizes| sizes.iter().sum());
        return pass.lacks(needed, room);
    };
    pass.slice(body.arrays.since, BRANCHES_MAX);
    pass.slice(body.arrays.taken, BRANCHES_MAX);
    let is_energy = |&words: &Double| number(words).is_finite();
    pass.slice_if(body.arrays.remembered, |_, words| is_energy(words));
    pass.slice_if(core::slice::from_mut(body.arrays.relaxed), |_, words| is_energy(words));
    // Strains, forces and tensions are finite.
    let numbers = body.arrays.rows.as_flattened_mut().as_flattened_mut();
    pass.slice_if(numbers, |_, number| number.is_finite());
    pass.slice_if(body.arrays.link_rows.as_flattened_mut(), |_, number| number.is_finite());
    if pass.is_reading() {
        body.derive();
    }
}
