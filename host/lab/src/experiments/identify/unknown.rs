//! The unknowns of a fit: what they are, where they are looked for, and their coordinates.
//!
//! A body of links has a stiffness and an alpha for each group of nodes and one time constant. A
//! body of nodal shapes has a Young's modulus for each group; the modulus and the half-width of its
//! stiffening bands, the thickness of a generated slab, where a tool met the surface and the toughness
//! are looked for where [`Wanted`] says so.
//! Poisson's ratio is held: a force alone does not tell it from Young's modulus.

use super::{Bench, Parameters};
use chaincell_host::error::{Error, Result};

/// A kind of parameter: its name, where it is looked for unless the user says otherwise, and the
/// widest bounds that a fit can have.
struct Kind {
    name: &'static str,
    usual: [f64; 2],
    widest: [f64; 2],
}

const fn kind(name: &'static str, usual: [f64; 2], widest: [f64; 2]) -> Kind {
    Kind { name, usual, widest }
}

/// Bounds of what must be above 0.
const ANY: [f64; 2] = [1e-12, 1e12];

const STIFFNESS: usize = 0;
const ALPHA: usize = 1;
const TIME: usize = 2;
const YOUNG: usize = 3;
const STIFFENING: usize = 4;
const HALF_WIDTH: usize = 5;
const THICKNESS: usize = 6;
const OFFSET: usize = 7;
const TOUGHNESS: usize = 8;
const KINDS: [Kind; 9] = [
    kind("stiffness_n_per_m", [0.01, 1e5], ANY),
    kind("alpha", [0.0, 0.5], [0.0, 0.95]),
    kind("time_constant_s", [1e-4, 1e4], ANY),
    kind("young_pa", [100.0, 1e6], ANY),
    kind("stiffening_pa", [10.0, 1e7], [1e-3, 1e12]),
    kind("half_width", [0.01, 0.5], [0.01, 0.95]),
    kind("thickness_m", [0.002, 0.1], ANY),
    kind("offset_m", [1e-5, 1e-3], ANY),
    kind("toughness_j_per_m2", [0.1, 1e4], [0.01, 1e6]),
];

/// Where parameters are looked for: the least and the largest value of each kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds([[f64; 2]; KINDS.len()]);

impl Default for Bounds {
    fn default() -> Self {
        Self(KINDS.map(|kind| kind.usual))
    }
}

impl Bounds {
    /// The same with other bounds of a parameter.
    pub fn with(mut self, name: &str, [low, high]: [f64; 2]) -> Result<Self> {
        let refuse = |why: String| Error::input(format!("--bounds {name}={low},{high}: {why}"));
        let Some(at) = KINDS.iter().position(|kind| kind.name == name) else {
            let names = KINDS.map(|kind| kind.name).join(", ");
            return Err(refuse(format!("no such parameter; there are {names}")));
        };
        let [least, most] = KINDS[at].widest;
        if !(low >= least && high > low && high <= most) || at == ALPHA && low != 0.0 {
            let from = if at == ALPHA { "0 and one" } else { "two numbers" };
            return Err(refuse(format!("give {from} from {least} to {most}, the lower first")));
        }
        self.0[at] = [low, high];
        Ok(self)
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
    /// How far the tool had gone on from where it met the surface when its displacement was 0.
    pub offset: bool,
    /// The energy that a cut takes for each area.
    pub toughness: bool,
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
    /// Displacement of the tool from where it meets the surface to its 0.
    Offset,
    /// Toughness of the body.
    Toughness,
}

impl Unknown {
    /// All unknowns of a bench.
    pub fn of(bench: &Bench<'_>) -> Vec<Self> {
        let groups = 0..bench.groups.len();
        let Some(tissue) = &bench.options.tissue else {
            let time = bench.has_time().then_some(Self::Time);
            let links = groups.clone().map(Self::Stiffness).chain(groups.map(Self::Alpha));
            return links.chain(time).collect();
        };
        let Wanted { stiffening, half_width, thickness, offset, toughness } = bench.wanted;
        let bands = |wanted: bool| 0..if wanted { tissue.stiffening.len() } else { 0 };
        let young = groups.map(Self::Young).chain(bands(stiffening).map(Self::Stiffening));
        let shape = bands(half_width).map(Self::HalfWidth);
        let place = thickness.then_some(Self::Thickness).into_iter();
        let offset = offset.then_some(Self::Offset);
        let toughness = toughness.then_some(Self::Toughness);
        young.chain(shape).chain(place).chain(offset).chain(toughness).collect()
    }

