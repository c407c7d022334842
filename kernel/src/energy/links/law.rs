//! The arithmetic of one link: its band (Eq. 5, 6), weight (Eq. 9, 13) and force (Eq. 7).
//!
//! All lengths are in mean link lengths. Every loop shape calls these functions, so all give the same bits.
//! Two thirds of the cost of a taut link are its square root and division; a slack link needs neither.

use core::hint::select_unpredictable;

use crate::number::Number;
use crate::number::cell::{dot, scale, sub};
use crate::number::sqrt::sqrt;

/// Widens the band on squared lengths, so that the rest length lies inside at alpha 0 too: the rounding
/// errors of l0, of l0^2 and of the product are together at most 5 units of 2^-24.
pub(crate) const RIM: f32 = 8.0 / 16_777_216.0;
/// Below this fraction of l0^2 a link's direction is undefined, and it takes that of the rest shape.
pub(crate) const COINCIDENT: f32 = 1.0e-12;

/// True if a slack link's root and division are computed and masked, not skipped: on out-of-order cores that
/// is cheaper than a mispredicted branch. Adding the masked zeros changes no bit.
const SPECULATE: bool = cfg!(any(target_arch = "x86_64", target_arch = "aarch64"));

/// The band of a link in rest lengths, in the form that the sweep uses.
#[derive(Debug, Clone, Copy)]
pub struct Band {
    pub(crate) low: f32,
    pub(crate) high: f32,
    pub(crate) low_squared: f32,
    pub(crate) high_squared: f32,
}

impl Band {
    /// The band `1 - alpha` to `1 + alpha` (Eq. 5).
    #[must_use]
    #[inline]
    pub fn new(alpha: f32) -> Self {
        let (low, high) = (1.0 - alpha, 1.0 + alpha);
        Self {
            low,
            high,
            low_squared: low * low * (1.0 - RIM),
            high_squared: high * high * (1.0 + RIM),
        }
    }
}

/// Force and energy of a taut link: its force on the first end (the second gets the opposite), and w d^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkForce<N: Number = f32> {
    /// w mu (`P_j` - `P_i`), Eq. 13.
    pub force: [N; 3],
    /// w d^2, with d the distance to the band: four times its energy.
    pub wd2: N::Product,
}

/// `low <= a <= high` for non-negative numbers; false for NaN.
///
/// It takes one comparison of bit patterns: a branch predictor cannot guess whether a taut link is too long
/// or too short.
#[inline(always)]
fn within(a: f32, low: f32, high: f32) -> bool {
    let width = high.to_bits().wrapping_sub(low.to_bits());
    a.to_bits().wrapping_sub(low.to_bits()) <= width
}

/// The force of a link of rest length `l0` and weight `w` on its end `pi`; the other end is `pj`. `None` or
/// zero inside its band.
///
/// `rest_difference` returns `P_j` - `P_i` of the rest shape; it is called only if the ends coincide.
#[inline(always)]
pub fn link_force(
    pi: [f32; 3],
    pj: [f32; 3],
    l0: f32,
    w: f32,
    band: Band,
    rest_difference: impl FnOnce() -> [f32; 3],
) -> Option<LinkForce> {
    if !SPECULATE {
        return branching(pi, pj, l0, w, band, rest_difference);
    }
    let difference = sub(pj, pi);
    let u2 = dot(difference, difference);
    let l02 = l0 * l0;
    let (low2, high2) = (l02 * band.low_squared, l02 * band.high_squared);
    let slack = within(u2, low2, high2);
    let u = sqrt(u2);
    let d = u - l0 * select_unpredictable(u2 > high2, band.high, band.low);
    let wd = w * d;
    let force = if u2 < COINCIDENT * l02 {
        scale(wd / (l0 + l0), rest_difference())
    } else {
        scale(wd / (u + u), difference)
    };
    let keep = |x: f32| f32::from_bits(x.to_bits() & if slack { 0 } else { u32::MAX });
    Some(LinkForce { force: force.map(keep), wd2: keep(wd * d) })
}

