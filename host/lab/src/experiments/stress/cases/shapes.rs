//! Nodal shapes in states that no tool brings them to, pressed too deep, and torn about.

use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::cases::{PRESS_TICKS, pressing, touching_once};
use crate::experiments::stress::trial::Trial;
use crate::states::{POINT, State};
use chaincell_host::bake::tissue::{Band, STRETCH_MIN, Tissue};
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "shapes-in-states",
        checks: "nodal shapes with the band of stretches and without, nu 0.3 and 0.49: in one point, \
                 flat, on a line, inside out, scattered",
        run: states,
    },
    Case {
        name: "shapes-pressed",
        checks: "the same pressed by 0.9 of the box and let go, and torn about by leaps of four links",
        run: pressed,
    },
    Case {
        name: "shapes-turned",
        checks: "the same turned by a quarter and shaken: track leaves under 2e-3 E, as in a body that \
                 was not turned",
        run: turned,
    },
];

/// Part of the energy that `track` may leave of a body that was turned and shaken.
const LEFT_MAX: f64 = 2e-3;
/// Bands that stiffen a body.
const STIFFENING: [Band; 2] = [
    Band { half_width: 0.05, modulus_pa: 12_000.0 },
    Band { half_width: 0.2, modulus_pa: 70_000.0 },
];
/// Ticks after a state.
const TICKS: u32 = 40;

/// Boxes of nodal shapes.
fn bodies(scale: Scale) -> Result<Vec<(String, Body)>> {
    let kinds = [
        (Some(STRETCH_MIN), 0.49, false),
        (Some(STRETCH_MIN), 0.3, false),
        (None, 0.49, false),
        (Some(STRETCH_MIN), 0.45, true),
    ];
    let body = |(stretch_min, poisson, stiff): (Option<f64>, f64, bool)| {
        let of = PerCell::Uniform;
        let stiffening = if stiff { STIFFENING.to_vec() } else { Vec::new() };
        let tissue = Tissue { stretch_min, stiffening, ..Tissue::new(of(5000.0), of(poisson)) };
        let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
        let band = if stretch_min.is_some() { "band" } else { "no band" };
        let stiff = if stiff { ", stiffened" } else { "" };
        let label = format!("{band}{stiff}, nu {poisson}");
        Ok((label, Body::new(cuboid(scale.nodes())?, &options)?))
    };
    kinds.into_iter().map(body).collect()
}

fn states(scale: Scale, found: &mut Findings) -> Result<()> {
    let ticks = scale.ticks(TICKS);
    for (label, body) in &bodies(scale)? {
        for (name, state) in [
            ("in one point", State::Coincident(POINT)),
            ("flat", State::Flattened),
            ("on a line", State::Line),
            ("mirrored", State::Mirrored),
            ("inside out", State::Inverted),
            ("shaken", State::Shaken),
            ("scattered", State::Scattered(20.0)),
        ] {
            for free in [false, true] {
                let cells = if free { "free cells" } else { "all cells" };
                let trial = Trial::new(format!("{label}, {name}, {cells}"), body, ticks);
                let trial = trial.from(move |model| match free {
                    true => state.of_free_cells(model, 0),
                    false => state.positions(model, 0),
                });
                found.play(&trial.under(touching_once(ticks)))?;
            }
        }
    }
    Ok(())
}

fn pressed(scale: Scale, found: &mut Findings) -> Result<()> {
    for (label, body) in &bodies(scale)? {
        let unit_m = body.plain()?.unit_m();
        let depth_m = 0.9 * 0.01 * (scale.nodes() - 1) as f32;
        let ticks = PRESS_TICKS + scale.ticks(60);
        let trial = Trial::new(format!("{label}, pressed"), body, ticks).under(pressing(depth_m));
        found.play(&trial)?;
        let by = 4.0 * unit_m;
        let trial = Trial::new(format!("{label}, torn about"), body, scale.ticks(TICKS));
        let trial = trial.under(move |tick| {
            let side = if tick % 2 == 0 { by } else { -by };
            ([side, by * (tick % 3) as f32, side], true)
        });
        found.play(&Trial { leaps: true, ..trial })?;
    }
    Ok(())
}

fn turned(scale: Scale, found: &mut Findings) -> Result<()> {
    for (label, body) in &bodies(scale)? {
        for (name, turn) in [("upright", [1.0, 0.0]), ("turned", [0.0, 1.0])] {
            let trial = Trial::new(format!("{label}, {name}"), body, TICKS);
            let trial = trial.from(move |model| {
                let ([cosine, sine], mut at) = (turn, State::Shaken.positions(model, 1));
                for &cell in model.fixed() {
                    at[usize::from(cell)] = model.rest_position(cell.into());
                }
                at.iter()
                    .map(|&[x, y, z]| [x, cosine * y - sine * z, sine * y + cosine * z])
                    .collect()
            });
            found.play(&Trial { left_max: Some(LEFT_MAX), ..trial })?;
        }
    }
    Ok(())
}
