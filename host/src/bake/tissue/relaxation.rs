//! Tissue that relaxes: a Prony series of the shear modulus, and its section in the image.
//!
//! A branch has its modulus, a ratio to the long-term shear modulus, and the time in which its stress fades to 1 / e.
//! With the sum G of the ratios the instantaneous shear modulus is 1 + G times the long-term one. Lame's lambda does
//! not relax, so Poisson's ratio rises in time: the image holds the instantaneous moduli.

use chaincell_kernel::image::{BRANCHES_MAX, branch, kind};

use crate::bake::image::Sections;
use crate::error::{Error, Result};

/// Poses that a device sends in a second, where nobody says how many.
pub const DEVICE_HZ: u32 = 1000;

/// The rates of which the kernel takes the ticks \[Hz\].
const RATES: std::ops::RangeInclusive<u32> = 10..=100_000;
/// The times that the kernel takes \[ticks\].
const TIMES: std::ops::RangeInclusive<f32> = 1.0..=1.6e6;
/// Largest sum of the ratios; the kernel accepts 99 in all.
const RATIOS_MAX: f64 = 98.0;

/// A branch of relaxation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// Its shear modulus over the long-term one, above 0.
    pub ratio: f64,
    /// Time in which the stress of a constant strain falls to 1 / e in it \[s\].
    pub time_s: f64,
}

/// Relaxation of a tissue.
#[derive(Debug, Clone, PartialEq)]
pub struct Relaxation {
    /// At most four branches of different times, of 98 times the long-term modulus together at most.
    pub branches: Vec<Branch>,
    /// Young's modulus of the tissue is the instantaneous one, not the long-term one.
    pub is_instant: bool,
    /// Ticks of a session in a second, from 10 to 100,000.
    pub device_hz: u32,
}

/// Young's modulus \[Pa\] and Poisson's ratio.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moduli {
    /// Young's modulus \[Pa\].
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

impl Moduli {
    /// Returns the moduli at which tissue of these instantaneous ones arrives, if `share` of its shear modulus fades.
    ///
    /// ```
    /// # use chaincell_host::bake::tissue::Moduli;
    /// let instant = Moduli { young_pa: 3000.0, poisson: 0.0 };
    /// assert_eq!(instant.long_term(0.5), Moduli { young_pa: 1500.0, poisson: 0.0 });
    /// ```
    #[must_use]
    pub fn long_term(self, share: f64) -> Self {
        let Self { young_pa, poisson } = self;
        let shear_pa = 0.5 * young_pa / (1.0 + poisson);
        let lambda_pa = 2.0 * shear_pa * poisson / (1.0 - 2.0 * poisson);
        let kept_pa = (1.0 - share) * shear_pa;
        let poisson = 0.5 * lambda_pa / (lambda_pa + kept_pa);
        Self { young_pa: 2.0 * kept_pa * (1.0 + poisson), poisson }
    }
}

impl Relaxation {
    /// Returns the branches in ascending time, those of equal times as one.
    #[must_use]
    pub fn sorted(&self) -> Vec<Branch> {
        let mut sorted = self.branches.clone();
        sorted.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        // Times are equal where they are in the image.
        sorted.dedup_by(|later, first| {
            let is_same = later.time_s as f32 == first.time_s as f32;
            if is_same {
                first.ratio += later.ratio;
            }
            is_same
        });
        sorted
    }

