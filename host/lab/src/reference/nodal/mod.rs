//! Tissue as nodal shapes with their spread, in double precision.
//!
//! Every node i has a volume `V_i`, a quarter of its tetrahedra's, and the mean `F_i` of their
//! deformation gradients (Dohrmann, Heinstein, Jung, Key, Witkowski 2000; Bonet and Burton 1998).
//! Its energy is a law of the stretches of `F_i` ([`Law`]). That alone has modes without energy,
//! so [`SPREAD`] of the shape's share is taken on the tetrahedra instead (Puso and Solberg 2006):
//!
//! E = sum over nodes of `V_i` law(`F_i`) + beta mu sum over nodes and their tetrahedra of
//! `V_t` / 4 |`F_t` - `F_i`|^2
//!
//! The second sum is that of `w_ij` |`u_j` - `u_i`|^2 over the links less that of
//! `V_i` |`F_i` - 1|^2 over the nodes, so no tetrahedron is needed after [`Shape`] is made.
//!
//! The rotation and the volume-preserving shape nearest to `F_i` are found exactly here: what this
//! gives is the model's equilibrium, not that of an iteration.

mod det1;
mod law;
#[cfg(test)]
mod running;
mod stretches;
#[cfg(test)]
mod tests;

use nalgebra::{Matrix3, Vector3};

use super::elastic::Elastic;
use super::vectors::{dot, minus, norm, plus};
pub use chaincell_host::bake::tissue::shape::{Shape, volume_m3};
use chaincell_host::error::{Error, Result};
use chaincell_kernel::Model;
use law::Moduli;
pub use law::{BAND_FROM, Law, Tangent};
use stretches::Stretches;

/// Beta: the part of the shape's stiffness that acts on tetrahedra.
///
/// A small displacement has at least beta / (1 + beta) of the energy of shape that linear
/// tetrahedra give it (mu |sym|^2 each), so no pattern that cancels in the means goes free: of
/// a^2 + beta b^2 with a + b = c that is the least.
pub const SPREAD: f64 = 0.2;

/// A body of nodal shapes. Positions \[m\], residuals \[N\], energy \[J\].
#[derive(Debug, Clone, PartialEq)]
pub struct Nodal {
    rest: Vec<[f64; 3]>,
    fixed: Vec<bool>,
    /// Weights of links are times mu.
    shape: Shape,
    young_pa: f64,
    /// Of each node.
    moduli: Vec<Moduli>,
    link_m: f64,
}

impl Nodal {
    /// A body at rest at `rest_m` `[node][axis]`, made of `tetrahedra`, the nodes `fixed` held for
    /// ever.
    ///
    /// # Errors
    /// As [`Shape::new`]; moduli out of the ranges of [`Law`]; a fixed node beyond the last.
    pub fn new(
        rest_m: &[[f64; 3]],
        tetrahedra: &[[u32; 4]],
        fixed: &[u32],
        law: Law,
    ) -> Result<Self> {
        Self::of_laws(rest_m, tetrahedra, fixed, &vec![law; rest_m.len()])
    }

    /// The same with a law for each node.
    fn of_laws(
        rest_m: &[[f64; 3]],
        tetrahedra: &[[u32; 4]],
        fixed: &[u32],
        laws: &[Law],
    ) -> Result<Self> {
        let moduli: Vec<Moduli> = laws.iter().map(|law| law.moduli()).collect::<Result<_>>()?;
        let mu = |node: u32| moduli.get(node as usize).map_or(0.0, |moduli| moduli.mu_pa);
        let mean = |nodes: [u32; 4]| nodes.iter().map(|&node| mu(node)).sum::<f64>() / 4.0;
        let shape = Shape::weighted(rest_m, tetrahedra, mean)
            .map_err(|fault| fault.of(rest_m, tetrahedra))?;
        let mut is_fixed = vec![false; rest_m.len()];
        for &node in fixed {
            let place = is_fixed.get_mut(node as usize);
            *place.ok_or_else(|| {
                Error::input(format!("fixed node {node}: give one below {}", rest_m.len()))
            })? = true;
        }
        let lengths = (0..rest_m.len()).flat_map(|i| {
            shape.of(i).iter().map(move |half| norm(minus(rest_m[half.to as usize], rest_m[i])))
        });
        let link_m = lengths.sum::<f64>() / shape.halves().max(1) as f64;
        let young_pa = laws.iter().map(|law| law.young_pa).sum::<f64>() / laws.len() as f64;
        Ok(Self { rest: rest_m.to_vec(), fixed: is_fixed, shape, young_pa, moduli, link_m })
    }

