//! Bands and stiffness at the ends of their ranges.

use chaincell_kernel::Unloading;

use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::cases::elements::press_and_disturb;
use crate::experiments::stress::cases::{PRESS_TICKS, pressing};
use crate::experiments::stress::trial::Trial;
use crate::monitor::Check;
use crate::states::scattered;
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "alpha-0",
        checks: "no slack: pressed, inverted, in one point; released, track leaves under 1e-3 E",
        run: |scale, found| {
            slack(scale, found, 0.0)?;
            let body = Body::new(cuboid(scale.nodes())?, &BakeOptions::default())?;
            release(scale, found, &body)
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
];

/// Presses a body by a link and lets it go.
fn release(scale: Scale, found: &mut Findings, body: &Body) -> Result<()> {
    let depth_m = body.plain()?.unit_m();
    let ticks = PRESS_TICKS + scale.ticks(120);
    let trial = Trial::new("released", body, ticks).under(pressing(depth_m));
    found.play(&Trial { left_max: Some(1e-3), ..trial })
}

fn slack(scale: Scale, found: &mut Findings, alpha: f64) -> Result<()> {
    let options = BakeOptions { alpha: PerCell::Uniform(alpha), ..BakeOptions::default() };
    let body = Body::new(cuboid(scale.nodes())?, &options)?;
    press_and_disturb(scale, found, &format!("alpha {alpha}"), &body)?;
    let depth_m = 2.5 * body.plain()?.unit_m();
    let ticks = PRESS_TICKS + scale.ticks(60);
    for unloading in [Unloading::Release, Unloading::Retreat] {
        let trial = Trial::new(format!("alpha {alpha}, {unloading:?}"), &body, ticks);
        found.play(&Trial { unloading, ..trial.under(pressing(depth_m)) })?;
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
    let each = |up: f64| -> Vec<f64> {
        (0..nodes).map(|node| 20.0 * libm::exp10(up * decades(node, jitter[node][0]))).collect()
    };
    for (label, up) in [("stiff on soft", 1.0), ("soft on stiff", -1.0)] {
        let body = of_stiffness(scale, &each(up))?;
        press_and_disturb(scale, found, label, &body)?;
    }
    Ok(())
}

/// Bounds of 2 k u and 2 k u^2 in the image's units.
const UNITS: [f64; 2] = [1e-17, 1e17];

fn ends(scale: Scale, found: &mut Findings) -> Result<()> {
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
