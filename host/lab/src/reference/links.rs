//! The links in double precision: energy, residual, force on held cells, second derivative.

use chaincell_kernel::Model;

use super::elastic::Elastic;
use super::vectors::{dot, minus, norm, plus};
use chaincell_host::error::{Error, Result};

/// Below this fraction of l0^2 a link takes its direction from the rest shape, as in the kernel.
const COINCIDENT: f64 = 1e-12;

/// A body's links in double precision, in the model's order of cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Links {
    rest: Vec<[f64; 3]>,
    ends: Vec<[u32; 2]>,
    rest_length: Vec<f64>,
    weight: Vec<f64>,
    alpha: Vec<f64>,
    fixed: Vec<bool>,
}

/// What one link does at its present length.
#[derive(Debug, Clone, Copy)]
struct Pull {
    /// Unit vector from the first end to the second.
    direction: [f64; 3],
    /// How far the link is outside its band, negative where it is too short.
    excess: f64,
    /// Present length.
    length: f64,
}

impl Links {
    /// The links of a model, in internal units: mean link lengths from the body's centre.
    #[must_use]
    pub fn of_model(model: &Model<'_>) -> Self {
        let cells = 0..model.cells();
        let wide = |p: [f32; 3]| p.map(f64::from);
        let upper = model.upper();
        let ends = cells.clone().flat_map(|i| {
            model.row(i).filter_map(move |link| Some([i as u32, u32::from(*upper.get(link)?)]))
        });
        let links = 0..model.links();
        let mut fixed = vec![false; model.cells()];
        for &cell in model.fixed() {
            fixed[usize::from(cell)] = true;
        }
        Self {
            rest: cells.clone().map(|cell| wide(model.rest_position(cell))).collect(),
            ends: ends.collect(),
            rest_length: model.rest_lengths().iter().map(|&l| f64::from(l)).collect(),
            weight: links.clone().map(|link| f64::from(model.link_weight(link))).collect(),
            alpha: links.map(|link| f64::from(model.link_alpha(link))).collect(),
            fixed,
        }
    }

    /// Links between `rest` positions along `edges`, of weight 1 and one `alpha`, the cells
    /// `fixed` held for ever; rest lengths are the distances.
    ///
    /// # Errors
    /// An edge or a fixed cell beyond the last position.
    pub fn from_edges(
        rest: &[[f64; 3]],
        edges: &[[u32; 2]],
        alpha: f64,
        fixed: &[u32],
    ) -> Result<Self> {
        let last = rest.len();
        if let Some(cell) =
            edges.as_flattened().iter().chain(fixed).find(|&&cell| cell as usize >= last)
        {
            return Err(Error::input(format!("cell {cell}: there are {last} cells")));
        }
        let mut is_fixed = vec![false; last];
        for &cell in fixed {
            is_fixed[cell as usize] = true;
        }
        let length = |&[i, j]: &[u32; 2]| norm(minus(rest[j as usize], rest[i as usize]));
        Ok(Self {
            rest: rest.to_vec(),
            ends: edges.to_vec(),
            rest_length: edges.iter().map(length).collect(),
            weight: vec![1.0; edges.len()],
            alpha: vec![alpha; edges.len()],
            fixed: is_fixed,
        })
    }

    /// The same links with a weight each.
    ///
    /// # Errors
    /// Another number of weights than of links.
    pub fn with_weights(mut self, weight: Vec<f64>) -> Result<Self> {
        if weight.len() != self.ends.len() {
            return Err(Error::input(format!(
                "{} weights for {} links",
                weight.len(),
                self.ends.len()
            )));
        }
        self.weight = weight;
        Ok(self)
    }

    /// The same links with their bands closed to the rest lengths (the paper's unloading).
    #[must_use]
    pub fn closed(&self) -> Self {
        Self { alpha: vec![0.0; self.alpha.len()], ..self.clone() }
    }

    /// Rest positions.
    #[must_use]
    pub fn rest(&self) -> &[[f64; 3]] {
        &self.rest
    }

    /// Ends of every link.
    #[must_use]
    pub fn ends(&self) -> &[[u32; 2]] {
        &self.ends
    }

    /// Rest lengths.
    #[must_use]
    pub fn rest_lengths(&self) -> &[f64] {
        &self.rest_length
    }

    /// Weights.
    #[must_use]
    pub fn weights(&self) -> &[f64] {
        &self.weight
    }

