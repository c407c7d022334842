//! The exact trajectory dP/dt = sum of w mu (`P_j` - `P_i`) (Eq. 2 in the linear range, C = 1).
//!
//! Dormand and Prince's pair of orders 5 and 4 with the usual step control (Hairer, Nørsett,
//! Wanner, Solving Ordinary Differential Equations I, section II.4 and II.5). A page of our own:
//! the crates at hand keep every step of every unknown, which here are thousands of both.

use super::elastic::{Elastic, Held};
use super::links::Links;
use super::vectors::plus;

/// Coefficients of the stages; the last row is the solution of order 5 too.
const A: [&[f64]; 7] = [
    &[],
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
/// Order 5 less order 4.
const E: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];
const FIRST_STEP: f64 = 1e-3;

type Vectors = Vec<[f64; 3]>;

/// Positions at `times` (ascending, dimensionless) from rest at t = 0, the cells `held` put at
/// their positions then and kept there.
///
/// `tolerance` bounds the error that a step may add, in mean rest lengths. Cost: six link passes a
/// step; steps of about 3 / W at the latest, W the largest weight of a cell.
#[must_use]
pub fn trajectory(links: &Links, held: &Held, times: &[f64], tolerance: f64) -> Vec<Vectors> {
    let unit = links.rest_lengths().iter().sum::<f64>() / links.rest_lengths().len() as f64;
    let free = links.free(held);
    let slope = |p: &[[f64; 3]], k: &mut Vectors| {
        links.residual(p, k);
        k.iter_mut().zip(&free).filter(|(_, free)| !**free).for_each(|(k, _)| *k = [0.0; 3]);
    };
    let mut at = links.rest().to_vec();
    for &(cell, position) in held {
        at[cell] = position;
    }
    let mut stages: [Vectors; 7] = std::array::from_fn(|_| vec![[0.0; 3]; at.len()]);
    let mut next = at.clone();
    slope(&at, &mut stages[0]);
    let (mut t, mut step) = (0.0, FIRST_STEP);
    let mut found = Vec::with_capacity(times.len());
    for &end in times {
        while t < end {
            // A last step that would leave a crumb takes it along.
            let last = t + 1.000_001 * step >= end;
            let h = if last { end - t } else { step };
            for stage in 1..7 {
                next.copy_from_slice(&at);
                for (k, a) in stages.iter().zip(A[stage]) {
                    add(&mut next, h * a, k);
                }
                slope(&next, &mut stages[stage]);
            }
            let error = error(&stages, h) / (tolerance * unit);
            let factor = (0.9 * error.powf(-0.2)).clamp(0.2, 5.0);
            if error <= 1.0 {
                t = if last { end } else { t + h };
                std::mem::swap(&mut at, &mut next);
                stages.swap(0, 6);
                step = if last { step.max(h * factor) } else { h * factor };
            } else {
                step = h * factor;
            }
        }
        found.push(at.clone());
    }
    found
}

/// Largest error of a coordinate in a step of length `h`.
fn error(stages: &[Vectors; 7], h: f64) -> f64 {
    let cells = 0..stages[0].len();
    let of = |cell: usize, axis: usize| {
        h * stages.iter().zip(E).map(|(k, e)| e * k[cell][axis]).sum::<f64>()
    };
    cells.flat_map(|cell| (0..3).map(move |axis| of(cell, axis).abs())).fold(1e-300, f64::max)
}

fn add(a: &mut [[f64; 3]], factor: f64, b: &[[f64; 3]]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a = plus(*a, factor, *b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One link between a held and a free cell: the excess decays as exp(-t / 2).
    #[test]
    fn a_single_link_relaxes_exponentially() {
        let rest = [[0.0; 3], [1.0, 0.0, 0.0]];
        let links = Links::from_edges(&rest, &[[0, 1]], 0.0, &[]).unwrap();
        let times = [0.0, 0.37, 1.0, 10.0];
        let found = trajectory(&links, &[(0, [-0.5, 0.0, 0.0])], &times, 1e-11);
        for (t, positions) in times.iter().zip(&found) {
            let exact = 0.5 + 0.5 * (-0.5 * t).exp();
            assert!((positions[1][0] - exact).abs() < 1e-9, "t = {t}: {positions:?}");
            assert_eq!(positions[0], [-0.5, 0.0, 0.0]);
        }
    }
}
