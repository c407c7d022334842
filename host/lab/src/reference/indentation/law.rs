//! Elastic laws of a gradient that turns around the axis.

use nalgebra::Matrix3;

use super::super::nodal;

/// Moduli \[Pa\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moduli {
    pub mu: f64,
    pub lambda: f64,
}

/// How the material answers strain.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// Compressible neo-Hookean: mu / 2 (tr C - 3) - mu ln J + lambda / 2 (ln J)^2.
    NeoHooke,
    /// Hooke's for small strain.
    Hooke,
    /// That of nodal shapes as they are baked unless asked otherwise: by the distance to determinant
    /// 1, with the band of stretches.
    Nodal,
}

/// Slopes of the displacement (r, z) by r and z, and the strain around the axis: `[rr, rz, zr, zz,
/// around]`.
pub type Slopes = [f64; 5];

/// Place of each slope in a matrix of three axes.
const PLACES: [(usize, usize); 5] = [(0, 0), (0, 1), (1, 0), (1, 1), (2, 2)];

/// Energy a volume \[J/m^3\], its first and second derivative by the slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Response {
    pub energy: f64,
    pub stress: Slopes,
    pub tangent: [Slopes; 5],
}

impl Moduli {
    pub fn new(young_pa: f64, poisson: f64) -> Self {
        let mu = 0.5 * young_pa / (1.0 + poisson);
        Self { mu, lambda: 2.0 * mu * poisson / (1.0 - 2.0 * poisson) }
    }

    /// `None` where the material is inside out.
    pub fn response(self, law: Law, slopes: &Slopes) -> Option<Response> {
        match law {
            Law::NeoHooke => self.neo_hooke(slopes),
            Law::Hooke => Some(self.hooke(slopes)),
            Law::Nodal => self.nodal(slopes),
        }
    }

    /// mu (F - G) + lambda ln J G, with G the inverse of F's transpose.
    fn neo_hooke(self, slopes: &Slopes) -> Option<Response> {
        let Self { mu, lambda } = self;
        let [rr, rz, zr, zz, around] = *slopes;
        let f = [1.0 + rr, rz, zr, 1.0 + zz, 1.0 + around];
        let flat = f[0] * f[3] - f[1] * f[2];
        if flat <= 0.0 || f[4] <= 0.0 {
            return None;
        }
        let g = [f[3] / flat, -f[2] / flat, -f[1] / flat, f[0] / flat, 1.0 / f[4]];
        let log = (flat * f[4]).ln();
        let trace: f64 = f.iter().map(|f| f * f).sum();
        Some(Response {
            energy: 0.5 * mu * (trace - 3.0) - mu * log + 0.5 * lambda * log * log,
            stress: std::array::from_fn(|a| mu * (f[a] - g[a]) + lambda * log * g[a]),
            tangent: self.tangent(&g, log),
        })
    }

    fn nodal(self, slopes: &Slopes) -> Option<Response> {
        let poisson = 0.5 * self.lambda / (self.lambda + self.mu);
        let (young_pa, volume) = (2.0 * self.mu * (1.0 + poisson), nodal::Volume::Det1);
        let law = nodal::Law { young_pa, poisson, volume, band: true };
        let flat = |matrix: &Matrix3<f64>| PLACES.map(|place| matrix[place]);
        let full = |slopes: &Slopes| {
            let mut matrix = Matrix3::zeros();
            PLACES.iter().zip(slopes).for_each(|(place, slope)| matrix[*place] = *slope);
            matrix
        };
        let answer = law.at(&(Matrix3::identity() + full(slopes))).ok()?;
        // The second derivative is symmetric: its columns are its rows.
        let tangent = std::array::from_fn(|a| {
            let mut unit = [0.0; 5];
            unit[a] = 1.0;
            flat(&answer.tangent.times(&full(&unit)))
        });
        Some(Response { energy: answer.energy, stress: flat(&answer.stress), tangent })
    }

    /// The same tangent at rest, for all strains.
    fn hooke(self, slopes: &Slopes) -> Response {
        let tangent = self.tangent(&[1.0, 0.0, 0.0, 1.0, 1.0], 0.0);
        let stress = tangent.map(|row| row.iter().zip(slopes).map(|(a, s)| a * s).sum());
        let energy = 0.5 * stress.iter().zip(slopes).map(|(p, s): (&f64, &f64)| p * s).sum::<f64>();
        Response { energy, stress, tangent }
    }

    /// mu dF + (mu - lambda ln J) G dF' G + lambda (G : dF) G.
    fn tangent(self, g: &Slopes, log: f64) -> [Slopes; 5] {
        let Self { mu, lambda } = self;
        let mut full = [[0.0; 3]; 3];
        for ((row, column), value) in PLACES.into_iter().zip(g) {
            full[row][column] = *value;
        }
        std::array::from_fn(|a| {
            let (i, j) = PLACES[a];
            std::array::from_fn(|b| {
                let (k, l) = PLACES[b];
                let own = if a == b { mu } else { 0.0 };
                own + (mu - lambda * log) * full[i][l] * full[k][j] + lambda * g[a] * g[b]
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stress_and_tangent_are_derivatives() {
        let moduli = Moduli::new(5000.0, 0.45);
        let at = [0.1, -0.2, 0.3, -0.15, 0.05];
        for law in [Law::NeoHooke, Law::Hooke, Law::Nodal] {
            let here = moduli.response(law, &at).unwrap();
            for a in 0..5 {
                let step = 1e-6;
                let [less, more] = [-step, step].map(|by| {
                    let mut slopes = at;
                    slopes[a] += by;
                    moduli.response(law, &slopes).unwrap()
                });
                let slope = (more.energy - less.energy) / (2.0 * step);
                assert!((slope - here.stress[a]).abs() < 1e-5 * 5000.0, "{law:?} {a}");
                for b in 0..5 {
                    let slope = (more.stress[b] - less.stress[b]) / (2.0 * step);
                    assert!((slope - here.tangent[b][a]).abs() < 1e-4 * 5000.0, "{law:?} {a} {b}");
                }
            }
        }
        assert!(moduli.response(Law::NeoHooke, &[-1.1, 0.0, 0.0, 0.0, 0.0]).is_none());
    }

    #[test]
    fn small_strain_is_hookes() {
        let moduli = Moduli::new(5000.0, 0.3);
        let at = [1e-4, -2e-4, 3e-4, 2e-4, -1e-4];
        let stress = |law| moduli.response(law, &at).unwrap().stress;
        let right = stress(Law::Hooke);
        for law in [Law::NeoHooke, Law::Nodal] {
            let pairs = stress(law).into_iter().zip(right);
            assert!(
                pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-3 * 5000.0 * 3e-4),
                "{law:?}"
            );
        }
    }
}
