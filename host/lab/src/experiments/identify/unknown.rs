//! The unknowns of a fit: what they are, where they are looked for, and their coordinates.
//!
//! A body of links has a stiffness and an alpha for each group of nodes and one time constant. A
//! body of nodal shapes has a Young's modulus for each group; the modulus and the half-width of its
//! stiffening bands, the thickness of a generated slab and where a probe met the surface are looked
//! for where [`Wanted`] says so.
//! Poisson's ratio is held: a force alone does not tell it from Young's modulus.

use super::{Bench, Parameters};
use chaincell_host::error::{Error, Result};

/// Where parameters are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least and largest stiffness [N/m].
    pub stiffness_n_per_m: [f64; 2],
    /// Largest alpha; the least is 0.
    pub alpha_max: f64,
    /// Least and largest time constant \[s\].
    pub time_constant_s: [f64; 2],
    /// Least and largest Young's modulus \[Pa\].
    pub young_pa: [f64; 2],
    /// Least and largest modulus of a stiffening band \[Pa\].
    pub stiffening_pa: [f64; 2],
    /// Least and largest half-width of a stiffening band \[rest lengths\].
    pub half_width: [f64; 2],
    /// Least and largest thickness of a slab \[m\].
    pub thickness_m: [f64; 2],
    /// Least and largest displacement of a probe from where it meets the surface to its 0 \[m\].
    pub offset_m: [f64; 2],
}

impl Default for Bounds {
    fn default() -> Self {
        Self {
            stiffness_n_per_m: [0.01, 1e5],
            alpha_max: 0.5,
            time_constant_s: [1e-4, 1e4],
            young_pa: [100.0, 1e6],
            stiffening_pa: [10.0, 1e7],
            half_width: [0.01, 0.5],
            thickness_m: [0.002, 0.1],
            offset_m: [1e-5, 1e-3],
        }
    }
}

/// What else is looked for on a body of nodal shapes, beside Young's modulus.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Wanted {
    /// The modulus of each stiffening band.
    pub stiffening: bool,
    /// The half-width of each stiffening band.
    pub half_width: bool,
    /// The thickness of the slab.
    pub thickness: bool,
    /// How far the probe had gone on from where it met the surface when its displacement was 0.
    pub offset: bool,
}

/// One unknown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unknown {
    /// Stiffness of a group.
    Stiffness(usize),
    /// Alpha of a group.
    Alpha(usize),
    /// The body's time constant.
    Time,
    /// Young's modulus of a group.
    Young(usize),
    /// Modulus of a stiffening band.
    Stiffening(usize),
    /// Half-width of a stiffening band.
    HalfWidth(usize),
    /// Thickness of the slab.
    Thickness,
    /// Displacement of the probe from where it meets the surface to its 0.
    Offset,
}

impl Unknown {
    /// All unknowns of a bench.
    #[must_use]
    pub fn of(bench: &Bench<'_>) -> Vec<Self> {
        let groups = 0..bench.groups.len();
        let Some(tissue) = &bench.options.tissue else {
            let time = bench.has_time().then_some(Self::Time);
            let links = groups.clone().map(Self::Stiffness).chain(groups.map(Self::Alpha));
            return links.chain(time).collect();
        };
        let Wanted { stiffening, half_width, thickness, offset } = bench.wanted;
        let bands = |wanted: bool| 0..if wanted { tissue.stiffening.len() } else { 0 };
        let young = groups.map(Self::Young).chain(bands(stiffening).map(Self::Stiffening));
        let shape = bands(half_width).map(Self::HalfWidth);
        let place = thickness.then_some(Self::Thickness).into_iter();
        young.chain(shape).chain(place).chain(offset.then_some(Self::Offset)).collect()
    }

    /// Its value.
    #[must_use]
    pub fn get(self, parameters: &Parameters) -> f64 {
        match self {
            Self::Stiffness(group) => parameters.stiffness_n_per_m[group],
            Self::Alpha(group) => parameters.alpha[group],
            Self::Time => parameters.time_constant_s,
            Self::Young(group) => parameters.young_pa[group],
            Self::Stiffening(band) => parameters.stiffening[band].modulus_pa,
            Self::HalfWidth(band) => parameters.stiffening[band].half_width,
            Self::Thickness => parameters.thickness_m,
            Self::Offset => parameters.offset_m,
        }
    }

