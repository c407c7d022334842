//! Rest is rest: every body, untouched and held without motion.

use crate::bodies::Variant;
use crate::bodies::shape::{cuboid, hub, spiral};
use crate::bodies::{Body, Shape};
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::{Trial, sample};
use crate::monitor::Check;
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::Result;
use chaincell_host::interrupt;

pub const CASES: &[Case] = &[Case {
    name: "rest",
    checks: "every body untouched, then held still: force 0, level 0, not a bit moves",
    run: rest,
}];

fn rest(scale: Scale, found: &mut Findings) -> Result<()> {
    let n = scale.nodes();
    let shapes: [(&str, Shape); 8] = [
        ("box", cuboid(n)?),
        ("floating", cuboid(n)?.floating()),
        ("two parts", cuboid(n)?.twice()),
        ("fixed", cuboid(n)?.all_fixed()),
        ("needles", cuboid(n)?.stretched([1000.0, 1.0, 1.0])),
        ("slivers", cuboid(n)?.stretched([1.0, 1.0, 1e-3])),
        ("valence 200", hub(200)),
        ("spiral", spiral()),
    ];
    for (name, shape) in shapes {
        let nodes = shape.mesh.nodes_m.len();
        let stiffness = (0..nodes).map(|node| libm::exp10((node % 10) as f64 - 4.5)).collect();
        let contrast =
            BakeOptions { stiffness_n_per_m: PerCell::Each(stiffness), ..BakeOptions::default() };
        still(scale, found, name, &Body::new(shape.clone(), &BakeOptions::default())?)?;
        still(scale, found, &format!("{name}, contrasts"), &Body::new(shape, &contrast)?)?;
    }
    Ok(())
}

fn still(scale: Scale, found: &mut Findings, name: &str, body: &Body) -> Result<()> {
    let ticks = scale.ticks(100);
    for variant in Variant::all() {
        interrupt::check()?;
        let Some(model) = body.model(variant.coarse)? else { continue };
        let mut engine = match Trial::new(name, body, ticks).engine(model, variant)? {
            Ok(engine) => engine,
            Err(why) => {
                found.refuse(why);
                continue;
            }
        };
        let (before, start_m) = (engine.state_hash(), engine.positions_m());
        let place = || format!("{name}, {variant}");
        for tick in 0..2 * ticks {
            let output = engine.tick(&sample(([0.3, -0.2, 0.1], tick >= ticks)));
            let nothing = output.force_n.norm() == 0.0 && output.energy_j.to_bits() == 0;
            let same = nothing && engine.state_hash() == before;
            found.hold(same, place(), Check::Rest, || {
                format!("tick {tick}: force {}, level {:e} J", output.force_n, output.energy_j)
            });
            if !same {
                break;
            }
        }
        let now_m = engine.positions_m();
        let apart = now_m.as_flattened().iter().zip(start_m.as_flattened());
        let farthest_m = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let farthest = farthest_m / f64::from(model.unit_m());
        found.hold(farthest == 0.0, place(), Check::Rest, || format!("{farthest} links"));
        found.figure("moved_links", farthest);
        found.figure("ticks_each", f64::from(2 * ticks));
    }
    Ok(())
}
