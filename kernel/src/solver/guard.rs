//! Common part of the guarded schemes: the decision to accept a pass.

use super::level::Level;
use crate::energy::links::number::LinkNumber;
use crate::energy::residual::Terms;
use crate::energy::rounding::Rounding;
use crate::number::cell::Cell;
use crate::number::two_float::TwoFloat;

/// Result of a pass.
pub(super) struct Pass<'a, N> {
    /// Positions of the pass.
    pub at: &'a [Cell<N>],
    pub residual: &'a [Cell<N>],
    /// Energy in internal units.
    pub energy: TwoFloat,
    /// The energy less the work of a current.
    pub potential: TwoFloat,
}

/// Returns true if a pass has to be discarded: it is above the level by more than half of the rounding
/// allowance. Under a current the level is no measure of the summed energies.
///
/// Cost: nothing for a pass within the level or a few last places above it, nor for one so far above that
/// rounding cannot explain it; between them one look at each cell.
pub(super) fn discards<N: LinkNumber>(
    terms: Terms<'_, '_, N>,
    level: &Level,
    pass: &Pass<'_, N>,
) -> bool {
    let Pass { at, residual, energy, potential } = *pass;
    let (model, is_driven) = (terms.model, terms.current.is_some());
    let scale = if is_driven { energy.hi } else { level.leading() };
    let is_above = |rounding| exceeds(potential, level, scale, rounding);
    // The part of the allowance that needs no sums.
    if !is_above(Rounding::default()) {
        return false;
    }
    // A number type with uniform spacing needs no sums.
    let is_even = N::GRAIN > 0.0;
    let reach = if is_even { N::GRAIN } else { model.saturation() };
    // Under a tool the cells' bounds exceed those of the model.
    let is_touched = terms.touch.get().is_some();
    !is_touched && is_above(Rounding::at_most(model, reach, energy.hi))
        || !is_even && is_above(Rounding::of_pass(terms.mobility(), at, residual))
}

/// Returns true if a potential is above the level by more than half of an allowance.
#[inline(never)]
fn exceeds(potential: TwoFloat, level: &Level, energy: f32, rounding: Rounding) -> bool {
    potential.exceeds(level.value().plus((0.5 * rounding.allowance(energy)).into()))
}