    /// Changes its value.
    pub fn set(self, parameters: &mut Parameters, value: f64) {
        *match self {
            Self::Stiffness(group) => &mut parameters.stiffness_n_per_m[group],
            Self::Alpha(group) => &mut parameters.alpha[group],
            Self::Time => &mut parameters.time_constant_s,
            Self::Young(group) => &mut parameters.young_pa[group],
            Self::Stiffening(band) => &mut parameters.stiffening[band].modulus_pa,
            Self::HalfWidth(band) => &mut parameters.stiffening[band].half_width,
            Self::Thickness => &mut parameters.thickness_m,
            Self::Offset => &mut parameters.offset_m,
        } = value;
    }

    /// Its bounds.
    #[must_use]
    pub fn bounds(self, bounds: &Bounds) -> [f64; 2] {
        match self {
            Self::Stiffness(_) => bounds.stiffness_n_per_m,
            Self::Alpha(_) => [0.0, bounds.alpha_max],
            Self::Time => bounds.time_constant_s,
            Self::Young(_) => bounds.young_pa,
            Self::Stiffening(_) => bounds.stiffening_pa,
            Self::HalfWidth(_) => bounds.half_width,
            Self::Thickness => bounds.thickness_m,
            Self::Offset => bounds.offset_m,
        }
    }

    /// Name of the parameter.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Stiffness(_) => "stiffness_n_per_m",
            Self::Alpha(_) => "alpha",
            Self::Time => "time_constant_s",
            Self::Young(_) => "young_pa",
            Self::Stiffening(_) => "stiffening_pa",
            Self::HalfWidth(_) => "half_width",
            Self::Thickness => "thickness_m",
            Self::Offset => "offset_m",
        }
    }

    /// Name of what it belongs to, a group of nodes or one of several bands; none for the body.
    #[must_use]
    pub fn owner(self, bench: &Bench<'_>) -> Option<String> {
        match self {
            Self::Stiffness(group) | Self::Alpha(group) | Self::Young(group) => {
                bench.groups.get(group).map(|group| group.name.clone())
            }
            Self::Stiffening(band) | Self::HalfWidth(band) => {
                let bands = bench.options.tissue.as_ref().map_or(0, |of| of.stiffening.len());
                (bands > 1).then(|| format!("band {}", band + 1))
            }
            Self::Time | Self::Thickness | Self::Offset => None,
        }
    }

    /// Whether it is a modulus or a stiffness: forces grow with all of them together.
    #[must_use]
    pub fn is_modulus(self) -> bool {
        matches!(self, Self::Stiffness(_) | Self::Young(_) | Self::Stiffening(_))
    }

    /// Value at a coordinate: alpha itself and the logarithms of the others run between their
    /// bounds along the logistic curve.
    #[must_use]
    pub fn value(self, bounds: &Bounds, x: f64) -> f64 {
        let [low, high] = self.bounds(bounds);
        let part = 1.0 / (1.0 + (-x).exp());
        match self {
            Self::Alpha(_) => part * high,
            _ => low * (high / low).powf(part),
        }
    }

    /// Coordinate of a value, kept off the bounds.
    #[must_use]
    pub fn coordinate(self, bounds: &Bounds, value: f64) -> f64 {
        let [low, high] = self.bounds(bounds);
        let part = match self {
            Self::Alpha(_) => value / high,
            _ => (value / low).ln() / (high / low).ln(),
        };
        let part = part.clamp(1e-3, 1.0 - 1e-3);
        (part / (1.0 - part)).ln()
    }
}

