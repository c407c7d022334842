//! Tissues by name: a table of measured ones with their sources.
//!
//! A row says how it was got: `read` in a source, `derived` from what was read, or `fitted` to measured curves.
//! Poisson's ratio is that of nearly incompressible tissue where the source has none. A file of the same form has
//! tissues of the user's own.

use std::path::Path;

use super::relaxation::{Branch, DEVICE_HZ, Relaxation};
use super::stiffening::Band;
use super::table::{
    BRANCHES, TableRow, fields, file_and_name, header, line, number, positive, read,
};
use crate::error::{Error, Result};

/// The table: a line of names, then a tissue a line.
const TABLE: &str = include_str!("known.csv");

/// A tissue of the table, or of a file of its form.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownTissue {
    /// Its name.
    pub name: String,
    /// The tissue in words.
    pub tissue: String,
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
    pub status: String,
    /// The publication.
    pub source: String,
    /// Conversions, error of the fit, limits.
    pub note: String,
    /// File and line that it was read from, as FILE:LINE; `None` for a tissue of the list.
    pub place: Option<String>,
}

impl KnownTissue {
    /// Returns the tissue of this name; of `FILE.csv:NAME` the one of a file, of `FILE.csv` its only one.
    ///
    /// ```
    /// # use chaincell_host::bake::tissue::KnownTissue;
    /// assert_eq!(KnownTissue::find("cervix")?.branches.len(), 2);
    /// assert!(KnownTissue::find("stone").is_err());
    /// # Ok::<(), chaincell_host::error::Error>(())
    /// ```
    ///
    /// # Errors
    /// A name that is not in the table or the file; the error lists those that are. A file that cannot be read or is
    /// no table of tissues, with its line and the remedy.
    pub fn find(name: &str) -> Result<Self> {
        if let Some((path, name)) = file_and_name(name) {
            return Self::of_file(path, name);
        }
        let all = Self::all();
        let why = format!(
            "`tissue` {name}: there is none; known are {}; or give a table of your own, as FILE.csv:NAME",
            names(&all)
        );
        all.into_iter().find(|tissue| tissue.name == name).ok_or_else(|| Error::input(why))
    }

    /// Returns all tissues, in the order of the table.
    #[must_use]
    pub fn all() -> Vec<Self> {
        TABLE.lines().skip(1).filter_map(|line| Self::parse(&fields(line)).ok()).collect()
    }

    /// Returns a table of this tissue alone, which [`Self::find`] reads from a file.
    ///
    /// ```
    /// # use chaincell_host::bake::tissue::KnownTissue;
    /// let table = KnownTissue::find("cervix")?.table();
    /// assert!(table.lines().nth(1).is_some_and(|row| row.starts_with("cervix,")));
    /// # Ok::<(), chaincell_host::error::Error>(())
    /// ```
    #[must_use]
    pub fn table(&self) -> String {
        let modulus = if self.is_instant { "instant" } else { "long-term" };
        let [young_pa, poisson] = [self.young_pa, self.poisson].map(|number| number.to_string());
        let mut fields =
            vec![self.name.clone(), self.tissue.clone(), young_pa, modulus.to_owned(), poisson];
        // The branches, and empty columns up to the usual number of them.
        let columns = self.branches.len().max(BRANCHES);
        for branch in &self.branches {
            fields.extend([branch.ratio, branch.time_s].map(|number| number.to_string()));
        }
        fields.resize(fields.len() + 2 * (columns - self.branches.len()), String::new());
        // The columns after them.
        let bands: Vec<String> = self.stiffening.iter().map(Band::to_string).collect();
        let optional = |value: Option<f64>| value.map_or_else(String::new, |x| x.to_string());
        fields.extend([
            bands.join(" "),
            optional(self.toughness_j_per_m2),
            optional(self.friction),
            self.status.clone(),
            self.source.clone(),
            self.note.clone(),
        ]);
        format!("{}\n{}\n", header(columns), line(&fields))
    }

