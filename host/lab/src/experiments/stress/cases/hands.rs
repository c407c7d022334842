//! Held cells under tools that do what no hand does.

use chaincell_kernel::Model;

use super::{boxes, each_material};
use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::Trial;
use crate::monitor::{Check, Step};
use crate::states::scattered;
use chaincell_host::bake::BakeOptions;
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "teleport-cells",
        checks: "held cell anywhere within 3 widths, elsewhere every tick; then let go",
        run: |scale, found| anywhere(scale, found, |_| None),
    },
    Case {
        name: "late-cells",
        checks: "held cell anywhere within 3 widths, 6 of 10 ticks late, others cut to 1 or 2 sweeps",
        run: |scale, found| anywhere(scale, found, cut),
    },
    Case {
        name: "jump-through-cells",
        checks: "held cell from above to below the body and back, every 5 ticks; then let go",
        run: jump,
    },
    Case {
        name: "nyquist-cells",
        checks: "held cell up and down by a link every tick; let go, track leaves under 1e-3 E",
        run: nyquist,
    },
    Case {
        name: "k-reached-and-left",
        checks: "held cell out to 3 K and back, then let go; body thrown to 3 K",
        run: reach,
    },
];

/// Ticks under the tool.
const HELD: u32 = 120;
/// Ticks after it.
const FREE: u32 = 60;

/// Sweeps of a tick as under a load: runs of poses that newer ones have overtaken, and ticks that end early.
pub fn cut(tick: u32) -> Option<u16> {
    match tick % 10 {
        0 | 5 => Some(1),
        3 | 9 => Some(2),
        _ => Some(0),
    }
}

/// The box under a tool at offsets from its centre [mean link lengths], then away.
fn around<'b>(
    label: &str,
    scale: Scale,
    body: &'b Body,
    offset: impl Fn(u32) -> [f32; 3] + 'b,
) -> Result<Trial<'b>> {
    let (model, held) = (body.plain()?, scale.ticks(HELD));
    let (unit_m, centre_m) = (model.unit_m(), model.centre_m());
    Ok(Trial::new(label, body, scale.ticks(HELD + FREE)).under(move |tick| {
        let offset = offset(tick.min(held - 1));
        let at_m = [0, 1, 2].map(|axis| centre_m[axis] + unit_m * offset[axis]);
        Step::at(at_m, u32::from(tick < held))
    }))
}

/// A tool that goes a link a tick at most, and one that goes any way at once.
const WAYS: [(&str, bool); 2] = [("a link a tick", false), ("at once", true)];

fn anywhere(scale: Scale, found: &mut Findings, sweeps: fn(u32) -> Option<u16>) -> Result<()> {
    let by = 3.0 * scale.nodes() as f32 / 2.0;
    for (material, body) in &boxes(scale)? {
        for (label, leaps) in WAYS {
            let places = scattered(u64::from(leaps), scale.ticks(HELD) as usize, by);
            let label = format!("{material}, {label}");
            let trial = around(&label, scale, body, move |tick| places[tick as usize])?;
            let script = trial.script;
            let script = Box::new(move |tick| Step { sweeps: sweeps(tick), ..script(tick) });
            found.play(&Trial { leaps, script, ..trial })?;
        }
    }
    Ok(())
}

fn jump(scale: Scale, found: &mut Findings) -> Result<()> {
    let height = scale.nodes() as f32;
    for (material, body) in &boxes(scale)? {
        for (label, leaps) in WAYS {
            let label = format!("{material}, {label}");
            let trial = around(&label, scale, body, move |tick| {
                let up = [1.0, 0.3, -1.0, -0.3][(tick / 5) as usize % 4];
                [0.05, 0.02, up * height]
            })?;
            found.play(&Trial { leaps, ..trial })?;
        }
    }
    Ok(())
}

fn nyquist(scale: Scale, found: &mut Findings) -> Result<()> {
    for (material, body) in &boxes(scale)? {
        for amplitude in [0.5_f32, 0.01] {
            let label = format!("{material}, amplitude {amplitude} links");
            let trial = around(&label, scale, body, move |tick| {
                [0.05, 0.02, if tick % 2 == 0 { amplitude } else { -amplitude }]
            })?;
            found.play(&Trial { left_max: Some(1e-3), ..trial })?;
        }
    }
    Ok(())
}

/// Enough for a tool to stretch a body to K \[J\].
const ENERGY_MAX_J: f64 = 1e6;

fn reach(scale: Scale, found: &mut Findings) -> Result<()> {
    let options = BakeOptions { energy_max_j: Some(ENERGY_MAX_J), ..BakeOptions::default() };
    for (material, body) in &each_material(&cuboid(scale.nodes())?, &options)? {
        let k = body.plain()?.saturation();
        let far_m = 3.0 * k * body.plain()?.unit_m();
        // Draw the held cell out to 3 K and back.
        let (out, way) = (scale.ticks(60), [0.6_f32, -0.5, 0.62]);
        let label = format!("{material}, held cell");
        let trial = Trial::new(label.clone(), body, 3 * out).under(move |tick| {
            let part = out.abs_diff(tick.min(2 * out)) as f32 / out as f32;
            Step::at(way.map(|x| x * far_m * (1.0 - part)), u32::from(tick < 2 * out))
        });
        found.play(&Trial { leaps: true, ..trial })?;
        found.hold(found.worst.coordinate_over_k >= 1.0, label, Check::Range, || {
            "K was not reached".to_owned()
        });
        // Throw the body as far.
        let thrown = move |model: &Model<'_>| {
            let place = |cell: usize| {
                let rest = model.rest_position(cell);
                let by = if model.is_fixed(cell as u16) { 0.0 } else { 3.0 * k };
                [0, 1, 2].map(|axis| rest[axis] + by * way[axis])
            };
            (0..model.cells()).map(place).collect()
        };
        let label = format!("{material}, thrown");
        found.play(&Trial::new(label, body, scale.ticks(120)).from(thrown))?;
    }
    Ok(())
}
