//! Bodies in states that no tool brings them to.

use chaincell_kernel::Model;
use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::experiments::stress::body::{Body, cuboid};
use crate::experiments::stress::case::{Case, Findings, Scale};
use crate::experiments::stress::cases::touching_once;
use crate::experiments::stress::trial::Trial;
use chaincell_host::bake::BakeOptions;
use chaincell_host::error::{Error, Result};

/// A state's function.
type Place = fn([f32; 3]) -> [f32; 3];

pub const CASES: &[Case] = &[
    Case {
        name: "coincident",
        checks: "all cells in one point, with the fixed ones and without",
        run: |scale, found| put(scale, found, &[("in one point", |_| [0.25, -0.5, 0.125])]),
    },
    Case {
        name: "flattened",
        checks: "all cells in a plane, on a line",
        run: |scale, found| {
            let plane: Place = |[x, y, _]| [x, y, 0.0];
            put(scale, found, &[("plane", plane), ("line", |[x, ..]| [x, 0.0, 0.0])])
        },
    },
    Case {
        name: "inside-out",
        checks: "mirrored at a plane, inverted through the centre",
        run: |scale, found| {
            let mirrored: Place = |[x, y, z]| [-x, y, z];
            put(scale, found, &[("mirrored", mirrored), ("inverted", |p| p.map(|x| -x))])
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
fn put(scale: Scale, found: &mut Findings, states: &[(&str, Place)]) -> Result<()> {
    let body = Body::new(cuboid(scale.nodes())?, &BakeOptions::default())?;
    let ticks = scale.ticks(TICKS);
    for &(label, place) in states {
        for keeps_fixed in [false, true] {
            let which = if keeps_fixed { "free cells" } else { "all cells" };
            let of = move |model: &Model<'_>, cell: usize| {
                let rest = model.rest_position(cell);
                let stays = keeps_fixed && model.is_fixed(cell as u16);
                if stays { rest } else { place(rest) }
            };
            let trial = Trial::new(format!("{label}, {which}"), &body, ticks);
            found.play(&trial.from(of).under(touching_once(ticks)))?;
        }
    }
    Ok(())
}

/// Random places of as many cells as asked for, `by` link lengths around the centre along each
/// axis.
///
/// # Errors
/// None for a finite positive `by`.
pub fn places(seed: u64, count: usize, by: f32) -> Result<Vec<[f32; 3]>> {
    let mut random = Pcg64::seed_from_u64(seed);
    let along = Uniform::new_inclusive(-by, by).map_err(Error::check)?;
    Ok((0..count).map(|_| [0, 1, 2].map(|_| along.sample(&mut random))).collect())
}

fn scatter(scale: Scale, found: &mut Findings, by: f32, k_links: Option<f64>) -> Result<()> {
    let shape = cuboid(scale.nodes())?;
    let unit_m = f64::from(Body::new(shape.clone(), &BakeOptions::default())?.plain()?.unit_m());
    let saturation_m = k_links.map(|k| k * unit_m);
    let body = Body::new(shape, &BakeOptions { saturation_m, ..BakeOptions::default() })?;
    let ticks = scale.ticks(TICKS);
    for seed in 0..if scale.quick { 2 } else { 6 } {
        let places = places(seed, body.plain()?.cells(), by)?;
        let of = move |_: &Model<'_>, cell: usize| places[cell];
        let trial = Trial::new(format!("{by} links, seed {seed}"), &body, ticks);
        found.play(&trial.from(of).under(touching_once(ticks)))?;
    }
    Ok(())
}