    /// Half-widths of the bands \[rest lengths\].
    #[must_use]
    pub fn alphas(&self) -> &[f64] {
        &self.alpha
    }

    /// Which cells are held for ever.
    #[must_use]
    pub fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    #[inline]
    fn pull(&self, link: usize, p: &[[f64; 3]]) -> Option<Pull> {
        let [i, j] = self.ends[link].map(|end| end as usize);
        let l0 = self.rest_length[link];
        let d = minus(p[j], p[i]);
        let squared = dot(d, d);
        let (length, direction) = if squared < COINCIDENT * l0 * l0 {
            let rest = minus(self.rest[j], self.rest[i]);
            let norm = norm(rest);
            (squared.sqrt(), rest.map(|x| x / norm))
        } else {
            let length = squared.sqrt();
            (length, d.map(|x| x / length))
        };
        let (low, high) = ((1.0 - self.alpha[link]) * l0, (1.0 + self.alpha[link]) * l0);
        // Inclusive: at alpha 0 a link at its rest length is stiff, it only pulls with nothing.
        let excess = if length >= high {
            length - high
        } else if length <= low {
            length - low
        } else {
            return None;
        };
        Some(Pull { direction, excess, length })
    }

    /// Energy E = sum of w d^2 / 4.
    #[must_use]
    pub fn energy(&self, p: &[[f64; 3]]) -> f64 {
        let term =
            |link| self.pull(link, p).map_or(0.0, |pull| self.weight[link] * pull.excess.powi(2));
        0.25 * (0..self.ends.len()).map(term).sum::<f64>()
    }

    /// Energy, and into `residual` r = sum of w mu (`P_j` - `P_i`) = -grad E of every cell, fixed
    /// and held ones included (Eq. 12).
    pub fn residual(&self, p: &[[f64; 3]], residual: &mut [[f64; 3]]) -> f64 {
        residual.fill([0.0; 3]);
        let mut energy = 0.0;
        for (link, ends) in self.ends.iter().enumerate() {
            let Some(pull) = self.pull(link, p) else { continue };
            let wd = self.weight[link] * pull.excess;
            energy += 0.25 * wd * pull.excess;
            let [i, j] = ends.map(|end| end as usize);
            residual[i] = plus(residual[i], 0.5 * wd, pull.direction);
            residual[j] = plus(residual[j], -0.5 * wd, pull.direction);
        }
        energy
    }

    /// Force of the links on the cells `of` in internal units: the sum of their residuals. Times
    /// [`Model::force_unit_n`] it is in newtons.
    #[must_use]
    pub fn force(&self, p: &[[f64; 3]], of: &[usize]) -> [f64; 3] {
        Elastic::force(self, p, of)
    }
}

impl Elastic for Links {
    type Curvature = Vec<LinkCurvature>;

    fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    fn length_unit(&self) -> f64 {
        self.rest_length.iter().sum::<f64>() / self.rest_length.len() as f64
    }

    /// The residual of a link of weight 1 is half its excess.
    fn residual_unit(&self) -> f64 {
        self.length_unit()
    }

    /// W / 2, the diagonal of the links' Laplacian.
    fn scale(&self) -> Vec<f64> {
        let mut scale = vec![0.0; self.rest.len()];
        for (ends, w) in self.ends.iter().zip(&self.weight) {
            for &end in ends {
                scale[end as usize] += 0.5 * w;
            }
        }
        scale
    }

    fn residual(&self, p: &[[f64; 3]], residual: &mut [[f64; 3]]) -> f64 {
        Self::residual(self, p, residual)
    }

    /// Link by link, the links between two cells that are not free left out.
    fn curvature(&self, p: &[[f64; 3]], free: &[bool]) -> Vec<LinkCurvature> {
        let mut all = Vec::with_capacity(self.ends.len());
        for (link, &ends) in self.ends.iter().enumerate() {
            let [i, j] = ends.map(|end| end as usize);
            if !free[i] && !free[j] {
                continue;
            }
            let Some(pull) = self.pull(link, p) else { continue };
            // Where the ends coincide the transverse part is unbounded below; it is left out.
            let across = if pull.length > 1e-6 * self.rest_length[link] {
                pull.excess / pull.length
            } else {
                0.0
            };
            let half = 0.5 * self.weight[link];
            let n = pull.direction;
            let block = |a: usize, b: usize| {
                let along = (1.0 - across) * n[a] * n[b];
                half * if a == b { along + across } else { along }
            };
            all.push(LinkCurvature {
                ends,
                block: [
                    block(0, 0),
                    block(1, 1),
                    block(2, 2),
                    block(0, 1),
                    block(0, 2),
                    block(1, 2),
                ],
            });
        }
        all
    }

