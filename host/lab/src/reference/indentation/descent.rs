//! Equilibria of a half section under a sphere: Newton's method on the energy.

use chaincell_host::error::{Error, Result};

use super::Press;
use super::band::Band;
use super::element::{self, Point};
use super::grid::Grid;
use super::law::{Law, Moduli};
use super::sphere::{self, Sphere, TopPoint};

/// Most steps of Newton's method to an equilibrium.
const STEPS_MAX: usize = 200;
/// Halvings of a step that does not lower the energy.
const HALVINGS: u32 = 30;
/// A promised decrease below this share of the energy is that of an equilibrium.
const ENOUGH: f64 = 1e-15;

/// A half section with its displacement.
pub struct Section {
    grid: Grid,
    points: Vec<[Point; 9]>,
    top: Vec<TopPoint>,
    held: Vec<usize>,
    moduli: Moduli,
    law: Law,
    /// (r, z) of each node \[m\].
    moves: Vec<[f64; 2]>,
}

/// Energy with its derivatives by the unknowns.
struct State {
    energy_j: f64,
    gradient: Vec<f64>,
    hessian: Band,
}

impl Section {
    pub fn new(grid: Grid, moduli: Moduli, law: Law) -> Self {
        let at = |nodes: &[usize; 8]| element::points(&nodes.map(|node| grid.nodes_m[node]));
        let points = grid.elements.iter().map(at).collect();
        let top = sphere::points(&grid.top, &grid.nodes_m);
        let mut held = Vec::new();
        for (node, &[r, z]) in grid.nodes_m.iter().enumerate() {
            if r == 0.0 || z == 0.0 {
                held.push(2 * node);
            }
            if z == 0.0 {
                held.push(2 * node + 1);
            }
        }
        let moves = vec![[0.0; 2]; grid.nodes_m.len()];
        Self { grid, points, top, held, moduli, law, moves }
    }

    /// Goes to the equilibrium under a sphere.
    ///
    /// # Errors
    /// None is found.
    pub fn settle(&mut self, sphere: &Sphere) -> Result<()> {
        for _ in 0..STEPS_MAX {
            let State { energy_j, gradient, hessian } = self.state(sphere)?;
            let step = downhill(&gradient, &hessian)?;
            let promised = 0.5 * gradient.iter().zip(&step).map(|(g, s)| g * s).sum::<f64>();
            if promised <= ENOUGH * energy_j {
                return Ok(());
            }
            let from = self.moves.clone();
            let lower = (0..HALVINGS).map(|halving| 0.5_f64.powi(halving as i32)).find(|share| {
                for (node, [r, z]) in self.moves.iter_mut().enumerate() {
                    let [at_r, at_z] = from[node];
                    *r = at_r - share * step[2 * node];
                    *z = at_z - share * step[2 * node + 1];
                }
                let least = 1e-4 * share * promised;
                self.energy(sphere).is_some_and(|energy| energy < energy_j - least)
            });
            if lower.is_none() {
                self.moves = from;
                let lost = promised < 1e-9 * energy_j;
                return if lost { Ok(()) } else { Err(self.stuck(sphere)) };
            }
        }
        Err(self.stuck(sphere))
    }

    fn stuck(&self, sphere: &Sphere) -> Error {
        let (radius_m, centre_m) = (sphere.radius_m, sphere.centre_m);
        Error::check(format!(
            "no equilibrium under a sphere of {radius_m} m with its centre at {centre_m} m; take \
             other elements, or less depth"
        ))
    }

    /// What the sphere feels.
    pub fn press(&self, sphere: &Sphere, depth_m: f64) -> Press {
        let energy_j = self.energy(sphere).unwrap_or(f64::NAN);
        let mut press = Press { depth_m, force_n: 0.0, energy_j, contact_m: 0.0, into_m: 0.0 };
        for point in &self.top {
            if let Some(touch) = sphere.touch(self.place(point), point.area_m2) {
                press.force_n += touch.gradient[1];
                press.contact_m = press.contact_m.max(point.rest_m);
                press.into_m = press.into_m.max(touch.depth_m);
            }
        }
        press
    }

    /// Where a point of the top is.
    fn place(&self, point: &TopPoint) -> [f64; 2] {
        let mut place = [0.0; 2];
        for (&node, weight) in point.nodes.iter().zip(point.weights) {
            for (axis, place) in place.iter_mut().enumerate() {
                *place += weight * (self.grid.nodes_m[node][axis] + self.moves[node][axis]);
            }
        }
        place
    }

