//! What a budget buys: the sweeps for which the time of a tick suffices under the default press, and the error of
//! the force that they leave. The reference is the same press with [`MANY`] sweeps a tick.

use super::sweeps::{SweepRow, Task, body, words};
use crate::experiments::page::table::{Table, csv, percent, us};
use crate::experiments::page::{Context, Numbers, Section};
use chaincell_host::bake::{ORGAN_POISSON, ORGAN_SIZE, ORGAN_YOUNG_PA};
use chaincell_host::engine::convergence::MANY;
use chaincell_host::error::Result;
use chaincell_host::words::counted;

/// Time that a tick may take \[us\].
const BUDGETS_US: [u64; 5] = [100, 250, 500, 750, 1000];
/// Sweeps a tick that are measured.
const SWEEPS: [u16; 5] = [1, 2, 4, 8, 16];
const QUICK_CELLS: usize = 300;

/// The row with the most sweeps of which 99 of 100 ticks take at most this time; `None` where one sweep takes longer.
fn bought(rows: &[SweepRow], budget_us: u64) -> Option<&SweepRow> {
    rows.iter().rev().find(|row| row.tick_ns.p99 <= 1000 * budget_us)
}

/// The default body under the default press.
pub(crate) fn section(context: &Context) -> Result<Section> {
    let cells = if context.quick { QUICK_CELLS } else { ORGAN_SIZE };
    let material = Some(ORGAN_POISSON);
    let scene = body(context.cells.unwrap_or(cells), material)?;
    let rows = Task::DEFAULT_PRESS.rows(&scene, &words(material), &SWEEPS, MANY)?;
    let each = BUDGETS_US.map(|budget_us| (budget_us, bought(&rows, budget_us)));
    let of_row = |show: fn(&SweepRow) -> String| {
        move |(_, row): (u64, Option<&SweepRow>)| row.map_or_else(|| "-".to_owned(), show)
    };
    let table = Table::of(each)
        .column("time for a tick [us]", |(budget_us, _)| budget_us)
        .column("sweeps", of_row(|row| row.sweeps.to_string()))
        .column("median tick [us]", of_row(|row| us(row.tick_ns.p50)))
        .column("99 of 100 ticks [us]", of_row(|row| us(row.tick_ns.p99)))
        .column("error, median [%]", of_row(|row| percent(row.median)))
        .column("error, nine of ten ticks [%]", of_row(|row| percent(row.p90)))
        .column("error, largest [%]", of_row(|row| percent(row.largest)));
    let caption = "The most sweeps of which 99 of 100 ticks keep within the time, and the error of the force in % of \
                   its peak; - where one sweep takes longer";
    Ok(Section {
        key: "budget",
        title: "What a budget buys".to_owned(),
        text: vec![text(&rows, bought(&rows, 1000))],
        tables: vec![(caption.to_owned(), table.table())],
        numbers: vec![Numbers { name: "budget".to_owned(), csv: csv(&rows) }],
        json: serde_json::json!(rows),
        ..Section::default()
    })
}

fn text(rows: &[SweepRow], millisecond: Option<&SweepRow>) -> String {
    let buys = millisecond.map_or_else(
        || "On this machine a millisecond does not suffice for one sweep".to_owned(),
        |row| {
            format!(
                "On this machine a millisecond buys {}: nine of ten forces are then within {} % of those of {}",
                counted(row.sweeps, "sweep"),
                percent(row.p90),
                counted(MANY, "sweep")
            )
        },
    );
    format!(
        "{buys}. The body is the generated organ of {}, {:.0} kPa and Poisson's ratio {ORGAN_POISSON}; {}.",
        counted(rows.first().map_or(0, |row| row.cells), "cell"),
        1e-3 * ORGAN_YOUNG_PA,
        Task::DEFAULT_PRESS.words()
    )
}

#[cfg(test)]
mod tests {
    use chaincell_host::session::timing::histogram::Summary;

    use super::*;

    #[test]
    fn a_budget_buys_the_most_sweeps_that_fit() {
        let row = |sweeps: u16| SweepRow {
            cells: 300,
            material: "shapes".into(),
            tool: "press".into(),
            peak_n: 1.0,
            sweeps,
            median: 0.1 / f64::from(sweeps),
            p90: 0.2 / f64::from(sweeps),
            largest: 1.0,
            rolled_back: 0,
            tick_ns: Summary {
                p50: 90_000,
                p99: 100_000 * u64::from(sweeps),
                ..Summary::default()
            },
            passes: 1.0,
        };
        let rows = SWEEPS.map(row);
        let sweeps = BUDGETS_US.map(|us| bought(&rows, us).map(|row| row.sweeps));
        assert_eq!(sweeps, [Some(1), Some(2), Some(4), Some(4), Some(8)]);
        assert!(bought(&rows, 99).is_none());
        let said = text(&rows, bought(&rows, 1000));
        assert!(
            said.starts_with("On this machine a millisecond buys 8 sweeps: nine of ten"),
            "{said}"
        );
        assert!(said.contains("within 2.5 % of those of 64 sweeps"), "{said}");
        assert!(text(&rows, None).contains("does not suffice for one sweep"));
    }
}
