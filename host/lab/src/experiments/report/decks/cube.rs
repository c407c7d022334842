//! The deck of DJTLED: a cube with four dents, drawn to half as long again.
//!
//! J. Zhang, *A direct Jacobian total Lagrangian explicit dynamics finite element algorithm for real-time simulation
//! of hyperelastic materials*, 2021, doi:10.1002/nme.6772; `models/NH.txt` of jinaojakezhang/DJTLED at 8f3b989, MIT:
//! the licence is beside the data. A cube of 0.1 m of 1,695 nodes and 7,726 linear tetrahedra, mu 6567 Pa,
//! K 326,210 Pa, 1,060 kg/m^3, its lower side held, its upper one moved by 0.05 m in 1 s, damping 5 /s, steps of
//! 0.2 ms.
//!
//! `data/djtled.bin` has the deck's mesh and the displacement with which DJTLED itself ends, built from that
//! revision by g++ 12 and run for its 5,000 steps: two numbers of 32 bits, nodes and tetrahedra; six of 16 bits a
//! node, place (z less 0.05 m) and displacement in 2 um; four of 16 bits a tetrahedron. The force was computed from
//! that field by the deck's law, as the program prints none: 76.50 N above and 76.26 N below, so the body is at rest
//! but for 0.3 %.

use std::collections::BTreeMap;

use serde::Serialize;

use super::body::{Elements, Load, settle};
use super::law::Moduli;
use crate::reference::vectors::{distance, minus, size};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::Mesh;

const DATA: &[u8] = include_bytes!("../../../../data/djtled.bin");
/// Unit of places and displacements in the data \[m\].
const UNIT_M: f64 = 2e-6;
const SIDE_M: f64 = 0.1;
/// Displacement of the upper side \[m\].
const DRAWN_M: f64 = 0.05;
/// Mean of the forces above and below \[N\].
const FORCE_N: f64 = 76.4;
const MU_PA: f64 = 6567.0;
const BULK_PA: f64 = 326_210.0;
/// Density \[kg/m^3\].
pub const DENSITY: f64 = 1060.0;
/// The deck's step \[s\].
pub const STEP_S: f64 = 2e-4;

/// The deck with DJTLED's displacement.
pub struct Cube {
    /// The deck's mesh.
    pub mesh: Mesh,
    /// Displacement at its end \[m\].
    pub by_m: Vec<[f64; 3]>,
}

/// A body beside DJTLED's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CubeRow {
    /// Nodes.
    pub cells: usize,
    /// Elements.
    pub body: &'static str,
    /// Distance of the displacements of free nodes, in that of DJTLED.
    pub field: f64,
    /// Distance of the displacements less the mean stretch, in the same of DJTLED.
    pub uneven: f64,
    /// Force on the upper side \[N\].
    pub force_n: f64,
    /// Force by DJTLED's field and law \[N\].
    pub expected_n: f64,
}

/// Moduli of the deck.
pub fn moduli() -> Moduli {
    Moduli::of_bulk(MU_PA, BULK_PA)
}

impl Cube {
    /// Reads the data.
    pub fn read() -> Result<Self> {
        let short = || Error::check("the deck's data end early");
        let word = |at: usize| -> Result<[u8; 2]> {
            DATA.get(2 * at..2 * at + 2).and_then(|word| word.try_into().ok()).ok_or_else(short)
        };
        let count = |at: usize| -> Result<usize> {
            let [low, high] = [word(at)?, word(at + 1)?].map(u16::from_le_bytes).map(usize::from);
            Ok(low + (high << 16))
        };
        let (nodes, tetrahedra) = (count(0)?, count(2)?);
        let length =
            |at: usize| -> Result<f64> { Ok(UNIT_M * f64::from(i16::from_le_bytes(word(at)?))) };
        let vector =
            |at: usize| -> Result<[f64; 3]> { Ok([length(at)?, length(at + 1)?, length(at + 2)?]) };
        let place = |node: usize| vector(4 + 6 * node).map(|[x, y, z]| [x, y, z + 0.5 * SIDE_M]);
        let first = 4 + 6 * nodes;
        let corner = |at: usize| -> Result<u32> { Ok(u32::from(u16::from_le_bytes(word(at)?))) };
        let element = |number: usize| -> Result<[u32; 4]> {
            let at = first + 4 * number;
            Ok([corner(at)?, corner(at + 1)?, corner(at + 2)?, corner(at + 3)?])
        };
        let nodes_m = (0..nodes).map(place).collect::<Result<Vec<_>>>()?;
        let elements = (0..tetrahedra).map(element).collect::<Result<Vec<_>>>()?;
        Ok(Self {
            mesh: Mesh::from_tetrahedra(nodes_m, &elements, BTreeMap::new()),
            by_m: (0..nodes).map(|node| vector(7 + 6 * node)).collect::<Result<_>>()?,
        })
    }

    /// Nodes of the lower and the upper side.
    fn is_held(&self) -> Vec<bool> {
        let middle_m = 0.5 * SIDE_M;
        self.mesh.nodes_m.iter().map(|x| (x[2] - middle_m).abs() > middle_m - 1e-6).collect()
    }

