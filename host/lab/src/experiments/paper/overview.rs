//! The paper's results, each with what was computed here, from the figures of the sections.

use serde_json::Value;

use crate::experiments::report::tables::{Table, percent};
use chaincell_host::words::counted;

/// What stands where a section is missing.
const MISSING: &str = "not computed";

/// A row: the paper's result, and the sentence on ours from the figures in `paper.json`.
type Row = (&'static str, fn(&Value) -> Option<String>);

const ROWS: &[Row] = &[
    ("Fig. 4: ChainMail gives a pyramid, the network a non-linear shape", shape),
    ("Fig. 5a: the force is not linear", compression),
    ("Fig. 5b: loading and unloading with restored links take two paths", unloading),
    ("Fig. 5c: the force relaxes towards a minimum", relaxation),
    ("Fig. 6: a better shape than ChainMail's", liver),
    ("Left open: many elements to one cell", scaling),
    ("Left open: the material parameters", identified),
];

/// One row a result of the paper.
pub(super) fn table(figures: &Value) -> Table {
    Table::of(ROWS)
        .column("the paper", |(result, _)| result)
        .column("computed here", |(_, ours)| ours(figures).unwrap_or_else(|| MISSING.to_owned()))
        .table()
}

fn real(value: &Value, path: &str) -> Option<f64> {
    value.pointer(path)?.as_f64()
}

fn list<'v>(value: &'v Value, path: &str) -> Option<&'v Vec<Value>> {
    value.pointer(path)?.as_array()
}

/// The list's numbers at a path, with a text each.
fn each(list: &[Value], path: &str, text: impl Fn(f64) -> String) -> String {
    let numbers = list.iter().filter_map(|value| real(value, path));
    numbers.map(text).collect::<Vec<_>>().join(", ")
}

fn mm(metres: f64) -> String {
    format!("{:.0}", 1e3 * metres)
}

fn shape(figures: &Value) -> Option<String> {
    let off = |neighbours: u8, method: &str| {
        real(figures, &format!("/plane/neighbours_{neighbours}/{method}/nonlinearity"))
    };
    Some(format!(
        "The plane, its centre held {} mm away. Distance of the profile from the straight sides of \
         a pyramid, over the depth: with 4 neighbours ChainMail {:.3}, the network {:.3} at \
         equilibrium and {:.2} to {:.2} on the way there; with 8 neighbours ChainMail {:.3}, the \
         network {:.3}.",
        mm(real(figures, "/plane/depth_m")?),
        off(4, "chainmail")?,
        off(4, "network")?,
        off(4, "network_t100")?,
        off(4, "network_t1")?,
        off(8, "chainmail")?,
        off(8, "network")?
    ))
}

/// A sentence for each body of the experiments of Fig. 5.
fn bodies(
    figures: &Value,
    sentence: impl Fn(&str, &Value, &[Value]) -> Option<String>,
) -> Option<String> {
    let bodies = list(figures, "/mechanics/bodies")?.iter();
    let sentences =
        bodies.map(|body| sentence(body.pointer("/body")?.as_str()?, body, list(body, "/cases")?));
    sentences.collect::<Option<Vec<String>>>().map(|sentences| sentences.join(" "))
}

fn compression(figures: &Value) -> Option<String> {
    bodies(figures, |name, _, cases| {
        let (elastic, bands) = cases.split_first()?;
        Some(format!(
            "The {name}, cells held by the tool: at alpha 0 the force grows with the displacement to \
             the power {:.2}, with {}. At alpha {} there is no force up to {} mm.",
            real(elastic, "/compression/nonlinearity_exponent")?,
            counted(real(elastic, "/compression/snaps")?, "snap"),
            each(bands, "/alpha", |alpha| alpha.to_string()),
            each(bands, "/slack_m", mm)
        ))
    })
}

fn unloading(figures: &Value) -> Option<String> {
    bodies(figures, |name, body, cases| {
        let (elastic, bands) = cases.split_first()?;
        let loops = list(body, "/speeds_at_alpha_0")?;
        Some(format!(
            "The {name}, {} mm deep: with a band the two paths are there, but the tool gets back more \
             work than it gave, by {} mJ. At alpha 0 and without speed the loop is {} % of the work; \
             a loop in the sense of tissue comes from the network's own time ({} % of the work).",
            mm(real(body, "/loop_m")?),
            each(bands, "/loop_area_j", |area_j| format!("{:.1}", -1e3 * area_j)),
            percent(real(elastic, "/loop_area_of_loading_work")?),
            each(loops, "/loop_area_of_loading_work", percent)
        ))
    })
}

