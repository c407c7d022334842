//! Bodies in states that no tool brings them to.

use chaincell_kernel::Model;

use crate::bodies::Body;
use crate::bodies::shape::cuboid;
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::cases::touching_once;
use crate::experiments::stress::trial::Trial;
use crate::states::{POINT, State};
use chaincell_host::bake::BakeOptions;
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
];

/// Ticks after a state.
const TICKS: u32 = 60;

/// Puts the box into states, all cells or the free ones.
fn put(scale: Scale, found: &mut Findings, states: &[(&str, State)]) -> Result<()> {
    let body = Body::new(cuboid(scale.nodes())?, &BakeOptions::default())?;
    let ticks = scale.ticks(TICKS);
    for &(label, state) in states {
        let all = Trial::new(format!("{label}, all cells"), &body, ticks);
        let all = all.from(move |model| state.positions(model, 0));
        let free = Trial::new(format!("{label}, free cells"), &body, ticks);
        let free = free.from(move |model| state.of_free_cells(model, 0));
        for trial in [all, free] {
            found.play(&trial.under(touching_once(ticks)))?;
        }
    }
    Ok(())
}

fn scatter(scale: Scale, found: &mut Findings, by: f32, k_links: Option<f64>) -> Result<()> {
    let shape = cuboid(scale.nodes())?;
    let unit_m = f64::from(Body::new(shape.clone(), &BakeOptions::default())?.plain()?.unit_m());
    let saturation_m = k_links.map(|k| k * unit_m);
    let body = Body::new(shape, &BakeOptions { saturation_m, ..BakeOptions::default() })?;
    let ticks = scale.ticks(TICKS);
    for seed in 0..if scale.quick { 2 } else { 6 } {
        let of = move |model: &Model<'_>| State::Scattered(by).positions(model, seed);
        let trial = Trial::new(format!("{by} links, seed {seed}"), &body, ticks);
        found.play(&trial.from(of).under(touching_once(ticks)))?;
    }
    Ok(())
}
