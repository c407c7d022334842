//! The geometry of nodal shapes of a mesh of tetrahedra.

use nalgebra::{Matrix3, Vector3};

use crate::error::{Error, Result};
use crate::mesh::geometry::{dot, minus};

/// `a + factor b`.
fn plus(a: [f64; 3], factor: f64, b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] + factor * b[axis])
}

/// Half a link: the coefficients of a neighbour at node i.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Half {
    /// The neighbour j.
    pub to: u32,
    /// `a_ij`: sum over the tetrahedra with i and j of `V_t` / 4 times the gradient of j's hat
    /// function \[m^2\].
    pub area_m2: [f64; 3],
    /// `w_ij`: -sum of `V_t` `g_i` . `g_j` over the same, the cotangent weight \[m\], each
    /// tetrahedron times its factor; negative on obtuse edges.
    pub weight_m: f64,
}

/// Volumes of the nodes, and the half-links of each.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    volume_m3: Vec<f64>,
    own_m2: Vec<[f64; 3]>,
    start: Vec<usize>,
    half: Vec<Half>,
}

/// Reason for which a mesh has no shapes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The tetrahedron of this number has no positive volume, or a node beyond the last.
    Tetrahedron(usize),
    /// This node is in no tetrahedron.
    Node(usize),
}

impl Fault {
    /// Returns the error for nodes at `rest_m` in `tetrahedra`.
    #[must_use]
    pub fn of(self, rest_m: &[[f64; 3]], tetrahedra: &[[u32; 4]]) -> Error {
        Error::input(match self {
            Self::Tetrahedron(number) => format!(
                "tetrahedron {number} of nodes {:?}: give nodes below {} that span a positive volume",
                tetrahedra[number],
                rest_m.len()
            ),
            Self::Node(node) => format!("node {node} is in no tetrahedron: leave it out"),
        })
    }
}

impl Shape {
    /// Computes the shapes of nodes at `rest_m` in `tetrahedra` of positive volume.
    ///
    /// # Errors
    /// A node beyond the last, a tetrahedron without positive volume, a node in no tetrahedron.
    pub fn new(rest_m: &[[f64; 3]], tetrahedra: &[[u32; 4]]) -> Result<Self> {
        Self::weighted(rest_m, tetrahedra, |_| 1.0).map_err(|fault| fault.of(rest_m, tetrahedra))
    }

