//! The charts of Fig. 5 and the numbers behind them.

use serde_json::{Value, json};

use super::words::mm as mm_of;
use super::{Case, Results};
use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use crate::experiments::page::Numbers;
use crate::experiments::page::table::csv;
use chaincell_host::error::Result;

/// Cases drawn as loops: both ways of each take a colour.
const LOOPS: [usize; 3] = [0, 1, 2];

fn mm([metres, force_n]: [f64; 2]) -> [f64; 2] {
    [1e3 * metres, force_n]
}

/// Every chart, in the order of the paper's parts.
pub fn figures(bodies: &[Results]) -> Result<Vec<Figure>> {
    let mut all = Vec::new();
    type Part = fn(&Results) -> (&'static str, String, Chart);
    let parts: [Part; 4] = [compression, turns, speeds, relaxation];
    for part in parts {
        for body in bodies {
            let (name, caption, chart) = part(body);
            let name = format!("paper_{name}_{}", body.name);
            all.push(Figure::new(name, caption, Picture::of(&chart)?));
        }
    }
    Ok(all)
}

fn compression(body: &Results) -> (&'static str, String, Chart) {
    let axes = (Axis::linear("displacement [mm]"), Axis::linear("force [N]"));
    let title = format!("5a: force over displacement ({})", body.words);
    let mut chart = Chart::new(&title, axes.0, axes.1);
    for case in &body.cases {
        let felt = case.compression.curve.iter().map(|at| mm([at.depth_m, at.force_n]));
        let points: Vec<[f64; 2]> = [[0.0; 2]].into_iter().chain(felt).collect();
        chart = chart.series(&format!("alpha {}", case.alpha), Style::Line, &points);
    }
    let grows = match body.elastic().compression.shape.nonlinearity_exponent > 1.0 {
        true => "ever more steeply",
        false => "ever less steeply",
    };
    let caption = format!(
        "The force rises {grows} with the depth, and with a band only from where the slack ends. \
         Compression of the {}, settled at every step, for four bands.",
        body.words
    );
    ("fig5a", caption, chart)
}

fn turns(body: &Results) -> (&'static str, String, Chart) {
    let axes = (Axis::linear("displacement [mm]"), Axis::linear("force [N]"));
    let title = format!("5b: loading, unloading with restored links ({})", body.words);
    let mut chart = Chart::new(&title, axes.0, axes.1);
    for case in LOOPS.iter().filter_map(|&at| body.cases.get(at)) {
        let ways = [
            ("loading", Style::Line, &case.turn.loading),
            ("unloading", Style::Dashed, &case.turn.unloading),
        ];
        for (way, style, points) in ways {
            let points: Vec<[f64; 2]> = points.iter().copied().map(mm).collect();
            chart = chart.series(&format!("alpha {}, {way}", case.alpha), style, &points);
        }
    }
    let caption = format!(
        "With a band the way back lies above the way in; without one they are one path. Loading and \
         unloading of the {}, settled at every step. A tenth of a mean link length after the turn the \
         links are restored to their initial lengths: from there on every path is that of alpha 0.",
        body.words
    );
    ("fig5b", caption, chart)
}

fn speeds(body: &Results) -> (&'static str, String, Chart) {
    let axes = (Axis::linear("displacement [mm]"), Axis::linear("force [N]"));
    let title = format!("5b: loops at speed, alpha 0 ({})", body.words);
    let mut chart = Chart::new(&title, axes.0, axes.1);
    for speed in body.speeds.iter().rev() {
        let all = speed.turn.loading.iter().chain(&speed.turn.unloading);
        let points: Vec<[f64; 2]> = thin(all.copied().map(mm).collect());
        chart = chart.series(&format!("{} s each way", speed.press_s), Style::Line, &points);
    }
    let still: Vec<[f64; 2]> = body.elastic().turn.loading.iter().copied().map(mm).collect();
    let chart = chart.series("settled at every step", Style::Dashed, &still);
    let caption = format!(
        "The faster the press, the wider the loop. Loading and unloading of the {} at constant speed on \
         the paper's own dynamics, without any change of the links: cells take their time to follow.",
        body.words
    );
    ("fig5b_speed", caption, chart)
}

/// At most some hundreds of points.
fn thin(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let stride = points.len().div_ceil(600).max(1);
    let last = points.last().copied();
    points.into_iter().step_by(stride).chain(last).collect()
}

fn relaxation(body: &Results) -> (&'static str, String, Chart) {
    let axes = (Axis::log10("time [s]"), Axis::linear("force [N]"));
    let title = format!("5c: held at {} mm ({})", mm_of(body.held_m), body.words);
    let mut chart = Chart::new(&title, axes.0, axes.1);
    for case in &body.cases {
        let label = format!("alpha {}", case.alpha);
        chart = chart.series(&label, Style::Line, &case.relaxation.curve);
    }
    let chart = chart
        .series("alpha 0, exact trajectory", Style::Markers, &body.exact)
        .horizontal(body.elastic().relaxation.minimum_n, "alpha 0, settled");
    let caption = format!(
        "The force falls to a minimum, at alpha 0 along the exact trajectory. Stress relaxation of the \
         {} after a jump to {} mm that is held.",
        body.words,
        mm_of(body.held_m)
    );
    ("fig5c", caption, chart)
}

/// The curves as CSV.
pub fn numbers(bodies: &[Results]) -> Vec<Numbers> {
    let mut all = Vec::new();
    for body in bodies {
        let mut put = |name: &str, rows: Vec<Value>| {
            all.push(Numbers { name: format!("paper_{name}_{}", body.name), csv: csv(&rows) });
        };
        put("fig5a", body.cases.iter().flat_map(curve_rows).collect());
        put("fig5b", body.cases.iter().flat_map(turn_rows).collect());
        let speeds = body.speeds.iter().flat_map(|speed| {
            let points = speed.turn.loading.iter().chain(&speed.turn.unloading).copied().collect();
            let row = move |[depth_m, force_n]: [f64; 2]| {
                json!({ "press_s": speed.press_s, "depth_m": depth_m, "force_n": force_n })
            };
            thin(points).into_iter().map(row)
        });
        put("fig5b_speed", speeds.collect());
        let times = body.cases.iter().flat_map(|case| {
            let row = move |&[time_s, force_n]: &[f64; 2]| {
                json!({ "alpha": case.alpha, "time_s": time_s, "force_n": force_n })
            };
            case.relaxation.curve.iter().map(row)
        });
        put("fig5c", times.collect());
    }
    all
}

/// A point of a curve of force over displacement.
fn row(case: &Case, way: &str, [depth_m, force_n]: [f64; 2], residual: Option<f64>) -> Value {
    json!({
        "alpha": case.alpha,
        "way": way,
        "depth_m": depth_m,
        "force_n": force_n,
        "residual_of_force": residual,
    })
}

fn curve_rows(case: &Case) -> impl Iterator<Item = Value> {
    let curve = case.compression.curve.iter();
    curve.map(|at| row(case, "loading", [at.depth_m, at.force_n], Some(at.residual)))
}

fn turn_rows(case: &Case) -> impl Iterator<Item = Value> {
    let ways = [("loading", &case.turn.loading), ("unloading", &case.turn.unloading)];
    ways.into_iter()
        .flat_map(move |(way, points)| points.iter().map(move |&point| row(case, way, point, None)))
}
