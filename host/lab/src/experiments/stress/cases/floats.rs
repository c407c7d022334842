//! The largest and the smallest floats, and what is no number at all.

use chaincell_kernel::{COORDINATE_MAX, Flags, ToolPose};
use nalgebra::Vector3;

use crate::bodies::Body;
use crate::bodies::Variant;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::{Trial, sample};
use crate::monitor::Check;
use chaincell_host::bake::BakeOptions;
use chaincell_host::engine::Engine;
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

fn the_box(scale: Scale) -> Result<Body> {
    Body::new(cuboid(scale.nodes())?, &BakeOptions::default())
}

fn tool(scale: Scale, found: &mut Findings) -> Result<()> {
    let body = the_box(scale)?;
    let ticks = scale.ticks(120);
    for leaps in [false, true] {
        let label = if leaps { "at once" } else { "a link a tick" };
        let trial = Trial::new(label, &body, ticks).under(move |tick| {
            let at = [0, 1, 2].map(|axis| extreme(3 * (tick / 2) + axis));
            (at, tick < ticks - 30 && tick % 40 != 39)
        });
        found.play(&Trial { leaps, ..trial })?;
    }
    Ok(())
}

/// A coordinate of a cell along an axis.
type State = fn(usize, u32) -> f32;

fn positions(scale: Scale, found: &mut Findings) -> Result<()> {
    let body = the_box(scale)?;
    let ticks = scale.ticks(60);
    let small: State = |cell, axis| {
        let x = extreme(3 * cell as u32 + axis);
        if x.abs() < 1.0 { x } else { f32::MIN_POSITIVE }
    };
    let large: State = |cell, axis| extreme(3 * cell as u32 + axis).signum() * COORDINATE_MAX;
    for (label, of) in [("smallest", small), ("1e6 links", large)] {
        let trial = Trial::new(label, &body, ticks);
        let trial = trial.from(move |model| {
            (0..model.cells()).map(|cell| [0, 1, 2].map(|axis| of(cell, axis))).collect()
        });
        found.play(&trial)?;
    }
    each_engine(&body, |variant, engine| {
        refuses(found, variant, engine, &[1.0001 * COORDINATE_MAX, f32::MAX, f32::MIN])
    })
}

/// States with one bad coordinate are refused and leave every bit as it was.
fn refuses(
    found: &mut Findings,
    variant: Variant,
    engine: &mut Engine<'_>,
    bad: &[f32],
) -> Result<()> {
    let cells = engine.network().model().cells();
    for &bad in bad {
        let before = engine.state_hash();
        let mut places = vec![[0.0; 3]; cells];
        places[cells - 1][1] = bad;
        let taken = engine.set_positions(&places).is_ok() || engine.state_hash() != before;
        found.hold(!taken, variant.to_string(), Check::Admission, || format!("{bad} is taken"));
        found.figure("states_refused", 1.0);
    }
    Ok(())
}

fn each_engine(
    body: &Body,
    mut of: impl FnMut(Variant, &mut Engine<'_>) -> Result<()>,
) -> Result<()> {
    for variant in Variant::all() {
        interrupt::check()?;
        let Some(model) = body.model(variant.coarse)? else { continue };
        if let Ok(mut engine) = Trial::new("", body, 0).engine(model, variant)? {
            of(variant, &mut engine)?;
        }
    }
    Ok(())
}

fn non_finite(scale: Scale, found: &mut Findings) -> Result<()> {
    let body = the_box(scale)?;
    let depth_m = body.plain()?.unit_m();
    each_engine(&body, |variant, engine| {
        refuses(found, variant, engine, &[f32::NAN, f32::INFINITY, f32::NEG_INFINITY])?;
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let bad = ToolPose::at(Vector3::new(0.0, bad, 0.0), 1);
            let bad_touch = ToolPose::at(Vector3::zeros(), 7);
            for bad in [bad, bad_touch] {
                safe(found, variant, engine, &bad, depth_m);
            }
        }
        Ok(())
    })
}

/// Held for ten ticks, then the safe state, then back.
fn safe(
    found: &mut Findings,
    variant: Variant,
    engine: &mut Engine<'_>,
    bad: &ToolPose,
    depth_m: f32,
) {
    let mut check = |holds: bool, tick: u32, what: &str| {
        let what = || format!("{what}, bad tick {tick}");
        found.hold(holds, variant.to_string(), Check::Safe, what);
    };
    engine.tick(&sample(([0.0; 3], true)));
    let pressed = sample(([0.0, 0.0, -depth_m], true));
    engine.tick(&pressed);
    let mut frozen = None;
    for tick in 1..=30 {
        let output = engine.tick(bad);
        let hash = engine.state_hash();
        let finite = output.force_n.iter().chain([&output.energy_j]).all(|x| x.is_finite());
        check(finite, tick, "not finite");
        check(output.flags.contains(Flags::BAD_SAMPLE), tick, "not flagged");
        let is_safe = output.flags.contains(Flags::SAFE_STATE);
        check(is_safe == (tick > 10), tick, "safe state at the wrong time");
        check(is_safe == (output.force_n.norm() == 0.0), tick, "force");
        check(!is_safe || frozen.is_none_or(|before| before == hash), tick, "cells moved");
        frozen = (tick >= 10).then_some(hash);
    }
    let back = engine.tick(&pressed);
    check(back.flags.0 == 0 && back.force_n.norm() > 0.0, 31, "does not come back");
    engine.tick(&sample(([0.0; 3], false)));
    found.figure("bad_ticks", 30.0);
}