    /// Returns the sum of the ratios.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.sorted().iter().map(|branch| branch.ratio).sum()
    }

    /// Checks the ranges; an error calls the branches `name`.
    pub(in crate::bake) fn check(&self, name: &str) -> Result<()> {
        if !RATES.contains(&self.device_hz) {
            let why = "must be from 10 to 100000, the ticks in a second";
            return Err(Error::input(format!("`device_hz` {}: {why}", self.device_hz)));
        }
        let (hz, sorted) = (f64::from(self.device_hz), self.sorted());
        for &Branch { ratio, time_s } in &sorted {
            let wrong = |why: String| Err(Error::input(format!("{name} {ratio},{time_s}: {why}")));
            if !(ratio > 0.0 && (ratio as f32).is_normal()) {
                return wrong(
                    "the first number, the modulus over the long-term one, must be above 0 and finite"
                        .into(),
                );
            }
            if !TIMES.contains(&(self.ticks(time_s) as f32)) {
                let [least, most] =
                    [TIMES.start(), TIMES.end()].map(|ticks| f64::from(*ticks) / hz);
                return wrong(format!(
                    "the second number, the time, must be from {least} to {most} s at {} ticks a second",
                    self.device_hz
                ));
            }
        }
        if !(1..=BRANCHES_MAX).contains(&sorted.len()) {
            let given = sorted.len();
            return Err(Error::input(format!(
                "{name}: {given} of different times, must be 1 to {BRANCHES_MAX}; one a decade follows real tissue"
            )));
        }
        if self.ratio() > RATIOS_MAX {
            return Err(Error::input(format!(
                "{name}: {} times the long-term modulus together, at most {RATIOS_MAX}; give a larger long-term \
                 modulus and smaller branches",
                self.ratio()
            )));
        }
        Ok(())
    }

    /// Returns the instantaneous stiffness over the given one.
    pub(in crate::bake) fn instant_rise(&self) -> f64 {
        if self.is_instant { 1.0 } else { 1.0 + self.ratio() }
    }

    /// Returns the instantaneous Young's modulus \[Pa\] of tissue whose given modulus is `young_pa`; Poisson's ratio
    /// is the instantaneous one.
    #[must_use]
    pub fn instant_pa(&self, young_pa: f64, poisson: f64) -> f64 {
        if self.is_instant {
            return young_pa;
        }
        let rise = 1.0 + self.ratio();
        // Lambda over the long-term shear modulus, with it the long-term Poisson's ratio and shear modulus.
        let lambda = 2.0 * rise * poisson / (1.0 - 2.0 * poisson);
        let in_the_end = 0.5 * lambda / (lambda + 1.0);
        let shear_pa = 0.5 * young_pa / (1.0 + in_the_end);
        2.0 * rise * shear_pa * (1.0 + poisson)
    }

    /// Adds the section.
    pub(in crate::bake) fn push(&self, sections: &mut Sections) {
        let sum = 1.0 + self.ratio();
        let tick_s = 1.0 / f64::from(self.device_hz);
        let numbers = |Branch { ratio, time_s }: Branch| {
            let time = self.ticks(time_s);
            let mut numbers = [0.0; branch::WORDS];
            numbers[branch::SHARE] = (ratio / sum) as f32;
            numbers[branch::TIME_TICKS] = time as f32;
            numbers[branch::TICK_S] = tick_s as f32;
            for (power, faded) in numbers[branch::FADED..].iter_mut().enumerate() {
                *faded = -libm::expm1(-f64::from(1_u32 << power) / time) as f32;
            }
            numbers
        };
        let numbers: Vec<_> = self.sorted().into_iter().map(numbers).collect();
        sections.push(kind::BRANCHES, numbers.as_flattened());
    }

    fn ticks(&self, time_s: f64) -> f64 {
        time_s * f64::from(self.device_hz)
    }
}

#[cfg(test)]
mod tests {
    use chaincell_kernel::Model;

    use super::*;
    use crate::bake::tissue::Tissue;
    use crate::bake::{BakeOptions, ImageBytes, PerCell, bake};
    use crate::mesh::{MeshOptions, load};

    fn relaxing(branches: &[(f64, f64)]) -> Relaxation {
        let branches = branches.iter().map(|&(ratio, time_s)| Branch { ratio, time_s }).collect();
        Relaxation { branches, is_instant: false, device_hz: DEVICE_HZ }
    }

    fn baked(young_pa: f64, relaxation: Option<Relaxation>) -> Result<ImageBytes> {
        let mesh = load("box:4x4x3x0.01", &MeshOptions::default()).unwrap();
        let tissue = Tissue::new(PerCell::Uniform(young_pa), PerCell::Uniform(0.45));
        let tissue = Some(Tissue { relaxation, ..tissue });
        let options = BakeOptions { tissue, ..BakeOptions::default() };
        bake(&mesh, &mesh.default_fixed, &options)
    }