    /// Its value.
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
            Self::Toughness => parameters.toughness_j_per_m2,
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
            Self::Toughness => &mut parameters.toughness_j_per_m2,
        } = value;
    }

    fn kind(self) -> usize {
        match self {
            Self::Stiffness(_) => STIFFNESS,
            Self::Alpha(_) => ALPHA,
            Self::Time => TIME,
            Self::Young(_) => YOUNG,
            Self::Stiffening(_) => STIFFENING,
            Self::HalfWidth(_) => HALF_WIDTH,
            Self::Thickness => THICKNESS,
            Self::Offset => OFFSET,
            Self::Toughness => TOUGHNESS,
        }
    }

    /// Its bounds.
    pub fn bounds(self, bounds: &Bounds) -> [f64; 2] {
        bounds.0[self.kind()]
    }

    /// Name of the parameter.
    pub fn name(self) -> &'static str {
        KINDS[self.kind()].name
    }

    /// Name of what it belongs to, a group of nodes or one of several bands; none for the body.
    pub fn owner(self, bench: &Bench<'_>) -> Option<String> {
        match self {
            Self::Stiffness(group) | Self::Alpha(group) | Self::Young(group) => {
                bench.groups.get(group).map(|group| group.name.clone())
            }
            Self::Stiffening(band) | Self::HalfWidth(band) => {
                let bands = bench.options.tissue.as_ref().map_or(0, |of| of.stiffening.len());
                (bands > 1).then(|| format!("band {}", band + 1))
            }
            Self::Time | Self::Thickness | Self::Offset | Self::Toughness => None,
        }
    }

    /// Whether it is a modulus, a stiffness or the toughness: forces grow with all of them together.
    pub fn is_modulus(self) -> bool {
        matches!(self, Self::Stiffness(_) | Self::Young(_) | Self::Stiffening(_) | Self::Toughness)
    }

    /// Value at a coordinate: alpha itself and the logarithms of the others run between their
    /// bounds along the logistic curve.
    pub fn value(self, bounds: &Bounds, x: f64) -> f64 {
        let [low, high] = self.bounds(bounds);
        let part = 1.0 / (1.0 + (-x).exp());
        match self {
            Self::Alpha(_) => part * high,
            _ => low * (high / low).powf(part),
        }
    }

    /// Coordinate of a value, kept off the bounds.
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

/// Ratios of a band's modulus to Young's that the kernel takes for any Poisson's ratio.
const RATIOS: [f64; 2] = [1e-6, 3e5];

/// Refuses moduli of bands that no body has beside its Young's modulus.
pub(super) fn check_ratios(bounds: &Bounds) -> Result<()> {
    let ([low, high], [soft, stiff]) = (bounds.0[STIFFENING], bounds.0[YOUNG]);
    if low >= RATIOS[0] * stiff && high <= RATIOS[1] * soft {
        return Ok(());
    }
    Err(Error::input(format!(
        "--bounds stiffening_pa={low},{high}: must be from {} to {} with young_pa={soft},{stiff}; \
         narrow one of them",
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
            (Unknown::Toughness, 160.0),
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
        for (name, bounds) in [
            ("stiffness_n_per_m", [2.0, 1.0]),
            ("time_constant_s", [0.0, 1.0]),
            ("stiffening_pa", [0.0, 1.0]),
            ("half_width", [0.1, 1.0]),
            ("alpha", [0.1, 0.2]),
            ("alpha", [0.0, f64::NAN]),
            ("poisson", [0.1, 0.2]),
        ] {
            let error = good.with(name, bounds).unwrap_err().to_string();
            assert!(error.contains(&format!("--bounds {name}=")), "{error}");
        }
        assert!(check_ratios(&good).is_ok());
        let error = check_ratios(&good.with("young_pa", [1.0, 1e8]).unwrap()).unwrap_err();
        assert!(error.to_string().contains("--bounds stiffening_pa=10,10000000"), "{error}");
    }
}
