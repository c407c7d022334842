//! The largest and the smallest floats, and what is no number at all.

use chaincell_kernel::{COORDINATE_MAX, Model};

use super::{TICKS, boxes};
use crate::bodies::{Body, Variant};
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::{Trial, refusal};
use crate::monitor::{Check, Step};
use chaincell_host::error::Result;
use chaincell_host::interrupt;

pub const CASES: &[Case] = &[
    Case {
        name: "tool-floats",
        checks: "tool at the largest, smallest and subnormal floats in turn",
        run: tool,
    },
    Case {
        name: "position-floats",
        checks: "cells at the smallest and subnormal floats, at +-1e6 links; beyond: refused, no \
                 bit changed",
        run: positions,
    },
    Case {
        name: "non-finite",
        checks: "NaN and infinity from the tool: 10 ticks held, then force 0 and no bit changed, \
                 then back; as positions: refused",
        run: non_finite,
    },
];

/// Finite floats at the ends.
const EXTREMES: [f32; 10] = [
    f32::MAX,
    f32::MIN_POSITIVE,
    f32::MIN,
    1e-45,
    -0.0,
    -1e-45,
    f32::EPSILON,
    1e19,
    -f32::MIN_POSITIVE,
    -1e38,
];

/// Another extreme for every number.
fn extreme(at: u32) -> f32 {
    EXTREMES[(at.wrapping_mul(2_654_435_761) >> 16) as usize % EXTREMES.len()]
}

fn tool(scale: Scale, found: &mut Findings) -> Result<()> {
    let ticks = scale.ticks(120);
    for (material, body) in &boxes(scale)? {
        for (label, leaps) in [("a link a tick", false), ("at once", true)] {
            let trial = Trial::new(format!("{material}, {label}"), body, ticks);
            let trial = trial.under(move |tick| {
                let at = [0, 1, 2].map(|axis| extreme(3 * (tick / 2) + axis));
                Step::at(at, u32::from(tick < ticks - 30 && tick % 40 != 39))
            });
            found.play(&Trial { leaps, ..trial })?;
        }
    }
    Ok(())
}

/// A coordinate of a cell along an axis.
type State = fn(usize, u32) -> f32;

fn positions(scale: Scale, found: &mut Findings) -> Result<()> {
    let small: State = |cell, axis| {
        let x = extreme(3 * cell as u32 + axis);
        if x.abs() < 1.0 { x } else { f32::MIN_POSITIVE }
    };
    let large: State = |cell, axis| extreme(3 * cell as u32 + axis).signum() * COORDINATE_MAX;
    for (material, body) in &boxes(scale)? {
        for (label, of) in [("smallest", small), ("1e6 links", large)] {
            let trial = Trial::new(format!("{material}, {label}"), body, scale.ticks(TICKS));
            found.play(&trial.from(move |model: &Model<'_>| {
                (0..model.cells()).map(|cell| [0, 1, 2].map(|axis| of(cell, axis))).collect()
            }))?;
        }
        refuses(found, body, &[1.0001 * COORDINATE_MAX, f32::MAX, f32::MIN])?;
    }
    Ok(())
}

/// States with one bad coordinate are refused and leave every bit as it was.
fn refuses(found: &mut Findings, body: &Body, bad: &[f32]) -> Result<()> {
    for variant in Variant::of_body(body)? {
        interrupt::check()?;
        let Some(model) = body.model(variant.coarse)? else { continue };
        let Ok(mut engine) = refusal(Trial::new("", body, 0).engine(model, variant))? else {
            continue;
        };
        for &bad in bad {
            let before = engine.state_hash();
            let mut places = vec![[0.0; 3]; model.cells()];
            places[model.cells() - 1][1] = bad;
            let taken = engine.set_positions(&places).is_ok() || engine.state_hash() != before;
            found.hold(!taken, variant.to_string(), Check::Admission, || format!("{bad} is taken"));
            found.figure("states_refused", 1.0);
        }
    }
    Ok(())
}

fn non_finite(scale: Scale, found: &mut Findings) -> Result<()> {
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for (material, body) in &boxes(scale)? {
        refuses(found, body, &bad)?;
        let depth_m = body.plain()?.unit_m();
        // Two ticks to press, 30 bad ones, a good one, one away.
        let rounds = 2 * bad.len() as u32;
        let trial = Trial::new(format!("{material}, bad samples"), body, 34 * rounds);
        found.play(&trial.under(move |tick| {
            let (round, within) = (tick / 34, tick % 34);
            match within {
                0 => Step::at([0.0; 3], 1),
                1 | 32 => Step::at([0.0, 0.0, -depth_m], 1),
                33 => Step::at([0.0; 3], 0),
                _ if round % 2 == 0 => Step::at([0.0, bad[round as usize / 2], 0.0], 1),
                _ => Step::at([0.0; 3], 7),
            }
        }))?;
    }
    Ok(())
}
