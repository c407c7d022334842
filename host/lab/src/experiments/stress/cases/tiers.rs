//! Number types against each other.

use crate::bodies::Body;
use crate::bodies::Variant;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::cases::{PRESS_TICKS, pressing};
use crate::experiments::stress::trial::{Trial, sample};
use crate::monitor::Check;
use chaincell_host::bake::BakeOptions;
use chaincell_host::engine::{Arithmetic, Scheme};
use chaincell_host::error::Result;
use chaincell_host::interrupt;

pub const CASES: &[Case] = &[Case {
    name: "number-tiers",
    checks: "a press of a link in f32 and fixed: force of every tick within 2e-3 of the largest",
    run: tiers,
}];

/// Largest difference of forces over the largest force.
const APART_MAX: f32 = 2e-3;

fn tiers(scale: Scale, found: &mut Findings) -> Result<()> {
    let body = Body::new(cuboid(scale.nodes())?, &BakeOptions::default())?;
    let depth_m = body.plain()?.unit_m();
    let trial = Trial::new("press", &body, PRESS_TICKS).under(pressing(depth_m));
    found.play(&trial)?;
    for scheme in [Scheme::Track, Scheme::Euler] {
        let mut forces = Vec::new();
        for numbers in [Arithmetic::F32, Arithmetic::Fixed] {
            interrupt::check()?;
            let variant = Variant { scheme, numbers, coarse: false };
            let Ok(mut engine) = trial.engine(body.plain()?, variant)? else {
                found.fail(variant.to_string(), Check::Admission, "refused".to_owned());
                continue;
            };
            let force =
                (0..PRESS_TICKS).map(|tick| engine.tick(&sample((trial.script)(tick))).force_n);
            forces.push((variant, force.collect::<Vec<_>>()));
        }
        let Some(((_, single), others)) = forces.split_first() else { continue };
        let largest = single.iter().map(|force| force.norm()).fold(0.0, f32::max);
        for (variant, forces) in others {
            let apart = forces.iter().zip(single).map(|(a, b)| (a - b).norm()).fold(0.0, f32::max);
            let part = apart / largest;
            found.hold(part <= APART_MAX, variant.to_string(), Check::Agreement, || {
                format!("{part:e} of the largest force")
            });
            let name = format!("{}_force_off", variant.to_string().replace(' ', "_"));
            found.figure(&name, f64::from(part));
        }
    }
    Ok(())
}
