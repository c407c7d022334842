//! Tissues by name: a table of measured ones with their sources.
//!
//! A row says how it was got: `read` in a source, `derived` from what was read, or `fitted` to measured curves.
//! Poisson's ratio is that of nearly incompressible tissue where the source has none.

use super::relaxation::{Branch, DEVICE_HZ, Relaxation};
use super::stiffening::Band;
use crate::error::{Error, Result};

/// The table: a line of names, then a tissue a line.
const TABLE: &str = include_str!("known.csv");
/// Number of columns.
const COLUMNS: usize = 17;

/// A tissue of the table.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownTissue {
    /// Its name.
    pub name: &'static str,
    /// The tissue in words.
    pub tissue: &'static str,
    /// Young's modulus \[Pa\].
    pub young_pa: f64,
    /// It is the instantaneous one, not the long-term one.
    pub is_instant: bool,
    /// Poisson's ratio, the instantaneous one.
    pub poisson: f64,
    /// Branches of relaxation; none where no relaxation was measured.
    pub branches: Vec<Branch>,
    /// Bands that stiffen it.
    pub stiffening: Vec<Band>,
    /// Energy that a cut takes for each area \[J/m^2\], where it was measured.
    pub toughness_j_per_m2: Option<f64>,
    /// Coefficient of friction with a tool, where it was measured.
    pub friction: Option<f64>,
    /// How the values were got: `read`, `derived`, `fitted`, or several of them.
    pub status: &'static str,
    /// The publication.
    pub source: &'static str,
    /// Conversions, error of the fit, limits.
    pub note: &'static str,
}

impl KnownTissue {
    /// Returns the tissue of this name.
    ///
    /// ```
    /// # use chaincell_host::bake::tissue::KnownTissue;
    /// assert_eq!(KnownTissue::find("cervix")?.branches.len(), 2);
    /// assert!(KnownTissue::find("stone").is_err());
    /// # Ok::<(), chaincell_host::error::Error>(())
    /// ```
    ///
    /// # Errors
    /// A name that is not in the table; the error lists those that are.
    pub fn find(name: &str) -> Result<Self> {
        let all = Self::all();
        let names: Vec<&str> = all.iter().map(|tissue| tissue.name).collect();
        let why = format!("`tissue` {name}: there is none; known are {}", names.join(", "));
        all.into_iter().find(|tissue| tissue.name == name).ok_or_else(|| Error::input(why))
    }

    /// Returns all tissues, in the order of the table.
    #[must_use]
    pub fn all() -> Vec<Self> {
        TABLE.lines().skip(1).filter_map(Self::read).collect()
    }

