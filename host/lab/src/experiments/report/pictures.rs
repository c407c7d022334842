//! The charts of a report: error of the force over time of a tick.

use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use chaincell_host::error::Result;

/// Errors below this are drawn at it \[%\].
const LEAST: f64 = 1e-3;

/// A row as a chart shows it.
pub struct Point<'r> {
    /// Which chart and which line.
    pub motion: &'r str,
    /// The line.
    pub line: String,
    /// Median time of a tick \[ns\].
    pub tick_ns: u64,
    /// Error as a fraction.
    pub error: f64,
}

/// A chart for each motion, `name_1` and so on, a line for each setting or body; `measure` says
/// which error it is.
pub fn figures(name: &str, measure: &str, points: &[Point<'_>]) -> Result<Vec<Figure>> {
    let mut motions: Vec<&str> = Vec::new();
    for point in points {
        if !motions.contains(&point.motion) {
            motions.push(point.motion);
        }
    }
    let draw = |(number, motion): (usize, &str)| {
        let here = points.iter().filter(|point| point.motion == motion);
        let caption = format!(
            "The lower left is best: a small error in a short tick. Along each line the sweeps a tick \
             grow from 1 on. Error of the force, {measure}: {motion}."
        );
        let picture = Picture::of(&chart(motion, measure, here))?;
        Ok(Figure::new(format!("{name}_{}", number + 1), caption, picture))
    };
    motions.into_iter().enumerate().map(draw).collect()
}

fn chart<'p>(title: &str, measure: &str, points: impl Iterator<Item = &'p Point<'p>>) -> Chart {
    let mut lines: Vec<(&str, Vec<[f64; 2]>)> = Vec::new();
    for point in points {
        let place = [1e-3 * point.tick_ns as f64, (100.0 * point.error).max(LEAST)];
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
