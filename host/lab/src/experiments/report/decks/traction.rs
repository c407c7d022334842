//! SOFA's cylinder and bar in traction.
//!
//! The cylinder is that of `Sofa/Component/SolidMechanics/simutests/LinearElasticity_test.cpp` (sofa-framework/sofa,
//! LGPL 2.1; dimensions and numbers only): radius 0.2, height 1, Young's modulus 1, a traction on its upper end, the
//! strain of Hooke's law expected within 1e-4 along it and 2e-4 across it. The bar is the block of
//! `examples/Component/SolidMechanics/FEM/TetrahedronHyperelasticityFEMForceField.scn`, 1 x 1 x 2.7, of SOFA's
//! `NeoHookean` with mu 3448.2759 Pa and lambda 31034.483 Pa, which is 10 kPa and 0.45. The scene has no expected
//! value, so the bar is drawn and compared with the closed form of its material.
//!
//! Both are held in their planes of symmetry, so that they neither turn nor buckle.

use serde::Serialize;

use super::body::{Elements, Grid};
use super::law::{Bar, Material, Moduli};
use chaincell_host::error::Result;

/// Poisson's ratios of the cylinder.
const POISSONS: [f64; 3] = [0.0, 0.3, 0.49];
/// Tractions on it, as shares of Young's modulus: a hundredth of one of the deck's, and all of the deck's.
const TRACTIONS: [f64; 5] = [0.002, 0.2, 0.6, -0.2, -0.6];
/// Stretches of the bar.
pub const STRETCHES: [f64; 6] = [0.8, 0.95, 1.02, 1.1, 1.3, 1.5];
/// Material of the bar.
pub const SOFT: Moduli = Moduli { young_pa: 1e4, poisson: 0.45 };

/// A bar that is drawn.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TractionRow {
    /// The deck.
    pub deck: &'static str,
    /// Nodes of the mesh.
    pub cells: usize,
    /// Mean edge \[m\].
    pub edge_m: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Closed form of the deck's material.
    pub expected: Drawn,
    /// Closed form of the material of nodal shapes.
    pub closed: Drawn,
    /// The body of nodal shapes.
    pub shapes: Drawn,
    /// The body of links, whose ratio is 1/4; not a number where there is none.
    pub links: Drawn,
}

/// Strains and force of a bar.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Drawn {
    /// Strain along the bar.
    pub along: f64,
    /// Strain across it.
    pub across: f64,
    /// Force by area at rest, in Young's moduli.
    pub stress: f64,
}

impl Drawn {
    const NONE: Self = Self { along: f64::NAN, across: f64::NAN, stress: f64::NAN };

    fn of(bar: Bar, young_pa: f64) -> Self {
        let Bar { along, across, stress_pa } = bar;
        Self { along: along - 1.0, across: across - 1.0, stress: stress_pa / young_pa }
    }
}

/// What moves the upper end.
#[derive(Debug, Clone, Copy)]
enum Push {
    /// A traction \[Pa\].
    Stress(f64),
    /// A stretch.
    Stretch(f64),
}

impl Push {
    fn bar(self, material: Material) -> Result<Bar> {
        match self {
            Self::Stress(stress_pa) => material.under(stress_pa),
            Self::Stretch(along) => material.at_stretch(along),
        }
    }

    /// A body's strains, means over its upper end and over the nodes of its side at mid-height. The search begins at
    /// the bar of another material.
    fn body(self, grid: &Grid, elements: Elements, start: Material, of: Moduli) -> Result<Drawn> {
        let start = self.bar(start)?;
        let mut load = grid.guided(matches!(self, Self::Stretch(_)));
        if let Self::Stress(stress_pa) = self {
            grid.draw(&mut load, stress_pa);
        }
        let place = |x: &[f64; 3]| [start.across * x[0], start.across * x[1], start.along * x[2]];
        let start_m: Vec<[f64; 3]> = grid.mesh.nodes_m.iter().map(place).collect();
        let rest = grid.settle(elements, of, &load, &start_m)?;
        let mean = |nodes: &[usize], of: &dyn Fn(usize) -> f64| {
            nodes.iter().map(|&node| of(node)).sum::<f64>() / nodes.len() as f64
        };
        let end = grid.at_height(grid.length_m);
        let (at_m, from_m) = (&rest.at_m, &grid.mesh.nodes_m);
        let middle = grid.at_height(0.5 * grid.length_m);
        let wide_m = |node: usize| from_m[node][0].hypot(from_m[node][1]);
        let widest_m = middle.iter().map(|&node| wide_m(node)).fold(0.0, f64::max);
        let rim: Vec<usize> =
            middle.into_iter().filter(|&node| wide_m(node) > 0.99 * widest_m).collect();
        // The body pulls back at its lower end.
        let pull_n: f64 = grid.at_height(0.0).iter().map(|&node| rest.body_n[node][2]).sum();
        Ok(Drawn {
            along: mean(&end, &|node| at_m[node][2]) / grid.length_m - 1.0,
            across: mean(&rim, &|node| at_m[node][0].hypot(at_m[node][1]) / wide_m(node)) - 1.0,
            stress: pull_n / grid.end_m2() / of.young_pa,
        })
    }

