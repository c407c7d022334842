//! What an experiment hands to the report: text, pictures, tables, the numbers behind them.

use std::path::PathBuf;

use crate::charts::plot::Figure;
use crate::experiments::report::tables::Table;

/// What the experiments are run on.
#[derive(Debug, Clone, Default)]
pub struct Context {
    /// Folder of reference data with the real liver; without it the generated organ stands in.
    pub reference: Option<PathBuf>,
    /// Fewer ticks, sizes and repetitions.
    pub quick: bool,
}

/// The numbers behind a picture.
#[derive(Debug, Clone)]
pub struct Numbers {
    /// Name of the file without ending, `paper_` in front.
    pub name: String,
    /// CSV text: a header whose names end in their units, rows.
    pub csv: String,
}

/// One experiment of the report.
#[derive(Debug, Clone)]
pub struct Section {
    /// Key of its figures in `paper.json`.
    pub key: &'static str,
    /// Heading.
    pub title: String,
    /// The paper's results that it is about, each with what was computed here.
    pub results: Vec<(&'static str, String)>,
    /// Paragraphs, plain text.
    pub text: Vec<String>,
    /// Pictures in order, their names with or without `paper_` in front.
    pub figures: Vec<Figure>,
    /// Tables with their captions.
    pub tables: Vec<(String, Table)>,
    /// CSV files.
    pub numbers: Vec<Numbers>,
    /// What `paper.json` holds of it; names end in their units.
    pub json: serde_json::Value,
}
