//! What the experiments of Fig. 5 say, in sentences and tables.

use super::{Case, Loop, Results, Shape, TIME_CONSTANT_S};
use crate::experiments::page::table::{Table, percent};
use crate::experiments::paper::body::SETTLE_SWEEPS;
use chaincell_host::words::counted;

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

/// The paper's findings and ours, a sentence for each body.
pub fn results(bodies: &[Results]) -> Vec<(&'static str, String)> {
    let each = |sentence: fn(&Results) -> String| {
        bodies.iter().map(sentence).collect::<Vec<_>>().join(" ")
    };
    vec![
        ("Fig. 5a: the force is not linear", each(compressed)),
        (
            "Fig. 5b: loading and unloading with restored links take two paths",
            each(loaded_and_unloaded),
        ),
        ("Fig. 5c: the force relaxes towards a minimum", each(relaxed)),
    ]
}

/// Values of the cases, in order.
fn list<'c>(cases: impl IntoIterator<Item = &'c Case>, of: impl Fn(&Case) -> String) -> String {
    cases.into_iter().map(of).collect::<Vec<_>>().join(", ")
}

fn compressed(body: &Results) -> String {
    let (elastic, bands) = (body.elastic(), &body.cases[1..]);
    format!(
        "The {}, cells held by the tool: at alpha 0 the force grows with the displacement to the \
         power {:.2}, with {}. At alpha {} there is no force up to {} mm.",
        body.name,
        elastic.compression.shape.nonlinearity_exponent,
        counted(elastic.compression.shape.snaps, "snap"),
        list(bands, |case| case.alpha.to_string()),
        list(bands, |case| format!("{:.0}", 1e3 * case.compression.shape.slack_m))
    )
}

fn loaded_and_unloaded(body: &Results) -> String {
    let part = |turn: &Loop| percent(turn.relative());
    let speeds: Vec<String> = body.speeds.iter().map(|speed| part(&speed.turn)).collect();
    format!(
        "The {}, {:.0} mm deep: with a band the two paths are there, but the tool gets back more work \
         than it gave, by {} mJ. At alpha 0 and without speed the loop is {} % of the work; a loop in \
         the sense of tissue comes from the network's own time ({} % of the work).",
        body.name,
        1e3 * body.loop_m,
        list(&body.cases[1..], |case| format!("{:.1}", -1e3 * case.turn.area_j())),
        part(&body.elastic().turn),
        speeds.join(", ")
    )
}

fn relaxed(body: &Results) -> String {
    let relaxation = &body.elastic().relaxation;
    format!(
        "The {}: yes, by diffusion, at alpha 0 from {} to {} N, within {} % of the exact trajectory.",
        body.name,
        short(relaxation.first_n),
        short(relaxation.minimum_n),
        percent(body.error())
    )
}

/// The paragraphs.
pub fn text(bodies: &[Results]) -> Vec<String> {
    vec![
        format!(
            "The paper shows a force that grows non-linearly with the displacement, two distinct \
             paths of loading and unloading, and a force that falls asymptotically towards a \
             minimum; it gives no numbers, scales or parameters. Here the bodies are {}, links of \
             {} N/m. Settled forces come from `track`, as many sweeps a step as it takes until no \
             free cell's residual exceeds 1e-4 of the force on the tool, at most {} (the largest \
             residual left stands in the table). What runs in time takes one Euler step of Eq. 4 a \
             millisecond with a time constant of {} s, which the paper leaves open: another one \
             stretches the time axis and changes nothing else.",
            (bodies.iter().map(|body| format!("the {}", body.words)))
                .collect::<Vec<_>>()
                .join(" and "),
            bodies.first().map_or(0.0, |body| body.stiffness_n_per_m),
            SETTLE_SWEEPS,
            TIME_CONSTANT_S
        ),
        "5a: links across the push on the plane are stretched only to second order, which makes the \
         force cubic at first: geometry, no property of the links. A solid body softens as its links \
         fold, and snaps deeper in. With a band there is no force at all until a chain of links is \
         taut: alpha is slack, no stiffness."
            .into(),
        "5b: with a band there are two distinct paths, but restoring the links to their initial \
         lengths puts energy into them, and the tool gets back more than it gave: the loop runs \
         against that of tissue. At alpha 0 what is left of it is how well the points have settled. \
         A loop in the sense of tissue comes from the network's own time: it is viscous and falls \
         with the speed. The tool holds its cells on the way back too and is pulled."
            .into(),
        "5c: what relaxes is diffusion from cell to cell, with a time for every length, so that no one \
         exponential describes it. Where the depth lies within the slack the minimum is next to \
         nothing. The exact trajectory is that of Eq. 4 in double precision."
            .into(),
    ]
}

/// The tables with their captions.
pub fn tables(bodies: &[Results]) -> Vec<(String, Table)> {
    vec![
        ("5a: the settled force in compression".into(), compressions(bodies)),
        (
            "5b: loops, links restored at the turn; negative: the tool got back more".into(),
            loops(bodies),
        ),
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
