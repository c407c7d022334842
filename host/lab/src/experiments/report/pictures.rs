//! The charts of a report.

use super::collect::Report;
use crate::charts::plot::{Axis, Chart, Style};
use chaincell_host::error::Result;
use chaincell_host::files::output::Folder;

/// Errors below this are drawn at it \[%\].
const LEAST: f64 = 1e-3;
/// How the names of the pictures begin, one for each motion of the first body.
pub const HAND: &str = "report_hand_";
/// Likewise one for each motion of a tool.
pub const TOOLS: &str = "report_tools_";

/// A row as a chart shows it.
struct Point<'r> {
    /// Which chart and which line.
    motion: &'r str,
    line: String,
    tick_us: f64,
    /// Error as a fraction.
    error: f64,
}

/// Writes every chart that there are figures for; returns their names with captions.
///
/// # Errors
/// As [`Chart::write`].
pub fn write(report: &Report, folder: &Folder) -> Result<Vec<(String, String)>> {
    let (hand, tools) = (&report.hand, &report.tools);
    let of_hand = hand.iter().filter(|row| row.body == hand[0].body).map(|row| Point {
        motion: &row.motion,
        line: row.scheme.to_string(),
        tick_us: 1e-3 * row.tick_ns.p50 as f64,
        error: row.force.largest,
    });
    let of_tools = tools.iter().map(|row| Point {
        motion: &row.tool,
        line: format!("{}, {} cells", row.material, row.cells),
        tick_us: 1e-3 * row.tick_ns.p50 as f64,
        error: row.p90,
    });
    let mut written = Vec::new();
    for (points, name, held, measure) in [
        (of_hand.collect::<Vec<_>>(), HAND, "Held cells, ", "largest"),
        (of_tools.collect(), TOOLS, "", "nine of ten ticks within this"),
    ] {
        let mut motions: Vec<&str> = Vec::new();
        for point in &points {
            if !motions.contains(&point.motion) {
                motions.push(point.motion);
            }
        }
        for (number, motion) in motions.into_iter().enumerate() {
            let caption = format!("{held}{motion}: error of the force against time of a tick");
            let here = points.iter().filter(|point| point.motion == motion);
            let chart = chart(&format!("{held}{motion}"), measure, here);
            let name = format!("{name}{}", number + 1);
            chart.write(folder, &name)?;
            written.push((name, caption));
        }
    }
    Ok(written)
}

/// Error of the force over time of a tick, a line for each setting or body.
fn chart<'p>(title: &str, measure: &str, points: impl Iterator<Item = &'p Point<'p>>) -> Chart {
    let mut lines: Vec<(&str, Vec<[f64; 2]>)> = Vec::new();
    for point in points {
        let place = [point.tick_us, (100.0 * point.error).max(LEAST)];
        match lines.iter_mut().find(|(line, _)| *line == point.line) {
            Some((_, places)) => places.push(place),
            None => lines.push((&point.line, vec![place])),
        }
    }
    let error = format!("error of the force, {measure} [%]");
    let axes = (Axis::log10("median tick [us]"), Axis::log10(&error));
    let mut chart = Chart::new(title, axes.0, axes.1).horizontal(1.0, "1 %");
    if lines.iter().any(|(_, places)| places.iter().any(|[tick_us, _]| *tick_us > 300.0)) {
        chart = chart.vertical(1000.0, "1 ms");
    }
    lines.iter().fold(chart, |chart, (line, places)| chart.series(line, Style::MarkedLine, places))
}
