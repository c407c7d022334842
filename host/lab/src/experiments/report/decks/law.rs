//! Materials of the decks, and a bar of each that is drawn.

use crate::reference::nodal::Law;
use chaincell_host::error::{Error, Result};

/// Halvings of a bracket.
const HALVINGS: usize = 80;
/// Brackets of the stretches along and across a bar.
const ALONG: [f64; 2] = [0.2, 2.0];
const ACROSS: [f64; 2] = [0.05, 20.0];

/// A material by its law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Material {
    /// Hooke's at small strain, stretch less 1 at any: SOFA's linear elements.
    Hooke(Moduli),
    /// mu / 2 (I1 - 3) - mu ln J + lambda / 2 (ln J)^2: SOFA's `NeoHookean`, after Bonet and Wood.
    NeoHooke(Moduli),
    /// mu / 2 (J^(-2/3) I1 - 3) + K / 2 (J - 1)^2: that of DJTLED.
    Isochoric(Moduli),
    /// Nodal shapes, as a bake makes them.
    Shapes(Moduli),
}

/// Young's modulus and Poisson's ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moduli {
    /// Young's modulus \[Pa\].
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

impl Moduli {
    /// From shear and bulk modulus \[Pa\].
    pub fn of_bulk(mu_pa: f64, bulk_pa: f64) -> Self {
        let young_pa = 9.0 * bulk_pa * mu_pa / (3.0 * bulk_pa + mu_pa);
        Self { young_pa, poisson: 0.5 * young_pa / mu_pa - 1.0 }
    }

    /// Shear modulus \[Pa\].
    pub fn mu_pa(self) -> f64 {
        0.5 * self.young_pa / (1.0 + self.poisson)
    }

    /// Lamé's first modulus \[Pa\].
    pub fn lambda_pa(self) -> f64 {
        2.0 * self.mu_pa() * self.poisson / (1.0 - 2.0 * self.poisson)
    }

    /// The law of nodal shapes with these moduli, with the band that a bake adds.
    pub fn law(self) -> Law {
        Law { young_pa: self.young_pa, poisson: self.poisson, band: true }
    }
}

/// A bar in uniform tension along an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bar {
    /// Stretch along the axis.
    pub along: f64,
    /// Stretch across it.
    pub across: f64,
    /// Force by area at rest \[Pa\].
    pub stress_pa: f64,
}

impl Material {
    /// Principal stresses, force by area at rest \[Pa\].
    pub fn stress_pa(self, stretches: [f64; 3]) -> Result<[f64; 3]> {
        let volume: f64 = stretches.iter().product();
        let squares: f64 = stretches.iter().map(|s| s * s).sum();
        Ok(match self {
            Self::Hooke(of) => {
                let growth = of.lambda_pa() * (stretches.iter().sum::<f64>() - 3.0);
                stretches.map(|s| growth + 2.0 * of.mu_pa() * (s - 1.0))
            }
            Self::NeoHooke(of) => {
                let pressure = of.lambda_pa() * volume.ln() - of.mu_pa();
                stretches.map(|s| of.mu_pa() * s + pressure / s)
            }
            Self::Isochoric(of) => {
                let bulk_pa = of.lambda_pa() + 2.0 / 3.0 * of.mu_pa();
                let shape = of.mu_pa() * volume.powf(-2.0 / 3.0);
                let pressure = bulk_pa * (volume - 1.0) * volume - shape * squares / 3.0;
                stretches.map(|s| shape * s + pressure / s)
            }
            Self::Shapes(of) => of.law().stress_pa(stretches)?,
        })
    }

    /// The bar at a stretch along its axis, free across it.
    pub fn at_stretch(self, along: f64) -> Result<Bar> {
        let across = root(ACROSS, |across| Ok(self.stress_pa([along, across, across])?[1]))?;
        Ok(Bar { along, across, stress_pa: self.stress_pa([along, across, across])?[0] })
    }

