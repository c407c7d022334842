//! `chaincell report`: speed against error, measured and written down.
//!
//! Every figure comes with the body and the tool that it was measured on. Times depend on the
//! machine and its load: compare ratios within one report. Sweeps and errors do not.
//!
//! | section of report.html | question | numbers |
//! |---|---|---|
//! | What a budget buys | sweeps and error that the time of a tick leaves under the default press | `report_budget.csv` |
//! | What a sweep buys | error of the force at few sweeps a tick against many, and time a tick, for held cells and a ball that moves, shapes and links | `report_sweeps.csv` |
//! | A hand that moves | time a tick and error of the force for held cells under a hand's motions, every scheme of a list, two bodies | `report_hand.csv` |
//! | Verification cases of others | SOFA's cylinder, bar and cantilever, and DJTLED's cube on its own mesh, beside nodal shapes and links; steps of an explicit method | `report_decks.csv`, `report_decks_beam.csv`, `report_decks_cube.csv`, `report_decks_steps.csv` |
//!
//! An error of the force is relative: to the largest force of the motion in the first section, to the
//! exact force under a hand. Which ticks count under a hand, and which are left out because the body
//! snaps from one equilibrium to another, is one rule: see `snaps`. `report.json` has every figure,
//! the CSV files the rows of the tables.

mod budget;
mod decks;
pub mod embedded;
mod hand;
mod motions;
mod pictures;
pub mod scene;
mod snaps;
pub mod sweeps;

use super::page::table::Table;
use super::page::{Context, Page, Section};
use chaincell_host::error::Result;

/// The page, with its measurements in order.
pub(crate) static PAGE: Page = Page {
    name: "report",
    title: "Speed against error",
    intro: "Time of a tick and error of the force on this machine: one thread, numbers in f32. Compare \
            ratios within one report, not times of two.",
    experiments: &[budget::section, sweeps::section, hand::section, decks::section, others],
};

/// Figures that other commands measure.
const OTHERS: [(&str, &str); 4] = [
    (
        "time of a tick, also by several threads, and round trip in the 1 kHz loop, beside the \
         machine's own floor",
        "chaincell cosim, chaincell latency MODEL --worst",
    ),
    ("the same for hours, under load", "chaincell cosim --load 1 --seconds 28800 --out night"),
    (
        "instructions of a sweep in its worst state (needs valgrind)",
        "cargo bench --locked -p chaincell-lab --bench sweep",
    ),
    (
        "instructions on microcontrollers, and the error of whole ticks beside them",
        "tests/firmware/run, tests/firmware/run --fit",
    ),
];

/// What this report does not measure, and what does.
fn others(_: &Context) -> Result<Section> {
    let table =
        Table::of(OTHERS).column("figure", |(figure, _)| figure).column("command", |(_, by)| by);
    Ok(Section {
        key: "others",
        title: "Figures of other commands".to_owned(),
        tables: vec![("Run in the source tree".to_owned(), table.table())],
        ..Section::default()
    })
}
