//! Measured tissue, fitted by `identify`: a porcine liver under a ball, human brain in tension,
//! compression and shear, a muscle that relaxes.
//!
//! The data is that of `tissue/` in the reference folder, with its sources there; it is read here
//! and nothing of it is kept. Each fit says what it assumes, how far the data determines each
//! parameter, and how far it is off: where the model cannot follow, that is the finding.

pub mod brain;
pub mod liver;
pub mod muscle;
mod read;

use std::path::Path;

use chaincell_host::error::{Error, Result};
use chaincell_host::files::output::Folder;

use super::identify::Identified;
use super::report::tables::Table;
use crate::charts::plot::Chart;

/// A fit as text, numbers and a picture.
#[derive(Debug, Clone)]
pub struct Section {
    /// Name of its files.
    pub name: &'static str,
    /// Markdown.
    pub text: String,
    /// Measured and fitted numbers.
    pub csv: String,
    /// Both as a picture.
    pub chart: Chart,
}

impl Section {
    /// Writes numbers and picture.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        folder.write(&format!("{}.csv", self.name), self.csv.as_bytes())?;
        self.chart.write(folder, self.name).map(drop)
    }
}

/// Fits the data of a reference folder; none where the folder lacks it.
pub type Fit = fn(&Path) -> Result<Option<Section>>;

/// The fits by name, in order.
pub const FITS: [(&str, Fit); 3] =
    [("liver", liver::section), ("brain", brain::section), ("muscle", muscle::section)];

/// The fit of a name; a line that says so where the folder lacks its data.
///
/// # Errors
/// A name that is none, data that cannot be read, what the fit refuses.
pub fn run(name: &str, reference: &Path) -> Result<std::result::Result<Section, String>> {
    let Some((_, fit)) = FITS.iter().find(|(of, _)| *of == name) else {
        let names = FITS.map(|(name, _)| name).join(", ");
        return Err(Error::input(format!("{name}: no such fit; take one of {names}")));
    };
    let skipped = || format!("SKIPPED {name}: {} has none of its data", reference.display());
    Ok(fit(reference)?.ok_or_else(skipped))
}

/// The parameters found, with what the data says of each.
fn parameters(found: &Identified) -> String {
    let table = Table::of(&found.estimates)
        .column("parameter", |of| of.name())
        .column("found", |of| digits(of.value))
        .column("95 % interval", |of| {
            format!("{} to {}", digits(of.interval[0]), digits(of.interval[1]))
        })
        .column("determined to 5 %", |of| if of.determined { "yes" } else { "no" });
    let open: String = found.undetermined.iter().map(|said| format!("- {said}\n")).collect();
    format!("{}{open}\n", table.table().markdown())
}

/// Three significant digits.
fn digits(value: f64) -> String {
    let before = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    format!("{value:.0$}", (2 - before).clamp(0, 6) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_its_data_a_fit_says_so() {
        let empty = tempfile::tempdir().unwrap();
        for (name, _) in FITS {
            let said = run(name, empty.path()).unwrap().unwrap_err();
            assert!(said.starts_with(&format!("SKIPPED {name}: ")), "{said}");
        }
        let error = run("bone", empty.path()).unwrap_err().to_string();
        assert!(error.contains("bone: no such fit; take one of liver, brain, muscle"), "{error}");
    }

    #[test]
    fn three_digits() {
        assert_eq!([1234.5, 12.345, 0.12345, 0.0].map(digits), ["1234", "12.3", "0.123", "0.00"]);
    }
}
