//! Tools that do what no hand does.

use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::{Pose, Trial};
use crate::states::scattered;
use chaincell_host::bake::BakeOptions;
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "teleport-cells",
        checks: "held cell anywhere within 3 widths, elsewhere every tick; then let go",
        run: |scale, found| teleport(scale, found),
    },
    Case {
        name: "late-cells",
        checks: "held cell anywhere within 3 widths, 6 of 10 ticks late, others cut to 1 or 2 sweeps",
        run: |scale, found| late(scale, found),
    },
    Case {
        name: "jump-through-cells",
        checks: "held cell from above to below the body and back, every 5 ticks; then let go",
        run: |scale, found| jump(scale, found, 5),
    },
    Case {
        name: "nyquist-cells",
        checks: "held cell up and down by a link every tick; let go, track leaves under 1e-3 E",
        run: |scale, found| nyquist(scale, found),
    },
];

/// Ticks under the tool.
const HELD: u32 = 120;
/// Ticks after it.
const FREE: u32 = 60;

/// The box, its mean link length \[m\] and its centre \[m\].
fn body(scale: Scale) -> Result<(Body, f32, [f32; 3])> {
    let body = Body::new(cuboid(scale.nodes())?, &BakeOptions::default())?;
    let model = body.plain()?;
    let (unit_m, centre_m) = (model.unit_m(), model.centre_m());
    Ok((body, unit_m, centre_m))
}

/// A script of offsets from the centre [mean link lengths] for `held` ticks, then away.
fn around(
    unit_m: f32,
    centre_m: [f32; 3],
    held: u32,
    offset: impl Fn(u32) -> [f32; 3],
) -> impl Fn(u32) -> Pose {
    move |tick| {
        let offset = offset(tick.min(held - 1));
        let at_m = std::array::from_fn(|axis| centre_m[axis] + unit_m * offset[axis]);
        (at_m, tick < held)
    }
}

fn teleport(scale: Scale, found: &mut Findings) -> Result<()> {
    anywhere(scale, found, |_| None)
}

/// As under a load: runs of poses that newer ones have overtaken, and ticks that end early.
fn late(scale: Scale, found: &mut Findings) -> Result<()> {
    anywhere(scale, found, |tick| match tick % 10 {
        0 | 5 => Some(1),
        3 | 9 => Some(2),
        _ => Some(0),
    })
}

fn anywhere(scale: Scale, found: &mut Findings, sweeps_made: fn(u32) -> Option<u16>) -> Result<()> {
    let (body, unit_m, centre_m) = body(scale)?;
    let held = scale.ticks(HELD);
    let by = 3.0 * scale.nodes() as f32 / 2.0;
    for leaps in [false, true] {
        let label = if leaps { "at once" } else { "a link a tick" };
        let places = scattered(u64::from(leaps), held as usize, by);
        let script = around(unit_m, centre_m, held, move |tick| places[tick as usize]);
        let trial = Trial::new(label, &body, scale.ticks(HELD + FREE)).under(script);
        found.play(&Trial { leaps, sweeps_made, ..trial })?;
    }
    Ok(())
}

fn jump(scale: Scale, found: &mut Findings, every: u32) -> Result<()> {
    let (body, unit_m, centre_m) = body(scale)?;
    let held = scale.ticks(HELD);
    let height = scale.nodes() as f32;
    for leaps in [false, true] {
        let label = if leaps { "at once" } else { "a link a tick" };
        let script = around(unit_m, centre_m, held, move |tick| {
            let up = [1.0, 0.3, -1.0, -0.3][(tick / every) as usize % 4];
            [0.05, 0.02, up * height]
        });
        let trial = Trial::new(label, &body, scale.ticks(HELD + FREE)).under(script);
        found.play(&Trial { leaps, ..trial })?;
    }
    Ok(())
}

fn nyquist(scale: Scale, found: &mut Findings) -> Result<()> {
    let (body, unit_m, centre_m) = body(scale)?;
    let held = scale.ticks(HELD);
    for amplitude in [0.5_f32, 0.01] {
        let script = around(unit_m, centre_m, held, move |tick| {
            let up = if tick % 2 == 0 { amplitude } else { -amplitude };
            [0.05, 0.02, up]
        });
        let label = format!("amplitude {amplitude} links");
        let trial = Trial::new(label, &body, scale.ticks(HELD + FREE)).under(script);
        found.play(&Trial { left_max: Some(1e-3), ..trial })?;
    }
    Ok(())
}