    #[test]
    fn lambda_stays_and_shear_falls_to_the_long_term_modulus() {
        for (young_pa, poisson, ratio) in
            [(1e3, 0.45, 2.0), (5e3, 0.0, 1.0), (7e2, 0.49, 6.0), (3e3, 0.3, 0.25)]
        {
            let instant_pa = relaxing(&[(ratio, 1.0)]).instant_pa(young_pa, poisson);
            let shear_pa = 0.5 * instant_pa / (1.0 + poisson);
            let lambda_pa = 2.0 * shear_pa * poisson / (1.0 - 2.0 * poisson);
            // Young's modulus of the Lame constants that are left.
            let left_pa = shear_pa / (1.0 + ratio);
            let in_the_end = left_pa * (3.0 * lambda_pa + 2.0 * left_pa) / (lambda_pa + left_pa);
            assert!((in_the_end / young_pa - 1.0).abs() < 1e-12, "{in_the_end} {young_pa}");
            let share = ratio / (1.0 + ratio);
            let back = Moduli { young_pa: instant_pa, poisson }.long_term(share);
            assert!((back.young_pa / young_pa - 1.0).abs() < 1e-12, "{back:?}");
            assert!((poisson..0.5).contains(&back.poisson), "{back:?}");
        }
    }

    #[test]
    fn the_body_is_baked_from_the_instantaneous_modulus() {
        let relaxation = relaxing(&[(1.0, 2.0), (0.5, 0.1), (0.5, 2.0)]);
        let instant_pa = relaxation.instant_pa(1000.0, 0.45);
        let image = baked(1000.0, Some(relaxation.clone())).unwrap();
        let given = Relaxation { is_instant: true, ..relaxation };
        assert_eq!(image, baked(instant_pa, Some(given)).unwrap());
        // Sections beside the branches' are those of the elastic body.
        let elastic = baked(instant_pa, None).unwrap();
        let [model, plain] = [&image, &elastic].map(|of| Model::from_bytes(of.as_bytes()).unwrap());
        assert_eq!(model.stiffness_n_per_m(), plain.stiffness_n_per_m());
        for cell in 0..plain.cells() {
            assert_eq!(model.elasticity(cell), plain.elasticity(cell));
            // But for the band of stretches, which has long-term moduli.
            assert!(model.cell_bound(cell) < plain.cell_bound(cell));
        }
        assert!(model.energy_max() < plain.energy_max());
        // Ascending times, equal ones merged: shares 0.5 and 1.5 of 3.
        let read: Vec<_> = model.branches().map(|of| (of.share, of.time_s, of.tick_s)).collect();
        assert_eq!(read, [(0.5 / 3.0, 0.1, 1e-3), (0.5, 2.0, 1e-3)]);
        assert_eq!(plain.branches().count(), 0);
    }

    #[test]
    fn all_times_and_rates_are_taken() {
        for device_hz in [10, 999, 1000, 3000, 100_000] {
            let tick_s = 1.0 / f64::from(device_hz);
            let branches = [1.0, 7.0, 3e3, 1.6e6].map(|ticks| (24.5, ticks * tick_s));
            let relaxation = Relaxation { device_hz, ..relaxing(&branches) };
            let image = baked(1000.0, Some(relaxation)).unwrap();
            let model = Model::from_bytes(image.as_bytes()).unwrap();
            assert_eq!(model.branches().count(), 4, "{device_hz}");
        }
    }

    #[test]
    fn branches_that_are_none_are_refused_by_name() {
        let five = [0.1, 0.2, 0.3, 0.4, 0.5].map(|time_s| (1.0, time_s));
        for (branches, part) in [
            (&[(0.0, 1.0)][..], "`branches` 0,1: the first number"),
            (&[(-1.0, 1.0)], "`branches` -1,1"),
            (&[(f64::NAN, 1.0)], "above 0 and finite"),
            (&[(f64::INFINITY, 1.0)], "above 0 and finite"),
            (&[(1.0, 9e-4)], "from 0.001 to 1600 s at 1000 ticks a second"),
            (&[(1.0, 1601.0)], "`branches` 1,1601: the second number"),
            (&[(1.0, f64::NAN)], "the second number"),
            (&[(1.0, -1.0)], "the second number"),
            (&[], "0 of different times"),
            (&five, "5 of different times, must be 1 to 4"),
            (&[(60.0, 1.0), (40.0, 2.0)], "100 times the long-term modulus together, at most 98"),
        ] {
            let why = baked(1000.0, Some(relaxing(branches))).unwrap_err().to_string();
            assert!(why.contains(part), "{why}");
        }
        for device_hz in [0, 9, 100_001] {
            let relaxation = Relaxation { device_hz, ..relaxing(&[(1.0, 1.0)]) };
            let why = baked(1000.0, Some(relaxation)).unwrap_err().to_string();
            assert!(why.contains(&format!("`device_hz` {device_hz}: must be from")), "{why}");
        }
    }
}
