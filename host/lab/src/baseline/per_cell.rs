//! The plain loop: every cell over its neighbours, a branch a link, square root and division for
//! taut links only, then the damped step of Eq. 12 with theta / n.

use chaincell_kernel::Model;

use super::{Baseline, difference, dot, plus, rest};

/// Damping of the step, below the proven 2.
const THETA: f32 = 1.8;

/// Cells with their half-links in compressed rows.
pub struct PerCell {
    rows: Vec<u32>,
    neighbour: Vec<u32>,
    rest_length: Vec<f32>,
    weight: Vec<f32>,
    alpha: Vec<f32>,
    /// theta / W; 0 for fixed and held cells.
    mobility: Vec<f32>,
    position: Vec<[f32; 3]>,
    residual: Vec<[f32; 3]>,
}

impl Baseline for PerCell {
    const NAME: &'static str = "plain per-cell loop";

    fn new(model: &Model<'_>) -> Self {
        let (mut rows, mut neighbour) = (vec![0], Vec::new());
        let (mut rest_length, mut weight, mut alpha) = (Vec::new(), Vec::new(), Vec::new());
        for cell in 0..model.cells() {
            for (link, other) in model.neighbours(cell) {
                neighbour.push(other as u32);
                rest_length.push(model.rest_lengths()[link]);
                weight.push(model.link_weight(link));
                alpha.push(model.link_alpha(link));
            }
            rows.push(neighbour.len() as u32);
        }
        let mobility = (0..model.cells()).map(|cell| {
            let weight = model.cell_weight(cell);
            if model.is_fixed(cell as u16) || weight == 0.0 { 0.0 } else { THETA / weight }
        });
        Self {
            mobility: mobility.collect(),
            rows,
            neighbour,
            rest_length,
            weight,
            alpha,
            position: rest(model),
            residual: vec![[0.0; 3]; model.cells()],
        }
    }

    fn hold(&mut self, cell: usize, position: [f32; 3]) {
        self.position[cell] = position;
        self.mobility[cell] = 0.0;
    }

    fn step(&mut self) {
        for cell in 0..self.position.len() {
            let here = self.position[cell];
            let mut sum = [0.0_f32; 3];
            for half in self.rows[cell] as usize..self.rows[cell + 1] as usize {
                let way = difference(here, self.position[self.neighbour[half] as usize]);
                let squared = dot(way, way);
                let high = (1.0 + self.alpha[half]) * self.rest_length[half];
                let low = (1.0 - self.alpha[half]) * self.rest_length[half];
                let mu = if squared > high * high {
                    let length = squared.sqrt();
                    (length - high) / (2.0 * length)
                } else if squared < low * low && squared > 0.0 {
                    let length = squared.sqrt();
                    (length - low) / (2.0 * length)
                } else {
                    continue;
                };
                sum = plus(sum, self.weight[half] * mu, way);
            }
            self.residual[cell] = sum;
        }
        for ((p, r), m) in self.position.iter_mut().zip(&self.residual).zip(&self.mobility) {
            *p = plus(*p, *m, *r);
        }
    }

    fn positions(&self) -> &[[f32; 3]] {
        &self.position
    }
}

impl PerCell {
    /// Puts every cell at a position, held ones included: the state that a measurement starts from.
    pub fn set_positions(&mut self, positions: &[[f32; 3]]) {
        self.position.copy_from_slice(positions);
    }
}
