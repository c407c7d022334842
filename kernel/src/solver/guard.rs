//! What the guarded schemes have in common: how far rounding may move a computed energy.

use super::level::Level;
use crate::number::sqrt::sqrt;
use crate::number::two_float::TwoFloat;
use crate::terms::residual::Terms;

/// Rounding allowance of an energy, 4 eps (E + sqrt(w E)) with w the smallest weight of a link: at
/// most the rounding 4 eps (E + sum of w u d / 2) that the sum may have in the worst case, and
/// about what it has, since the links' errors add up like a random walk.
pub(super) fn tolerance(energy: f32, weight_min: f32) -> f32 {
    let energy = if energy > 0.0 { energy } else { 0.0 };
    4.0 * f32::EPSILON * (energy + sqrt(weight_min * energy))
}

/// Up to where a pass that found the energy `energy` is accepted. Under a current the level is no
/// measure of the energies that were summed.
pub(super) fn allowed(terms: Terms<'_, '_>, level: &Level, energy: TwoFloat) -> TwoFloat {
    let scale = if terms.current.is_some() { energy.hi } else { level.leading() };
    level.value().plus(tolerance(scale, terms.model.weight_min).into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerance_is_far_below_the_energy() {
        assert!(tolerance(1.0, 1.0) < 1e-6 && tolerance(0.0, 1.0) == 0.0);
        assert!(TwoFloat::from(1.0).exceeds(TwoFloat::from(1.0 - 1e-6)));
    }
}
