//! `chaincell tissues`: the tissues that `bake --tissue` knows by name.

use serde::Serialize;

use super::shared::PrintArgs;
use super::values::tissue_options;
use crate::bake::tissue::{Band, KnownTissue};
use crate::error::Result;
use crate::terminal;

/// List the tissues that `bake --tissue` knows, with their values and sources.
///
/// A tissue is read in a publication, derived from what was read there, or fitted to published curves. Poisson's
/// ratio is assumed where the source has none; it and a modulus said to be instant hold before anything has relaxed.
/// Toughness is printed as the options of a body that can be cut, friction as that of `run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  chaincell bake organ --tissue cervix -o cervix.chaincell")]
pub struct Args {
    #[command(flatten)]
    print: PrintArgs,
}

/// A tissue of the list.
#[derive(Serialize)]
struct Listed {
    name: String,
    tissue: String,
    young_pa: f64,
    /// `long-term` or `instant`.
    modulus: &'static str,
    poisson: f64,
    /// Shear modulus over the long-term one, and time \[s\].
    branches: Vec<[f64; 2]>,
    stiffening: Vec<Band>,
    toughness_j_per_m2: Option<f64>,
    friction: Option<f64>,
    status: String,
    source: String,
    note: String,
}

/// The output of `--json`.
#[derive(Serialize)]
struct Printed {
    tissues: Vec<Listed>,
}

impl From<KnownTissue> for Listed {
    fn from(known: KnownTissue) -> Self {
        Self {
            name: known.name,
            tissue: known.tissue,
            young_pa: known.young_pa,
            modulus: if known.is_instant { "instant" } else { "long-term" },
            poisson: known.poisson,
            branches: known.branches.iter().map(|of| [of.ratio, of.time_s]).collect(),
            stiffening: known.stiffening,
            toughness_j_per_m2: known.toughness_j_per_m2,
            friction: known.friction,
            status: known.status,
            source: known.source,
            note: known.note,
        }
    }
}

impl Listed {
    /// Its values as the options of a bake.
    fn options(&self) -> String {
        let number = |option: &str, value: Option<f64>| {
            value.map_or_else(String::new, |value| format!("{option}{value}"))
        };
        [
            tissue_options(&self.branches, self.modulus == "instant", &self.stiffening),
            number(", --cuttable --toughness-j-per-m2 ", self.toughness_j_per_m2),
            number(", run --friction ", self.friction),
        ]
        .concat()
    }
}

pub fn execute(args: &Args) -> Result<()> {
    let tissues: Vec<Listed> = KnownTissue::all().into_iter().map(Listed::from).collect();
    if args.print.json {
        return terminal::say_json(&Printed { tissues });
    }
    for tissue in &tissues {
        let Listed { name, tissue: words, young_pa, poisson, status, source, note, .. } = tissue;
        terminal::say(format_args!("{name}: {words}"))?;
        let options = tissue.options();
        terminal::say(format_args!("  --young-pa {young_pa} --poisson {poisson}{options}"))?;
        terminal::say(format_args!("  {status}: {source}"))?;
        terminal::say(format_args!("  {note}"))?;
    }
    Ok(())
}
