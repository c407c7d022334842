//! Contact energy of the tools.

use crate::contact::memory::TouchArrays;
use crate::energy::surface::{Meeting, TOOLS_MAX};
use crate::number::two_float::TwoFloat;

/// Contact energy of all engaged tools, and of each.
pub(super) fn energies_of(
    arrays: &TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
) -> (TwoFloat, [f32; TOOLS_MAX]) {
    let mut single = [0.0; TOOLS_MAX];
    let each = arrays.tools.iter().zip(&mut single).enumerate().filter(|(_, (tool, _))| tool.is_in);
    let all = each.fold(TwoFloat::ZERO, |sum, (number, (tool, slot))| {
        let among = (arrays.near(), arrays.anchors());
        let energy = Meeting::of((&tool.proxy, number), among, at).energy;
        *slot = energy.hi;
        sum.plus(energy)
    });
    (all, single)
}

/// Contact energy of all engaged tools.
pub(super) fn energy_of(arrays: &TouchArrays<'_>, at: &impl Fn(usize) -> [f32; 3]) -> TwoFloat {
    energies_of(arrays, at).0
}

/// Change of the energy, rounded up.
pub(crate) fn rise(before: TwoFloat, after: TwoFloat) -> TwoFloat {
    let rounding = f32::EPSILON * (before.hi + after.hi);
    after.minus(before).plus(rounding.into())
}
