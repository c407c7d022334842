//! The section of the report: tables, bars, pictures.

use super::running::{RunningRow, SPEED_M_PER_S};
use super::{Measured, Model, ModelRow};
use crate::charts::plot::{Axis, Chart, Style};
use crate::experiments::report::tables::{Table, percent};

/// Name of the table's file.
pub const CSV: &str = "report_model.csv";
/// Name of the running kernel's table.
pub const RUNNING_CSV: &str = "report_model_running.csv";
/// How the names of the pictures begin, one for each body pressed to several depths.
pub const PICTURE: &str = "report_model_";

/// Depth that the running kernel is shown at \[mm\].
const SHOWN_MM: f64 = 4.0;

/// What the model is meant to keep, without any number fitted to these bodies.
#[derive(Debug, Clone, Copy)]
struct Bar {
    body: &'static str,
    poisson_percent: u8,
    /// Depths that it is about \[mm\].
    depths_mm: [f64; 2],
    field_max: f64,
    force: Option<[f64; 2]>,
}

/// The model of the bars.
const JUDGED: &str = "nodal, det1, band";

const fn bar(
    body: &'static str,
    poisson_percent: u8,
    depths_mm: [f64; 2],
    field_max: f64,
    force: Option<[f64; 2]>,
) -> Bar {
    Bar { body, poisson_percent, depths_mm, field_max, force }
}

const BARS: [Bar; 8] = [
    bar("liver_5762", 30, [1.0, 4.0], 0.045, Some([0.94, 1.03])),
    bar("liver_5762", 30, [1.0, 10.0], 0.07, Some([0.94, 1.03])),
    bar("liver_5762", 45, [1.0, 4.0], 0.06, Some([0.93, 1.03])),
    bar("liver_5762", 45, [1.0, 10.0], 0.08, Some([0.93, 1.03])),
    bar("box_uns", 30, [1.0, 1.0], 0.04, None),
    bar("box_uns", 30, [1.0, 10.0], 0.07, Some([0.91, 1.03])),
    bar("liver_500", 30, [1.0, 1.0], 0.11, None),
    bar("liver_181", 30, [1.0, 1.0], 0.13, None),
];

/// A bar with what was measured.
#[derive(Debug, Clone)]
pub struct Judged {
    /// Body, Poisson's ratio and depths.
    pub what: String,
    /// Largest error of the field, and its bar.
    pub field: [f64; 2],
    /// Least and largest ratio of the forces, and their bar.
    pub force: ([f64; 2], Option<[f64; 2]>),
}

impl Judged {
    /// Whether the bar holds.
    #[must_use]
    pub fn holds(&self) -> bool {
        let [field, field_max] = self.field;
        let ([least, most], bar) = self.force;
        field <= field_max && bar.is_none_or(|[low, high]| low <= least && most <= high)
    }
}

/// The bars of the bodies that were measured.
#[must_use]
pub fn bars(rows: &[ModelRow]) -> Vec<Judged> {
    let judge = |bar: &Bar| {
        let [from, to] = bar.depths_mm;
        let of = |row: &&ModelRow| {
            let body = (row.body, row.poisson_percent) == (bar.body, bar.poisson_percent);
            let depth = (from - 0.01..to + 0.01).contains(&row.depth_mm);
            body && depth && row.model == JUDGED
        };
        let rows: Vec<&ModelRow> = rows.iter().filter(of).collect();
        let forces = || rows.iter().map(|row| row.force);
        let depths = if from == to { from.to_string() } else { format!("{from} to {to}") };
        (!rows.is_empty()).then(|| Judged {
            what: format!("{}, nu 0.{}, {depths} mm", bar.body, bar.poisson_percent),
            field: [rows.iter().map(|row| row.field).fold(0.0, f64::max), bar.field_max],
            force: (
                [forces().fold(f64::INFINITY, f64::min), forces().fold(0.0, f64::max)],
                bar.force,
            ),
        })
    };
    BARS.iter().filter_map(judge).collect()
}

/// The rows of each body, in their order.
fn bodies(rows: &[ModelRow]) -> impl Iterator<Item = &[ModelRow]> {
    rows.chunk_by(|a, b| (a.body, a.poisson_percent) == (b.body, b.poisson_percent))
}

/// The rows of each model of a body.
fn models(rows: &[ModelRow]) -> impl Iterator<Item = &[ModelRow]> {
    rows.chunk_by(|a, b| a.model == b.model)
}

