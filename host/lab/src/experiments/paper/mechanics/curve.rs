//! Curves of force over displacement: slack, degree of non-linearity, work.

use serde::Serialize;

use crate::experiments::paper::body::Felt;

/// How a force grows with the displacement.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Shape {
    /// Deepest displacement without force, 0 where the first step is felt \[m\].
    pub slack_m: f64,
    /// Largest force \[N\].
    pub force_max_n: f64,
    /// Displacement at the largest force \[m\].
    pub depth_at_max_m: f64,
    /// p of the least-squares line through ln F = p ln d + c, from the slack to the largest force:
    /// 1 for a linear spring, 3 for a plane that is pushed out of itself.
    pub nonlinearity_exponent: f64,
    /// Forces that fall from one point to the next by more than a fifth of the largest: snaps.
    pub snaps: usize,
    /// Largest residual of a free cell over the force on the tool, where that is above a
    /// hundredth of the largest.
    pub residual: f64,
}

/// Measures a curve of ascending depths; forces up to `none_n` count as none.
pub fn shape(curve: &[Felt], none_n: f64) -> Shape {
    let top = curve.iter().copied().max_by(|a, b| a.force_n.total_cmp(&b.force_n));
    let Some(top) = top.filter(|top| top.force_n > none_n) else {
        let slack_m = curve.last().map_or(0.0, |last| last.depth_m);
        return Shape { slack_m, ..Shape::default() };
    };
    let slack_m = (curve.iter().take_while(|at| at.force_n <= none_n).last())
        .map_or(0.0, |last| last.depth_m);
    let logarithms: Vec<[f64; 2]> = curve
        .iter()
        .filter(|at| at.depth_m > slack_m && at.depth_m <= top.depth_m && at.force_n > none_n)
        .map(|at| [at.depth_m.ln(), at.force_n.ln()])
        .collect();
    let falls = curve.windows(2).filter(|w| w[0].force_n - w[1].force_n > 0.2 * top.force_n);
    let felt = curve.iter().filter(|at| at.force_n > 0.01 * top.force_n);
    Shape {
        slack_m,
        force_max_n: top.force_n,
        depth_at_max_m: top.depth_m,
        nonlinearity_exponent: slope(&logarithms),
        snaps: falls.count(),
        residual: felt.map(|at| at.residual).fold(0.0, f64::max),
    }
}

/// Slope of the least-squares line through points; 0 for fewer than two.
fn slope(points: &[[f64; 2]]) -> f64 {
    let n = points.len() as f64;
    let mean = |at: usize| points.iter().map(|p| p[at]).sum::<f64>() / n;
    let (x, y) = (mean(0), mean(1));
    let product = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>();
    let square = points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>();
    if square > 0.0 { product / square } else { 0.0 }
}

/// Work along a curve of displacement \[m\] and force \[N\], by trapezoids \[J\]; negative on the
/// way back.
pub fn work_j(points: &[[f64; 2]]) -> f64 {
    points.windows(2).map(|w| 0.5 * (w[0][1] + w[1][1]) * (w[1][0] - w[0][0])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(force: impl Fn(f64) -> f64) -> Vec<Felt> {
        let depths = (1..=100).map(|i| f64::from(i) * 1e-3);
        let felt =
            |depth_m| Felt { depth_m, force_n: force(depth_m), energy_j: 0.0, residual: 0.0 };
        depths.map(felt).collect()
    }

    #[test]
    fn a_cubic_is_told_from_a_line_and_from_slack() {
        let line = shape(&curve(|d| 20.0 * d), 1e-9);
        assert!((line.nonlinearity_exponent - 1.0).abs() < 1e-12 && line.slack_m == 0.0);
        let cubic = shape(&curve(|d| d.powi(3)), 1e-12);
        assert!((cubic.nonlinearity_exponent - 3.0).abs() < 1e-12);
        let slack = shape(&curve(|d| 5.0 * (d - 0.0205).max(0.0)), 1e-9);
        assert!((slack.slack_m - 0.020).abs() < 1e-12);
        assert!(slack.nonlinearity_exponent > 1.5 && slack.snaps == 0);
        let never = shape(&curve(|_| 0.0), 1e-9);
        assert!(never.slack_m == 0.1 && never.force_max_n == 0.0);
        let snap = shape(&curve(|d| if d < 0.05 { d } else { d - 0.04 }), 1e-9);
        assert_eq!((snap.snaps, snap.depth_at_max_m), (1, 0.1));
    }

    #[test]
    fn work_of_a_spring() {
        let way: Vec<[f64; 2]> = (0..=10).map(|i| [f64::from(i), 2.0 * f64::from(i)]).collect();
        assert!((work_j(&way) - 100.0).abs() < 1e-12);
        let back: Vec<[f64; 2]> = way.into_iter().rev().collect();
        assert!((work_j(&back) + 100.0).abs() < 1e-12);
    }
}
