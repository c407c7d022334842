//! Force and energy of a generated body's links in double precision, from published positions.

use std::path::Path;

use chaincell_host::mesh::{MeshOptions, load};
use chaincell_lab::monitor::energy::energy;
use chaincell_lab::reference::Links;

use crate::files::Table;

/// Rounding of a level that is printed as a single-precision number.
const PRINTED_LEVEL: f64 = f32::EPSILON as f64;
/// Rounding of a coordinate that is printed with nine digits.
const PRINTED_COORDINATE: f64 = 5e-9;

/// Links of a body between input ids, with their rest lengths taken from positions at rest \[m\].
#[derive(Debug, Clone)]
pub struct Lattice {
    /// In mean link lengths, as the kernel has them.
    links: Links,
    closed: Links,
    unit_m: f64,
    stiffness_n_per_m: f64,
}

/// Positions of a cells file whose rows are nodes 0, 1, 2 and so on.
#[track_caller]
#[must_use]
pub fn positions(file: &Path) -> Vec<[f64; 3]> {
    let table = Table::read(file);
    assert_eq!(table.header, "node,x_m,y_m,z_m");
    let in_order = table.whole("node").into_iter().eq(0..table.rows.len() as u64);
    assert!(in_order, "{}: not in input order", file.display());
    table.vectors("x_m")
}

impl Lattice {
    /// The links of a generated body.
    #[must_use]
    pub fn new(spec: &str, rest: &[[f64; 3]], stiffness_n_per_m: f64, alpha: f64) -> Self {
        let mesh = load(spec, &MeshOptions::default()).unwrap();
        let in_m = Links::from_edges(rest, &mesh.links, alpha, &[]).unwrap();
        let unit_m = in_m.rest_lengths().iter().sum::<f64>() / mesh.links.len() as f64;
        let links = Links::from_edges(&scaled(rest, unit_m), &mesh.links, alpha, &[]).unwrap();
        Self { closed: links.closed(), links, unit_m, stiffness_n_per_m }
    }

    /// Force of the links on held nodes \[N\].
    #[must_use]
    pub fn force_n(&self, at: &[[f64; 3]], held: &[usize], closed: bool) -> [f64; 3] {
        let links = if closed { &self.closed } else { &self.links };
        // The residual of a link is half its excess.
        let force_unit_n = 2.0 * self.stiffness_n_per_m * self.unit_m;
        links.force(&scaled(at, self.unit_m), held).map(|excess| force_unit_n * excess)
    }

    /// Sum of k d^2 / 2 over all links \[J\], and how far a certified level may lie below it: the
    /// kernel's allowance, and the printing.
    ///
    /// Nine printed digits move a coordinate x by at most 5e-9 |x|, hence a node by 5e-9 sqrt(3) X
    /// with X the largest coordinate, and the length of a link, a difference of two lengths, by
    /// four times that. The level itself is printed as a single-precision number.
    #[must_use]
    pub fn energy_j(&self, at: &[[f64; 3]], closed: bool) -> (f64, f64) {
        let at = scaled(at, self.unit_m);
        let largest = at.iter().flatten().fold(0.0_f64, |a, x| a.max(x.abs()));
        let printing = 4.0 * 3.0_f64.sqrt() * PRINTED_COORDINATE * largest;
        let sum = energy(&self.links, &at, closed, |_| 0.5 * printing);
        let sum = sum.times(2.0 * self.stiffness_n_per_m * self.unit_m * self.unit_m);
        (sum.energy, sum.allowance + PRINTED_LEVEL * sum.energy)
    }
}

/// Positions in units of a length.
fn scaled(at: &[[f64; 3]], unit_m: f64) -> Vec<[f64; 3]> {
    at.iter().map(|at| at.map(|x| x / unit_m)).collect()
}
