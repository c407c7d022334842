//! Whether a body has the size of something that a hand presses; most often one that has not was read in the
//! wrong unit.

use crate::words::length;

/// Sizes that need no remark \[m\].
const SIZE_M: std::ops::RangeInclusive<f64> = 1e-3..=2.0;

/// What to say of a body of another size, whose coordinates were read in this unit: its size, the unit, and the
/// other one.
#[must_use]
pub fn unlikely_size(nodes_m: &[[f64; 3]], unit_m: f64) -> Option<String> {
    let along = |axis: usize| {
        let xs = nodes_m.iter().map(|node| node[axis]);
        let least = xs.clone().fold(f64::INFINITY, f64::min);
        xs.fold(f64::NEG_INFINITY, f64::max) - least
    };
    let size_m = [0, 1, 2].map(along).into_iter().fold(0.0, f64::max);
    if SIZE_M.contains(&size_m) || nodes_m.is_empty() {
        return None;
    }
    let size = length(size_m);
    let (is, other) = if unit_m == 1.0 { ("m", "mm") } else { ("mm", "m") };
    Some(format!(
        "the body is {size} large, its coordinates read as {is}; `unit_m` {other} reads them as {other}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_unit_is_said_and_a_hand_s_scale_is_not() {
        let said = |size_m: f64, unit_m| unlikely_size(&[[0.0; 3], [0.0, size_m, 0.0]], unit_m);
        assert_eq!(
            said(199.6, 1.0).unwrap(),
            "the body is 200 m large, its coordinates read as m; `unit_m` mm reads them as mm"
        );
        let small = said(0.000_19, 0.001).unwrap();
        assert!(
            small.starts_with("the body is 0.190 mm large, its coordinates read as mm; `unit_m` m")
        );
        assert_eq!((said(0.2, 1.0), said(0.2, 0.001), unlikely_size(&[], 1.0)), (None, None, None));
    }
}
