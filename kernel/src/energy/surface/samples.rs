//! Sample points of a triangle: the centres of its equal parts.

use crate::number::cell::{add, scale, sub};

/// A sample in the part, or held by an anchor.
pub(crate) struct Sample {
    /// Its index in the triangle.
    pub index: u16,
    /// Weights of the triangle's corners.
    pub weights: [f32; 3],
    pub point: [f32; 3],
    /// Depth in the part; 0 outside.
    pub depth: f32,
    /// Unit vector out of the part; 0 inside the core.
    pub normal: [f32; 3],
    /// Stiffness [2 `k_ref`].
    pub stiffness: f32,
    /// Pressure on the tissue along the normal.
    pub push: [f32; 3],
    /// Friction on the tissue, or the pull of a grip.
    pub drag: [f32; 3],
    /// True if an anchor holds it and it does not slip.
    pub is_stuck: bool,
    /// Energy of contact and friction.
    pub energy: f32,
}

/// Calls `visit(weights, point)` for the samples of a triangle whose edges are cut into `parts` parts, always
/// in the same order; the weights are those of its corners.
#[inline(always)]
pub(crate) fn each(
    parts: u16,
    [a, b, c]: [[f32; 3]; 3],
    mut visit: impl FnMut([f32; 3], [f32; 3]),
) {
    const THIRD: f32 = 1.0 / 3.0;
    let (along, across) = (sub(b, a), sub(c, a));
    let part = 1.0 / f32::from(parts);
    for i in 0..parts {
        for j in 0..parts - i {
            // The part oriented like the triangle, then its inverted neighbour.
            for third in [THIRD, 2.0 * THIRD] {
                if third > 0.5 && i + j + 1 >= parts {
                    continue;
                }
                let u = part * (f32::from(i) + third);
                let v = part * (f32::from(j) + third);
                let point = add(a, add(scale(u, along), scale(v, across)));
                visit([1.0 - u - v, u, v], point);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_weigh_the_corners_alike() {
        let corners = [[1.0, 0.0, 0.0], [4.0, 0.0, 3.0], [1.0, 6.0, 0.0]];
        for parts in [1, 2, 3, 7, 32] {
            let (mut count, mut sums, mut mean) = (0, [0.0_f32; 3], [0.0_f32; 3]);
            each(parts, corners, |weights, point| {
                count += 1;
                sums = add(sums, weights);
                mean = add(mean, point);
                assert!(weights.iter().all(|w| (0.0..1.0).contains(w)), "{weights:?}");
            });
            assert_eq!(count, parts * parts);
            let all = f32::from(count);
            assert!(sums.iter().all(|sum| (sum / all - 1.0 / 3.0).abs() < 1e-5), "{sums:?}");
            assert!(sub(scale(1.0 / all, mean), [2.0, 2.0, 1.0]).iter().all(|x| x.abs() < 1e-4));
        }
    }
}
