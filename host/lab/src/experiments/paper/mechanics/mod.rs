//! The paper's Fig. 5: force over displacement, hysteresis, stress relaxation.

mod compression;
mod curve;
mod pictures;
mod relaxation;
mod words;

use serde_json::{Value, json};

pub use compression::{Compression, Loop, at_speed, compress, there_and_back};
pub use curve::Shape;
pub use relaxation::{Relaxation, exact, interpolate, relax};

use crate::experiments::page::{Context, Section};
use crate::experiments::report::scene::{Scene, Source};
use chaincell_host::error::Result;

/// Length of a tick \[s\].
pub const TICK_S: f64 = 1e-3;
/// Time constant of the body: the paper gives no seconds \[s\].
pub const TIME_CONSTANT_S: f64 = 0.02;
/// Half-widths of the bands.
pub const ALPHAS: [f64; 4] = [0.0, 0.02, 0.05, 0.1];
/// Depth of the plane's loop and of its relaxation, of its compression.
const PLANE_LOOP: f64 = 0.5;
/// Depth of the organ's loop, of the depth at its largest force, and of its relaxation [mean link
/// lengths]: a jump by more would push the patch through the cells behind it.
const ORGAN_LOOP: f64 = 0.9;
const ORGAN_JUMP: f64 = 0.5;
/// Depths of compression: the plane \[m\], the organ [mean link lengths].
const PLANE_M: f64 = 0.1;
const ORGAN_LINKS: f64 = 2.4;
/// Times of a press in the loops at speed \[s\].
const PRESS_S: [f64; 3] = [10.0, 1.0, 0.1];

/// One body at one alpha.
struct Case {
    alpha: f64,
    compression: Compression,
    turn: Loop,
    relaxation: Relaxation,
}

/// A press at a speed and back.
struct Speed {
    press_s: f64,
    turn: Loop,
}

/// All of one body.
struct Results {
    name: &'static str,
    words: String,
    stiffness_n_per_m: f64,
    /// Depth of compression, of loops, of relaxation \[m\].
    deepest_m: f64,
    loop_m: f64,
    held_m: f64,
    cases: Vec<Case>,
    speeds: Vec<Speed>,
    /// The relaxation at alpha 0 on the exact trajectory \[s, N\].
    exact: Vec<[f64; 2]>,
}

/// How much is computed.
struct Effort {
    steps: u32,
    seconds: f64,
    speeds: usize,
}

impl Results {
    fn run(source: &Source, effort: &Effort) -> Result<Self> {
        let elastic = source.with_alpha(0.0)?;
        let unit_m = f64::from(elastic.model()?.unit_m());
        let stiffness_n_per_m = f64::from(elastic.model()?.stiffness_n_per_m());
        let is_plane = source.name == "plane";
        let deepest_m = if is_plane { PLANE_M } else { ORGAN_LINKS * unit_m };
        let first = compress(&elastic, deepest_m, effort.steps)?;
        let loop_m = match is_plane {
            true => PLANE_LOOP * deepest_m,
            false => ORGAN_LOOP * first.shape.depth_at_max_m,
        };
        let held_m = if is_plane { loop_m } else { ORGAN_JUMP * unit_m };
        let mut first = Some(first);
        let mut cases = Vec::new();
        for alpha in ALPHAS {
            let body = source.with_alpha(alpha)?;
            cases.push(Case {
                alpha,
                compression: match first.take() {
                    Some(done) => done,
                    None => compress(&body, deepest_m, effort.steps)?,
                },
                turn: there_and_back(&body, loop_m, effort.steps)?,
                relaxation: relax(&body, held_m, effort.seconds, TIME_CONSTANT_S)?,
            });
        }
        let exact = exact(&elastic, held_m, effort.seconds, TIME_CONSTANT_S)?;
        let speeds = speeds(&elastic, loop_m, effort.speeds)?;
        let words = match is_plane {
            true => source.words.clone(),
            false => format!("generated organ of {} cells", source.mesh.nodes_m.len()),
        };
        let name = source.name;
        Ok(Self { name, words, stiffness_n_per_m, deepest_m, loop_m, held_m, cases, speeds, exact })
    }

    /// The case without slack.
    fn elastic(&self) -> &Case {
        &self.cases[0]
    }

    /// Largest difference of the relaxation from the exact trajectory at alpha 0, as a fraction.
    fn error(&self) -> f64 {
        let curve = &self.elastic().relaxation.curve;
        let errors = self
            .exact
            .iter()
            .filter_map(|&[t_s, force_n]| Some((interpolate(curve, t_s)? / force_n - 1.0).abs()));
        errors.fold(0.0, f64::max)
    }
}

/// Loops at speeds, the slowest last of `PRESS_S` left out first.
fn speeds(body: &Scene, loop_m: f64, count: usize) -> Result<Vec<Speed>> {
    let chosen = PRESS_S.into_iter().skip(PRESS_S.len() - count);
    chosen
        .map(|press_s| {
            let turn = at_speed(body, loop_m, loop_m / press_s, TIME_CONSTANT_S)?;
            Ok(Speed { press_s, turn })
        })
        .collect()
}

/// Fig. 5: on the paper's plane and the generated organ.
pub fn section(context: &Context) -> Result<Section> {
    let effort = if context.quick {
        Effort { steps: 25, seconds: 2.0, speeds: 2 }
    } else {
        Effort { steps: 50, seconds: 10.0, speeds: 3 }
    };
    let sources = [Source::plane(true)?, Source::organ(context.quick.then_some(1000))?];
    let bodies: Vec<Results> =
        sources.iter().map(|source| Results::run(source, &effort)).collect::<Result<_>>()?;
    Ok(Section {
        key: "mechanics",
        title: "Typical mechanical behaviour (Fig. 5)".into(),
        results: words::results(&bodies),
        text: words::text(&bodies),
        figures: pictures::figures(&bodies)?,
        tables: words::tables(&bodies),
        numbers: pictures::numbers(&bodies),
        json: json!({
            "time_constant_s": TIME_CONSTANT_S,
            "bodies": bodies.iter().map(json_of).collect::<Vec<Value>>(),
        }),
    })
}

fn json_of(body: &Results) -> Value {
    let cases = body.cases.iter().map(|case| {
        let (shape, turn) = (&case.compression.shape, &case.turn);
        json!({
            "alpha": case.alpha,
            "slack_m": shape.slack_m,
            "compression": shape,
            "loading_work_j": turn.loading_work_j,
            "returned_work_j": turn.returned_work_j,
            "loop_area_j": turn.area_j(),
            "loop_area_of_loading_work": turn.relative(),
            "band_energy_j": turn.band_energy_j,
            "relaxation": {
                "first_n": case.relaxation.first_n,
                "minimum_n": case.relaxation.minimum_n,
            },
        })
    });
    let speeds = body.speeds.iter().map(|speed| {
        json!({
            "press_s": speed.press_s,
            "loading_work_j": speed.turn.loading_work_j,
            "loop_area_j": speed.turn.area_j(),
            "loop_area_of_loading_work": speed.turn.relative(),
        })
    });
    json!({
        "body": body.name,
        "compression_m": body.deepest_m,
        "loop_m": body.loop_m,
        "held_m": body.held_m,
        "cases": cases.collect::<Vec<Value>>(),
        "speeds_at_alpha_0": speeds.collect::<Vec<Value>>(),
        "relaxation_error_against_exact": body.error(),
    })
}

#[cfg(test)]
mod tests;
