//! What an experiment hands to its page: text, pictures, tables, the numbers behind them.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use serde_json::{Value, json};

use super::table::Table;
use crate::charts::plot::Figure;
use chaincell_host::error::Result;
use chaincell_host::session::timing::machine::Machine;

/// What the experiments are run on.
#[derive(Debug, Clone, Default)]
pub struct Context {
    /// Folder of reference data with the real liver; without it the generated organ stands in.
    pub reference: Option<PathBuf>,
    /// Fewer ticks, sizes and repetitions.
    pub quick: bool,
    /// Cells of the organ that shows what a sweep buys, where they are given.
    pub cells: Option<usize>,
}

/// The numbers behind a picture or a table.
#[derive(Debug, Clone)]
pub struct Numbers {
    /// Name of the file without ending, the page's name in front or not.
    pub name: String,
    /// CSV text: a header whose names end in their units, rows.
    pub csv: String,
}

/// One experiment on a page.
#[derive(Debug, Clone, Default)]
pub struct Section {
    /// Key of its figures in the JSON file.
    pub key: &'static str,
    /// Heading.
    pub title: String,
    /// The paper's results that it is about, each with what was computed here.
    pub results: Vec<(&'static str, String)>,
    /// Paragraphs, plain text.
    pub text: Vec<String>,
    /// Pictures in order, their names with or without the page's name in front.
    pub figures: Vec<Figure>,
    /// Tables with their captions.
    pub tables: Vec<(String, Table)>,
    /// CSV files.
    pub numbers: Vec<Numbers>,
    /// What the JSON file holds of it; names end in their units.
    pub json: Value,
}

/// What computes a section.
pub type Experiment = fn(&Context) -> Result<Section>;

/// A page of experiments, made by one command.
#[derive(Debug)]
pub struct Page {
    /// Name of the command, of the page's files and in front of all others.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// The first paragraph.
    pub intro: &'static str,
    /// What it shows, in order.
    pub experiments: &'static [Experiment],
}

impl Page {
    /// Name of a file of the page, without its ending.
    pub fn file_name(&self, name: &str) -> String {
        let front = format!("{}_", self.name);
        format!("{front}{}", name.strip_prefix(&front).unwrap_or(name))
    }
}

/// All sections of a page so far, with what they were computed on.
#[derive(Debug, Clone)]
pub struct Findings {
    /// The page.
    pub page: &'static Page,
    /// What the experiments were run on.
    pub context: Context,
    /// The machine.
    pub machine: Machine,
    /// Whether sections are missing, by the user's wish or an error.
    pub interrupted: bool,
    /// In the order of the page.
    pub sections: Vec<Section>,
    /// How long each took, by its key \[s\].
    pub seconds: BTreeMap<&'static str, f64>,
}

impl Findings {
    /// Nothing so far.
    pub fn new(page: &'static Page, context: Context) -> Self {
        let (sections, seconds) = (Vec::new(), BTreeMap::new());
        Self { page, context, machine: Machine::read(), interrupted: false, sections, seconds }
    }

    /// The command line that gives them again.
    pub fn command(&self) -> String {
        let quick = if self.context.quick { " --quick" } else { "" };
        let reference = if self.context.reference.is_some() { " --reference DIR" } else { "" };
        let cells =
            self.context.cells.map_or_else(String::new, |cells| format!(" --cells {cells}"));
        format!("chaincell {}{quick}{reference}{cells}", self.page.name)
    }

    /// The figures of every section by its key, and where they come from.
    pub fn json(&self) -> Value {
        let mut all = json!({
            "command": self.command(),
            "version": env!("CARGO_PKG_VERSION"),
            "date": today(),
            "machine": self.machine,
            "quick": self.context.quick,
            "reference": self.context.reference.is_some(),
            "interrupted": self.interrupted,
            "seconds": self.seconds,
        });
        for section in self.sections.iter().filter(|section| !section.json.is_null()) {
            all[section.key] = section.json.clone();
        }
        all
    }
}

/// The date in UTC, year-month-day.
pub fn today() -> String {
    let since_1970 = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    date((since_1970.as_secs() / 86_400) as i64)
}

/// The date of a day after 1 January 1970, by H. Hinnant's rule: years begin in March, so that the leap day is
/// their last.
fn date(days: i64) -> String {
    let from_march_0 = days + 719_468;
    let (era, day) = (from_march_0.div_euclid(146_097), from_march_0.rem_euclid(146_097));
    let year = (day - day / 1_460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    format!("{}-{month:02}-{day:02}", year + era * 400 + i64::from(month <= 2))
}

#[cfg(test)]
mod tests {
    #[test]
    fn days_have_their_dates() {
        let dates = [0, 59, 11_016, 11_017, 20_784].map(super::date);
        assert_eq!(dates, ["1970-01-01", "1970-03-01", "2000-02-29", "2000-03-01", "2026-11-27"]);
    }
}
