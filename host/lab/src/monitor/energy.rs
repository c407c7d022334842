//! The energy of positions in double precision: what the certified level is compared with.

use crate::reference::Links;
use crate::reference::vectors::{minus, norm};

/// Relative spacing of single-precision numbers.
const EPS: f64 = f32::EPSILON as f64;

/// An energy with its uncertainty, in the unit of E = sum of w d^2 / 4.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energy {
    /// Sum of w d^2 / 4.
    pub energy: f64,
    /// How far rounding may move the energy of the same state in single precision.
    pub allowance: f64,
    /// How far rounding may move a force, in the unit of w d / 2: the direction of a link is as
    /// exact as its length.
    pub force_allowance: f64,
}

impl Energy {
    /// The energies, times `unit`.
    #[must_use]
    pub fn times(self, unit: f64) -> Self {
        Self { energy: unit * self.energy, allowance: unit * self.allowance, ..self }
    }
}

/// Energy of the links at positions, with the bands as they are or `closed` to the rest lengths.
///
/// `error` gives how far a stored position may be off along a link. With u the length of a link, d
/// its part outside the band and r the errors of its two ends, the allowance is the sum of
/// 4 eps (w d^2 / 4 + w u d / 2) for the kernel's sum and w r (d + r / 2) / 2 for the positions.
/// For a force it is w d r / u, twice what an error r of the length does, at most w d / 2.
///
/// Cost: one root a link.
#[must_use]
pub fn energy(
    links: &Links,
    positions: &[[f64; 3]],
    closed: bool,
    error: impl Fn(&[f64; 3]) -> f64,
) -> Energy {
    let errors: Vec<f64> = positions.iter().map(error).collect();
    let mut sum = Energy::default();
    for (link, ends) in links.ends().iter().enumerate() {
        let [i, j] = ends.map(|end| end as usize);
        let u = norm(minus(positions[j], positions[i]));
        let (w, l0) = (links.weights()[link], links.rest_lengths()[link]);
        let alpha = if closed { 0.0 } else { links.alphas()[link] };
        let d = (u - (1.0 + alpha) * l0).max((1.0 - alpha) * l0 - u).max(0.0);
        let r = errors[i] + errors[j];
        let own = 0.25 * w * d * d;
        sum.energy += own;
        sum.force_allowance += 0.5 * w * d * (2.0 * r / u).min(1.0);
        sum.allowance += 4.0 * EPS * (own + 0.5 * w * u * d) + 0.5 * w * r * (d + 0.5 * r);
    }
    sum
}

/// How far a published position may be off [mean link lengths]: a step and its sum with the
/// position round once each, to single precision and to the `resolution` of the numbers.
#[must_use]
pub fn rounding(position: &[f64; 3], resolution: f64) -> f64 {
    EPS * norm(*position) + 0.5 * resolution
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_energy_is_that_of_the_links_and_the_allowance_grows_with_the_error() {
        let rest = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let links = Links::from_edges(&rest, &[[0, 1], [0, 2]], 0.1, &[]).unwrap();
        let at = [[0.0; 3], [1.5, 0.0, 0.0], [0.0, 1.9, 0.0]];
        let exact = energy(&links, &at, false, |_| 0.0);
        assert!((exact.energy - links.energy(&at)).abs() < 1e-15);
        assert!((exact.energy - 0.25 * 0.4 * 0.4).abs() < 1e-15, "{exact:?}");
        let closed = energy(&links, &at, true, |_| 0.0);
        assert!((closed.energy - links.closed().energy(&at)).abs() < 1e-15);
        assert!((closed.energy - 0.25 * (0.25 + 0.01)).abs() < 1e-15, "{closed:?}");
        let moment = 4.0 * EPS * (exact.energy + 0.5 * 1.5 * 0.4);
        assert!((exact.allowance - moment).abs() < 1e-15, "{exact:?}");
        // An error of e at both ends: e (d + e) for the taut link, e^2 for the slack one.
        let off = energy(&links, &at, false, |_| 0.01).allowance - exact.allowance;
        assert!((off - 0.01 * (0.4 + 0.01) - 0.01 * 0.01).abs() < 1e-15, "{off}");
        assert_eq!(rounding(&[3.0, 4.0, 0.0], 0.5), 5.0 * EPS + 0.25);
    }
}
