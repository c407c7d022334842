//! The shape of unit volume nearest to given stretches.

/// Most steps of the root; five are usual, fifty halve the bracket to nothing.
const STEPS_MAX: usize = 100;

/// The nearest stretches of product 1, with their derivative by the given ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Unit {
    pub values: [f64; 3],
    pub slope: [[f64; 3]; 3],
}

/// Nearest to `s`, which falls and whose last value alone may be negative.
///
/// The nearest matrix of determinant 1 has the singular vectors of the given one. Its stretches q
/// solve `q_i` (`q_i` - `s_i`) = p with one p for all, so the least one gives the other two, and
/// their product leaves one equation in one unknown. For a product of `s` up to about 6 that is the
/// nearest of all; beyond there may be two candidates, and this stays with the one that small
/// strain leads to.
pub(super) fn nearest(s: [f64; 3]) -> Unit {
    // At the upper end every q is at least 1 or at least its s, whose product is at least 1.
    let (mut low, mut high) = (0.0, s[2].max(1.0));
    let mut least = high;
    for _ in 0..STEPS_MAX {
        let q = others(s, least);
        let off = (q[0] * q[1] * q[2]).ln();
        if off == 0.0 {
            break;
        }
        *(if off > 0.0 { &mut high } else { &mut low }) = least;
        let steep = (0..2).map(|k| 1.0 / (q[k] * (2.0 * q[k] - s[k]))).sum::<f64>();
        let newton = least - off / (1.0 / least + (2.0 * least - s[2]) * steep);
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - least).abs() <= f64::EPSILON * least {
            break;
        }
        least = next;
    }
    let values = others(s, least);
    Unit { values, slope: slope(s, values) }
}

/// All three stretches from the least one.
fn others(s: [f64; 3], least: f64) -> [f64; 3] {
    let p = least * (least - s[2]);
    let other = |s: f64| 0.5 * (s + (s * s + 4.0 * p).max(0.0).sqrt());
    [other(s[0]), other(s[1]), least]
}

/// `dq_i / ds_j`, from the differentials of `q_i` (`q_i` - `s_i`) = p and of the product.
fn slope(s: [f64; 3], q: [f64; 3]) -> [[f64; 3]; 3] {
    let inverse: [f64; 3] = std::array::from_fn(|i| 1.0 / (2.0 * q[i] - s[i]));
    let sum = (0..3).map(|i| inverse[i] / q[i]).sum::<f64>();
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            let own = if i == j { q[i] * inverse[i] } else { 0.0 };
            own - inverse[i] * inverse[j] / sum
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASES: [[f64; 3]; 10] = [
        [1.0, 1.0, 1.0],
        [1.3, 1.1, 0.4],
        [2.0, 1.5, 1.2],
        [1.8, 1.8, 1.8],
        [3.0, 1.4, 1.3],
        [0.2, 0.1, 0.05],
        [1.2, 0.9, -0.6],
        [1.0, 1e-3, -1e-3],
        [0.7, 0.7, -0.7],
        [3.0, 0.2, 0.0],
    ];

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    }

    /// Against every point of a grid on the surface of product 1.
    #[test]
    fn nothing_of_product_1_is_nearer() {
        for s in CASES {
            let q = nearest(s).values;
            assert!((q[0] * q[1] * q[2] - 1.0).abs() < 1e-14, "{s:?}: {q:?}");
            let grid = || (1..400).map(|k| 0.01 * f64::from(k));
            for (x, y) in grid().flat_map(|x| grid().map(move |y| (x, y))) {
                let off = distance(s, [x, y, 1.0 / (x * y)]) - distance(s, q);
                assert!(off > -1e-12, "{s:?}: {q:?} is farther than {x}, {y} by {off:e}");
            }
        }
        assert_eq!(nearest([1.0; 3]).values, [1.0; 3]);
    }

    #[test]
    fn its_slope_is_that_of_finite_differences() {
        let step = 1e-6;
        // A little apart, so that every step leaves the order as it is.
        for s in CASES.map(|[a, b, c]| [a + 1e-5, b, c - 1e-5]) {
            let unit = nearest(s);
            for j in 0..3 {
                let at = |by: f64| {
                    let mut s = s;
                    s[j] += by;
                    nearest(s).values
                };
                let (ahead, behind) = (at(step), at(-step));
                for (i, row) in unit.slope.iter().enumerate() {
                    let found = (ahead[i] - behind[i]) / (2.0 * step);
                    assert!((found - row[j]).abs() < 1e-7, "{s:?}: {found} {}", row[j]);
                }
            }
        }
    }
}
