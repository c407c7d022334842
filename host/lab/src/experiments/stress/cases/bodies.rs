//! Bodies in states that no tool brings them to, of shapes that meshes should not have, and at rest.

use chaincell_kernel::Model;

use super::{
    TICKS, displaced, each_material, plain, press_and_disturb, pressed, the_box, touching_once,
};
use crate::bodies::shape::{cuboid, hub, spiral};
use crate::bodies::{Body, Shape};
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::Trial;
use crate::monitor::Step;
use crate::states::{POINT, State};
use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
    Case {
        name: "coincident",
        checks: "all cells in one point, with the fixed ones and without",
        run: |scale, found| put(scale, found, &[("in one point", State::Coincident(POINT))]),
    },
    Case {
        name: "flattened",
        checks: "all cells in a plane, on a line",
        run: |scale, found| {
            put(scale, found, &[("plane", State::Flattened), ("line", State::Line)])
        },
    },
    Case {
        name: "inside-out",
        checks: "mirrored at a plane, inverted through the centre",
        run: |scale, found| {
            put(scale, found, &[("mirrored", State::Mirrored), ("inverted", State::Inverted)])
        },
    },
    Case {
        name: "scattered-500",
        checks: "random positions at 500 link lengths, K at 2000; fixed point: 62, K 62.9",
        run: |scale, found| {
            scatter(scale, found, 500.0, Some(2000.0))?;
            scatter(scale, found, 62.0, Some(62.9))
        },
    },
    Case {
        name: "scattered-beyond-k",
        checks: "random positions at 500 link lengths, K at 4 half-widths: the outputs saturate",
        run: |scale, found| scatter(scale, found, 500.0, None),
    },
    Case {
        name: "needles",
        checks: "tetrahedra 1000 times longer than wide: pressed, inverted, in one point",
        run: |scale, found| disturb(scale, found, "needles", needles(scale)?),
    },
    Case {
        name: "slivers",
        checks: "tetrahedra 1000 times wider than thick: pressed, inverted, in one point",
        run: |scale, found| disturb(scale, found, "slivers", slivers(scale)?),
    },
    Case {
        name: "valence-3-to-200",
        checks: "hubs of 3, 8, 30, 100, 200 links: pressed, inverted, in one point",
        run: |scale, found| {
            [3, 8, 30, 100, 200].into_iter().try_for_each(|spokes| {
                disturb(scale, found, &format!("valence {spokes}"), hub(spokes))
            })
        },
    },
    Case {
        name: "lengths-6-decades",
        checks: "links from 1e-6 of the longest on: pressed, inverted, in one point",
        run: |scale, found| disturb(scale, found, "spiral", spiral()),
    },
    Case {
        name: "free-floating",
        checks: "nothing fixed: pressed, inverted, in one point",
        run: |scale, found| disturb(scale, found, "floating", cuboid(scale.nodes())?.floating()),
    },
    Case {
        name: "disconnected",
        checks: "two parts, one of them floating, ten widths apart: the same",
        run: |scale, found| disturb(scale, found, "two parts", cuboid(scale.nodes())?.twice()),
    },
    Case {
        name: "fully-fixed",
        checks: "nothing can move: a tool that holds no cell",
        run: |scale, found| disturb(scale, found, "fixed", cuboid(scale.nodes())?.all_fixed()),
    },
    Case {
        name: "rods",
        checks: "two rows of 3,000 cells together, in full also 64,000: an end bent by 8 links, held, \
                 let go",
        run: |scale, found| {
            rod(scale, found, 1_500)?;
            if scale.quick { Ok(()) } else { rod(scale, found, 32_000) }
        },
    },
    Case {
        name: "far-away",
        checks: "a floating box, 1e3 links from where it was baked, of links 1e5 too: pressed by 2 links, \
                 let go",
        run: |scale, found| [1e3, 1e5].into_iter().try_for_each(|way| far(scale, found, way)),
    },
    Case {
        name: "rest",
        checks: "every body untouched, then held still: force 0, level 0, not a bit moves",
        run: rest,
    },
];

/// Puts the box into states, all cells or the free ones.
fn put(scale: Scale, found: &mut Findings, states: &[(&str, State)]) -> Result<()> {
    let (body, ticks) = (the_box(scale)?, scale.ticks(TICKS));
    for &(label, state) in states {
        for all in [true, false] {
            found.play(&displaced(label, &body, state, all, ticks))?;
        }
    }
    Ok(())
}

