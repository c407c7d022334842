//! Runs the experiments and writes what they give: page, figures, pictures, numbers.

use std::collections::BTreeMap;
use std::time::Instant;

use indicatif::ProgressBar;
use serde_json::{Value, json};

use super::section::{Context, Section};
use super::{EXPERIMENTS, html};
use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_host::interrupt;
use chaincell_host::session::timing::machine::Machine;

/// All sections so far, with what they were computed on.
#[derive(Debug, Clone, Default)]
pub struct PaperReport {
    /// The command line that gives them again.
    pub command: String,
    /// Version of the program.
    pub version: &'static str,
    /// The machine.
    pub machine: Machine,
    /// Fewer ticks, sizes and repetitions.
    pub quick: bool,
    /// Whether the reference data was used.
    pub reference: bool,
    /// Whether the user stopped it.
    pub interrupted: bool,
    /// In the order of [`EXPERIMENTS`].
    pub sections: Vec<Section>,
    /// How long each took, by its key \[s\].
    pub seconds: BTreeMap<&'static str, f64>,
}

/// Steps of the progress bar.
#[must_use]
pub fn pieces() -> u64 {
    EXPERIMENTS.len() as u64
}

/// Runs every experiment into `report`; those that are done stay in it whatever ends the rest.
///
/// # Errors
/// What an experiment says; the user's wish to stop.
pub fn collect(context: &Context, report: &mut PaperReport, bar: &ProgressBar) -> Result<()> {
    for experiment in EXPERIMENTS {
        let start = Instant::now();
        // Sections are missing, whatever the reason of an error.
        let section = interrupt::check().and_then(|()| experiment(context));
        report.interrupted = section.is_err();
        let section = section?;
        report.seconds.insert(section.key, start.elapsed().as_secs_f64());
        report.sections.push(section);
        bar.inc(1);
    }
    Ok(())
}

impl PaperReport {
    /// What `paper.json` holds: the figures of every section by its key, and where they come from.
    #[must_use]
    pub fn json(&self) -> Value {
        let mut all = json!({
            "command": self.command,
            "version": self.version,
            "machine": self.machine,
            "quick": self.quick,
            "reference": self.reference,
            "interrupted": self.interrupted,
            "seconds": self.seconds,
        });
        for section in &self.sections {
            all[section.key] = section.json.clone();
        }
        all
    }

    /// Writes paper.html, paper.json, pictures and CSV files.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        for section in &self.sections {
            for figure in &section.figures {
                figure.picture.write(folder, &file_name(&figure.name))?;
            }
            for numbers in &section.numbers {
                let name = file_name(&numbers.name);
                folder.write(&format!("{name}.csv"), numbers.csv.as_bytes())?;
            }
        }
        folder.write_json("paper.json", &self.json())?;
        folder.write("paper.html", html::page(self).as_bytes())
    }
}

/// Name of a file of the report, without its ending.
pub(super) fn file_name(name: &str) -> String {
    format!("paper_{}", name.strip_prefix("paper_").unwrap_or(name))
}