    /// Returns the tissue of this name in a file, or the only one of the file.
    fn of_file(path: &Path, name: Option<&str>) -> Result<Self> {
        let text = read(path)?;
        let file = path.display();
        let columns = text.lines().next().map_or(0, |header| fields(header).len());
        // Read every line.
        let mut all: Vec<Self> = Vec::new();
        let rows = (1..).zip(text.lines()).skip(1).filter(|(_, row)| !row.trim().is_empty());
        for (number, row) in rows {
            let refuse = |why: String| Error::input(format!("{file}:{number}: {why}"));
            let fields = fields(row);
            if fields.len() != columns {
                let found = fields.len();
                return Err(refuse(format!(
                    "{found} columns, and the header has {columns}; give each column its comma, and a text with a \
                     comma its quotes"
                )));
            }
            let place = Some(format!("{file}:{number}"));
            let tissue = Self { place, ..Self::parse(&fields).map_err(refuse)? };
            if all.iter().any(|other| other.name == tissue.name) {
                return Err(refuse(format!(
                    "the name {} stands twice; give each tissue a name of its own",
                    tissue.name
                )));
            }
            all.push(tissue);
        }
        // Choose one.
        let names = names(&all);
        match (name, all.len()) {
            (_, 0) => Err(Error::input(format!(
                "{file}: there is no tissue under the header; give a line for each"
            ))),
            (None, 2..) => Err(Error::input(format!(
                "{file}: there are several tissues, {names}; name one, as {file}:NAME"
            ))),
            (name, _) => all
                .into_iter()
                .find(|tissue| name.is_none_or(|name| tissue.name == name))
                .ok_or_else(|| {
                    let name = name.unwrap_or_default();
                    Error::input(format!("{file}: there is no tissue {name}; there are {names}"))
                }),
        }
    }

    /// Returns the row of a file that has the values, but those of options for which `is_given` is true.
    pub fn row(&self, is_given: impl Fn(&str) -> bool) -> Option<TableRow> {
        self.place.as_deref().map(|place| TableRow::new(place, is_given))
    }

    /// Reads the fields of a line; the error names the column and the remedy.
    fn parse(fields: &[&str]) -> std::result::Result<Self, String> {
        let [
            name,
            tissue,
            young_pa,
            modulus,
            poisson,
            pairs @ ..,
            bands,
            toughness,
            friction,
            status,
            source,
            note,
        ] = fields
        else {
            return Err(format!("{} columns; give all of the header", fields.len()));
        };
        if name.is_empty() {
            return Err("name is empty; give the tissue a name".to_owned());
        }
        let is_ratio = |ratio: f64| (0.0..=0.495).contains(&ratio);
        let is_coefficient = |friction: f64| friction >= 0.0;
        let friction = (!friction.is_empty()).then(|| {
            number("friction", friction, is_coefficient, "a number of 0 or above, or nothing")
        });
        let toughness = (!toughness.is_empty()).then(|| positive("toughness_j_per_m2", toughness));
        let band = |text: &str| text.parse::<Band>().map_err(|why| format!("stiffening_pa {why}"));
        Ok(Self {
            name: (*name).to_owned(),
            tissue: (*tissue).to_owned(),
            young_pa: positive("young_pa", young_pa)?,
            is_instant: match *modulus {
                "instant" => true,
                "long-term" => false,
                other => {
                    return Err(format!("modulus is \"{other}\"; give long-term or instant"));
                }
            },
            poisson: number("poisson", poisson, is_ratio, "a number from 0 to 0.495")?,
            branches: branches(pairs)?,
            stiffening: bands
                .split_whitespace()
                .map(band)
                .collect::<std::result::Result<_, _>>()?,
            toughness_j_per_m2: toughness.transpose()?,
            friction: friction.transpose()?,
            status: (*status).to_owned(),
            source: (*source).to_owned(),
            note: (*note).to_owned(),
            place: None,
        })
    }
}

/// Returns the branches of these columns, a ratio and a time each; a pair of empty ones is none.
fn branches(columns: &[&str]) -> std::result::Result<Vec<Branch>, String> {
    let mut branches = Vec::new();
    for (at, pair) in (1..).zip(columns.chunks(2)) {
        match *pair {
            ["", ""] => {}
            [ratio, time_s] => branches.push(Branch {
                ratio: positive(&format!("g{at}"), ratio)?,
                time_s: positive(&format!("tau{at}_s"), time_s)?,
            }),
            _ => return Err(format!("g{at} has no column tau{at}_s; give both")),
        }
    }
    Ok(branches)
}

