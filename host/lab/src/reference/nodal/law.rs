//! The law of a node's shape: energy a volume by its signed principal stretches.

use nalgebra::Matrix3;

use super::det1;
use super::stretches::Stretches;
use chaincell_host::error::{Error, Result};

/// Stretch below which the band acts.
pub const BAND_FROM: f64 = 0.7;
/// Stiffness of the band [shear moduli].
const BAND_WEIGHT: f64 = 4.0;
/// Sums and differences of stretches below this count as it: there the law is a kink.
const KINK: f64 = 1e-6;

/// An elastic law, Hooke's for small strain: mu |F - R|^2, R the rotation nearest to F, 3 lambda / 2 times
/// the squared distance of F to the shapes of determinant 1, and outside a band of stretches a term that
/// resists their fall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// Young's modulus \[Pa\], above 0.
    pub young_pa: f64,
    /// Poisson's ratio, from 0 to below 0.5.
    pub poisson: f64,
    /// Whether `BAND_WEIGHT` mu times the squared distance of F to the shapes whose stretches are
    /// all at least [`BAND_FROM`] is added.
    pub band: bool,
}

impl Law {
    /// Returns the principal stresses, force by area at rest \[Pa\], at principal stretches above 0 in any order.
    ///
    /// # Errors
    /// Moduli out of their range.
    pub fn stress_pa(self, stretches: [f64; 3]) -> Result<[f64; 3]> {
        let moduli = self.moduli()?;
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| stretches[b].total_cmp(&stretches[a]));
        let slope = moduli.response(order.map(|axis| stretches[axis])).slope;
        let mut stress_pa = [0.0; 3];
        for (place, axis) in order.into_iter().enumerate() {
            stress_pa[axis] = slope[place];
        }
        Ok(stress_pa)
    }

    /// # Errors
    /// Moduli out of their range.
    pub(super) fn moduli(self) -> Result<Moduli> {
        let Self { young_pa, poisson, band } = self;
        if !(young_pa > 0.0 && young_pa.is_finite()) {
            return Err(Error::input(format!("`young_pa` {young_pa}: above 0 and finite [Pa]")));
        }
        if !(0.0..0.5).contains(&poisson) {
            return Err(Error::input(format!("`poisson` {poisson}: from 0 to below 0.5")));
        }
        let mu_pa = 0.5 * young_pa / (1.0 + poisson);
        let lambda_pa = 2.0 * mu_pa * poisson / (1.0 - 2.0 * poisson);
        Ok(Moduli { mu_pa, lambda_pa, band })
    }
}

/// A law by its moduli.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moduli {
    pub mu_pa: f64,
    pub lambda_pa: f64,
    pub(super) band: bool,
}

/// Energy \[J/m^3\] at some stretches, its first and second derivatives by them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Response {
    pub energy: f64,
    pub slope: [f64; 3],
    pub curvature: [[f64; 3]; 3],
}

impl Moduli {
    /// What volume and band add to the 2 mu of the shape in a bound of the second derivative by F,
    /// in every state.
    pub fn bound_pa(&self) -> f64 {
        let band = if self.band { 2.0 * BAND_WEIGHT } else { 0.0 };
        3.0 * self.lambda_pa + band * self.mu_pa
    }

    pub fn response(&self, s: [f64; 3]) -> Response {
        let mut all = self.det1(s);
        for (i, s) in s.into_iter().enumerate() {
            let (off, short) = (s - 1.0, (s - BAND_FROM).min(0.0));
            let band = if self.band && short < 0.0 { BAND_WEIGHT } else { 0.0 };
            all.energy += self.mu_pa * (off * off + band * short * short);
            all.slope[i] += 2.0 * self.mu_pa * (off + band * short);
            all.curvature[i][i] += 2.0 * self.mu_pa * (1.0 + band);
        }
        all
    }

    fn det1(&self, s: [f64; 3]) -> Response {
        let unit = det1::nearest(s);
        let off: [f64; 3] = std::array::from_fn(|i| s[i] - unit.values[i]);
        let stiff = 3.0 * self.lambda_pa;
        Response {
            energy: 0.5 * stiff * off.iter().map(|x| x * x).sum::<f64>(),
            slope: off.map(|x| stiff * x),
            curvature: std::array::from_fn(|i| {
                std::array::from_fn(|j| stiff * (f64::from(u8::from(i == j)) - unit.slope[i][j]))
            }),
        }
    }
}

/// Second derivative of a law by F, in the frame of its stretches: the stretches themselves by the
/// law's curvature, and for each pair of axes a symmetric and a skew part (Smith, de Goes, Kim
/// 2019).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tangent {
    left: Matrix3<f64>,
    right: Matrix3<f64>,
    along: [[f64; 3]; 3],
    symmetric: [f64; 3],
    skew: [f64; 3],
}

/// The pairs of axes.
const PAIRS: [(usize, usize); 3] = [(0, 1), (0, 2), (1, 2)];

impl Tangent {
    pub(super) fn new(moduli: &Moduli, stretches: Stretches) -> Self {
        let s = stretches.values;
        let Response { slope, curvature, .. } = moduli.response(s);
        let symmetric = PAIRS.map(|(i, j)| {
            let apart = s[i] - s[j];
            if apart > KINK {
                (slope[i] - slope[j]) / apart
            } else {
                0.5 * (curvature[i][i] + curvature[j][j]) - curvature[i][j]
            }
        });
        let skew = PAIRS.map(|(i, j)| (slope[i] + slope[j]) / (s[i] + s[j]).max(KINK));
        let Stretches { left, right, .. } = stretches;
        Self { left, right, along: curvature, symmetric, skew }
    }

    /// Change of the stress with a change of F.
    #[inline]
    #[must_use]
    pub fn times(&self, change: &Matrix3<f64>) -> Matrix3<f64> {
        let d = self.left.transpose() * change * self.right;
        let mut stress = Matrix3::zeros();
        for i in 0..3 {
            stress[(i, i)] = (0..3).map(|j| self.along[i][j] * d[(j, j)]).sum();
        }
        for (k, (i, j)) in PAIRS.into_iter().enumerate() {
            let both = 0.5 * self.symmetric[k] * (d[(i, j)] + d[(j, i)]);
            let turn = 0.5 * self.skew[k] * (d[(i, j)] - d[(j, i)]);
            (stress[(i, j)], stress[(j, i)]) = (both + turn, both - turn);
        }
        self.left * stress * self.right.transpose()
    }
}
