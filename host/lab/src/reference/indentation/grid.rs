//! Quadrilaterals of eight nodes over a round slab's half section, fine where a sphere touches it.

/// Growth of an element over its neighbour, away from the sphere.
const GROWTH: f64 = 1.2;

/// Nodes (r, z) \[m\], r from the axis and z from the bottom, in columns from the axis outward.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    pub nodes_m: Vec<[f64; 2]>,
    /// Corners against the clock from the lowest and innermost, then the middles of the edges that
    /// begin there.
    pub elements: Vec<[usize; 8]>,
    /// Edges of the top: inner end, middle, outer end.
    pub top: Vec<[usize; 3]>,
}

impl Grid {
    /// A slab of a radius and a height \[m\], with elements of `element_m` as far as `near_m` from
    /// the middle of the top.
    pub fn new([radius_m, height_m]: [f64; 2], near_m: f64, element_m: f64) -> Self {
        let r = lines(radius_m, near_m, element_m);
        let z: Vec<f64> =
            lines(height_m, near_m, element_m).into_iter().rev().map(|z| height_m - z).collect();
        Self::of_lines(&r, &z)
    }

    /// Elements between lines.
    pub fn of_lines(r: &[f64], z: &[f64]) -> Self {
        let (columns, rows) = (r.len() - 1, z.len() - 1);
        let half = |lines: &[f64], at: usize| 0.5 * (lines[at / 2] + lines[at.div_ceil(2)]);
        let mut nodes_m = Vec::new();
        for i in 0..=2 * columns {
            let rows = (0..=2 * rows).filter(|j| i % 2 == 0 || j % 2 == 0);
            nodes_m.extend(rows.map(|j| [half(r, i), half(z, j)]));
        }
        // A full column and one of the middles alone, then the next.
        let both = 3 * rows + 2;
        let at = |i: usize, j: usize| {
            let place = if i.is_multiple_of(2) { j } else { 2 * rows + 1 + j / 2 };
            i / 2 * both + place
        };
        let element = |i: usize, j: usize| {
            let (i, j) = (2 * i, 2 * j);
            [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
                .map(|(k, l)| at(i + k, j + l))
        };
        let elements = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
        let elements = elements.map(|(i, j)| element(i, j)).collect();
        let top = (0..columns).map(|i| [0, 1, 2].map(|k| at(2 * i + k, 2 * rows))).collect();
        Self { nodes_m, elements, top }
    }

    /// Largest difference of two nodes' numbers in an element.
    pub fn width(&self) -> usize {
        let widths = self.elements.iter().map(|nodes| {
            let (low, high) = nodes.iter().fold((usize::MAX, 0), |(a, b), &n| (a.min(n), b.max(n)));
            high - low
        });
        widths.max().unwrap_or(0)
    }
}

/// Lines from 0 to a length: evenly as far as `near_m`, then farther and farther apart.
fn lines(length_m: f64, near_m: f64, element_m: f64) -> Vec<f64> {
    let even = (near_m.min(length_m) / element_m).ceil().max(1.0) as usize;
    let mut lines: Vec<f64> = (0..=even).map(|k| k as f64 * element_m).collect();
    let start = even as f64 * element_m;
    if start >= length_m {
        lines.iter_mut().for_each(|line| *line *= length_m / start);
    }
    let (mut end, mut step) = (start, element_m);
    while end < length_m {
        step *= GROWTH;
        end += step;
        lines.push(end);
    }
    let stretch = (length_m - start) / (end - start);
    for line in &mut lines[even + 1..] {
        *line = start + stretch * (*line - start);
    }
    if let Some(last) = lines.last_mut() {
        *last = length_m;
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_at_the_length_to_the_last_bit() {
        for near in 1..60 {
            let lines = lines(0.04, 1e-3 * f64::from(near), 0.00125);
            assert_eq!([lines[0], lines[lines.len() - 1]], [0.0, 0.04]);
            assert!(lines.windows(2).all(|two| two[0] < two[1]));
        }
    }

    #[test]
    fn nodes_and_elements_fit() {
        let grid = Grid::new([0.05, 0.04], 0.01, 0.0025);
        for [a, b, c, d, ab, bc, cd, da] in &grid.elements {
            let x = |node: &usize| grid.nodes_m[*node];
            assert!(x(a)[0] < x(b)[0] && x(a)[1] == x(b)[1] && x(b)[1] < x(c)[1]);
            for (middle, ends) in [(ab, [a, b]), (bc, [b, c]), (cd, [c, d]), (da, [d, a])] {
                for axis in 0..2 {
                    let mean = 0.5 * (x(ends[0])[axis] + x(ends[1])[axis]);
                    assert!((x(middle)[axis] - mean).abs() < 1e-15);
                }
            }
        }
        assert!(grid.top.iter().flatten().all(|&node| grid.nodes_m[node][1] == 0.04));
        assert_eq!(grid.nodes_m.first(), Some(&[0.0, 0.0]));
        let used: std::collections::BTreeSet<_> = grid.elements.iter().flatten().collect();
        assert_eq!(used.len(), grid.nodes_m.len());
    }
}
