//! A measured curve beside the answer of a baked body.

use serde_json::{Value, json};

use crate::experiments::page::table::{Table, percent};

/// A measured curve with the answers of a body at its points.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// The tissue that was measured.
    pub tissue: &'static str,
    /// The curve.
    pub curve: String,
    /// The body, as a bake is given it.
    pub body: String,
    /// Number of its cells.
    pub cells: usize,
    /// The measured points.
    pub points: Vec<[f64; 2]>,
    /// The body's answer at each of them.
    pub answers: Vec<f64>,
}

impl Compared {
    /// Root mean square distance from the points, over the largest one.
    pub fn misfit(&self) -> f64 {
        let squares: f64 = self.errors().map(|error| error * error).sum();
        (squares / self.points.len().max(1) as f64).sqrt() / self.peak()
    }

    /// Largest distance from a point, over the largest one.
    pub fn worst(&self) -> f64 {
        self.errors().map(f64::abs).fold(0.0, f64::max) / self.peak()
    }

    /// The body's largest answer over the largest point, less 1.
    pub fn peak_error(&self) -> f64 {
        let largest = self.answers.iter().map(|answer| answer.abs()).fold(0.0, f64::max);
        largest / self.peak() - 1.0
    }

    fn errors(&self) -> impl Iterator<Item = f64> {
        self.answers.iter().zip(&self.points).map(|(answer, point)| answer - point[1])
    }

    fn peak(&self) -> f64 {
        self.points.iter().map(|point| point[1].abs()).fold(0.0, f64::max)
    }

    /// The body's answers as points.
    pub fn line(&self) -> Vec<[f64; 2]> {
        self.points.iter().zip(&self.answers).map(|(point, &answer)| [point[0], answer]).collect()
    }

    /// The figures under their names.
    pub fn json(&self) -> Value {
        json!({
            "tissue": self.tissue,
            "curve": self.curve,
            "body": self.body,
            "cells": self.cells,
            "points": self.points.len(),
            "misfit": self.misfit(),
            "worst": self.worst(),
            "peak_error": self.peak_error(),
        })
    }
}

/// A row for each comparison.
pub fn table(all: &[Compared]) -> Table {
    Table::of(all)
        .column("tissue", |of| of.tissue)
        .column("curve", |of| &of.curve)
        .column("body", |of| &of.body)
        .column("cells", |of| of.cells)
        .column("points", |of| of.points.len())
        .column("rms [% of the peak]", |of| percent(of.misfit()))
        .column("worst [% of the peak]", |of| percent(of.worst()))
        .column("peak [% off]", |of| percent(of.peak_error()))
        .table()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_shares_of_the_peak() {
        let points = vec![[0.0, 0.0], [1.0, -2.0], [2.0, -4.0]];
        let answers = vec![0.0, -2.0, -3.0];
        let (curve, body) = (String::new(), String::new());
        let of = Compared { tissue: "", curve, body, cells: 1, points, answers };
        assert!((of.misfit() - (1.0_f64 / 3.0).sqrt() / 4.0).abs() < 1e-12);
        assert_eq!((of.worst(), of.peak_error()), (0.25, -0.25));
    }
}
