//! What an identification leaves behind: the residuals as CSV, charts of data, fit and residuals.

use std::fmt::Write as _;

use super::fit::Identified;
use super::target::{Kind, Target};
use crate::charts::plot::{Axis, Chart, Figure, Picture, Style};
use chaincell_host::error::Result;

/// First line of residuals.csv.
pub const RESIDUALS_HEADER: &str = "target,kind,row,x,measured,fit,residual,held_out";

/// `target,kind,row,x,measured,fit,residual,held_out`: x is the displacement \[m\], the time \[s\],
/// or the node; a field has three rows a node, x, y and z. Targets are numbered from 1.
pub fn residuals_csv(targets: &[Target], found: &Identified) -> String {
    let mut text = format!("{RESIDUALS_HEADER}\n");
    let each = targets.iter().zip(&found.fitted).zip(&found.held_out);
    for (number, ((target, fit), held)) in (1..).zip(each) {
        let (kind, x) = (target.words().0, places(target));
        for (at, (measured, fit)) in target.observed.iter().zip(fit).enumerate() {
            let row = at / target.width();
            let (x, held, off) = (x[row], u8::from(held[row]), fit - measured);
            let _ = writeln!(
                text,
                "{number},{kind},{},{x:.8e},{measured:.8e},{fit:.8e},{off:.8e},{held}",
                row + 1
            );
        }
    }
    text
}

/// Abscissa of every row.
fn places(target: &Target) -> Vec<f64> {
    match target.kind {
        Kind::Press => target.displacement_m.clone(),
        Kind::Relaxation | Kind::Path => target.time_s.clone(),
        Kind::Field => target.nodes.iter().map(|&node| f64::from(node)).collect(),
    }
}

/// Two charts for each target of more than one row: measured and fitted, and the residuals.
pub fn charts(targets: &[Target], found: &Identified) -> Result<Vec<Figure>> {
    let mut drawn = Vec::new();
    let each = targets.iter().zip(&found.fitted).zip(&found.held_out);
    for (number, ((target, fit), held)) in (1..).zip(each) {
        if target.rows() < 2 {
            continue;
        }
        let (kind, _) = target.words();
        let both =
            if target.width() == 3 { field(target, fit, held) } else { curve(target, fit, held) };
        for (chart, what) in both.into_iter().zip(["fit", "residuals"]) {
            let shows = match what {
                "fit" => "The nearer the markers are to the line, the better is the fit.",
                _ => "Residuals of a good fit have no pattern.",
            };
            let caption = format!(
                "{shows} Markers of another colour were held out. Target {number}, {kind}."
            );
            let name = format!("target{number}_{}_{what}", kind.replace(['-', ' '], "_"));
            drawn.push(Figure::new(name, caption, Picture::of(&chart)?));
        }
    }
    Ok(drawn)
}

/// Points of the rows held out, or of the others.
fn part(points: &[[f64; 2]], held: &[bool], width: usize, which: bool) -> Vec<[f64; 2]> {
    let all = points.iter().enumerate();
    all.filter(|(at, _)| held[at / width] == which).map(|(_, point)| *point).collect()
}

fn curve(target: &Target, fit: &[f64], held: &[bool]) -> [Chart; 2] {
    let (title, x_title, factor) = match target.kind {
        Kind::Relaxation => ("Relaxation after a step", "time [s]", 1.0),
        Kind::Path => ("Force along a path in time", "time [s]", 1.0),
        _ => ("Force against displacement", "displacement [mm]", 1e3),
    };
    let x: Vec<f64> = places(target).iter().map(|x| factor * x).collect();
    let points = |y: &[f64]| -> Vec<[f64; 2]> { x.iter().zip(y).map(|(&x, &y)| [x, y]).collect() };
    let measured = points(&target.observed);
    let off: Vec<f64> = fit.iter().zip(&target.observed).map(|(f, o)| f - o).collect();
    let off = points(&off);
    let fitted = Chart::new(title, Axis::linear(x_title), Axis::linear("force [N]"))
        .series("fit", Style::Line, &points(fit))
        .series("measured, fitted", Style::Markers, &part(&measured, held, 1, false))
        .series("measured, held out", Style::Markers, &part(&measured, held, 1, true));
    let residuals = Chart::new(
        &format!("{title}: residuals"),
        Axis::linear(x_title),
        Axis::linear("fit less measured [N]"),
    )
    .series("fitted", Style::Markers, &part(&off, held, 1, false))
    .series("held out", Style::Markers, &part(&off, held, 1, true))
    .horizontal(0.0, "no residual");
    [fitted, residuals]
}

fn field(target: &Target, fit: &[f64], held: &[bool]) -> [Chart; 2] {
    let measured: Vec<f64> = target.observed.iter().map(|u| 1e3 * u).collect();
    let pairs: Vec<[f64; 2]> = measured.iter().zip(fit).map(|(&m, f)| [m, 1e3 * f]).collect();
    // Over the fit: noise in the abscissa would slant the cloud.
    let off: Vec<[f64; 2]> = pairs.iter().map(|&[m, f]| [f, f - m]).collect();
    let low = measured.iter().copied().fold(f64::INFINITY, f64::min);
    let high = measured.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let fitted = Chart::new(
        "Displacement field",
        Axis::linear("measured displacement, each axis [mm]"),
        Axis::linear("fitted displacement [mm]"),
    )
    .series("equal", Style::Line, &[[low, low], [high, high]])
    .series("nodes fitted", Style::Markers, &part(&pairs, held, 3, false))
    .series("nodes held out", Style::Markers, &part(&pairs, held, 3, true));
    let residuals = Chart::new(
        "Displacement field: residuals",
        Axis::linear("fitted displacement, each axis [mm]"),
        Axis::linear("fit less measured [mm]"),
    )
    .series("nodes fitted", Style::Markers, &part(&off, held, 3, false))
    .series("nodes held out", Style::Markers, &part(&off, held, 3, true))
    .horizontal(0.0, "no residual");
    [fitted, residuals]
}