fn relaxation(figures: &Value) -> Option<String> {
    bodies(figures, |name, _, cases| {
        let series = list(cases.first()?, "/prony")?;
        Some(format!(
            "The {name}: yes, by diffusion. A Prony series of {} terms misses it by {} %.",
            (1..=series.len()).map(|terms| terms.to_string()).collect::<Vec<_>>().join(", "),
            each(series, "/residual", percent)
        ))
    })
}

fn liver(figures: &Value) -> Option<String> {
    let of = |name: &str| real(figures, &format!("/liver/{name}"));
    Some(format!(
        "{:.1} mm deep under a moving probe of {:.0} mm radius: the network moves {:.0} of {} \
         smoothly and resists with up to {:.2} N; ChainMail moves a block of {:.0} cells with an \
         edge and gives no force. As nodal shapes it resists with up to {:.2} N, {} % off the force at \
         rest on the way in at most.",
        1e3 * of("depth_m")?,
        1e3 * of("radius_m")?,
        of("network/moved")?,
        counted(of("cells")?, "cell"),
        of("force_max_n")?,
        of("chainmail/moved")?,
        of("tissue/force_max_n")?,
        percent(of("tissue/force_error_max")?)
    ))
}

fn scaling(figures: &Value) -> Option<String> {
    let networks = list(figures, "/scaling/networks")?;
    let nodes = real(figures, "/scaling/nodes")?;
    let mut sites: Vec<&str> = networks.iter().filter_map(|row| row["site"].as_str()).collect();
    sites.dedup();
    let sentences = sites.iter().map(|site| {
        let rows = networks.iter().filter(|row| row["site"] == **site);
        let grouped: Vec<Value> =
            rows.filter(|row| real(row, "/cells") < Some(nodes)).cloned().collect();
        format!(
            "{site}: as {} cells, {} % of the time a tick, field {} % and force {} % off.",
            each(&grouped, "/cells", |cells| cells.to_string()),
            each(&grouped, "/tick_share", percent),
            each(&grouped, "/field_error", percent),
            each(&grouped, "/force_error", |error| percent(error.abs()))
        )
    });
    let pressed = format!(
        "The organ of {} pressed at its dome and its tip by cells held by the tool, {} mm deep \
         (shallow: {} mm). ",
        counted(nodes, "node"),
        mm(real(figures, "/scaling/depth_m")?),
        mm(real(figures, "/scaling/shallow_depth_m")?)
    );
    Some(pressed + &sentences.collect::<Vec<_>>().join(" "))
}

fn identified(figures: &Value) -> Option<String> {
    let of = |name: &str| figures.pointer(&format!("/identified/{name}"));
    Some(format!(
        "Two materials, slack and time from curves and a field with {} % of noise, on a body of {} \
         cells: within {:.1} % where they are determined. From curves alone {} of the parameters \
         are not determined, and the fit says so.",
        of("noise_percent")?,
        of("cells")?,
        of("largest_error_where_determined_percent")?.as_f64()?,
        list(figures, "/identified/curves")?
            .iter()
            .filter(|row| row["determined"] == false)
            .count()
    ))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_row_has_the_figures_of_its_section_or_says_that_it_is_missing() {
        let figures = json!({ "liver": {
            "depth_m": 0.0096, "radius_m": 0.023, "cells": 5783, "force_max_n": 0.4,
            "network": { "moved": 5479 }, "chainmail": { "moved": 582 },
            "tissue": { "force_max_n": 1.2, "force_error_max": 0.012 },
        } });
        let table = table(&figures);
        let row = |part: &str| table.rows().iter().find(|row| row[0].contains(part)).unwrap();
        for part in ["9.6 mm deep", "moving probe of 23 mm", "5479 of 5783 cells", "582 cells"] {
            assert!(row("Fig. 6")[1].contains(part), "{:?}", row("Fig. 6"));
        }
        assert_eq!(row("Fig. 4")[1], MISSING);
    }
}