fn scatter(scale: Scale, found: &mut Findings, by: f32, k_links: Option<f64>) -> Result<()> {
    let unit_m = f64::from(the_box(scale)?.plain()?.unit_m());
    let saturation_m = k_links.map(|k| k * unit_m);
    let options = BakeOptions { saturation_m, ..BakeOptions::default() };
    let ticks = scale.ticks(TICKS);
    for (material, body) in &each_material(&cuboid(scale.nodes())?, &options)? {
        for seed in 0..if scale.quick { 2 } else { 6 } {
            let of = move |model: &Model<'_>| State::Scattered(by).positions(model, seed);
            let label = format!("{material}, {by} links, seed {seed}");
            found.play(&Trial::new(label, body, ticks).from(of).under(touching_once(ticks)))?;
        }
    }
    Ok(())
}

fn needles(scale: Scale) -> Result<Shape> {
    Ok(cuboid(scale.nodes())?.stretched([1000.0, 1.0, 1.0]))
}

fn slivers(scale: Scale) -> Result<Shape> {
    Ok(cuboid(scale.nodes())?.stretched([1.0, 1.0, 1e-3]))
}

fn disturb(scale: Scale, found: &mut Findings, name: &str, shape: Shape) -> Result<()> {
    for (material, body) in &each_material(&shape, &BakeOptions::default())? {
        press_and_disturb(scale, found, &format!("{name}, {material}"), body)?;
    }
    Ok(())
}

/// Distance of the cells of a rod, a power of two \[m\].
const SPACING_M: f32 = 1.0 / 1024.0;

fn rod(scale: Scale, found: &mut Findings, columns: u32) -> Result<()> {
    let shape = Shape::generated(&format!("plane:{columns}x2x{SPACING_M}"))?;
    let xs = || shape.mesh.nodes_m.iter().map(|node| node[0]);
    let low = xs().fold(f64::INFINITY, f64::min);
    let near = |&(_, x): &(u32, f64)| x < low + 0.5 * f64::from(SPACING_M);
    let fixed = (0..).zip(xs()).filter(near).map(|(node, _)| node).collect();
    let last = shape.mesh.nodes_m.len() as u32 - 1;
    let body = plain(Shape { fixed, ..shape }.holding(&[last]))?;
    let free = if scale.quick { 20 } else { 40 };
    let links = 8.0 * SPACING_M / body.plain()?.unit_m();
    let bent = pressed(format!("{columns} x 2 cells"), &body, links, free)?;
    found.play(&Trial { sweeps: Some(8), ..bent })
}

/// Largest way of a body of shapes, whose images bound K [mean link lengths].
const SHAPES_FAR: f32 = 1e3;

fn far(scale: Scale, found: &mut Findings, way: f32) -> Result<()> {
    let n = scale.nodes();
    let middle = n / 2;
    let shape = Shape::generated(&format!("box:{n}x{n}x{n}x0.01"))?.floating();
    let shape = shape.holding(&[(middle * n + middle) * n + n - 1]);
    let unit_m = f64::from(plain(shape.clone())?.plain()?.unit_m());
    // K with a margin for the way.
    let saturation_m = Some(4.0 * f64::from(way) * unit_m);
    let options = BakeOptions { saturation_m, ..BakeOptions::default() };
    let moved = move |model: &Model<'_>| {
        let by = [way, -0.9 * way, 0.8 * way];
        let place = |cell| {
            let rest = model.rest_position(cell);
            [0, 1, 2].map(|axis| rest[axis] + by[axis])
        };
        (0..model.cells()).map(place).collect()
    };
    let bodies = if way > SHAPES_FAR {
        vec![("links", Body::new(shape, &options)?)]
    } else {
        each_material(&shape, &options)?
    };
    for (material, body) in &bodies {
        let label = format!("{material}, {way:e} links away");
        found.play(&pressed(label, body, 2.0, scale.ticks(TICKS))?.from(moved))?;
    }
    Ok(())
}

fn rest(scale: Scale, found: &mut Findings) -> Result<()> {
    let n = scale.nodes();
    let shapes = [
        ("box", cuboid(n)?),
        ("floating", cuboid(n)?.floating()),
        ("two parts", cuboid(n)?.twice()),
        ("fixed", cuboid(n)?.all_fixed()),
        ("needles", needles(scale)?),
        ("slivers", slivers(scale)?),
        ("valence 200", hub(200)),
        ("spiral", spiral()),
    ];
    let ticks = scale.ticks(100);
    for (name, shape) in shapes {
        let nodes = shape.mesh.nodes_m.len();
        let stiffness = (0..nodes).map(|node| libm::exp10((node % 10) as f64 - 4.5)).collect();
        let contrasts =
            BakeOptions { stiffness_n_per_m: PerCell::Each(stiffness), ..BakeOptions::default() };
        for (label, options) in [("", BakeOptions::default()), (", contrasts", contrasts)] {
            for (material, body) in &each_material(&shape, &options)? {
                let still = move |tick| Step::at([0.3, -0.2, 0.1], u32::from(tick >= ticks));
                let label = format!("{name}{label}, {material}");
                found.play(&Trial::new(label, body, 2 * ticks).under(still))?;
            }
        }
    }
    Ok(())
}
