//! Bands, stiffness and nodal shapes at the ends of their ranges.

use chaincell_kernel::{Model, Unloading};

use super::{TICKS, displaced, press_and_disturb, pressed, the_box};
use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::Trial;
use crate::monitor::{Check, Step};
use crate::states::{POINT, State, scattered};
use chaincell_host::bake::tissue::{Band, STRETCH_MIN, Tissue};
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "alpha-0",
        checks: "no slack: pressed, inverted, in one point; released, track leaves under 1e-3 E",
        run: |scale, found| {
            slack(scale, found, 0.0)?;
            release(scale, found, &the_box(scale)?)
        },
    },
    Case {
        name: "alpha-0.99",
        checks: "nearly all slack: the same; released, the bands close",
        run: |scale, found| slack(scale, found, 0.99),
    },
    Case {
        name: "stiff-body",
        checks: "20 kN/m, pressed by a link; released, track leaves under 1e-3 E",
        run: |scale, found| release(scale, found, &of_stiffness(scale, &[2e4])?),
    },
    Case {
        name: "stiffness-9-decades",
        checks: "nodes of 10^-4.5 to 10^4.5 times 20 N/m mixed: pressed, inverted, in one point",
        run: nine_decades,
    },
    Case {
        name: "ends-of-the-formats",
        checks: "softest and stiffest body that the image takes, half as soft and twice as stiff \
                 refused; widest contrast of fixed point, twice that refused",
        run: ends,
    },
    Case {
        name: "shapes-in-states",
        checks: "nodal shapes with the band of stretches and without, nu 0.3 and 0.49: in one point, \
                 flat, on a line, inside out, scattered",
        run: shapes_in_states,
    },
    Case {
        name: "shapes-pressed",
        checks: "the same pressed by 0.9 of the box and let go, and torn about by leaps of four links",
        run: shapes_pressed,
    },
    Case {
        name: "shapes-turned",
        checks: "the same turned by a quarter and shaken: track leaves under 2e-3 E, as in a body that \
                 was not turned",
        run: shapes_turned,
    },
];

/// Presses a body by a link and lets it go.
fn release(scale: Scale, found: &mut Findings, body: &Body) -> Result<()> {
    let trial = pressed("released", body, 1.0, scale.ticks(120))?;
    found.play(&Trial { left_max: Some(1e-3), ..trial })
}

fn slack(scale: Scale, found: &mut Findings, alpha: f64) -> Result<()> {
    let options = BakeOptions { alpha: PerCell::Uniform(alpha), ..BakeOptions::default() };
    let body = Body::new(cuboid(scale.nodes())?, &options)?;
    press_and_disturb(scale, found, &format!("alpha {alpha}"), &body)?;
    for unloading in [Unloading::Release, Unloading::Retreat] {
        let label = format!("alpha {alpha}, {unloading:?}");
        let trial = pressed(label, &body, 2.5, scale.ticks(TICKS))?;
        found.play(&Trial { unloading, ..trial })?;
    }
    Ok(())
}

/// A box whose nodes have these stiffnesses, the first node the first, in turn.
fn of_stiffness(scale: Scale, n_per_m: &[f64]) -> Result<Body> {
    let shape = cuboid(scale.nodes())?;
    let each = n_per_m.iter().copied().cycle().take(shape.mesh.nodes_m.len()).collect();
    let stiffness_n_per_m = PerCell::Each(each);
    Body::new(shape, &BakeOptions { stiffness_n_per_m, ..BakeOptions::default() })
}

fn nine_decades(scale: Scale, found: &mut Findings) -> Result<()> {
    let nodes = scale.nodes().pow(3) as usize;
    // A link has the mean of its ends: soft links need soft neighbours, so layers differ most.
    let layer = |node: usize| (node % scale.nodes() as usize) as f64 / f64::from(scale.nodes() - 1);
    let decades = |node: usize, jitter: f32| 9.0 * layer(node) - 4.5 + f64::from(jitter);
    let jitter = scattered(9, nodes, 0.5);
    for (label, up) in [("stiff on soft", 1.0), ("soft on stiff", -1.0)] {
        let of = |node: usize| 20.0 * libm::exp10(up * decades(node, jitter[node][0]));
        let each: Vec<f64> = (0..nodes).map(of).collect();
        press_and_disturb(scale, found, label, &of_stiffness(scale, &each)?)?;
    }
    Ok(())
}

/// Bounds of 2 k u and 2 k u^2 in the image's units.
const UNITS: [f64; 2] = [1e-17, 1e17];