/// Returns the names of tissues with commas.
fn names(tissues: &[KnownTissue]) -> String {
    let names: Vec<&str> = tissues.iter().map(|tissue| tissue.name.as_str()).collect();
    names.join(", ")
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
                let why = "the body has no branches that relax; give `branches`, or leave it out";
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bake::tissue::{Moduli, Tissue};
    use crate::bake::{
        BakeOptions, ORGAN_POISSON, ORGAN_TISSUE, ORGAN_YOUNG_PA, PerCell, bake, organ,
        organ_of_known,
    };
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
            let words = [&tissue.tissue, &tissue.source, &tissue.note];
            assert!(words.iter().all(|text| text.len() > 5), "{name}");
        }
        let names = "name,tissue,young_pa,modulus,poisson,g1,tau1_s,g2,tau2_s,g3,tau3_s,stiffening_pa,\
                     toughness_j_per_m2,friction,status,source,note";
        assert_eq!(TABLE.lines().next(), Some(names));
        assert_eq!(header(BRANCHES), names);
    }

    /// A liver has the values of the default body, and the default toughness comes from the same publication.
    #[test]
    fn a_liver_is_the_default_body() {
        let liver = KnownTissue::find(ORGAN_TISSUE).unwrap();
        assert_eq!((liver.young_pa, liver.poisson), (ORGAN_YOUNG_PA, ORGAN_POISSON));
        assert_eq!(liver.toughness_j_per_m2, Some(164.0));
        assert!(liver.branches.is_empty() && liver.stiffening.is_empty());
        assert_eq!(organ_of_known(&liver).unwrap(), organ().unwrap());
    }

    /// Also tissue with four branches, bands and all that may be missing.
    #[test]
    fn a_tissue_is_found_in_its_own_table() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.csv");
        let file = file.to_str().unwrap();
        let mut all = KnownTissue::all();
        let branches = [0.1, 1.0, 10.0, 100.0].map(|time_s| Branch { ratio: 0.125, time_s });
        all.push(KnownTissue {
            name: "own".to_owned(),
            branches: branches.to_vec(),
            stiffening: vec!["short:0.035=22000".parse().unwrap(), Band::new(0.1, 500.5)],
            toughness_j_per_m2: Some(90.0),
            friction: Some(0.0),
            ..all[0].clone()
        });
        for tissue in all {
            std::fs::write(file, tissue.table()).unwrap();
            let found = |name: &str| {
                let found = KnownTissue::find(name).unwrap();
                assert_eq!(found.place.as_deref(), Some(&*format!("{file}:2")));
                KnownTissue { place: None, ..found }
            };
            assert_eq!(found(file), tissue);
            assert_eq!(found(&format!("{file}:{}", tissue.name)), tissue);
        }
    }

    #[test]
    fn what_is_no_table_is_refused_by_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("own.csv");
        let file = file.to_str().unwrap();
        let top = header(1);
        let row = "soft,some tissue,900,long-term,0.45,2,0.5,0.1=500,,,fitted,own,none";
        let why = |text: &str, name: &str| {
            std::fs::write(file, text).unwrap();
            let why = KnownTissue::find(&format!("{file}{name}")).unwrap_err().to_string();
            why.replace(file, "FILE")
        };
        let other = row.replace("soft,", "other,");
        for (text, name, part) in [
            (
                "time_s,strain\n1,2\n".to_owned(),
                "",
                "FILE:1: the header is \"time_s,strain\"; a table",
            ),
            (top.clone(), "", "FILE: there is no tissue under the header"),
            (
                format!("{top}\n{row}\n{other}\n"),
                "",
                "several tissues, soft, other; name one, as FILE:",
            ),
            (format!("{top}\n{row}\n"), ":hard", "FILE: there is no tissue hard; there are soft"),
            (format!("{top}\n{row}\n\n{row}\n"), ":soft", "FILE:4: the name soft stands twice"),
            (format!("{top}\n{row},more\n"), "", "FILE:2: 14 columns, and the header has 13"),
        ] {
            let why = why(&text, name);
            assert!(why.contains(part), "{why}");
        }
        for (good, bad, part) in [
            ("soft,", ",", "FILE:2: name is empty"),
            ("900", "-900", "FILE:2: young_pa is \"-900\"; give a number above 0"),
            ("900", "inf", "young_pa is \"inf\""),
            ("long-term", "late", "modulus is \"late\"; give long-term or instant"),
            ("0.45", "0.5", "poisson is \"0.5\"; give a number from 0 to 0.495"),
            ("2,0.5", ",0.5", "g1 is \"\"; give a number above 0"),
            ("2,0.5", "2,x", "tau1_s is \"x\""),
            ("0.1=500", "0.1", "stiffening_pa 0.1: give HALF_WIDTH=PASCAL"),
            (",,,fitted", ",0,,fitted", "toughness_j_per_m2 is \"0\""),
            (",,,fitted", ",,-1,fitted", "friction is \"-1\"; give a number of 0 or above"),
        ] {
            let changed = row.replacen(good, bad, 1);
            assert_ne!(changed, row);
            let why = why(&format!("{top}\n{changed}\n"), ":soft");
            assert!(why.contains(part), "{why}");
        }
        let why = KnownTissue::find("none/own.csv:soft").unwrap_err().to_string();
        assert!(why.contains("cannot read tissues none/own.csv"), "{why}");
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
            for Band { half_width, modulus_pa, .. } in stiffening {
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
            (Some(&brain), true, true, None, "`instant`: the body has no branches"),
            (None, true, false, Some(1000), "`device_hz`: the body has no branches"),
        ] {
            let why = relaxation(known, None, is_modulus_given, is_instant, device_hz);
            let why = why.unwrap_err().to_string();
            assert!(why.contains(part), "{why}");
        }
        let why = KnownTissue::find("stone").unwrap_err().to_string();
        assert!(why.contains("`tissue` stone") && why.contains("muscle, muscle_3, gl"), "{why}");
    }
}