    /// Reads a line; `None` for one that is no tissue.
    fn read(line: &'static str) -> Option<Self> {
        let fields: [&'static str; COLUMNS] = fields(line).try_into().ok()?;
        let [name, tissue, young_pa, modulus, poisson, branches @ .., _, _, _, _, _, _] = fields;
        let [.., stiffening, toughness, friction, status, source, note] = fields;
        let branches = branches.chunks(2).filter(|pair| pair.iter().any(|text| !text.is_empty()));
        let branch = |pair: &[&str]| match *pair {
            [ratio, time_s] => {
                Some(Branch { ratio: ratio.parse().ok()?, time_s: time_s.parse().ok()? })
            }
            _ => None,
        };
        let band = |text: &str| {
            let (half_width, modulus_pa) = text.split_once('=')?;
            Some(Band {
                half_width: half_width.parse().ok()?,
                modulus_pa: modulus_pa.parse().ok()?,
            })
        };
        Some(Self {
            name,
            tissue,
            young_pa: young_pa.parse().ok()?,
            is_instant: match modulus {
                "instant" => true,
                "long-term" => false,
                _ => return None,
            },
            poisson: poisson.parse().ok()?,
            branches: branches.map(branch).collect::<Option<_>>()?,
            stiffening: stiffening.split_whitespace().map(band).collect::<Option<_>>()?,
            toughness_j_per_m2: optional(toughness)?,
            friction: optional(friction)?,
            status,
            source,
            note,
        })
    }
}

/// Relaxation as the options have it: `branches` given by hand replace those of the tissue, and a modulus given by
/// hand is the long-term one unless `is_instant`. No branches are elastic tissue.
///
/// # Errors
/// An option without branches, `instant` beside the modulus of the tissue.
pub fn relaxation(
    known: Option<&KnownTissue>,
    branches: Option<Vec<Branch>>,
    is_modulus_given: bool,
    is_instant: bool,
    device_hz: Option<u32>,
) -> Result<Option<Relaxation>> {
    let of_known = known.map(|tissue| tissue.branches.clone());
    let branches = branches.or(of_known).unwrap_or_default();
    let of_tissue = known.filter(|_| !is_modulus_given);
    if is_instant && of_tissue.is_some() {
        return Err(Error::input(
            "`instant`: the modulus is that of `tissue`, which knows which one it is; leave it out, or give \
             `young_pa` too",
        ));
    }
    if branches.is_empty() {
        for (name, is_asked) in [("instant", is_instant), ("device_hz", device_hz.is_some())] {
            if is_asked {
                let why = "the tissue has no branches that relax; give `branches`, or leave it out";
                return Err(Error::input(format!("`{name}`: {why}")));
            }
        }
        return Ok(None);
    }
    Ok(Some(Relaxation {
        branches,
        is_instant: of_tissue.map_or(is_instant, |tissue| tissue.is_instant),
        device_hz: device_hz.unwrap_or(DEVICE_HZ),
    }))
}

/// Splits a line at its commas; a field in quotes may have some.
fn fields(line: &str) -> Vec<&str> {
    let (mut fields, mut rest) = (Vec::new(), Some(line));
    while let Some(line) = rest {
        let quoted = line.strip_prefix('"').and_then(|line| line.split_once('"'));
        let (field, after) = match (quoted, line.split_once(',')) {
            (Some((field, after)), _) => (field, after.strip_prefix(',')),
            (None, Some((field, after))) => (field, Some(after)),
            (None, None) => (line, None),
        };
        fields.push(field);
        rest = after;
    }
    fields
}

/// Reads a number that may be missing; `None` for what is no number.
fn optional(text: &str) -> Option<Option<f64>> {
    if text.is_empty() { Some(None) } else { text.parse().ok().map(Some) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::tissue::{Moduli, Tissue};
    use crate::bake::{BakeOptions, PerCell, bake};
    use crate::mesh::{MeshOptions, load};

    #[test]
    fn every_line_is_a_tissue_with_its_source() {
        let all = KnownTissue::all();
        assert_eq!(all.len(), TABLE.lines().count() - 1);
        for (at, tissue) in all.iter().enumerate() {
            let KnownTissue { name, status, .. } = tissue;
            let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
            assert!(!name.is_empty() && name.chars().all(plain), "{name}");
            assert!(!all[..at].iter().any(|other| other.name == *name), "{name} twice");
            let known = ["read", "derived", "fitted"];
            assert!(status.split(" + ").all(|word| known.contains(&word)), "{name}: {status}");
            let words = [tissue.tissue, tissue.source, tissue.note];
            assert!(words.iter().all(|text| text.len() > 5), "{name}");
        }
        let names = "name,tissue,young_pa,modulus,poisson,g1,tau1_s,g2,tau2_s,g3,tau3_s,stiffening_pa,\
                     toughness_j_per_m2,friction,status,source,note";
        assert_eq!(TABLE.lines().next(), Some(names));
    }

    /// Units by what soft tissue has: pascals, seconds, J/m^2.
    #[test]
    fn values_are_those_of_soft_tissue() {
        for KnownTissue { name, young_pa, poisson, branches, stiffening, .. } in KnownTissue::all()
        {
            assert!((100.0..1e6).contains(&young_pa), "{name}: {young_pa} Pa");
            assert!((0.3..0.495).contains(&poisson), "{name}: {poisson}");
            for Branch { ratio, time_s } in branches {
                assert!((0.1..20.0).contains(&ratio), "{name}: {ratio}");
                assert!((1e-3..=1600.0).contains(&time_s), "{name}: {time_s} s");
            }
            for Band { half_width, modulus_pa } in stiffening {
                assert!((0.01..0.5).contains(&half_width), "{name}: {half_width}");
                assert!((100.0..1e6).contains(&modulus_pa), "{name}: {modulus_pa} Pa");
            }
        }
        for KnownTissue { name, toughness_j_per_m2, friction, .. } in KnownTissue::all() {
            let toughness = toughness_j_per_m2.unwrap_or(100.0);
            assert!((1.0..1e4).contains(&toughness), "{name}: {toughness} J/m^2");
            assert!((0.0..2.0).contains(&friction.unwrap_or(0.1)), "{name}: {friction:?}");
        }
    }

    #[test]
    fn every_tissue_bakes_with_the_modulus_of_its_row() {
        let mesh = load("box:4x4x3x0.01", &MeshOptions::default()).unwrap();
        for known in KnownTissue::all() {
            let relaxation = relaxation(Some(&known), None, false, false, None).unwrap();
            assert_eq!(relaxation.is_some(), !known.branches.is_empty());
            let of = PerCell::Uniform;
            let tissue = Tissue::new(of(known.young_pa), of(known.poisson));
            let stiffening = known.stiffening.clone();
            let tissue = Some(Tissue { stiffening, relaxation, ..tissue });
            let options = BakeOptions { tissue, ..BakeOptions::default() };
            let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
            let model = chaincell_kernel::Model::from_bytes(image.as_bytes()).unwrap();
            assert_eq!(model.branches().count(), known.branches.len(), "{}", known.name);
            let [young_pa, poisson] = model.elasticity(0).unwrap().map(f64::from);
            let share: f32 = model.branches().map(|branch| branch.share).sum();
            let share = if known.is_instant { 0.0 } else { share.into() };
            let found = Moduli { young_pa, poisson }.long_term(share).young_pa;
            assert!((found / known.young_pa - 1.0).abs() < 1e-4, "{}: {found}", known.name);
        }
    }

    #[test]
    fn what_is_given_by_hand_goes_before_the_tissue() {
        let (muscle, rat, brain) = ("muscle", "muscle_rat", "brain_in_vivo");
        let [muscle, rat, brain] =
            [muscle, rat, brain].map(|name| KnownTissue::find(name).unwrap());
        let own = vec![Branch { ratio: 1.0, time_s: 2.0 }];
        let of = |known, branches, is_modulus_given, is_instant| {
            relaxation(Some(known), branches, is_modulus_given, is_instant, None).unwrap()
        };
        assert_eq!(of(&muscle, None, false, false).unwrap().branches, muscle.branches);
        assert_eq!(of(&muscle, Some(own.clone()), false, false).unwrap().branches, own);
        assert_eq!(of(&brain, Some(own.clone()), false, false).unwrap().branches, own);
        assert_eq!(of(&muscle, Some(Vec::new()), false, false), None);
        assert_eq!(of(&brain, None, false, false), None);
        // The instantaneous modulus is one of the tissue or of the hand.
        assert!(of(&rat, None, false, false).unwrap().is_instant);
        assert!(!of(&rat, None, true, false).unwrap().is_instant);
        assert!(of(&muscle, None, true, true).unwrap().is_instant);
        for (known, is_modulus_given, is_instant, device_hz, part) in [
            (Some(&muscle), false, true, None, "give `young_pa` too"),
            (Some(&brain), true, true, None, "`instant`: the tissue has no branches"),
            (None, true, false, Some(1000), "`device_hz`: the tissue has no branches"),
        ] {
            let why = relaxation(known, None, is_modulus_given, is_instant, device_hz);
            let why = why.unwrap_err().to_string();
            assert!(why.contains(part), "{why}");
        }
        let why = KnownTissue::find("stone").unwrap_err().to_string();
        assert!(why.contains("`tissue` stone") && why.contains("muscle, muscle_3, gl"), "{why}");
    }
}