/// [`link_force`] with the fewest instructions per case: a link that is too long cannot coincide.
#[inline(always)]
fn branching(
    pi: [f32; 3],
    pj: [f32; 3],
    l0: f32,
    w: f32,
    band: Band,
    rest_difference: impl FnOnce() -> [f32; 3],
) -> Option<LinkForce> {
    let difference = sub(pj, pi);
    let u2 = dot(difference, difference);
    let l02 = l0 * l0;
    if u2 > l02 * band.high_squared {
        let u = sqrt(u2);
        let d = u - l0 * band.high;
        let wd = w * d;
        return Some(LinkForce { force: scale(wd / (u + u), difference), wd2: wd * d });
    }
    if u2 >= l02 * band.low_squared {
        return None;
    }
    let u = sqrt(u2);
    let d = u - l0 * band.low;
    let wd = w * d;
    let force = if u2 < COINCIDENT * l02 {
        scale(wd / (l0 + l0), rest_difference())
    } else {
        scale(wd / (u + u), difference)
    };
    Some(LinkForce { force, wd2: wd * d })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::rest_length;
    use proptest::prelude::*;

    const SLACK: LinkForce = LinkForce { force: [0.0; 3], wd2: 0.0 };

    fn at_alpha(pi: [f32; 3], pj: [f32; 3], l0: f32, alpha: f32) -> LinkForce {
        link_force(pi, pj, l0, 1.0, Band::new(alpha), || [l0, 0.0, 0.0]).unwrap_or(SLACK)
    }

    proptest! {
        /// The rest length is inside its own band for every alpha, including 0.
        // REQ-ENE-07
        #[test]
        fn rest_is_slack(a in prop::array::uniform3(-40.0_f32..40.0),
                         b in prop::array::uniform3(-40.0_f32..40.0), alpha in 0.0_f32..1.0) {
            let l0 = rest_length(a, b);
            prop_assume!(l0 > 1e-6);
            prop_assert_eq!(at_alpha(a, b, l0, 0.0), SLACK);
            prop_assert_eq!(at_alpha(a, b, l0, alpha), SLACK);
        }

        /// Both shapes of the code give the same bits.
        #[test]
        fn branches_change_no_bit(
            pj in prop::array::uniform3(prop_oneof![-4.0_f32..4.0, -1e-7_f32..1e-7, Just(0.0)]),
            l0 in 0.1_f32..4.0, w in 0.1_f32..9.0, alpha in 0.0_f32..0.9,
        ) {
            let (band, rest) = (Band::new(alpha), || [l0, 0.0, 0.0]);
            let plain = link_force([0.0; 3], pj, l0, w, band, rest).unwrap_or(SLACK);
            let branching = branching([0.0; 3], pj, l0, w, band, rest).unwrap_or(SLACK);
            prop_assert_eq!(plain, branching);
        }

        /// Eq. 13 in double precision; and the force on j is the opposite of that on i.
        // REQ-FOR-01
        #[test]
        fn link_force_is_the_papers(pj in prop::array::uniform3(-4.0_f32..4.0), l0 in 0.1_f32..4.0,
                              alpha in 0.0_f32..0.9) {
            let u = pj.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt();
            prop_assume!(u > 1e-3);
            let (low, high) = (f64::from(l0 * (1.0 - alpha)), f64::from(l0 * (1.0 + alpha)));
            let d = if u > high { u - high } else if u < low { u - low } else { 0.0 };
            let mu = d / (2.0 * u);
            let got = at_alpha([0.0; 3], pj, l0, alpha);
            for (got, x) in got.force.iter().zip(pj) {
                prop_assert!((f64::from(*got) - mu * f64::from(x)).abs() < 2e-6);
            }
            prop_assert!((f64::from(got.wd2) - d * d).abs() < 1e-5);
            let back = at_alpha(pj, [0.0; 3], l0, alpha);
            prop_assert_eq!(back.force.map(|f| -f), got.force);
        }
    }

    #[test]
    fn within_is_the_comparison_of_floats() {
        let values = [0.0, f32::from_bits(1), 1e-30, 0.5, 1.0, 1.0 + f32::EPSILON, 7.0, f32::MAX];
        for a in values {
            for low in values {
                for high in values.into_iter().filter(|&high| high >= low) {
                    assert_eq!(within(a, low, high), low <= a && a <= high, "{a} {low} {high}");
                }
            }
        }
        assert!(!within(f32::NAN, 0.0, 1.0) && !within(f32::INFINITY, 0.0, 1.0));
    }

    #[test]
    fn coincident_ends_part_along_the_rest_shape() {
        let got = at_alpha([1.0; 3], [1.0; 3], 2.0, 0.25);
        // d = -1.5, so half of it pushes i backwards along +x, the direction of j at rest.
        assert_eq!(got.force, [-0.75, 0.0, 0.0]);
        assert_eq!(got.wd2, 2.25);
    }
}