    fn times(&self, curvature: &Self::Curvature, v: &[[f64; 3]], product: &mut [[f64; 3]]) {
        product.fill([0.0; 3]);
        for link in curvature {
            let [i, j] = link.ends.map(|end| end as usize);
            let pulled = symmetric_times(&link.block, minus(v[i], v[j]));
            product[i] = plus(product[i], 1.0, pulled);
            product[j] = plus(product[j], -1.0, pulled);
        }
    }
}

/// The 3 x 3 block of a link in the second derivative of E: xx, yy, zz, xy, xz, yz.
#[derive(Debug, Clone, Copy)]
pub struct LinkCurvature {
    ends: [u32; 2],
    block: [f64; 6],
}

/// A symmetric 3 x 3 block times a vector.
#[inline]
fn symmetric_times(block: &[f64; 6], v: [f64; 3]) -> [f64; 3] {
    let [xx, yy, zz, xy, xz, yz] = *block;
    [
        xx * v[0] + xy * v[1] + xz * v[2],
        xy * v[0] + yy * v[1] + yz * v[2],
        xz * v[0] + yz * v[1] + zz * v[2],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two triangles with a shared side, bent out of their plane, with a band.
    fn bent() -> (Links, Vec<[f64; 3]>) {
        let rest = [[0.0; 3], [1.0, 0.0, 0.0], [0.4, 0.9, 0.0], [1.3, 1.1, 0.2]];
        let edges = [[0, 1], [0, 2], [1, 2], [1, 3], [2, 3]];
        let links = Links::from_edges(&rest, &edges, 0.05, &[0]).unwrap();
        let links = links.with_weights(vec![1.0, 2.0, 0.5, 1.5, 3.0]).unwrap();
        (links, vec![[0.0; 3], [1.3, 0.1, -0.2], [0.1, 0.5, 0.3], [1.0, 1.6, 0.4]])
    }

    #[test]
    fn the_residual_is_minus_the_gradient_and_the_curvature_its_slope() {
        let (links, p) = bent();
        let free = [true; 4];
        let mut at = vec![[0.0; 3]; 4];
        assert_eq!(links.residual(&p, &mut at), links.energy(&p));
        let curvature = links.curvature(&p, &free);
        let step = 1e-6;
        for cell in 0..4 {
            for axis in 0..3 {
                let shifted = |by: f64| {
                    let mut p = p.clone();
                    p[cell][axis] += by;
                    let mut r = vec![[0.0; 3]; 4];
                    (links.residual(&p, &mut r), r)
                };
                let ((e_plus, r_plus), (e_minus, r_minus)) = (shifted(step), shifted(-step));
                let slope = (e_plus - e_minus) / (2.0 * step);
                assert!((slope + at[cell][axis]).abs() < 1e-8, "{slope} {}", at[cell][axis]);
                let mut unit = [[0.0; 3]; 4];
                unit[cell][axis] = 1.0;
                let mut product = [[0.0; 3]; 4];
                links.times(&curvature, &unit, &mut product);
                for other in 0..4 {
                    for x in 0..3 {
                        let slope = (r_minus[other][x] - r_plus[other][x]) / (2.0 * step);
                        assert!((slope - product[other][x]).abs() < 1e-7);
                    }
                }
            }
        }
    }

    #[test]
    fn coincident_ends_part_along_the_rest_shape() {
        let (links, mut p) = bent();
        p[1] = p[0];
        let mut residual = vec![[0.0; 3]; 4];
        links.residual(&p, &mut residual);
        assert!(residual[0][0] < -0.4 && residual.iter().flatten().all(|x| x.is_finite()));
    }

    #[test]
    fn a_cell_that_is_not_there_is_refused() {
        assert!(Links::from_edges(&[[0.0; 3]], &[[0, 1]], 0.0, &[]).is_err());
        assert!(Links::from_edges(&[[0.0; 3]; 2], &[[0, 1]], 0.0, &[2]).is_err());
        assert!(bent().0.with_weights(vec![1.0]).is_err());
    }
}