    fn row(
        self,
        deck: &'static str,
        grid: &Grid,
        material: fn(Moduli) -> Material,
        of: Moduli,
        links: bool,
    ) -> Result<TractionRow> {
        let material = material(of);
        let drawn = |material: Material| -> Result<Drawn> {
            Ok(Drawn::of(self.bar(material)?, of.young_pa))
        };
        Ok(TractionRow {
            deck,
            cells: grid.mesh.nodes_m.len(),
            edge_m: grid.edge_m,
            poisson: of.poisson,
            expected: drawn(material)?,
            closed: drawn(Material::Shapes(of))?,
            shapes: self.body(grid, Elements::Shapes, material, of)?,
            links: if links {
                self.body(grid, Elements::Links, material, of)?
            } else {
                Drawn::NONE
            },
        })
    }
}

/// The cylinder on a grid of some nodes along its length.
pub fn cylinder(along: usize) -> Result<Vec<TractionRow>> {
    let across = along / 4 * 2 + 1;
    let grid = Grid::cylinder([across, across, along], 0.2, 1.0)?;
    let cases = POISSONS.into_iter().flat_map(|poisson| TRACTIONS.map(|share| (poisson, share)));
    let row = |(poisson, share): (f64, f64)| {
        let of = Moduli { young_pa: 1.0, poisson };
        // Links have a ratio of their own, nearest to the middle one.
        let links = (poisson - 0.3).abs() < 0.1 && (0.0..0.5).contains(&share);
        Push::Stress(share).row("SOFA cylinder, linear", &grid, Material::Hooke, of, links)
    };
    cases.map(row).collect()
}

/// The neo-Hookean bar.
pub fn bar(across: usize) -> Result<Vec<TractionRow>> {
    let grid = Grid::block([across, across, 4 * across - 3], [1.0, 1.0, 2.7])?;
    let row = |along: f64| {
        Push::Stretch(along).row("SOFA bar, neo-Hookean", &grid, Material::NeoHooke, SOFT, false)
    };
    STRETCHES.into_iter().map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: Drawn, b: Drawn, within: f64) -> bool {
        [a.along - b.along, a.across - b.across, a.stress - b.stress]
            .iter()
            .all(|off| off.abs() < within)
    }

    /// A uniform state is met on any mesh: the body is its material's closed form, and SOFA's strain within SOFA's
    /// tolerances where the strain is small.
    #[test]
    fn the_cylinder_is_its_closed_form() {
        for row in cylinder(9).unwrap() {
            assert!(near(row.shapes, row.closed, 1e-7), "{row:?}");
            if row.expected.stress.abs() < 0.01 {
                let off = [
                    row.shapes.along - row.expected.along,
                    row.shapes.across - row.expected.across,
                ];
                assert!(off[0].abs() < 1e-4 && off[1].abs() < 2e-4, "{row:?}");
            }
            let has_links =
                (row.poisson - 0.3).abs() < 0.1 && (0.0..0.5).contains(&row.expected.stress);
            assert_eq!(row.links.along * row.expected.along > 0.0, has_links, "{row:?}");
        }
    }

    /// The material of shapes is another one than neo-Hooke's: this far apart.
    #[test]
    fn the_bar_is_near_neo_hookes() {
        for row in bar(3).unwrap() {
            assert!(near(row.shapes, row.closed, 1e-7), "{row:?}");
            let ratio = row.shapes.stress / row.expected.stress;
            let strain = row.expected.along.abs();
            assert!((ratio - 1.0).abs() < 0.01 + 0.3 * strain, "{ratio} {row:?}");
        }
    }
}
