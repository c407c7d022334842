//! What the experiments of Fig. 5 say, in sentences and tables.

use super::{Case, Results, Shape, TIME_CONSTANT_S};
use crate::experiments::paper::body::SETTLE_SWEEPS;
use crate::experiments::report::tables::{Table, percent};

/// Half the width of the paper's plane \[m\].
const HALF_M: f64 = 0.1;

/// Four significant digits of a quantity that spans decades.
pub fn short(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        size if (1e-2..1e4).contains(&size) => {
            let digits = (2 - size.log10().floor() as i32).max(0) as usize;
            format!("{value:.digits$}")
        }
        _ => format!("{value:.2e}"),
    }
}

pub fn mm(metres: f64) -> String {
    short(1e3 * metres)
}

/// A list of one figure a case: `0.02: 20 mm, ...`.
fn by_alpha<'a>(cases: impl Iterator<Item = &'a Case>, of: impl Fn(&Case) -> String) -> String {
    let all: Vec<String> =
        cases.map(|case| format!("alpha {}: {}", case.alpha, of(case))).collect();
    all.join(", ")
}

/// The paragraphs.
pub fn text(bodies: &[Results]) -> Vec<String> {
    let mut text = vec![format!(
        "The paper shows a force that grows non-linearly with the displacement, two distinct paths \
         of loading and unloading, and a force that falls asymptotically towards a minimum; it \
         gives no numbers, scales or parameters. Here the bodies are {}, links of {} N/m. Settled \
         forces come from `track`, as many sweeps a step as it takes until no free cell's residual \
         exceeds 1e-4 of the force on the tool, at most {} (the largest residual left stands in the \
         table). What runs in time takes one Euler step of Eq. 4 a millisecond with a time constant of {} \
         s, which the paper leaves open: another one stretches the time axis and changes nothing \
         else.",
        bodies.iter().map(|body| format!("the {}", body.words)).collect::<Vec<_>>().join(" and "),
        bodies.first().map_or(0.0, |body| body.stiffness_n_per_m),
        SETTLE_SWEEPS,
        TIME_CONSTANT_S
    )];
    for body in bodies {
        text.push(compression(body));
        text.push(slack(body));
        text.push(turns(body));
        text.push(relaxation(body));
    }
    text.push(
        "Beside the paper's Fig. 5: the non-linear force is there, by geometry and by slack, and on \
         a solid body it softens where the figure of a tissue would stiffen; the two paths are \
         there, in the sense of tissue only at speed or where it snaps; the force that relaxes \
         towards a minimum is there, with a spectrum of times."
            .into(),
    );
    text
}

fn compression(body: &Results) -> String {
    let shape = &body.elastic().compression.shape;
    let ratio = shape.stiffness_end_n_per_m / shape.stiffness_start_n_per_m;
    let sort = match shape.nonlinearity_exponent {
        p if p > 1.2 => {
            "it stiffens: links across the push are stretched only to second order, which makes the \
             force cubic at first; that is geometry, no property of the links"
        }
        p if p < 0.95 => "it softens as the links fold",
        _ => "it is nearly linear",
    };
    let snaps = match shape.snaps {
        0 => String::new(),
        count => format!(
            " Deeper in, the force falls within a step by more than a fifth of the largest, in {count} \
             place{}: the body snaps to another equilibrium.",
            if count == 1 { "" } else { "s" }
        ),
    };
    format!(
        "5a, {}: at alpha 0 the force goes with the displacement to the power {:.2} up to its \
         largest value, {} N at {} mm, and the stiffness from {} N/m over the first fifth to {} N/m \
         over the last, a factor of {}; {sort}.{snaps}",
        body.words,
        shape.nonlinearity_exponent,
        short(shape.force_max_n),
        mm(shape.depth_at_max_m),
        short(shape.stiffness_start_n_per_m),
        short(shape.stiffness_end_n_per_m),
        short(ratio),
    )
}

