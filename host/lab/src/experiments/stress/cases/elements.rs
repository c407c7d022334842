//! Bodies of shapes that meshes should not have.

use crate::bodies::shape::{cuboid, hub, spiral};
use crate::bodies::{Body, Shape};
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::cases::{PRESS_TICKS, pressing, touching_once};
use crate::experiments::stress::trial::Trial;
use crate::states::State;
use chaincell_host::bake::BakeOptions;
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "needles",
        checks: "tetrahedra 1000 times longer than wide: pressed, inverted, in one point",
        run: |scale, found| {
            press_and_disturb_shape(
                scale,
                found,
                "needles",
                cuboid(scale.nodes())?.stretched([1000.0, 1.0, 1.0]),
            )
        },
    },
    Case {
        name: "slivers",
        checks: "tetrahedra 1000 times wider than thick: pressed, inverted, in one point",
        run: |scale, found| {
            press_and_disturb_shape(
                scale,
                found,
                "slivers",
                cuboid(scale.nodes())?.stretched([1.0, 1.0, 1e-3]),
            )
        },
    },
    Case {
        name: "valence-3-to-200",
        checks: "hubs of 3, 8, 30, 100, 200 links: pressed, inverted, in one point",
        run: |scale, found| {
            [3, 8, 30, 100, 200].into_iter().try_for_each(|spokes| {
                press_and_disturb_shape(scale, found, &format!("valence {spokes}"), hub(spokes))
            })
        },
    },
    Case {
        name: "lengths-6-decades",
        checks: "links from 1e-6 of the longest on: pressed, inverted, in one point",
        run: |scale, found| press_and_disturb_shape(scale, found, "spiral", spiral()),
    },
];

/// Presses a body by two mean link lengths and lets it go; inverts it; puts it into one point.
fn press_and_disturb_shape(
    scale: Scale,
    found: &mut Findings,
    name: &str,
    shape: Shape,
) -> Result<()> {
    let body = Body::new(shape, &BakeOptions::default())?;
    press_and_disturb(scale, found, name, &body)
}

/// The same for a baked body.
pub fn press_and_disturb(
    scale: Scale,
    found: &mut Findings,
    name: &str,
    body: &Body,
) -> Result<()> {
    let depth_m = 2.0 * body.plain()?.unit_m();
    let ticks = PRESS_TICKS + scale.ticks(60);
    let pressed = Trial::new(format!("{name}, pressed"), body, ticks).under(pressing(depth_m));
    found.play(&pressed)?;
    let ticks = scale.ticks(60);
    for (label, state) in
        [("inverted", State::Inverted), ("in one point", State::Coincident([0.0; 3]))]
    {
        let trial = Trial::new(format!("{name}, {label}"), body, ticks);
        let trial = trial.from(move |model| state.of_free_cells(model, 0));
        found.play(&trial.under(touching_once(ticks)))?;
    }
    Ok(())
}
