//! The range of the state: K reached and left.

use chaincell_kernel::Model;

use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::trial::Trial;
use crate::monitor::Check;
use chaincell_host::bake::BakeOptions;
use chaincell_host::error::Result;

pub const CASES: &[Case] = &[Case {
    name: "k-reached-and-left",
    checks: "held cell out to 3 K and back, then let go; body thrown to 3 K",
    run: reach,
}];

/// Enough for a tool to stretch a body to K \[J\].
const ENERGY_MAX_J: f64 = 1e6;

fn reach(scale: Scale, found: &mut Findings) -> Result<()> {
    let shape = cuboid(scale.nodes())?;
    let options = BakeOptions { energy_max_j: Some(ENERGY_MAX_J), ..BakeOptions::default() };
    let body = Body::new(shape, &options)?;
    let model = body.plain()?;
    let (unit_m, k) = (model.unit_m(), model.saturation());
    let far_m = 3.0 * k * unit_m;
    let out = scale.ticks(60);
    let way = [0.6_f32, -0.5, 0.62];
    let trial = Trial::new("held cell", &body, 3 * out).under(move |tick| {
        let part = out.abs_diff(tick.min(2 * out)) as f32 / out as f32;
        (way.map(|x| x * far_m * (1.0 - part)), tick < 2 * out)
    });
    found.play(&Trial { leaps: true, ..trial })?;
    found.hold(found.worst.coordinate_over_k >= 1.0, "held cell", Check::Range, || {
        "K was not reached".to_owned()
    });
    let thrown = move |model: &Model<'_>| {
        let place = |cell: usize| {
            let rest = model.rest_position(cell);
            let by = if model.is_fixed(cell as u16) { 0.0 } else { 3.0 * k };
            [0, 1, 2].map(|axis| rest[axis] + by * way[axis])
        };
        (0..model.cells()).map(place).collect()
    };
    found.play(&Trial::new("thrown", &body, scale.ticks(120)).from(thrown))
}
