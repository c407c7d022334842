//! Positions so large that their own rounding is felt: long bodies, and bodies far away.

use chaincell_kernel::Model;

use crate::bodies::{Body, Shape};
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::cases::{PRESS_TICKS, pressing};
use crate::experiments::stress::trial::Trial;
use chaincell_host::bake::BakeOptions;
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[
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
        checks: "a floating box, 1e3 and 1e5 links from where it was baked: pressed by 2 links, let go",
        run: |scale, found| [1e3, 1e5].into_iter().try_for_each(|way| far(scale, found, way)),
    },
];

/// Distance of the cells of a rod, a power of two \[m\].
const SPACING_M: f32 = 1.0 / 1024.0;

fn rod(scale: Scale, found: &mut Findings, columns: u32) -> Result<()> {
    let shape = Shape::generated(&format!("plane:{columns}x2x{SPACING_M}"))?;
    let xs = || shape.mesh.nodes_m.iter().map(|node| node[0]);
    let low = xs().fold(f64::INFINITY, f64::min);
    let near = |&(_, x): &(u32, f64)| x < low + 0.5 * f64::from(SPACING_M);
    let fixed = (0..).zip(xs()).filter(near).map(|(node, _)| node).collect();
    let last = shape.mesh.nodes_m.len() as u32 - 1;
    let body = Body::new(Shape { fixed, ..shape }.holding(&[last]), &BakeOptions::default())?;
    let ticks = PRESS_TICKS + if scale.quick { 20 } else { 40 };
    let bent = Trial::new(format!("{columns} x 2 cells"), &body, ticks);
    let bent = bent.under(pressing(8.0 * SPACING_M));
    found.play(&Trial { sweeps: Some(8), ..bent })
}

/// Room for the way, of K [mean link lengths].
const FAR: f64 = 4e5;

fn far(scale: Scale, found: &mut Findings, way: f32) -> Result<()> {
    let n = scale.nodes();
    let middle = n / 2;
    let shape = Shape::generated(&format!("box:{n}x{n}x{n}x0.01"))?.floating();
    let shape = shape.holding(&[(middle * n + middle) * n + n - 1]);
    let unit_m = f64::from(Body::new(shape.clone(), &BakeOptions::default())?.plain()?.unit_m());
    let options = BakeOptions { saturation_m: Some(FAR * unit_m), ..BakeOptions::default() };
    let body = Body::new(shape, &options)?;
    let displaced = move |model: &Model<'_>| {
        let by = [way, -0.9 * way, 0.8 * way];
        let place = |cell| {
            let rest = model.rest_position(cell);
            [0, 1, 2].map(|axis| rest[axis] + by[axis])
        };
        (0..model.cells()).map(place).collect()
    };
    let ticks = PRESS_TICKS + scale.ticks(60);
    let pressed = Trial::new(format!("{way:e} links away"), &body, ticks).from(displaced);
    let pressed = pressed.under(pressing(2.0 * unit_m as f32));
    found.play(&pressed)
}