    /// The nodal shapes of a model, lengths in mean link lengths from the centre, energies in its own
    /// unit; `None` for one of links, or with a band elsewhere than [`BAND_FROM`].
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_model(model: &Model<'_>) -> Result<Option<Self>> {
        let Some(least) = model.stretch_min() else { return Ok(None) };
        let band = least > 0.0;
        if band && least != BAND_FROM as f32 {
            return Ok(None);
        }
        let unit_pa = 2.0 * f64::from(model.stiffness_n_per_m()) / f64::from(model.unit_m());
        let moduli = (0..model.cells()).filter_map(|cell| model.elasticity(cell));
        let law = |[young_pa, poisson]: [f32; 2]| {
            // A ratio of single precision may lie just below 0.
            let poisson = f64::from(poisson).max(0.0);
            Law { young_pa: f64::from(young_pa) / unit_pa, poisson, band }
        };
        let laws: Vec<Law> = moduli.map(law).collect();
        let rest: Vec<_> =
            (0..model.cells()).map(|cell| model.rest_position(cell).map(f64::from)).collect();
        let tetrahedra: Vec<_> = model.tetrahedra().iter().map(|ids| ids.map(u32::from)).collect();
        let fixed: Vec<u32> = model.fixed().iter().map(|&cell| cell.into()).collect();
        Self::of_laws(&rest, &tetrahedra, &fixed, &laws).map(Some)
    }

    /// Energy of each node's shape and of the halves of its links.
    #[must_use]
    pub fn energies(&self, positions: &[[f64; 3]]) -> Vec<f64> {
        let u = self.displacements(positions);
        let of = |i: usize| {
            let slope = self.shape.slope(&u, i);
            let stretches = Stretches::of(&(Matrix3::identity() + slope));
            let shape = self.moduli[i].response(stretches.values).energy
                - 0.5 * self.spread_pa(i) * slope.norm_squared();
            let halves = self.shape.of(i).iter().map(|half| {
                let d = minus(u[half.to as usize], u[i]);
                0.5 * SPREAD * half.weight_m * dot(d, d)
            });
            self.shape.volume_m3(i) * shape + halves.sum::<f64>()
        };
        (0..u.len()).map(of).collect()
    }

    /// What the mesh gives.
    #[must_use]
    pub fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Mean Young's modulus times a link's length squared: a force of the body's own size \[N\].
    #[must_use]
    pub fn force_n(&self) -> f64 {
        self.young_pa * self.link_m * self.link_m
    }

    /// Signed principal stretches of every node's shape, falling, the last one negative where the
    /// shape is inverted.
    #[must_use]
    pub fn stretches(&self, positions_m: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let u = self.displacements(positions_m);
        (0..u.len()).map(|i| Stretches::of(&self.gradient(&u, i)).values).collect()
    }

    fn displacements(&self, positions_m: &[[f64; 3]]) -> Vec<[f64; 3]> {
        positions_m.iter().zip(&self.rest).map(|(x, rest)| minus(*x, *rest)).collect()
    }

    /// Deformation gradient of a node.
    fn gradient(&self, u: &[[f64; 3]], i: usize) -> Matrix3<f64> {
        Matrix3::identity() + self.shape.slope(u, i)
    }

