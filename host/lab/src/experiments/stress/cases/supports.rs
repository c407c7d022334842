//! Bodies that nothing holds, that fall apart, that cannot move.

use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::cases::elements::press_and_disturb;
use crate::experiments::stress::trial::{Touch, Trial};
use chaincell_host::bake::BakeOptions;
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "free-floating",
        checks: "nothing fixed: pressed, inverted, in one point; pushed by a probe",
        run: |scale, found| {
            let body = Body::new(cuboid(scale.nodes())?.floating(), &BakeOptions::default())?;
            press_and_disturb(scale, found, "floating", &body)?;
            probe(scale, found, &body)
        },
    },
    Case {
        name: "disconnected",
        checks: "two parts, one of them floating, ten widths apart: the same",
        run: |scale, found| {
            let body = Body::new(cuboid(scale.nodes())?.twice(), &BakeOptions::default())?;
            press_and_disturb(scale, found, "two parts", &body)?;
            probe(scale, found, &body)
        },
    },
    Case {
        name: "fully-fixed",
        checks: "nothing can move: a tool that holds no cell, a probe in its middle",
        run: |scale, found| {
            let body = Body::new(cuboid(scale.nodes())?.all_fixed(), &BakeOptions::default())?;
            press_and_disturb(scale, found, "fixed", &body)?;
            probe(scale, found, &body)
        },
    },
];

/// A probe of two links' radius goes through the body from above, and stays in it.
fn probe(scale: Scale, found: &mut Findings, body: &Body) -> Result<()> {
    let model = body.plain()?;
    let (unit_m, [x, y, z]) = (model.unit_m(), model.centre_m());
    let ticks = scale.ticks(60);
    let trial = Trial::new("probe", body, ticks).under(move |tick| {
        let up = 6.0 * (1.0 - 2.0 * tick as f32 / ticks as f32).max(0.0);
        ([x + 0.1 * unit_m, y, z + up * unit_m], tick < 3 * ticks / 4)
    });
    found.play(&Trial { touch: Touch::Probe(2.0 * unit_m), ..trial })
}