/// Refuses bounds and shares that no fit can have.
pub(super) fn check_bounds(bounds: &Bounds, hold_out: f64) -> Result<()> {
    for (option, [low, high]) in [
        ("--stiffness-bounds-n-per-m", bounds.stiffness_n_per_m),
        ("--time-constant-bounds-s", bounds.time_constant_s),
        ("--young-bounds-pa", bounds.young_pa),
        ("--thickness-bounds-m", bounds.thickness_m),
        ("--offset-bounds-m", bounds.offset_m),
    ] {
        if !(low > 0.0 && high > low && high <= 1e12 && low >= 1e-12) {
            return Err(Error::input(format!(
                "{option} {low},{high}: give two numbers from 1e-12 to 1e12, the lower first"
            )));
        }
    }
    // What a bake takes.
    for (option, [low, high], [least, most]) in [
        ("--stiffening-bounds-pa", bounds.stiffening_pa, [1e-3, 1e12]),
        ("--half-width-bounds", bounds.half_width, [0.01, 0.95]),
    ] {
        if !(low >= least && high > low && high <= most) {
            return Err(Error::input(format!(
                "{option} {low},{high}: give two numbers from {least} to {most}, the lower first"
            )));
        }
    }
    if !(bounds.alpha_max > 0.0 && bounds.alpha_max <= 0.95) {
        return Err(Error::input(format!(
            "--alpha-max {}: must be above 0 and at most 0.95",
            bounds.alpha_max
        )));
    }
    if (0.0..=0.5).contains(&hold_out) {
        Ok(())
    } else {
        Err(Error::input(format!("--hold-out {hold_out}: must be from 0 to 0.5")))
    }
}

/// Ratios of a band's modulus to Young's that the kernel takes for any Poisson's ratio.
const RATIOS: [f64; 2] = [1e-6, 3e5];

/// Refuses moduli of bands that no body has beside its Young's modulus.
pub(super) fn check_ratios(bounds: &Bounds) -> Result<()> {
    let ([low, high], [soft, stiff]) = (bounds.stiffening_pa, bounds.young_pa);
    if low >= RATIOS[0] * stiff && high <= RATIOS[1] * soft {
        return Ok(());
    }
    Err(Error::input(format!(
        "--stiffening-bounds-pa {low},{high}: must be from {} to {} with --young-bounds-pa \
         {soft},{stiff}; narrow one of them",
        RATIOS[0] * stiff,
        RATIOS[1] * soft
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_run_between_the_bounds() {
        let bounds = Bounds::default();
        for (unknown, value) in [
            (Unknown::Stiffness(0), 37.0),
            (Unknown::Alpha(0), 0.05),
            (Unknown::Time, 0.2),
            (Unknown::Young(0), 5000.0),
            (Unknown::HalfWidth(0), 0.1),
        ] {
            let x = unknown.coordinate(&bounds, value);
            assert!((unknown.value(&bounds, x) / value - 1.0).abs() < 1e-9);
            let [low, high] = unknown.bounds(&bounds);
            for x in [-50.0, 50.0] {
                let end = unknown.value(&bounds, x);
                assert!((low..=high * (1.0 + 1e-9)).contains(&end), "{end}");
            }
        }
    }

    #[test]
    fn bad_bounds_are_named() {
        let good = Bounds::default();
        let named = |bounds: &Bounds, hold_out: f64, part: &str| {
            let error = check_bounds(bounds, hold_out).unwrap_err().to_string();
            assert!(error.contains(part), "{error}");
        };
        named(&Bounds { stiffness_n_per_m: [2.0, 1.0], ..good }, 0.2, "--stiffness-bounds-n-per-m");
        named(&Bounds { time_constant_s: [0.0, 1.0], ..good }, 0.2, "--time-constant-bounds-s");
        named(&Bounds { young_pa: [0.0, 1.0], ..good }, 0.2, "--young-bounds-pa");
        named(&Bounds { thickness_m: [1.0, 0.1], ..good }, 0.2, "--thickness-bounds-m");
        named(&Bounds { stiffening_pa: [0.0, 1.0], ..good }, 0.2, "--stiffening-bounds-pa");
        named(&Bounds { half_width: [0.1, 1.0], ..good }, 0.2, "--half-width-bounds");
        named(&Bounds { alpha_max: f64::NAN, ..good }, 0.2, "--alpha-max");
        named(&good, 0.9, "--hold-out 0.9");
        named(&Bounds { offset_m: [0.0, 0.1], ..good }, 0.2, "--offset-bounds-m");
        assert!(check_ratios(&good).is_ok());
        let error = check_ratios(&Bounds { young_pa: [1.0, 1e8], ..good }).unwrap_err();
        assert!(error.to_string().contains("--stiffening-bounds-pa 10,10000000"), "{error}");
    }
}