    /// As [`Self::new`], with the weights of links times a factor of each tetrahedron.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn weighted(
        rest_m: &[[f64; 3]],
        tetrahedra: &[[u32; 4]],
        factor: impl Fn([u32; 4]) -> f64,
    ) -> std::result::Result<Self, Fault> {
        let mut volume_m3 = vec![0.0; rest_m.len()];
        let mut parts: Vec<(u32, Half)> = Vec::with_capacity(12 * tetrahedra.len());
        for (number, nodes) in tetrahedra.iter().enumerate() {
            let (volume, gradients) = element(rest_m, *nodes).ok_or(Fault::Tetrahedron(number))?;
            let factor = factor(*nodes);
            for (a, &i) in nodes.iter().enumerate() {
                volume_m3[i as usize] += 0.25 * volume;
                for b in (0..4).filter(|b| *b != a) {
                    let area_m2 = gradients[b].map(|g| 0.25 * volume * g);
                    let weight_m = -factor * volume * dot(gradients[a], gradients[b]);
                    parts.push((i, Half { to: nodes[b], area_m2, weight_m }));
                }
            }
        }
        if let Some(node) = volume_m3.iter().position(|volume| *volume <= 0.0) {
            return Err(Fault::Node(node));
        }
        parts.sort_by_key(|(i, half)| (*i, half.to));
        Ok(Self::gathered(volume_m3, &parts))
    }

    /// Adds up the parts of each half-link, which are consecutive.
    fn gathered(volume_m3: Vec<f64>, parts: &[(u32, Half)]) -> Self {
        let mut own_m2 = vec![[0.0; 3]; volume_m3.len()];
        let mut count = vec![0; volume_m3.len() + 1];
        let mut half: Vec<Half> = Vec::new();
        for same in parts.chunk_by(|a, b| (a.0, a.1.to) == (b.0, b.1.to)) {
            let (i, first) = same[0];
            let mut sum = Half { to: first.to, area_m2: [0.0; 3], weight_m: 0.0 };
            for (_, part) in same {
                sum.area_m2 = plus(sum.area_m2, 1.0, part.area_m2);
                sum.weight_m += part.weight_m;
            }
            own_m2[i as usize] = plus(own_m2[i as usize], -1.0, sum.area_m2);
            count[i as usize + 1] += 1;
            half.push(sum);
        }
        let start = count.iter().scan(0, |sum, n| {
            *sum += n;
            Some(*sum)
        });
        Self { volume_m3, own_m2, start: start.collect(), half }
    }

    /// Returns the half-links of node i, its neighbours ascending.
    #[inline]
    #[must_use]
    pub fn of(&self, i: usize) -> &[Half] {
        &self.half[self.start[i]..self.start[i + 1]]
    }

    /// Returns the number of half-links of all nodes: twice the links.
    #[must_use]
    pub fn halves(&self) -> usize {
        self.half.len()
    }

    /// Returns `a_ji` for a half-link of node i, which has `a_ij`; zero if there is no link back.
    #[must_use]
    pub fn back(&self, i: usize, half: &Half) -> [f64; 3] {
        let there = self.of(half.to as usize);
        let at = there.binary_search_by_key(&(i as u32), |half| half.to);
        at.map_or([0.0; 3], |at| there[at].area_m2)
    }

    /// Returns `V_i`: a quarter of the volume of the tetrahedra around node i.
    #[inline]
    #[must_use]
    pub fn volume_m3(&self, i: usize) -> f64 {
        self.volume_m3[i]
    }

    /// Returns `a_ii`: minus the sum of the areas of i's half-links; zero inside the body.
    #[inline]
    #[must_use]
    pub fn own(&self, i: usize) -> [f64; 3] {
        self.own_m2[i]
    }

    /// Returns the gradient at node i of a field with one vector a node: the mean over its tetrahedra.
    #[inline]
    #[must_use]
    pub fn slope(&self, field: &[[f64; 3]], i: usize) -> Matrix3<f64> {
        let mut sum = Matrix3::zeros();
        for half in self.of(i) {
            let d = Vector3::from(minus(field[half.to as usize], field[i]));
            sum += d * Vector3::from(half.area_m2).transpose();
        }
        sum / self.volume_m3[i]
    }
}

/// Returns the signed volume of a tetrahedron.
///
/// # Panics
/// A node beyond the last.
#[must_use]
pub fn volume_m3(positions_m: &[[f64; 3]], nodes: [u32; 4]) -> f64 {
    sides(nodes.map(|node| positions_m[node as usize])).determinant() / 6.0
}

/// The sides from the first corner, in columns.
fn sides(corners: [[f64; 3]; 4]) -> Matrix3<f64> {
    let side = |k: usize| Vector3::from(minus(corners[k], corners[0]));
    Matrix3::from_columns(&[side(1), side(2), side(3)])
}

/// Returns the volume of a tetrahedron and the gradients of its corners' hat functions; `None` without
/// positive volume.
#[must_use]
pub fn element(rest: &[[f64; 3]], nodes: [u32; 4]) -> Option<(f64, [[f64; 3]; 4])> {
    let mut corners = [[0.0; 3]; 4];
    for (corner, node) in corners.iter_mut().zip(nodes) {
        *corner = *rest.get(node as usize)?;
    }
    let sides = sides(corners);
    let volume = sides.determinant() / 6.0;
    if volume.is_nan() || volume <= 0.0 {
        return None;
    }
    let inverse = sides.try_inverse()?;
    let row = |k: usize| [inverse[(k, 0)], inverse[(k, 1)], inverse[(k, 2)]];
    let [b, c, d] = [row(0), row(1), row(2)];
    let a = std::array::from_fn(|x| -(b[x] + c[x] + d[x]));
    Some((volume, [a, b, c, d]))
}