fn ends(scale: Scale, found: &mut Findings) -> Result<()> {
    // The softest and the stiffest body.
    let body = of_stiffness(scale, &[1.0])?;
    let unit_m = f64::from(body.plain()?.unit_m());
    let softest = 1.001 * UNITS[0] / (2.0 * unit_m * unit_m);
    let stiffest = 0.999 * UNITS[1] / (2.0 * unit_m);
    found.figure("stiffness_min_n_per_m", softest);
    found.figure("stiffness_max_n_per_m", stiffest);
    for (label, n_per_m, beyond) in
        [("softest", softest, 0.5 * softest), ("stiffest", stiffest, 2.0 * stiffest)]
    {
        press_and_disturb(scale, found, label, &of_stiffness(scale, &[n_per_m])?)?;
        let taken = of_stiffness(scale, &[beyond]).is_ok();
        found.hold(!taken, label, Check::Admission, || format!("{beyond:e} N/m is taken"));
    }
    // Layers of soft nodes among stiff ones: the softest link over the mean is 1/64 at least.
    let contrast = |soft: f64| {
        let layers: Vec<f64> =
            (0..scale.nodes()).map(|at| if at < 2 { soft } else { 20.0 }).collect();
        of_stiffness(scale, &layers)
    };
    let weight = |soft: f64| -> Result<f64> {
        let body = contrast(soft)?;
        let model = body.plain()?;
        let weights = (0..model.links()).map(|link| f64::from(model.link_weight(link)));
        Ok(weights.fold(f64::INFINITY, f64::min))
    };
    let (mut low, mut high) = (1e-3, 20.0);
    for _ in 0..14 {
        let middle = 0.5 * (low + high);
        if weight(middle)? < 1.0 / 64.0 { low = middle } else { high = middle }
    }
    found.figure("fixed_weight_min", weight(high)?);
    press_and_disturb(scale, found, "widest contrast of fixed point", &contrast(high)?)?;
    let refused = found.refused.len();
    press_and_disturb(scale, found, "twice that contrast", &contrast(0.5 * high)?)?;
    let says = found.refused.len() > refused;
    found.hold(says, "twice that contrast", Check::Admission, || "is taken".to_owned());
    Ok(())
}

/// Part of the energy that `track` may leave of a body that was turned and shaken.
const LEFT_MAX: f64 = 2e-3;
/// Ticks after a state of shapes in the quick suite.
const SHAPE_TICKS: u32 = 40;

/// Two sets of bands that stiffen a body.
pub fn stiffening() -> Vec<Band> {
    vec![Band::new(0.05, 12_000.0), Band::new(0.2, 70_000.0)]
}

/// Boxes of nodal shapes.
fn shapes(scale: Scale) -> Result<Vec<(String, Body)>> {
    let kinds = [
        (Some(STRETCH_MIN), 0.49, false),
        (Some(STRETCH_MIN), 0.3, false),
        (None, 0.49, false),
        (Some(STRETCH_MIN), 0.45, true),
    ];
    let body = |(stretch_min, poisson, stiff): (Option<f64>, f64, bool)| -> Result<_> {
        let of = PerCell::Uniform;
        let stiffening = if stiff { stiffening() } else { Vec::new() };
        let tissue = Tissue { stretch_min, stiffening, ..Tissue::new(of(5000.0), of(poisson)) };
        let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
        let band = if stretch_min.is_some() { "band" } else { "no band" };
        let stiff = if stiff { ", stiffened" } else { "" };
        let label = format!("{band}{stiff}, nu {poisson}");
        Ok((label, Body::new(cuboid(scale.nodes())?, &options)?))
    };
    kinds.into_iter().map(body).collect()
}

fn shapes_in_states(scale: Scale, found: &mut Findings) -> Result<()> {
    let ticks = scale.ticks(SHAPE_TICKS);
    for (label, body) in &shapes(scale)? {
        for (name, state) in [
            ("in one point", State::Coincident(POINT)),
            ("flat", State::Flattened),
            ("on a line", State::Line),
            ("mirrored", State::Mirrored),
            ("inside out", State::Inverted),
            ("shaken", State::Shaken),
            ("scattered", State::Scattered(20.0)),
        ] {
            for all in [false, true] {
                found.play(&displaced(&format!("{label}, {name}"), body, state, all, ticks))?;
            }
        }
    }
    Ok(())
}

fn shapes_pressed(scale: Scale, found: &mut Findings) -> Result<()> {
    for (label, body) in &shapes(scale)? {
        let unit_m = body.plain()?.unit_m();
        let links = 0.9 * 0.01 * (scale.nodes() - 1) as f32 / unit_m;
        found.play(&pressed(format!("{label}, pressed"), body, links, scale.ticks(TICKS))?)?;
        let by = 4.0 * unit_m;
        let trial = Trial::new(format!("{label}, torn about"), body, scale.ticks(SHAPE_TICKS));
        let trial = trial.under(move |tick| {
            let side = if tick % 2 == 0 { by } else { -by };
            Step::at([side, by * (tick % 3) as f32, side], 1)
        });
        found.play(&Trial { leaps: true, ..trial })?;
    }
    Ok(())
}

fn shapes_turned(scale: Scale, found: &mut Findings) -> Result<()> {
    for (label, body) in &shapes(scale)? {
        for (name, [cosine, sine]) in [("upright", [1.0, 0.0]), ("turned", [0.0, 1.0])] {
            let trial = Trial::new(format!("{label}, {name}"), body, SHAPE_TICKS);
            let trial = trial.from(move |model: &Model<'_>| {
                let shaken = State::Shaken.of_free_cells(model, 1).into_iter();
                shaken.map(|[x, y, z]| [x, cosine * y - sine * z, sine * y + cosine * z]).collect()
            });
            found.play(&Trial { left_max: Some(LEFT_MAX), ..trial })?;
        }
    }
    Ok(())
}