fn slack(body: &Results) -> String {
    let slack = by_alpha(body.cases.iter().skip(1), |case| {
        let shape = &case.compression.shape;
        let throughout = if shape.force_max_n > 0.0 { "" } else { ", as far as it was pressed" };
        format!("{} mm{throughout}", mm(shape.slack_m))
    });
    let felt = body.cases.iter().skip(1).filter(|case| case.compression.shape.force_max_n > 0.0);
    let exponents =
        by_alpha(felt, |case| format!("{:.1}", case.compression.shape.nonlinearity_exponent));
    let chain = if body.name == "plane" {
        let taut = by_alpha(body.cases.iter().skip(1), |case| {
            format!("{} mm", mm(HALF_M * (case.alpha * (2.0 + case.alpha)).sqrt()))
        });
        format!(" (a straight chain from the centre to the border is taut at {taut})")
    } else {
        String::new()
    };
    format!(
        "5a, {}, with a band: no force at all, up to {slack}{chain}, to within a step of {} mm. \
         Measured from the first contact the exponent is {exponents} instead of {:.1}. So the curve \
         is more bent with a band, but because it is slack first: alpha is no stiffness.",
        body.words,
        mm(body.deepest_m / body.elastic().compression.curve.len() as f64),
        body.elastic().compression.shape.nonlinearity_exponent
    )
}

fn turns(body: &Results) -> String {
    let none = body.elastic();
    let areas = by_alpha(body.cases.iter().skip(1), |case| {
        format!(
            "{} J given, {} J got back, area {} J",
            short(case.turn.loading_work_j),
            short(case.turn.returned_work_j),
            short(case.turn.area_j())
        )
    });
    let fast: Vec<String> = (body.speeds.iter())
        .map(|speed| {
            let part = percent(speed.turn.relative().unwrap_or_default());
            format!("{} s each way {} J, {part} %", speed.press_s, short(speed.turn.area_j()))
        })
        .collect();
    let pulls = body.speeds.iter().map(|speed| {
        let unloading = speed.turn.unloading.iter();
        format!("{} N", short(unloading.map(|at| at[1]).fold(f64::INFINITY, f64::min)))
    });
    let pulls: Vec<String> = pulls.collect();
    let deep = match body.deep.area_j() / body.deep.loading_work_j {
        part if part > 0.01 => format!(
            " The whole compression and back at alpha 0 keeps {} J, {} % of its work, without any \
             speed: the snaps go over at other depths on the way back.",
            short(body.deep.area_j()),
            percent(part)
        ),
        _ => String::new(),
    };
    format!(
        "5b, {}, to {} mm and back: with a band there are two distinct paths as in the paper, but the way back \
         lies above the way in. Restoring the links to their initial lengths puts energy into them, \
         and the tool gets back more than it gave ({areas}): the loop runs against that of tissue, \
         which keeps work. At alpha 0 there is none: {} J, {} % of the work, which is how well the \
         points have settled. A loop in the sense of tissue comes from the network's own time: at \
         alpha 0 and constant speed the area is {} of the work; it is viscous, and its area \
         falls with the speed. The tool holds its cells on the way back too, so the force goes down \
         to {}: a tool that can let go would feel none below 0.{deep}",
        body.words,
        mm(body.loop_m),
        short(none.turn.area_j()),
        percent(none.turn.relative().unwrap_or_default()),
        fast.join(", "),
        pulls.join(", "),
    )
}

fn relaxation(body: &Results) -> String {
    let elastic = &body.elastic().relaxation;
    let time = |left: f64| match elastic.time_to_s(left) {
        Some(time_s) => format!("{} s", short(time_s)),
        None => "a time beyond the window".to_owned(),
    };
    let fits: Vec<String> =
        elastic.series.iter().map(|fit| format!("{} %", percent(fit.residual))).collect();
    let last = elastic.series.last().map_or(0.0, |fit| fit.f_inf_n);
    let dead: Vec<String> = body
        .cases
        .iter()
        .filter(|case| case.relaxation.minimum_n < 1e-3 * case.relaxation.first_n)
        .map(|case| case.alpha.to_string())
        .collect();
    let to_none = match dead.is_empty() {
        true => String::new(),
        false => format!(
            " Where the depth lies within the slack the minimum is next to nothing (alpha {}).",
            dead.join(", ")
        ),
    };
    format!(
        "5c, {}, held at {} mm, alpha 0: the force falls from {} N as the tool jumps towards {} N, \
         asymptotically as in the paper; half of the difference is left at {}, a tenth at {}. \
         It is within {} % of the exact trajectory of Eq. 4 in double precision. One exponential \
         does not describe it: Prony series of 1, 2 and 3 terms miss by {} (relative, root mean \
         square, over {} to {} s), and the time constants found spread over the window, because \
         what relaxes is diffusion from cell to cell, with a time for every length. What the three \
         terms leave at infinity, {} N, is {} % off the settled force.{to_none}",
        body.words,
        mm(body.held_m),
        short(elastic.first_n),
        short(elastic.minimum_n),
        time(0.5),
        time(0.1),
        percent(body.error()),
        fits.join(", "),
        elastic.curve.first().map_or_else(String::new, |at| short(at[0])),
        elastic.curve.last().map_or_else(String::new, |at| short(at[0])),
        short(last),
        percent(last / elastic.minimum_n - 1.0),
    )
}

