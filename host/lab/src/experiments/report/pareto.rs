//! Which setting to use for a budget: the front of the points that none beats in both respects.

/// Indices of the points that no other one beats, ascending in the first coordinate; smaller is
/// better in both.
#[must_use]
pub fn front(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let key = |&at: &usize| points[at];
    order.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    });
    let mut best = f64::INFINITY;
    order.retain(|at| {
        let better = points[*at][1] < best;
        best = best.min(points[*at][1]);
        better
    });
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_points_that_none_beats() {
        let points =
            [[4.0, 1.0], [1.0, 9.0], [2.0, 9.0], [2.0, 5.0], [3.0, 6.0], [4.0, 0.5], [3.5, 5.0]];
        assert_eq!(front(&points), [1, 3, 5]);
        assert!(front(&[]).is_empty());
    }
}
