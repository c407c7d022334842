//! A local minimum of the energy under prescribed cells, followed from a start.
//!
//! Trust-region Newton with preconditioned conjugate gradients (Steihaug 1983; Nocedal and Wright,
//! Numerical Optimization, algorithms 4.1 and 7.2). What is compressed makes the second derivative
//! indefinite: a direction of negative curvature is followed to the rim of the trust region, so a
//! body that buckles leaves the saddle downhill. No cell moves more than a quarter of a mean rest
//! length an iteration, which keeps the descent in the valley of its start.

use super::elastic::{Elastic, Held};
use super::vectors::{dot, fields, plus};

/// Most Newton steps; a warm start takes about ten, a fold a few hundred.
const ITERATIONS_MAX: usize = 2000;
/// Most conjugate-gradient steps in a Newton step.
const INNER_MAX: usize = 3000;
/// Longest way of a cell in one iteration [mean rest lengths].
const CELL_MOVE_MAX: f64 = 0.25;
/// A predicted decrease below this fraction of the energy is lost in the rounding of its sum.
const ROUNDING: f64 = 1e-13;

type Vectors = Vec<[f64; 3]>;

/// A stationary point as far as the iteration got.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// Positions of all cells.
    pub positions: Vec<[f64; 3]>,
    /// Energy there, in internal units.
    pub energy: f64,
    /// Largest residual |`r_i`| of a free cell; above the tolerance where the iteration ended early.
    pub residual_max: f64,
    /// Newton steps tried.
    pub iterations: usize,
}

/// Follows the energy downhill from `start`, the cells `held` put at their positions, until no
/// free cell has a residual above `tolerance`.
///
/// Positions are in the body's unit, `tolerance` in that of its residual (that of a link is half
/// its excess). Cost: a few hundred passes over the body from a warm start; memory of one second
/// derivative.
#[must_use]
pub fn minimum<E: Elastic>(body: &E, held: &Held, start: &[[f64; 3]], tolerance: f64) -> Minimum {
    Descent::new(body, held, start).run(tolerance)
}

struct Descent<'a, E> {
    body: &'a E,
    free: Vec<bool>,
    /// The diagonal of the preconditioner and of the trust region's norm.
    scale: Vec<f64>,
    unit: f64,
    positions: Vectors,
    residual: Vectors,
    energy: f64,
}

/// A trial step with the decrease that the quadratic model promises.
struct Step {
    way: Vectors,
    decrease: f64,
    on_rim: bool,
}

impl<'a, E: Elastic> Descent<'a, E> {
    fn new(body: &'a E, held: &Held, start: &[[f64; 3]]) -> Self {
        let mut positions = start.to_vec();
        for &(cell, position) in held {
            positions[cell] = position;
        }
        let scale = body.scale();
        let mut free = body.free(held);
        for (free, scale) in free.iter_mut().zip(&scale) {
            *free &= *scale > 0.0;
        }
        let unit = body.length_unit();
        let residual = vec![[0.0; 3]; positions.len()];
        let mut descent = Self { body, free, scale, unit, positions, residual, energy: 0.0 };
        (descent.energy, descent.residual) = descent.evaluate(&descent.positions);
        descent
    }

    /// Energy and masked residual.
    fn evaluate(&self, positions: &[[f64; 3]]) -> (f64, Vectors) {
        let mut residual = vec![[0.0; 3]; positions.len()];
        let energy = self.body.residual(positions, &mut residual);
        self.mask(&mut residual);
        (energy, residual)
    }

    fn run(mut self, tolerance: f64) -> Minimum {
        let mut radius = self.unit * self.scale.iter().sum::<f64>().sqrt();
        let mut iterations = 0;
        while largest(&self.residual) > tolerance && iterations < ITERATIONS_MAX {
            iterations += 1;
            let step = self.step(radius, tolerance);
            let length = self.length(&step.way);
            let trial = fields(&self.positions, 1.0, &step.way);
            let (energy, residual) = self.evaluate(&trial);
            let quality = if step.decrease > ROUNDING * self.energy.abs() {
                (self.energy - energy) / step.decrease
            } else if largest(&residual) < largest(&self.residual) {
                1.0
            } else {
                0.0
            };
            if quality < 0.25 {
                radius = 0.25 * length;
            } else if quality > 0.75 && step.on_rim {
                radius = radius.max(2.0 * length);
            }
            if quality > 0.05 {
                (self.positions, self.energy, self.residual) = (trial, energy, residual);
            } else if length == 0.0 {
                break;
            }
        }
        Minimum {
            residual_max: largest(&self.residual),
            positions: self.positions,
            energy: self.energy,
            iterations,
        }
    }

    /// Length in the norm of the trust region.
    fn length(&self, way: &[[f64; 3]]) -> f64 {
        way.iter().zip(&self.scale).map(|(d, s)| s * dot(*d, *d)).sum::<f64>().sqrt()
    }

    /// Steihaug's conjugate gradients inside the trust region, then no cell too far.
    fn step(&self, radius: f64, tolerance: f64) -> Step {
        let mut step = self.conjugate_gradients(radius, tolerance);
        let farthest = largest(&step.way);
        let limit = CELL_MOVE_MAX * self.unit;
        if farthest > limit {
            // On the way to its end the model falls all along, and least at the end.
            let part = limit / farthest;
            step.way.iter_mut().for_each(|d| *d = d.map(|x| part * x));
            step.decrease = self.promised(&step.way);
            step.on_rim = true;
        }
        step
    }