    /// A body on the deck's mesh beside DJTLED's.
    pub fn row(&self, elements: Elements) -> Result<CubeRow> {
        let held = self.is_held();
        let rest_m = &self.mesh.nodes_m;
        let load = Load {
            force_n: vec![[0.0; 3]; rest_m.len()],
            kept: held.iter().map(|held| [*held; 3]).collect(),
        };
        let drawn = |x: &[f64; 3]| [x[0], x[1], x[2] * (1.0 + DRAWN_M / SIDE_M)];
        let start_m: Vec<[f64; 3]> = rest_m.iter().map(drawn).collect();
        let rest = settle(&self.mesh, elements, moduli(), &load, &start_m)?;
        let free = |field: &[[f64; 3]]| -> Vec<[f64; 3]> {
            let each = field.iter().zip(&held);
            each.filter(|(_, held)| !**held).map(|(x, _)| *x).collect()
        };
        let by_m: Vec<_> = rest.at_m.iter().zip(rest_m).map(|(x, rest)| minus(*x, *rest)).collect();
        let even_m: Vec<_> = start_m.iter().zip(rest_m).map(|(x, rest)| minus(*x, *rest)).collect();
        let (by_m, theirs_m, even_m) = (free(&by_m), free(&self.by_m), free(&even_m));
        let apart_m = distance(&by_m, &theirs_m);
        let above = |node: usize| held[node] && rest_m[node][2] > 0.5 * SIDE_M;
        let pulled = rest.body_n.iter().enumerate().filter(|(node, _)| above(*node));
        Ok(CubeRow {
            cells: rest_m.len(),
            body: match elements {
                Elements::Shapes => "nodal shapes",
                Elements::Links => "links",
                Elements::Tetrahedra => "linear tetrahedra",
            },
            field: apart_m / size(&theirs_m),
            uneven: apart_m / distance(&theirs_m, &even_m),
            force_n: -pulled.map(|(_, force_n)| force_n[2]).sum::<f64>(),
            expected_n: FORCE_N,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn the_data_are_the_decks() {
        let cube = Cube::read().unwrap();
        assert_eq!((cube.mesh.nodes_m.len(), cube.mesh.tetrahedra.len()), (1695, 7726));
        assert!((cube.mesh.nodes_m[20][2] - 0.023_46).abs() < 1e-9);
        let held = cube.is_held();
        assert_eq!(held.iter().filter(|held| **held).count(), 2 * 144);
        let nodes = cube.mesh.nodes_m.iter().zip(&cube.by_m).zip(&held);
        for ((x, by), _) in nodes.filter(|(_, held)| **held) {
            let expected = if x[2] > 0.05 { DRAWN_M } else { 0.0 };
            assert!((by[2] - expected).abs() < UNIT_M && by[0].abs() < UNIT_M, "{x:?} {by:?}");
        }
    }

    /// The force by DJTLED's own field and law: mu J^(-2/3) (F - I1 / 3 F^-T) + K (J - 1) J F^-T in each tetrahedron.
    #[test]
    fn the_expected_force_is_that_of_their_field() {
        let cube = Cube::read().unwrap();
        let edges = |of: &[[f64; 3]], [a, b, c, d]: [u32; 4]| {
            let from = Vector3::from(of[a as usize]);
            Matrix3::from_columns(&[b, c, d].map(|node| Vector3::from(of[node as usize]) - from))
        };
        let (mut above_n, mut below_n) = (0.0, 0.0);
        for &nodes in &cube.mesh.tetrahedra {
            let rest_m = edges(&cube.mesh.nodes_m, nodes);
            let inverse = rest_m.try_inverse().unwrap();
            let f = Matrix3::identity() + edges(&cube.by_m, nodes) * inverse;
            let (volume, turned) = (f.determinant(), f.try_inverse().unwrap().transpose());
            let stress_pa =
                MU_PA * volume.powf(-2.0 / 3.0) * (f - turned * (f.norm_squared() / 3.0))
                    + turned * (BULK_PA * (volume - 1.0) * volume);
            // Forces on the last three corners, and their opposite on the first.
            let forces_n = stress_pa * inverse.transpose() * (rest_m.determinant().abs() / 6.0);
            let first_n = -forces_n.column_sum();
            let columns = (0..3).map(|corner| forces_n.column(corner)[2]);
            let each_n = std::iter::once(first_n[2]).chain(columns);
            for (node, force_n) in nodes.into_iter().zip(each_n) {
                match cube.mesh.nodes_m[node as usize][2] / SIDE_M {
                    z if z > 1.0 - 1e-5 => above_n += force_n,
                    z if z < 1e-5 => below_n -= force_n,
                    _ => {}
                }
            }
        }
        // The data round the displacements to 2 um, which is 0.06 N above.
        println!("{above_n} N above, {below_n} N below");
        assert!((above_n - 76.50).abs() < 0.1 && (below_n - 76.26).abs() < 0.1);
        assert!((0.5 * (above_n + below_n) - FORCE_N).abs() < 0.1);
    }

    /// On their own mesh, half as long again: another law, other elements, and this near.
    #[test]
    fn shapes_are_near_djtled() {
        let row = Cube::read().unwrap().row(Elements::Shapes).unwrap();
        println!("{row:?}");
        assert!(row.field < 0.05, "{row:?}");
        assert!((row.force_n / row.expected_n - 1.0).abs() < 0.25, "{row:?}");
    }
}
