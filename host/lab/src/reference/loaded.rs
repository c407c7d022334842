//! A body under dead loads, some coordinates of its nodes kept.

use super::elastic::Elastic;
use super::vectors::dot;

/// A body with a force on each node and coordinates that stay where a search begins.
///
/// The energy is that of the body less the forces' work from the origin. Cost: as the body, and one pass over
/// the nodes.
#[derive(Debug, Clone)]
pub struct Loaded<'b, B> {
    /// The body.
    pub body: &'b B,
    /// Force on each node, in the unit of the body's residual.
    pub force: Vec<[f64; 3]>,
    /// The coordinates of each node that are kept.
    pub kept: Vec<[bool; 3]>,
}

impl<B> Loaded<'_, B> {
    /// Puts zero where a coordinate is kept.
    fn mask(&self, field: &mut [[f64; 3]]) {
        for (vector, kept) in field.iter_mut().zip(&self.kept) {
            for (x, kept) in vector.iter_mut().zip(kept) {
                if *kept {
                    *x = 0.0;
                }
            }
        }
    }
}

impl<B: Elastic> Elastic for Loaded<'_, B> {
    type Curvature = B::Curvature;

    fn fixed(&self) -> &[bool] {
        self.body.fixed()
    }

    fn length_unit(&self) -> f64 {
        self.body.length_unit()
    }

    fn residual_unit(&self) -> f64 {
        self.body.residual_unit()
    }

    fn scale(&self) -> Vec<f64> {
        self.body.scale()
    }

    fn residual(&self, positions: &[[f64; 3]], residual: &mut [[f64; 3]]) -> f64 {
        let mut energy = self.body.residual(positions, residual);
        for ((r, force), x) in residual.iter_mut().zip(&self.force).zip(positions) {
            energy -= dot(*force, *x);
            *r = std::array::from_fn(|axis| r[axis] + force[axis]);
        }
        self.mask(residual);
        energy
    }

    fn curvature(&self, positions: &[[f64; 3]], free: &[bool]) -> Self::Curvature {
        self.body.curvature(positions, free)
    }

    fn times(&self, curvature: &Self::Curvature, v: &[[f64; 3]], product: &mut [[f64; 3]]) {
        self.body.times(curvature, v, product);
        self.mask(product);
    }
}

#[cfg(test)]
mod tests {
    use super::super::links::Links;
    use super::super::minimum::minimum;
    use super::*;

    /// Two springs in a row along x, the far end drawn: its way is that of both, and the middle keeps its z.
    #[test]
    fn a_load_draws_springs_in_a_row() {
        let rest = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let links = Links::from_edges(&rest, &[[0, 1], [1, 2]], 0.0, &[0]).unwrap();
        let mut start = rest;
        start[1][2] = 0.3;
        let force = vec![[0.0; 3], [0.0, 0.0, 5.0], [0.1, 0.0, 0.0]];
        let kept = vec![[false; 3], [false, true, true], [false, true, true]];
        let loaded = Loaded { body: &links, force, kept };
        let found = minimum(&loaded, &[], &start, 1e-12);
        assert!(found.residual_max <= 1e-12, "{found:?}");
        assert!((found.positions[1][2] - 0.3).abs() < 1e-15, "{found:?}");
        // A link of weight 1 pulls with half its excess.
        let along = [0, 1].map(|link| {
            let [a, b] = [found.positions[link], found.positions[link + 1]];
            let length = ((b[0] - a[0]).powi(2) + (b[2] - a[2]).powi(2)).sqrt();
            0.5 * (length - 1.0) * (b[0] - a[0]) / length
        });
        assert!(along.iter().all(|pull| (pull - 0.1).abs() < 1e-10), "{along:?} {found:?}");
    }
}