    /// The bar under a force by area at rest \[Pa\] that stretches it to between 0.2 and 2.
    pub fn under(self, stress_pa: f64) -> Result<Bar> {
        let along = root(ALONG, |along| Ok(self.at_stretch(along)?.stress_pa - stress_pa))?;
        self.at_stretch(along)
    }
}

/// The stretch between two at which a rising function is 0.
fn root([mut low, mut high]: [f64; 2], function: impl Fn(f64) -> Result<f64>) -> Result<f64> {
    if function(low)? > 0.0 || function(high)? < 0.0 {
        return Err(Error::check("a bar of the decks has no equilibrium"));
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if function(middle)? > 0.0 { &mut high } else { &mut low }) = middle;
    }
    Ok(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOFT: Moduli = Moduli { young_pa: 1e4, poisson: 0.45 };

    /// Energy by volume \[Pa\], written out apart from the stresses.
    fn energy_pa(material: Material, s: [f64; 3]) -> f64 {
        let j: f64 = s.iter().product();
        let squares: f64 = s.iter().map(|s| s * s).sum();
        match material {
            Material::NeoHooke(of) => {
                let (mu, lambda) = (of.mu_pa(), of.lambda_pa());
                0.5 * mu * (squares - 3.0) - mu * j.ln() + 0.5 * lambda * j.ln().powi(2)
            }
            Material::Isochoric(of) => {
                let bulk = of.young_pa / 3.0 / (1.0 - 2.0 * of.poisson);
                0.5 * of.mu_pa() * (j.powf(-2.0 / 3.0) * squares - 3.0)
                    + 0.5 * bulk * (j - 1.0).powi(2)
            }
            Material::Hooke(of) | Material::Shapes(of) => {
                let off: f64 = s.iter().map(|s| (s - 1.0).powi(2)).sum();
                let sum = s.iter().sum::<f64>() - 3.0;
                of.mu_pa() * off + 0.5 * of.lambda_pa() * sum * sum
            }
        }
    }

    #[test]
    fn stresses_are_the_slope_of_the_energy() {
        for material in [Material::Hooke(SOFT), Material::NeoHooke(SOFT), Material::Isochoric(SOFT)]
        {
            let at = [1.3, 0.8, 1.1];
            let stress_pa = material.stress_pa(at).unwrap();
            for axis in 0..3 {
                let energy = |by: f64| {
                    let mut moved = at;
                    moved[axis] += by;
                    energy_pa(material, moved)
                };
                let slope = (energy(1e-6) - energy(-1e-6)) / 2e-6;
                assert!((slope / stress_pa[axis] - 1.0).abs() < 1e-7, "{material:?}: {slope}");
            }
        }
    }

    /// All laws are Hooke's at small strain, and a bar of Hooke's is E times the strain, thinner by nu.
    #[test]
    fn bars_are_hookes_at_small_strain() {
        let all = [Material::Hooke, Material::NeoHooke, Material::Isochoric, Material::Shapes];
        for of in all {
            for poisson in [0.0, 0.3, 0.49] {
                let bar = of(Moduli { young_pa: 2.0, poisson }).under(2e-6).unwrap();
                assert!((bar.along - 1.0 - 1e-6).abs() < 1e-11, "{bar:?}");
                assert!((bar.across - 1.0 + 1e-6 * poisson).abs() < 1e-11, "{bar:?}");
            }
        }
        // Of SOFA's deck, at its own load.
        let bar = Material::Hooke(Moduli { young_pa: 1.0, poisson: 0.3 }).under(0.6).unwrap();
        assert!((bar.along - 1.6).abs() < 1e-12 && (bar.across - 0.82).abs() < 1e-12, "{bar:?}");
    }

    #[test]
    fn moduli_of_djtled() {
        let of = Moduli::of_bulk(6567.0, 326_210.0);
        assert!((of.poisson - 0.49).abs() < 1e-4, "{of:?}");
        assert!((of.lambda_pa() + 2.0 / 3.0 * of.mu_pa() - 326_210.0).abs() < 1e-6, "{of:?}");
    }
}