/// The section of the report; `picture` stands in it as it is.
#[must_use]
pub fn markdown(measured: &Measured, picture: &str) -> String {
    let rows = &measured.rows;
    if rows.is_empty() {
        return "## Model error\n\nSKIPPED: no reference data was given (--reference, \
                CHAINCELL_REFERENCE).\n\n"
            .to_owned();
    }
    let judged = bars(rows);
    let range = |[low, high]: [f64; 2]| format!("{low:.2} .. {high:.2}");
    let table = Table::of(&judged)
        .column("body", |bar| &bar.what)
        .column("field, largest [%]", |bar| format!("{:.1}", 100.0 * bar.field[0]))
        .column("bar [%]", |bar| percent(bar.field[1]))
        .column("force ratio", |bar| range(bar.force.0))
        .column("bar", |bar| bar.force.1.map_or("-".to_owned(), range))
        .column("holds", |bar| if bar.holds() { "yes" } else { "**no**" });
    let bodies: String = bodies(rows).map(body).collect();
    format!(
        "## Model error\n\n{picture}How far the exact equilibrium of a model is from quadratic \
         finite elements (P2) on the same mesh, which are the nearest to the truth at hand and not \
         converged: no time, no solver. Held nodes are pressed and stick, E = 5 kPa. Field: \
         |u - u_P2| over |u_P2|, L2 over the free nodes weighted by their volumes. Worst: the \
         largest error of a node over the depth. Inverted: tetrahedra inside out, those of the \
         reference by the corners of its elements. `links, one stiffness`: all links alike, as the \
         bake makes them, with the stiffness that gives the mean modulus E; `E sum V / l^2`: each by \
         the volume around it (van Gelder 1998); alpha is 0 for both, and their Poisson's ratio is \
         always 0.25; where links fold they have many equilibria, of which these are some. Linear tetrahedra: of the reference data. `nodal`: mean gradients at the \
         nodes, a fifth of the shear stiffness on the tetrahedra, volume by determinant or trace; \
         `band`: stretches below 0.7 are resisted. No number is fitted to these bodies. Relative \
         residual of every equilibrium: at most {:.0e}.\n\nWhat `{JUDGED}` is meant to keep:\n\n\
         {}{}{bodies}",
        rows.iter().filter_map(|row| row.residual).fold(0.0, f64::max),
        table.table().markdown(),
        running(&measured.running)
    )
}

/// What a budget leaves: the running kernel at the last depth of at most [`SHOWN_MM`].
fn running(rows: &[RunningRow]) -> String {
    let presses = rows.chunk_by(|a, b| {
        (a.body, a.poisson_percent, a.model, a.sweeps)
            == (b.body, b.poisson_percent, b.model, b.sweeps)
    });
    let shown = |rows: &'_ [RunningRow]| {
        rows.iter().rev().find(|row| row.depth_mm < SHOWN_MM + 0.01).cloned()
    };
    let shown: Vec<RunningRow> = presses.filter_map(shown).collect();
    let table = Table::of(&shown)
        .column("body", |row| format!("{}, nu 0.{}", row.body, row.poisson_percent))
        .column("model", |row| row.model)
        .column("scheme", |row| row.scheme)
        .column("sweeps", |row| row.sweeps.to_string())
        .column("depth [mm]", |row| format!("{:.0}", row.depth_mm))
        .column("tick [us]", |row| format!("{:.0}", row.tick_us))
        .column("tick [bare sweeps]", |row| format!("{:.1}", row.tick_bare_sweeps))
        .column("field, own equilibrium [%]", |row| format!("{:.1}", 100.0 * row.field_own))
        .column("force ratio, own", |row| format!("{:.3}", row.force_own))
        .column("field, elements [%]", |row| format!("{:.1}", 100.0 * row.field))
        .column("force ratio, elements", |row| format!("{:.3}", row.force))
        .column("20 ms after, own: field [%]", |row| format!("{:.2}", 100.0 * row.field_held))
        .column("force ratio", |row| format!("{:.4}", row.force_held))
        .column("rolled back [%]", |row| format!("{:.0}", 100.0 * row.rolled_back));
    format!(
        "### What a budget leaves\n\nThe running kernel, the held cells pressed at {} mm/s without \
         a stop, as it is when the tool goes through the depth: against the equilibrium of its own \
         model and against quadratic elements. Tick: the median of the press on this machine, and \
         the same in sweeps over the links of this body without a coarse level, measured beside it. 20 ms \
         after: the tool at rest at its deepest.\n\n{}",
        1e3 * SPEED_M_PER_S,
        table.table().markdown()
    )
}

