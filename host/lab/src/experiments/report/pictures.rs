//! The charts of a report.

use super::collect::{BUDGET_NS, Report, Track};
use super::hand::HandRow;
use super::model;
use super::press::{Errors, PressRow};
use super::setting::Setting;
use super::specimen;
use crate::charts::plot::{Axis, Chart, Style};
use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;
use chaincell_host::words::counted;

/// Errors below this are drawn at it \[%\].
const LEAST: f64 = 1e-3;
/// How the names of the pictures of a hand begin, one for each motion.
pub const HAND: &str = "report_hand_";

/// Rows of the main body, ascending in sweeps.
fn main_rows(report: &Report) -> Vec<&PressRow> {
    let main = report.scenes.first().map_or("", |scene| scene.name);
    let mut rows: Vec<&PressRow> = report.rows.iter().filter(|row| row.scene == main).collect();
    rows.sort_by_key(|row| row.sweeps);
    rows
}

/// Time of a tick \[us\] and error of a row \[%\].
fn point(row: &PressRow, error: fn(&PressRow) -> f64) -> [f64; 2] {
    [row.tick_ns.p50 as f64 * 1e-3, (100.0 * error(row)).max(LEAST)]
}

/// Writes every chart that there are figures for; returns their names with captions.
///
/// # Errors
/// As [`Chart::write`].
pub fn write(report: &Report, folder: &Folder) -> Result<Vec<(String, String)>> {
    let mut written = Vec::new();
    let mut put = |chart: Chart, name: &str, caption: &str| {
        chart.write(folder, name).map(|_| written.push((name.to_owned(), caption.to_owned())))
    };
    if !report.rows.is_empty() {
        let field = |row: &PressRow| row.largest.field;
        let title = "Error of the field against time a tick";
        let caption = "Error of the field against time of a tick; along a line the number of sweeps \
                       grows";
        put(
            budget(report, title, "largest error of the field during the press [%]", field),
            "report_field",
            caption,
        )?;
        let force = |row: &PressRow| row.largest.force;
        let caption = "Error of the force against time of a tick, the same settings";
        put(
            budget(
                report,
                "Error of the force against time a tick",
                "largest error of the force during the press [%]",
                force,
            ),
            "report_force",
            caption,
        )?;
    }
    for (number, motion) in motions(&report.hand).into_iter().enumerate() {
        let caption = format!("Held cells, {motion}: error of the force against time of a tick");
        put(hand(&report.hand, motion), &format!("{HAND}{}", number + 1), &caption)?;
    }
    for (number, (chart, caption)) in model::charts(&report.model).into_iter().enumerate() {
        put(chart, &format!("{}{}", model::PICTURE, number + 1), &caption)?;
    }
    if !report.specimen.is_empty() {
        let caption = "A soft sheet in pure shear: measured, and nodal shapes";
        put(specimen::chart(&report.specimen), specimen::PICTURE, caption)?;
    }
    if let Some(track) = &report.track {
        let caption = "track in half a millisecond a tick: its errors during the press";
        put(time(report, track), "report_time", caption)?;
    }
    Ok(written)
}

/// Error over time of a tick on the main body, every scheme.
fn budget(report: &Report, title: &str, error_title: &str, error: fn(&PressRow) -> f64) -> Chart {
    let rows = main_rows(report);
    let body = rows.first().map_or("", |row| row.scene);
    let x = Axis::log10("median tick [us]");
    let mut chart = Chart::new(&format!("{title} ({body})"), x, Axis::log10(error_title))
        .vertical(BUDGET_NS as f64 * 1e-3, "0.5 ms")
        .vertical(1000.0, "1 ms")
        .horizontal(7.0, "7 %: noticed");
    for setting in Setting::all(true) {
        let of_scheme = rows.iter().filter(|row| row.scheme == setting);
        let points: Vec<[f64; 2]> = of_scheme.map(|row| point(row, error)).collect();
        if points.is_empty() {
            continue;
        }
        chart = chart.series(&setting.to_string(), Style::MarkedLine, &points);
    }
    chart
}

/// The first body's rows.
fn of_first(rows: &[HandRow]) -> impl Iterator<Item = &HandRow> {
    rows.iter().filter(|row| row.body == rows[0].body)
}

/// The motions of the first body, in their order.
fn motions(rows: &[HandRow]) -> Vec<&str> {
    let mut motions: Vec<&str> = of_first(rows).map(|row| row.motion.as_str()).collect();
    motions.dedup();
    motions
}

/// Error of the force over time of a tick: every scheme under a motion of the first body.
fn hand(rows: &[HandRow], motion: &str) -> Chart {
    let mut schemes: Vec<(Setting, Vec<[f64; 2]>)> = Vec::new();
    for row in of_first(rows).filter(|row| row.motion == motion) {
        let point = [row.tick_ns.p50 as f64 * 1e-3, (100.0 * row.force.largest).max(LEAST)];
        match schemes.iter_mut().find(|(known, _)| *known == row.scheme) {
            Some((_, points)) => points.push(point),
            None => schemes.push((row.scheme, vec![point])),
        }
    }
    let title = format!("A hand that moves: {motion} ({})", rows[0].body);
    let axes = (Axis::log10("median tick [us]"), Axis::log10("largest error of the force [%]"));
    let mut chart = Chart::new(&title, axes.0, axes.1).horizontal(1.0, "1 %");
    if schemes.iter().any(|(_, points)| points.iter().any(|[tick_us, _]| *tick_us > 300.0)) {
        chart = chart.vertical(1000.0, "1 ms");
    }
    schemes.iter().fold(chart, |chart, (setting, points)| {
        chart.series(&setting.to_string(), Style::MarkedLine, points)
    })
}

/// Errors of `track` within the budget over the ticks of the press, snaps marked.
fn time(report: &Report, track: &Track) -> Chart {
    let title = format!("track, {} a tick ({})", counted(track.sweeps, "sweep"), track.scene);
    let of = |error: fn(&Errors) -> f64| -> Vec<[f64; 2]> {
        let path = report.budget_path.iter();
        path.map(|(tick, errors)| [*tick as f64, (100.0 * error(errors)).max(LEAST)]).collect()
    };
    let axes = (Axis::linear("time since the tool touched [ms]"), Axis::log10("error [%]"));
    let chart = Chart::new(&title, axes.0, axes.1)
        .series("field", Style::Line, &of(|errors| errors.field))
        .series("force", Style::Line, &of(|errors| errors.force))
        .horizontal(7.0, "7 %");
    track.snaps.ticks.iter().fold(chart, |chart, &snap| chart.vertical(snap as f64, "snap"))
}
