//! The network's force and energy once more, in double precision from published positions.

use std::path::Path;

use chaincell_host::mesh::{MeshOptions, load};

use crate::files::Table;

/// Links of a body between input ids, with their rest lengths taken from positions at rest.
#[derive(Debug, Clone)]
pub struct Lattice {
    links: Vec<[usize; 2]>,
    rest_m: Vec<f64>,
    stiffness_n_per_m: f64,
    alpha: f64,
}

fn way(from: [f64; 3], to: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| to[axis] - from[axis])
}

/// Length of a vector.
#[must_use]
pub fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
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
        let links: Vec<[usize; 2]> =
            mesh.links.iter().map(|link| link.map(|id| id as usize)).collect();
        let rest_m = links.iter().map(|&[i, j]| norm(way(rest[i], rest[j]))).collect();
        Self { links, rest_m, stiffness_n_per_m, alpha }
    }

    /// Length outside the band, negative where too short; `None` for a slack link.
    fn excess_m(&self, link: usize, length_m: f64, closed: bool) -> Option<f64> {
        let rest_m = self.rest_m[link];
        let half_m = if closed { 0.0 } else { self.alpha * rest_m };
        let nearest_m = length_m.clamp(rest_m - half_m, rest_m + half_m);
        (length_m != nearest_m).then_some(length_m - nearest_m)
    }

    /// Force of the links on held nodes \[N\].
    #[must_use]
    pub fn force_n(&self, at: &[[f64; 3]], held: &[usize], closed: bool) -> [f64; 3] {
        let mut force_n = [0.0; 3];
        for (link, &ends) in self.links.iter().enumerate() {
            for [one, other] in [ends, [ends[1], ends[0]]] {
                if !held.contains(&one) || held.contains(&other) {
                    continue;
                }
                let way_m = way(at[one], at[other]);
                let length_m = norm(way_m);
                if let Some(excess_m) = self.excess_m(link, length_m, closed) {
                    for axis in 0..3 {
                        let direction = way_m[axis] / length_m;
                        force_n[axis] += self.stiffness_n_per_m * excess_m * direction;
                    }
                }
            }
        }
        force_n
    }

    /// Sum of k d^2 / 2 over all links \[J\], and how far a certified level may lie below it.
    ///
    /// The level is certified within 4 eps (E + sum of u d / 2) in units of 2 k, where the
    /// single-precision energy is the sum of d^2 / 4: in joules 4 eps (E + k sum of u d), u the
    /// length and d its part outside the band. Nine printed digits move a coordinate x by at most
    /// 5e-9 |x|, hence the ends of a link by 5e-9 sqrt(3) X each with X the largest coordinate,
    /// and d, a difference of two lengths, by e = 4 sqrt(3) 5e-9 X: the sum then moves by at most
    /// k (d e + e^2 / 2) a link. The level itself is printed as a single-precision number.
    #[must_use]
    pub fn energy_j(&self, at: &[[f64; 3]], closed: bool) -> (f64, f64) {
        const EPS: f64 = f32::EPSILON as f64;
        let largest_m = at.iter().flatten().fold(0.0_f64, |a, x| a.max(x.abs()));
        let printing_m = 4.0 * 3.0_f64.sqrt() * 5e-9 * largest_m;
        let (mut energy_j, mut moment_j, mut printing_j) = (0.0, 0.0, 0.0);
        for (link, &[i, j]) in self.links.iter().enumerate() {
            let length_m = norm(way(at[i], at[j]));
            let excess_m = self.excess_m(link, length_m, closed).unwrap_or(0.0).abs();
            energy_j += 0.5 * self.stiffness_n_per_m * excess_m * excess_m;
            moment_j += self.stiffness_n_per_m * length_m * excess_m;
            printing_j += self.stiffness_n_per_m * printing_m * (excess_m + 0.5 * printing_m);
        }
        (energy_j, 4.0 * EPS * (energy_j + moment_j) + printing_j + EPS * energy_j)
    }
}
