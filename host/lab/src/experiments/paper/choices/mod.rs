//! Choices that the paper leaves open: saturation and resistance, what the force is, the current
//! source.

mod current;
mod force;
mod words;

use serde::Serialize;
use serde_json::json;

use super::body::{Body, Source, Tool};
use super::section::{Context, Numbers, Section};
use crate::charts::plot::{Axis, Chart, Figure, Style};
use crate::experiments::report::tables::csv;
use chaincell_host::bake::BakeOptions;
use chaincell_host::error::Result;
use current::Yield;
use force::Readings;

/// Depth of the press \[m\].
const DEPTH_M: f64 = 0.05;
/// Step of `euler`, of the proven bound: the default.
const STEP: f64 = 0.9;
/// Network time of a press [dimensionless time].
const PRESS_TIME: f64 = 30.0;
/// K, of the largest coordinate at rest; the last but one is the default.
const SATURATIONS: [f64; 4] = [2.0, 3.0, 4.0, 8.0];
/// Half the width of the plane: its largest coordinate at rest \[m\].
const LARGEST_M: f64 = 0.1;
/// The least K that the bake takes is twice that as stored: a hair more passes.
const HAIR: f64 = 1e-6;
const RESISTANCES: [f64; 4] = [0.5, 1.0, 2.0, 4.0];
/// A depth beyond the smallest K \[m\].
const BEYOND_M: f64 = 0.25;

/// A run under one K and `R_x`.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Range {
    /// K over the largest coordinate at rest.
    k_of_largest: f64,
    r_x: f64,
    depth_m: f64,
    force_n: f64,
    state_hash: String,
}

/// Everything that is told.
struct Results {
    within: Vec<Range>,
    beyond: Vec<Range>,
    readings: Vec<Readings>,
    yields: Vec<Yield>,
}

impl Results {
    fn run() -> Result<Self> {
        let plane = Source::plane()?;
        let body = plane.with_alpha(0.0)?;
        let step = STEP * f64::from(body.model()?.step_max());
        let both = |depth_m: f64| -> Result<Vec<Range>> {
            let ks = SATURATIONS.map(|k| (k, RESISTANCES[1]));
            let rs = RESISTANCES
                .map(|r_x| (if depth_m > DEPTH_M { SATURATIONS[0] } else { SATURATIONS[2] }, r_x));
            ks.into_iter().chain(rs).map(|(k, r_x)| range(&plane, k, r_x, depth_m, step)).collect()
        };
        Ok(Self {
            within: both(DEPTH_M)?,
            beyond: both(BEYOND_M)?,
            readings: force::readings(&body, DEPTH_M, step)?,
            yields: current::yields(&plane)?,
        })
    }
}

/// A press to `depth_m` in a fixed network time with Euler steps of about `step`: the tool at its
/// end, with the last force \[N\].
fn press(body: &Body, depth_m: f64, step: f64) -> Result<(Tool<'_>, f64)> {
    let ticks = (PRESS_TIME / step).ceil();
    let mut tool = body.in_time(PRESS_TIME / ticks)?;
    let mut force_n = 0.0;
    for tick in 1..=ticks as u32 {
        force_n = tool.press(depth_m * f64::from(tick) / ticks)?;
    }
    Ok((tool, force_n))
}

/// A press of the plane with Euler steps of `step` under a saturation and a resistance.
fn range(plane: &Source, k_of_largest: f64, r_x: f64, depth_m: f64, step: f64) -> Result<Range> {
    let saturation_m = Some(k_of_largest * LARGEST_M * (1.0 + HAIR));
    let options = BakeOptions { saturation_m, resistance: r_x, ..BakeOptions::default() };
    let body = plane.bake(&options)?;
    let (mut tool, force_n) = press(&body, depth_m, step)?;
    let state_hash = format!("{:016x}", tool.state_hash());
    Ok(Range { k_of_largest, r_x, depth_m, force_n, state_hash })
}

/// What the paper leaves open, on its plane with 8 neighbours.
///
/// # Errors
/// The user asked to stop; a picture that cannot be drawn.
pub fn section(_: &Context) -> Result<Section> {
    let found = Results::run()?;
    let numbers = [
        ("paper_choices_range", csv(&[found.within.as_slice(), &found.beyond].concat())),
        ("paper_choices_force", csv(&found.readings)),
        ("paper_choices_current", csv(&found.yields)),
    ];
    Ok(Section {
        key: "choices",
        title: "Choices the paper leaves open".into(),
        text: words::text(&found),
        figures: vec![figure(&found)?],
        tables: words::tables(&found),
        numbers: numbers.map(|(name, csv)| Numbers { name: name.into(), csv }).into(),
        json: json!({
            "depth_m": DEPTH_M,
            "within_range": found.within,
            "beyond_range": found.beyond,
            "force_readings": found.readings,
            "current": found.yields,
        }),
    })
}

fn figure(found: &Results) -> Result<Figure> {
    let axes =
        (Axis::log10("input displacement [mm]"), Axis::log10("displacement of the cell [mm]"));
    let mut current =
        Chart::new("The input as current source and as position (plane)", axes.0, axes.1);
    for (alpha, label) in [(0.0, "current, alpha 0, any stiffness"), (0.05, "current, alpha 0.05")]
    {
        let of = found.yields.iter().filter(|at| at.alpha == alpha && at.stiffness_n_per_m == 20.0);
        let points: Vec<[f64; 2]> =
            of.map(|at| [1e3 * at.input_m, 1e3 * at.displacement_m]).collect();
        current = current.series(label, Style::MarkedLine, &points);
    }
    let same = [1.0, 100.0].map(|mm| [mm, mm]);
    let current = current.series("prescribed", Style::Dashed, &same);
    Ok(Figure::new(
        "paper_choices_current",
        "Where the contact cell settles when the input displacement is its current source, beside \
         the prescribed position.",
        current.draw()?,
    ))
}

#[cfg(test)]
mod tests;