/// The tables with their captions.
pub fn tables(bodies: &[Results]) -> Vec<(String, Table)> {
    vec![
        ("5a: the settled force in compression".into(), compressions(bodies)),
        (
            "5b: loops, links restored at the turn; negative: the tool got back more".into(),
            loops(bodies),
        ),
        ("5c: Prony series through the relaxation".into(), prony(bodies)),
    ]
}

fn compressions(bodies: &[Results]) -> Table {
    let cases = bodies.iter().flat_map(|body| body.cases.iter().map(move |case| (body, case)));
    let rows = cases.map(|(body, case)| (body, case, &case.compression.shape));
    type Row<'r> = (&'r Results, &'r Case, &'r Shape);
    let told = |of: fn(&Shape) -> String, none: &'static str| {
        move |(_, _, shape): Row<'_>| if shape.force_max_n > 0.0 { of(shape) } else { none.into() }
    };
    Table::of(rows)
        .column("body", |(body, ..)| body.name)
        .column("alpha", |(_, case, _)| case.alpha)
        .column("slack [mm]", |(.., shape)| mm(shape.slack_m))
        .column(
            "largest force [N] at [mm]",
            told(|of| format!("{} at {}", short(of.force_max_n), mm(of.depth_at_max_m)), "none"),
        )
        .column("exponent", told(|of| format!("{:.2}", of.nonlinearity_exponent), "-"))
        .column("beyond the slack", told(|of| format!("{:.2}", of.exponent_beyond_slack), "-"))
        .column(
            "stiffness, first and last fifth [N/m]",
            told(
                |of| [of.stiffness_start_n_per_m, of.stiffness_end_n_per_m].map(short).join(", "),
                "-",
            ),
        )
        .column("snaps", |(.., shape)| shape.snaps)
        .column("residual of the force", told(|of| format!("{:.0e}", of.residual), "-"))
        .table()
}

fn loops(bodies: &[Results]) -> Table {
    let mut rows = Vec::new();
    for body in bodies {
        let mut row = |name: String, depth_m: f64, turn| rows.push((body, name, depth_m, turn));
        for case in &body.cases {
            row(format!("settled, alpha {}", case.alpha), body.loop_m, &case.turn);
        }
        row("settled, alpha 0, whole way".to_owned(), body.deepest_m, &body.deep);
        for speed in &body.speeds {
            row(format!("alpha 0, {} s each way", speed.press_s), body.loop_m, &speed.turn);
        }
    }
    Table::of(&rows)
        .column("body", |(body, ..)| body.name)
        .column("loop", |(_, name, ..)| name)
        .column("depth [mm]", |(_, _, depth_m, _)| mm(*depth_m))
        .column("work given [J]", |(.., turn)| short(turn.loading_work_j))
        .column("got back [J]", |(.., turn)| short(turn.returned_work_j))
        .column("area [J]", |(.., turn)| short(turn.area_j()))
        .column("of the work given", |(.., turn)| match turn.relative() {
            Some(part) => format!("{} %", percent(part)),
            None => "nothing given".to_owned(),
        })
        .table()
}

fn prony(bodies: &[Results]) -> Table {
    let cases = bodies.iter().flat_map(|body| body.cases.iter().map(move |case| (body, case)));
    let fits = cases
        .flat_map(|(body, case)| case.relaxation.series.iter().map(move |fit| (body, case, fit)));
    let list = |all: &[f64]| all.iter().map(|&x| short(x)).collect::<Vec<_>>().join(", ");
    Table::of(fits)
        .column("body", |(body, ..)| body.name)
        .column("alpha", |(_, case, _)| case.alpha)
        .column("settled [N]", |(_, case, _)| short(case.relaxation.minimum_n))
        .column("F_inf [N]", |(.., fit)| short(fit.f_inf_n))
        .column("F_i [N]", |(.., fit)| list(&fit.f_n))
        .column("tau_i [s]", |(.., fit)| list(&fit.tau_s))
        .column("residual [%]", |(.., fit)| percent(fit.residual))
        .column("window [s]", |(.., fit)| fit.window_s.map(short).join(" to "))
        .table()
}