    /// Stiffness of node i's shape that its tetrahedra have instead.
    fn spread_pa(&self, i: usize) -> f64 {
        2.0 * SPREAD * self.moduli[i].mu_pa
    }

    /// Adds P by the derivative of node i's gradient, times its volume and a sign, to a field.
    fn scatter(&self, i: usize, p: &Matrix3<f64>, sign: f64, field: &mut [[f64; 3]]) {
        let push = |area: [f64; 3]| -> [f64; 3] { (p * Vector3::from(area)).into() };
        field[i] = plus(field[i], sign, push(self.shape.own(i)));
        for half in self.shape.of(i) {
            let j = half.to as usize;
            field[j] = plus(field[j], sign, push(half.area_m2));
        }
    }
}

impl Elastic for Nodal {
    type Curvature = Vec<Tangent>;

    fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    fn length_unit(&self) -> f64 {
        self.link_m
    }

    fn residual_unit(&self) -> f64 {
        self.force_n()
    }

    /// The diagonal of the bound 2 mu ((1 - beta) Ln + beta Lc) + 3 lambda Ln of the second
    /// derivative, and 8 mu Ln more with a band; Ln and Lc are the Laplacians of the nodes' and of
    /// the tetrahedra's gradients.
    fn scale(&self) -> Vec<f64> {
        let mut scale = vec![0.0; self.rest.len()];
        for (i, moduli) in self.moduli.iter().enumerate() {
            let nodal = 2.0 * (1.0 - SPREAD) * moduli.mu_pa + moduli.bound_pa();
            let per_volume = nodal / self.shape.volume_m3(i);
            let own = self.shape.own(i);
            scale[i] += per_volume * dot(own, own);
            for half in self.shape.of(i) {
                scale[i] += 2.0 * SPREAD * half.weight_m;
                scale[half.to as usize] += per_volume * dot(half.area_m2, half.area_m2);
            }
        }
        scale
    }

    fn residual(&self, positions: &[[f64; 3]], residual: &mut [[f64; 3]]) -> f64 {
        let u = self.displacements(positions);
        residual.fill([0.0; 3]);
        let mut energy = 0.0;
        for i in 0..u.len() {
            let slope = self.shape.slope(&u, i);
            let stretches = Stretches::of(&(Matrix3::identity() + slope));
            let response = self.moduli[i].response(stretches.values);
            let volume = self.shape.volume_m3(i);
            energy += volume * (response.energy - 0.5 * self.spread_pa(i) * slope.norm_squared());
            let stress = stretches.with(response.slope) - self.spread_pa(i) * slope;
            self.scatter(i, &stress, -1.0, residual);
            for half in self.shape.of(i) {
                let d = minus(u[half.to as usize], u[i]);
                let pull = 2.0 * SPREAD * half.weight_m;
                residual[i] = plus(residual[i], pull, d);
                // A link has two halves.
                energy += 0.25 * pull * dot(d, d);
            }
        }
        energy
    }

    fn curvature(&self, positions: &[[f64; 3]], _free: &[bool]) -> Self::Curvature {
        let u = self.displacements(positions);
        let at = |i: usize| Tangent::new(&self.moduli[i], Stretches::of(&self.gradient(&u, i)));
        (0..u.len()).map(at).collect()
    }

    fn times(&self, curvature: &Self::Curvature, v: &[[f64; 3]], product: &mut [[f64; 3]]) {
        product.fill([0.0; 3]);
        for (i, tangent) in curvature.iter().enumerate() {
            let slope = self.shape.slope(v, i);
            let stress = tangent.times(&slope) - self.spread_pa(i) * slope;
            self.scatter(i, &stress, 1.0, product);
            for half in self.shape.of(i) {
                let d = minus(v[half.to as usize], v[i]);
                product[i] = plus(product[i], -2.0 * SPREAD * half.weight_m, d);
            }
        }
    }
}
