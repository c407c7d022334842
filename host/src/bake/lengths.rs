//! Checks that every link has a length in the model's single precision.

use chaincell_kernel::model::rest_length;

use super::layout::OrderedCells;
use crate::error::{Error, Result};

/// Shortest and longest link that the kernel accepts, in mean link lengths.
const LENGTHS: std::ops::RangeInclusive<f32> = 1e-6..=1e6;

/// Refuses a link without a length in single precision, whose steps grow with the distance from the centre.
pub(super) fn check(body: &OrderedCells) -> Result<()> {
    let place = |cell: u16| body.rest[usize::from(cell)];
    let length = |[i, j]: [u16; 2]| rest_length(place(i), place(j));
    match body.links.iter().find(|(ends, _)| !LENGTHS.contains(&length(*ends))) {
        None => Ok(()),
        Some((ends, _)) => {
            let [a, b] = ends.map(|cell| body.node[usize::from(cell)]);
            Err(Error::input(format!(
                "linked nodes {a} and {b} have no distance in single precision, counted from the middle of \
                 the body in mean link lengths: merge them, or remove what lies far away"
            )))
        }
    }
}