/// The tables of a body: a row a model, a column a depth.
fn body(rows: &[ModelRow]) -> String {
    let models: Vec<&[ModelRow]> = models(rows).collect();
    let table = |figures: fn(&ModelRow) -> String| {
        let mut table = Table::of(models.iter().copied()).column("model", |rows| rows[0].model);
        for (at, row) in models[0].iter().enumerate() {
            let figures = |rows: &[ModelRow]| rows.get(at).map_or("-".to_owned(), figures);
            table = table.column(&format!("{:.0} mm", row.depth_mm), figures);
        }
        table.table().markdown()
    };
    let first = &rows[0];
    let inverted: Vec<String> =
        models[0].iter().map(|row| row.inverted_reference.to_string()).collect();
    format!(
        "### {}, nu 0.{}\n\n{} nodes, against elements: {}; inverted ones of these: {}.\n\nField \
         error [%] / force ratio:\n\n{}Worst node [%] / inverted tetrahedra / nodes with a stretch \
         below the band:\n\n{}",
        first.body,
        first.poisson_percent,
        first.nodes,
        first.against,
        inverted.join(", "),
        table(|row| format!("{:.1} / {:.3}", 100.0 * row.field, row.force)),
        table(|row| {
            let band = row.in_band.map_or("-".to_owned(), |nodes| nodes.to_string());
            format!("{:.1} / {} / {band}", 100.0 * row.worst, row.inverted)
        })
    )
}

/// Error of the field over depth and over the time of a tick, two charts a body that is pressed to
/// several depths, with captions.
#[must_use]
pub fn charts(measured: &Measured) -> Vec<(Chart, String)> {
    let several = |rows: &&[ModelRow]| rows.iter().any(|row| row.depth_mm > 1.5);
    let mut charts = Vec::new();
    for rows in bodies(&measured.rows).filter(several) {
        charts.push((chart(rows), format!("{}: error over depth", title(rows))));
        let budget = budget(rows, &measured.running);
        charts.push((budget, format!("{}: error over the time of a tick", title(rows))));
    }
    charts
}

/// How far off the elements the time of a tick leaves the running kernel at [`SHOWN_MM`], beside
/// what linear tetrahedra are off.
fn budget(rows: &[ModelRow], running: &[RunningRow]) -> Chart {
    let is_shown = |depth_mm: f64| (depth_mm - SHOWN_MM).abs() < 0.01;
    let axes =
        (Axis::log10("time of a tick [bare link sweeps]"), Axis::linear("error of the field [%]"));
    let title = format!(
        "Off quadratic elements at {SHOWN_MM} mm and {} mm/s ({})",
        1e3 * SPEED_M_PER_S,
        title(rows)
    );
    let mut chart = Chart::new(&title, axes.0, axes.1);
    let of = (rows[0].body, rows[0].poisson_percent);
    let here: Vec<&RunningRow> = running
        .iter()
        .filter(|row| (row.body, row.poisson_percent) == of && is_shown(row.depth_mm))
        .collect();
    for same in here.chunk_by(|a, b| a.model == b.model) {
        let points: Vec<[f64; 2]> =
            same.iter().map(|row| [row.tick_bare_sweeps, 100.0 * row.field]).collect();
        chart = chart.series(
            &format!("{}, {}", same[0].model, same[0].scheme),
            Style::MarkedLine,
            &points,
        );
    }
    for row in
        rows.iter().filter(|row| is_shown(row.depth_mm) && row.model == Model::Linear.words())
    {
        chart = chart.horizontal(100.0 * row.field, row.model);
    }
    chart
}

fn title(rows: &[ModelRow]) -> String {
    format!("{}, nu 0.{}", rows[0].body, rows[0].poisson_percent)
}

fn chart(rows: &[ModelRow]) -> Chart {
    let axes = (Axis::linear("depth [mm]"), Axis::linear("error of the field [%]"));
    let title = format!("Model error against quadratic elements ({})", title(rows));
    models(rows).fold(Chart::new(&title, axes.0, axes.1), |chart, rows| {
        let points: Vec<[f64; 2]> =
            rows.iter().map(|row| [row.depth_mm, 100.0 * row.field]).collect();
        chart.series(rows[0].model, Style::MarkedLine, &points)
    })
}