    /// Energy of slab and penalty \[J\]; `None` where some material is inside out.
    fn energy(&self, sphere: &Sphere) -> Option<f64> {
        let mut energy = 0.0;
        for (nodes, points) in self.grid.elements.iter().zip(&self.points) {
            let moves = nodes.map(|node| self.moves[node]);
            for point in points {
                let response = self.moduli.response(self.law, &point.slopes(&moves))?;
                energy += point.volume_m3 * response.energy;
            }
        }
        let touch = |point: &TopPoint| sphere.touch(self.place(point), point.area_m2);
        Some(energy + self.top.iter().filter_map(touch).map(|touch| touch.energy_j).sum::<f64>())
    }

    fn state(&self, sphere: &Sphere) -> Result<State> {
        let size = 2 * self.moves.len();
        let mut state = State {
            energy_j: 0.0,
            gradient: vec![0.0; size],
            hessian: Band::new(size, 2 * self.grid.width() + 1),
        };
        for (nodes, points) in self.grid.elements.iter().zip(&self.points) {
            for point in points {
                self.add_volume(nodes, point, &mut state).ok_or_else(|| self.stuck(sphere))?;
            }
        }
        for point in &self.top {
            let Some(touch) = sphere.touch(self.place(point), point.area_m2) else { continue };
            state.energy_j += touch.energy_j;
            for (&one, weight) in point.nodes.iter().zip(point.weights) {
                for a in 0..2 {
                    state.gradient[2 * one + a] += weight * touch.gradient[a];
                    for (&two, other) in point.nodes.iter().zip(point.weights) {
                        for b in 0..2 {
                            let entry = weight * other * touch.hessian[a][b];
                            state.add(2 * one + a, 2 * two + b, entry);
                        }
                    }
                }
            }
        }
        for &unknown in &self.held {
            state.gradient[unknown] = 0.0;
            state.hessian.hold(unknown);
        }
        Ok(state)
    }

    /// Adds the material around a point; `None` where it is inside out.
    fn add_volume(&self, nodes: &[usize; 8], point: &Point, state: &mut State) -> Option<()> {
        let moves = nodes.map(|node| self.moves[node]);
        let response = self.moduli.response(self.law, &point.slopes(&moves))?;
        state.energy_j += point.volume_m3 * response.energy;
        let units: [[f64; 5]; 16] = std::array::from_fn(|k| point.unit(k / 2)[k % 2]);
        let dot = |a: &[f64; 5], b: &[f64; 5]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (k, unit) in units.iter().enumerate() {
            let row = 2 * nodes[k / 2] + k % 2;
            state.gradient[row] += point.volume_m3 * dot(&response.stress, unit);
            let change = response.tangent.map(|tangent| point.volume_m3 * dot(&tangent, unit));
            for (l, other) in units.iter().enumerate() {
                state.add(row, 2 * nodes[l / 2] + l % 2, dot(&change, other));
            }
        }
        Some(())
    }
}

impl State {
    /// Adds an entry of the lower half.
    fn add(&mut self, row: usize, column: usize, entry: f64) {
        if column <= row {
            *self.hessian.at(row, column) += entry;
        }
    }
}

/// Newton's step, its sign turned; with a stiffer diagonal where the energy does not curve upwards.
fn downhill(gradient: &[f64], hessian: &Band) -> Result<Vec<f64>> {
    let mut share = 0.0;
    while share < 1e3 {
        let mut matrix = hessian.clone();
        matrix.stiffen(share);
        if let Some(factor) = matrix.factor() {
            let mut step = gradient.to_vec();
            factor.solve(&mut step);
            return Ok(step);
        }
        share = f64::max(1e-4, 4.0 * share);
    }
    Err(Error::check("the second derivative is far from positive; take less depth".to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Even strain is an equilibrium: no node inside is pulled.
    #[test]
    fn even_strain_passes_the_patch_test() {
        let (r, z) = ([0.0, 0.3, 1.0, 1.2, 2.0], [0.0, 0.5, 0.7, 1.5]);
        let away = Sphere { radius_m: 1.0, centre_m: 9.0, stiffness: 1.0, turns_m: 1.0 };
        for law in [Law::Hooke, Law::NeoHooke] {
            let grid = Grid::of_lines(&r, &z);
            let mut section = Section::new(grid, Moduli::new(5000.0, 0.45), law);
            let nodes = section.grid.nodes_m.clone();
            section.moves = nodes.iter().map(|[r, z]| [0.2 * r, -0.25 * z]).collect();
            let state = section.state(&away).unwrap();
            let mut inside = 0;
            for (node, [r, z]) in nodes.iter().enumerate() {
                if *r < 2.0 && *z > 0.0 && *z < 1.5 {
                    let pull = state.gradient[2 * node].hypot(state.gradient[2 * node + 1]);
                    assert!(pull < 1e-9 * 5000.0, "{law:?} {r} {z} {pull}");
                    inside += 1;
                }
            }
            let most = state.gradient.iter().fold(0.0, |most: f64, g| most.max(g.abs()));
            assert!(inside > 20 && most > 100.0, "{inside} {most}");
        }
    }
}
