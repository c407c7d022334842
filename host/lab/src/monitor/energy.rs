//! The energy of positions in double precision: what the certified level is compared with.

use chaincell_kernel::Rounding;

use crate::reference::vectors::{minus, norm};
use crate::reference::{Links, Nodal, Stiffening};

/// Relative spacing of single-precision numbers.
const EPS: f64 = f32::EPSILON as f64;

/// An energy with its uncertainty, in the unit of E = sum of w d^2 / 4.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energy {
    /// Sum of w d^2 / 4.
    pub energy: f64,
    /// The kernel's allowance for its rounding, and what the positions are off by beyond it.
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
/// Lengths are in the kernel's unit, mean link lengths from the centre. The allowance is that of
/// [`Rounding`]. `error` gives how far a position may be off beyond single precision: with d the
/// part of a link outside its band and r the errors of its two ends, it adds w r (d + r / 2) / 2.
/// For a force the allowance is w d r / u, u being the link's length and r with the rounding of the
/// positions: twice what an error r of the length does, at most w d / 2.
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
    // Weight, and sum of w d^2, of the links of each cell.
    let mut cells = vec![[0.0; 2]; positions.len()];
    for (link, ends) in links.ends().iter().enumerate() {
        let [i, j] = ends.map(|end| end as usize);
        let u = norm(minus(positions[j], positions[i]));
        let (w, l0) = (links.weights()[link], links.rest_lengths()[link]);
        let alpha = if closed { 0.0 } else { links.alphas()[link] };
        let d = (u - (1.0 + alpha) * l0).max((1.0 - alpha) * l0 - u).max(0.0);
        let r = errors[i] + errors[j];
        let own = 0.25 * w * d * d;
        sum.energy += own;
        let off = r + EPS * (norm(positions[i]) + norm(positions[j]));
        sum.force_allowance += 0.5 * w * d * (2.0 * off / u).min(1.0);
        sum.allowance += 0.5 * w * r * (d + 0.5 * r);
        for end in [i, j] {
            cells[end][0] += w;
            cells[end][1] += w * d * d;
        }
    }
    sum.allowance += allowance(links, positions, &cells, sum.energy);
    sum
}

/// Energy of nodal shapes and of their stiffening at positions, with the nearest rotation and shape of
/// unit volume: what the kernel keeps of them makes it no lower.
///
/// Lengths and energies are in the kernel's units, `bounds` are those of its cells. The allowance is
/// that of [`Rounding`] with eight times each cell's energy in place of its sum of w d^2.
#[must_use]
pub fn energy_of_shapes(
    shapes: &Nodal,
    stiffening: &Stiffening,
    positions: &[[f64; 3]],
    bounds: &[f64],
) -> Energy {
    let stiffened = stiffening.energies(positions);
    let energies: Vec<f64> =
        shapes.energies(positions).into_iter().zip(stiffened).map(|(a, b)| a + b).collect();
    let (mut sum, energy) = (Rounding::default(), energies.iter().sum::<f64>());
    for ((at, bound), energy) in positions.iter().zip(bounds).zip(energies) {
        let mobility = if *bound > 0.0 { 1.0 / bound } else { 0.0 };
        let stored = (8.0 * energy) as f32;
        sum.add_cell(Rounding::of_cell(at.map(|x| x as f32), mobility as f32, stored));
    }
    Energy { energy, allowance: sum.allowance(energy as f32).into(), force_allowance: 0.0 }
}

/// The kernel's allowance for the energy of a state whose cells have these weights and sums of
/// w d^2.
fn allowance(links: &Links, positions: &[[f64; 3]], cells: &[[f64; 2]], energy: f64) -> f64 {
    let mut sum = Rounding::default();
    for (&w, &l0) in links.weights().iter().zip(links.rest_lengths()) {
        sum.add_link(w as f32, l0 as f32);
    }
    for (at, &[weight, wd2]) in positions.iter().zip(cells) {
        let mobility = if weight > 0.0 { 1.0 / weight } else { 0.0 };
        sum.add_cell(Rounding::of_cell(at.map(|x| x as f32), mobility as f32, wd2 as f32));
    }
    sum.allowance(energy as f32).into()
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
        // Cell 0 has both links, at 0; cell 1 the taut one, at 1.5. The slack one has no part.
        let moments = [2.0, 1.5 * 1.5 + 1.0].map(|moment| moment * EPS * EPS);
        let slack = 5.0 * EPS * EPS;
        let stored = (moments[0] + moments[1]) * 0.4 * 0.4;
        let rounding = 4.0 * EPS * exact.energy
            + 0.5 * stored.sqrt()
            + 2.0 * (moments[1] * 0.4 * 0.4).sqrt()
            + (moments[0] + moments[1]) / 48.0
            + slack;
        assert!((exact.allowance / rounding - 1.0).abs() < 1e-5, "{exact:?}");
        // An error of e at both ends: e (d + e) for the taut link, e^2 for the slack one.
        let off = energy(&links, &at, false, |_| 0.01).allowance - exact.allowance;
        assert!((off - 0.01 * (0.4 + 0.01) - 0.01 * 0.01).abs() < 1e-15, "{off}");
    }
}