    fn conjugate_gradients(&self, radius: f64, tolerance: f64) -> Step {
        let curvature = self.body.curvature(&self.positions, &self.free);
        let precondition = |r: &[[f64; 3]]| -> Vectors {
            let each = r.iter().zip(&self.scale);
            each.map(|(r, s)| if *s > 0.0 { r.map(|x| x / s) } else { [0.0; 3] }).collect()
        };
        let cells = self.positions.len();
        let mut way = vec![[0.0; 3]; cells];
        let mut r = self.residual.clone();
        let mut y = precondition(&r);
        let mut p = y.clone();
        let mut rho = inner(&r, &y);
        let mut decrease = 0.0;
        // Inexact Newton: as accurate as the distance from the minimum deserves.
        let reached = largest(&r) / self.body.residual_unit();
        let aim = (0.3 * tolerance).max(largest(&r) * reached.sqrt().clamp(1e-4, 0.1));
        let mut product = vec![[0.0; 3]; cells];
        for _ in 0..INNER_MAX {
            self.body.times(&curvature, &p, &mut product);
            self.mask(&mut product);
            let kappa = inner(&p, &product);
            let stride = rho / kappa;
            let to_rim = || self.to_rim(&way, &p, radius);
            if kappa <= 1e-12 * self.length(&p).powi(2) || stride >= to_rim() {
                let stride = to_rim();
                decrease += stride * rho - 0.5 * stride * stride * kappa;
                add(&mut way, stride, &p);
                return Step { way, decrease, on_rim: true };
            }
            decrease += 0.5 * stride * rho;
            add(&mut way, stride, &p);
            add(&mut r, -stride, &product);
            if largest(&r) <= aim {
                break;
            }
            y = precondition(&r);
            let next = inner(&r, &y);
            let beta = next / rho;
            rho = next;
            for (p, y) in p.iter_mut().zip(&y) {
                *p = plus(*y, beta, *p);
            }
        }
        Step { way, decrease, on_rim: false }
    }

    /// How far along `p` the rim of the trust region lies, from `way` inside it.
    fn to_rim(&self, way: &[[f64; 3]], p: &[[f64; 3]], radius: f64) -> f64 {
        let product = |a: &[[f64; 3]], b: &[[f64; 3]]| {
            a.iter().zip(b).zip(&self.scale).map(|((a, b), s)| s * dot(*a, *b)).sum::<f64>()
        };
        let (pp, wp, ww) = (product(p, p), product(way, p), product(way, way));
        let room = (radius * radius - ww).max(0.0);
        room / (wp + (wp * wp + pp * room).sqrt())
    }

    /// What the quadratic model promises for a step.
    fn promised(&self, way: &[[f64; 3]]) -> f64 {
        let curvature = self.body.curvature(&self.positions, &self.free);
        let mut product = vec![[0.0; 3]; way.len()];
        self.body.times(&curvature, way, &mut product);
        inner(&self.residual, way) - 0.5 * inner(way, &product)
    }

    /// Puts zero where nothing may move.
    fn mask(&self, field: &mut [[f64; 3]]) {
        let cells = field.iter_mut().zip(&self.free);
        cells.filter(|(_, free)| !**free).for_each(|(x, _)| *x = [0.0; 3]);
    }
}

fn largest(v: &[[f64; 3]]) -> f64 {
    v.iter().map(|v| dot(*v, *v)).fold(0.0, f64::max).sqrt()
}

fn inner(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum()
}

fn add(a: &mut [[f64; 3]], factor: f64, b: &[[f64; 3]]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a = plus(*a, factor, *b);
    }
}

#[cfg(test)]
mod tests {
    use super::super::links::Links;
    use super::super::vectors::norm;
    use super::*;

    /// A straight chain of three cells, its ends pressed together: the middle one is on the saddle.
    #[test]
    fn a_pressed_chain_buckles_to_its_rest_lengths() {
        let rest = [[-1.0, 0.0, 0.0], [0.0; 3], [1.0, 0.0, 0.0]];
        let links = Links::from_edges(&rest, &[[0, 1], [1, 2]], 0.0, &[0, 2]).unwrap();
        let held = [(0, [-0.8, 0.0, 0.0]), (2, [0.8, 0.0, 0.0])];
        let start = [[-0.8, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.8, 0.0, 0.0]];
        let found = minimum(&links, &held, &start, 1e-12);
        assert!(found.residual_max <= 1e-12 && found.energy < 1e-20, "{found:?}");
        assert!((norm(found.positions[1]) - 0.6).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn two_springs_share_a_stretch_by_their_weights() {
        let rest = [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        let links = Links::from_edges(&rest, &[[0, 1], [1, 2]], 0.0, &[0]).unwrap();
        let links = links.with_weights(vec![3.0, 1.0]).unwrap();
        let found = minimum(&links, &[(2, [3.0, 0.0, 0.0])], &rest, 1e-13);
        assert!((found.positions[1][0] - 1.25).abs() < 1e-12, "{found:?}");
        // 1/4 (3 / 16 + 9 / 16), and the held cell feels half the excess of its link.
        assert!((found.energy - 0.1875).abs() < 1e-12);
        assert!((links.force(&found.positions, &[2])[0] + 0.375).abs() < 1e-12);
    }
}
