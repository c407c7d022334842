//! Linear tetrahedra of Hooke's material at small displacements, in double precision: the elements that nodal
//! shapes are compared with.

use nalgebra::{Matrix3, Vector3};

use super::elastic::Elastic;
use super::nodal::volume_m3;
use super::vectors::{minus, norm, plus};
use chaincell_host::error::{Error, Result};

/// A body of linear tetrahedra. Positions \[m\], residuals \[N\], energy \[J\].
#[derive(Debug, Clone, PartialEq)]
pub struct Tetrahedra {
    rest: Vec<[f64; 3]>,
    elements: Vec<Element>,
    fixed: Vec<bool>,
    mu_pa: f64,
    lambda_pa: f64,
    edge_m: f64,
}

/// A tetrahedron: its nodes, its volume, the gradients of its hat functions.
#[derive(Debug, Clone, PartialEq)]
struct Element {
    nodes: [usize; 4],
    volume_m3: f64,
    gradients: [Vector3<f64>; 4],
}

impl Element {
    fn new(rest: &[[f64; 3]], nodes: [u32; 4]) -> Result<Self> {
        let volume_m3 = volume_m3(rest, nodes);
        let nodes = nodes.map(|node| node as usize);
        let edge = |at: usize| Vector3::from(minus(rest[nodes[at]], rest[nodes[0]]));
        let edges = Matrix3::from_columns(&[edge(1), edge(2), edge(3)]);
        let inverse = edges.try_inverse().filter(|_| volume_m3 > 0.0);
        let inverse = inverse
            .ok_or_else(|| Error::input(format!("tetrahedron {nodes:?}: no positive volume")))?;
        let [b, c, d] = [0, 1, 2].map(|row| inverse.row(row).transpose());
        Ok(Self { nodes, volume_m3, gradients: [-(b + c + d), b, c, d] })
    }

    /// The derivative of a field by place.
    fn slope(&self, field: &[[f64; 3]]) -> Matrix3<f64> {
        let each = self.nodes.iter().zip(&self.gradients);
        each.map(|(&node, gradient)| Vector3::from(field[node]) * gradient.transpose()).sum()
    }
}

impl Tetrahedra {
    /// A body at rest at `rest_m` `[node][axis]`, of Young's modulus and Poisson's ratio, without fixed nodes.
    ///
    /// # Errors
    /// A tetrahedron without a positive volume.
    pub fn new(
        rest_m: &[[f64; 3]],
        tetrahedra: &[[u32; 4]],
        young_pa: f64,
        poisson: f64,
    ) -> Result<Self> {
        let elements: Vec<Element> =
            tetrahedra.iter().map(|nodes| Element::new(rest_m, *nodes)).collect::<Result<_>>()?;
        let edge =
            |element: &Element| norm(minus(rest_m[element.nodes[1]], rest_m[element.nodes[0]]));
        let edge_m = elements.iter().map(edge).sum::<f64>() / elements.len().max(1) as f64;
        let mu_pa = 0.5 * young_pa / (1.0 + poisson);
        Ok(Self {
            rest: rest_m.to_vec(),
            elements,
            fixed: vec![false; rest_m.len()],
            mu_pa,
            lambda_pa: 2.0 * mu_pa * poisson / (1.0 - 2.0 * poisson),
            edge_m,
        })
    }

    /// Adds an element's forces, times a factor, under a displacement, and returns its energy \[J\].
    fn pull(&self, element: &Element, u: &[[f64; 3]], factor: f64, into: &mut [[f64; 3]]) -> f64 {
        let slope = element.slope(u);
        let strain = 0.5 * (slope + slope.transpose());
        let trace = strain.trace();
        let stress = 2.0 * self.mu_pa * strain + self.lambda_pa * trace * Matrix3::identity();
        for (&node, gradient) in element.nodes.iter().zip(&element.gradients) {
            into[node] = plus(into[node], factor * element.volume_m3, (stress * gradient).into());
        }
        let [shape, volume] = [strain.norm_squared(), trace * trace];
        element.volume_m3 * (self.mu_pa * shape + 0.5 * self.lambda_pa * volume)
    }
}

impl Elastic for Tetrahedra {
    /// The same everywhere.
    type Curvature = ();

    fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    fn length_unit(&self) -> f64 {
        self.edge_m
    }

    fn residual_unit(&self) -> f64 {
        self.mu_pa * self.edge_m * self.edge_m
    }

    fn scale(&self) -> Vec<f64> {
        let mut scale = vec![0.0; self.rest.len()];
        let stiff_pa = self.lambda_pa + 2.0 * self.mu_pa;
        for element in &self.elements {
            for (&node, gradient) in element.nodes.iter().zip(&element.gradients) {
                scale[node] += element.volume_m3 * stiff_pa * gradient.norm_squared();
            }
        }
        scale
    }

    fn residual(&self, positions: &[[f64; 3]], residual: &mut [[f64; 3]]) -> f64 {
        let u: Vec<_> =
            positions.iter().zip(&self.rest).map(|(x, rest)| minus(*x, *rest)).collect();
        residual.fill([0.0; 3]);
        self.elements.iter().map(|element| self.pull(element, &u, -1.0, residual)).sum()
    }

    fn curvature(&self, _positions: &[[f64; 3]], _free: &[bool]) -> Self::Curvature {}

    fn times(&self, _curvature: &Self::Curvature, v: &[[f64; 3]], product: &mut [[f64; 3]]) {
        product.fill([0.0; 3]);
        for element in &self.elements {
            self.pull(element, v, 1.0, product);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::mesh::{MeshOptions, load};

    #[test]
    fn forces_are_the_slope_of_the_energy() {
        let mesh = load("box:3x3x3x0.01", &MeshOptions::default()).unwrap();
        let body = Tetrahedra::new(&mesh.nodes_m, &mesh.tetrahedra, 5000.0, 0.45).unwrap();
        let bent = |x: [f64; 3]| [x[0] + 3.0 * x[2] * x[2], x[1] - x[0] * x[2], 0.9 * x[2]];
        let at: Vec<_> = mesh.nodes_m.iter().map(|x| bent(*x)).collect();
        let mut residual = vec![[0.0; 3]; at.len()];
        body.residual(&at, &mut residual);
        let step_m = 1e-6;
        for node in [0, 7, 13, 26] {
            for axis in 0..3 {
                let energy = |by_m: f64| {
                    let mut moved = at.clone();
                    moved[node][axis] += by_m;
                    body.residual(&moved, &mut vec![[0.0; 3]; at.len()])
                };
                let slope = (energy(step_m) - energy(-step_m)) / (2.0 * step_m);
                let off = (slope + residual[node][axis]).abs();
                assert!(off < 1e-6 * body.residual_unit(), "{node} {axis}: {slope} {residual:?}");
            }
        }
        let along = residual.iter().map(|r| r[2]).sum::<f64>();
        assert!(along.abs() < 1e-12, "{along}");
    }
}
