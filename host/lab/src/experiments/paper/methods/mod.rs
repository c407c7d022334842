//! What each method gives and costs: the network beside traditional `ChainMail`, mass-spring and
//! position-based dynamics, on the same bodies under the same move.

mod body;
mod measure;
mod method;
mod words;

use serde_json::json;

use crate::charts::plot::Figure;
use crate::experiments::paper::section::{Context, Numbers, Section};
use crate::experiments::report::tables::csv;
use body::{Body, HOLD_TICKS, PRESS_TICKS};
use chaincell_host::error::Result;
use measure::{Row, TURN_DEGREES};
use method::SWEEPS;

/// A body with its exact minimum and the methods on it.
struct Comparison {
    body: Body,
    exact: Vec<[f64; 3]>,
    rows: Vec<Row>,
}

impl Comparison {
    fn new(body: Body, rounds: usize) -> Result<Self> {
        let exact = body.minimum()?.positions;
        let rows = measure::rows(&body, &exact, rounds)?;
        Ok(Self { body, exact, rows })
    }

    fn json(&self) -> Result<serde_json::Value> {
        Ok(json!({
            "body": self.body.source,
            "cells": self.exact.len(),
            "links": self.body.mesh.links.len(),
            "depth_m": self.body.depth_m(),
            "chain_alpha": self.body.alpha,
            "press_ticks": PRESS_TICKS,
            "hold_ticks": HOLD_TICKS,
            "sweeps_per_tick": SWEEPS,
            "turn_degrees": TURN_DEGREES,
            "minimum_force_n": self.body.force_n(&self.exact),
            "minimum_nonlinearity": measure::of_plane(&self.body, &self.exact)?,
            "methods": self.rows,
        }))
    }
}

/// The comparison on the paper's plane and on a box. A few seconds.
///
/// # Errors
/// As the methods; an exact minimum that is not reached; Ctrl-C.
pub fn section(context: &Context) -> Result<Section> {
    let rounds = if context.quick { 2 } else { 40 };
    let plane = Comparison::new(Body::plane()?, rounds)?;
    let cuboid = Comparison::new(Body::cuboid()?, rounds)?;
    let profiles = words::profiles(&plane)?.draw()?;
    let figure = Figure::new("paper_methods_profiles", words::caption(&plane), profiles);
    let numbers = [&plane, &cuboid].map(|comparison| Numbers {
        name: format!("paper_methods_{}", comparison.body.name),
        csv: csv(&comparison.rows),
    });
    let profiles =
        Numbers { name: "paper_methods_profiles".into(), csv: words::profile_csv(&plane)? };
    Ok(Section {
        key: "methods",
        title: "What each method gives and costs".into(),
        text: words::text(&plane, &cuboid)?,
        figures: vec![figure],
        tables: [&plane, &cuboid].map(words::table).into(),
        numbers: numbers.into_iter().chain([profiles]).collect(),
        json: json!({ "plane": plane.json()?, "box": cuboid.json()? }),
    })
}

#[cfg(test)]
mod tests;
