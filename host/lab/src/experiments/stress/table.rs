//! The suite as a table for a terminal of 100 columns.

use std::fmt::Write;

use comfy_table::presets::{ASCII_HORIZONTAL_ONLY, NOTHING};
use comfy_table::{ColumnConstraint, ContentArrangement, Table, Width};

use super::Suite;
use super::case::Outcome;
use chaincell_host::words::counted;

/// Columns of the terminal.
const WIDTH: u16 = 100;
/// Widths of the table's columns.
const COLUMNS: [u16; 4] = [20, 58, 8, 10];
/// Failures that are shown of a case; all stand in the JSON.
const SHOWN: usize = 5;

/// The table, the failures in full, what number types refuse.
#[must_use]
pub fn table(suite: &Suite) -> String {
    let mut table = plain(&COLUMNS);
    table.load_style(ASCII_HORIZONTAL_ONLY);
    table.set_header(["case", "checked besides (*)", "result", "nearest"]);
    table.add_rows(suite.cases.iter().map(row));
    let mut notes = plain(&[WIDTH]);
    notes.add_row([format!("(*) in every tick: {}.", suite.every_tick)]);
    notes.add_row([NOTES]);
    let mut text = format!("{}\n{}\n", table.trim_fmt(), notes.trim_fmt());
    for case in suite.cases.iter().filter(|case| !case.ok) {
        let _ = writeln!(text, "\n{} FAILED:", case.name);
        for failed in case.found.failures.iter().take(SHOWN) {
            let failure = &failed.failure;
            let _ = writeln!(
                text,
                "  {}, tick {}: {:?}: {}",
                failed.place, failure.tick, failure.check, failure.what
            );
        }
        if let Some(more) = case.found.failures.len().checked_sub(SHOWN).filter(|&more| more > 0) {
            let _ = writeln!(text, "  and {more} more");
        }
    }
    let mut refused = suite
        .cases
        .iter()
        .flat_map(|case| case.found.refused.iter().map(|why| format!("  {}: {why}\n", case.name)));
    if let Some(first) = refused.next() {
        text += "\nRefused, with the reason:\n";
        text += &first;
        text.extend(refused);
    }
    let _ = write!(
        text,
        "\n{} of {} ok, {}, {}",
        suite.done - suite.failed,
        counted(suite.done, "case"),
        counted(suite.runs, "run"),
        counted(suite.ticks, "tick")
    );
    text
}

/// A table without lines, of columns of these widths.
fn plain(widths: &[u16]) -> Table {
    let mut table = Table::new();
    table.load_style(NOTHING).set_content_arrangement(ContentArrangement::Dynamic);
    table.set_width(WIDTH).set_header(vec![""; widths.len()]);
    for (column, &width) in table.column_iter_mut().zip(widths) {
        column.set_padding((0, 1)).set_constraint(ColumnConstraint::Absolute(Width::Fixed(width)));
    }
    table
}

/// What the last column means.
const NOTES: &str = "nearest: the figure nearest to its bound, which is 1: E of what a tool may load, \
    F of 2 k sqrt(W E), x of K, r of the rounding allowed.";

fn row(case: &Outcome) -> [String; 4] {
    [
        case.name.to_owned(),
        case.checks.to_owned(),
        if case.ok { "ok" } else { "FAILED" }.to_owned(),
        nearest(case),
    ]
}

/// The figure that came nearest to its bound, which is 1.
fn nearest(case: &Outcome) -> String {
    let of = [
        ("energy_over_bound", "E"),
        ("force_over_bound", "F"),
        ("coordinate_over_k", "x"),
        ("rounding_over_allowance", "r"),
    ];
    let figures = of.iter().filter_map(|(key, name)| Some((name, *case.found.figures.get(*key)?)));
    match figures.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((name, value)) => format!("{name} {value:.2}"),
        None => "-".to_owned(),
    }
}
