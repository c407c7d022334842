//! Equilibria of the models under the presses of a body.

use std::time::Instant;

use super::Model;
use super::body::{Body, Press, YOUNG_PA};
use crate::reference::nodal::{BAND_FROM, Law, Volume};
use crate::reference::vectors::{dot, fields, plus, size};
use crate::reference::{Elastic, Held, Links, Nodal, minimum};
use chaincell_host::error::{Error, Result};

/// Largest residual of a free node, in Young's modulus times a link length times the depth.
const TOLERANCE: f64 = 1e-10;
/// Largest residual of all free nodes together over that of the held ones.
const RESIDUAL_MAX: f64 = 1e-8;

/// The equilibrium of a body at a depth; none of the figures of a search where it was given.
pub(super) struct Found {
    pub displacement_m: Vec<[f64; 3]>,
    pub force_n: f64,
    pub in_band: Option<usize>,
    pub residual: Option<f64>,
    pub iterations: Option<usize>,
    pub seconds: Option<f64>,
}

/// The nodal tissue of a body.
pub(super) fn nodal(body: &Body, volume: Volume, band: bool) -> Result<Nodal> {
    let law = Law { young_pa: YOUNG_PA, poisson: body.case.poisson(), volume, band };
    Nodal::new(&body.rest_m, &body.tetrahedra, &body.fixed, law)
}

/// The equilibria of a model from depth to depth.
pub(super) fn follow(body: &Body, model: Model) -> Result<Vec<Found>> {
    match model {
        Model::Linear => Ok(body.linear.iter().map(given).collect()),
        Model::EvenLinks | Model::VolumeLinks => {
            let all = body.links();
            let (ends, volumes): (Vec<_>, Vec<_>) = all.into_iter().unzip();
            let links = Links::from_edges(&body.rest_m, &ends, 0.0, &body.fixed)?;
            let mean = match model {
                Model::EvenLinks => body.even_stiffness_n_per_m() / YOUNG_PA,
                _ => volumes.iter().sum::<f64>() / volumes.len() as f64,
            };
            let links = match model {
                Model::EvenLinks => links,
                _ => links.with_weights(volumes.iter().map(|v| v / mean).collect())?,
            };
            // The residual of a link is half its excess.
            steps(body, &links, 2.0 * YOUNG_PA * mean, |_| None)
        }
        Model::Nodal(volume, band) => {
            let nodal = nodal(body, volume, band)?;
            let least = |at: &[[f64; 3]]| {
                nodal.stretches(at).iter().filter(|stretches| stretches[2] < BAND_FROM).count()
            };
            steps(body, &nodal, 1.0, |at| Some(least(at)))
        }
    }
}

/// What the data give.
fn given(press: &Press) -> Found {
    Found {
        displacement_m: press.displacement_m.clone(),
        force_n: press.force_n,
        in_band: None,
        residual: None,
        iterations: None,
        seconds: None,
    }
}

/// Equilibria of a body whose residual is in units of `unit_n`, each started from the one before,
/// scaled to its depth.
fn steps<E: Elastic>(
    body: &Body,
    elastic: &E,
    unit_n: f64,
    in_band: impl Fn(&[[f64; 3]]) -> Option<usize>,
) -> Result<Vec<Found>> {
    let mut found: Vec<Found> = Vec::new();
    let (mut u, mut before_m) = (vec![[0.0; 3]; body.rest_m.len()], 1.0);
    for &Press { depth_m, .. } in &body.quadratic {
        let start = fields(&body.rest_m, depth_m / before_m, &u);
        let place = |&i: &usize| (i, plus(body.rest_m[i], depth_m, body.direction));
        let held: Vec<_> = body.pressed.iter().map(place).collect();
        let tolerance = TOLERANCE * elastic.residual_unit() * depth_m / elastic.length_unit();
        let begun = Instant::now();
        let end = minimum(elastic, &held, &start, tolerance);
        let seconds = begun.elapsed().as_secs_f64();
        let residual = residual(elastic, &held, &end.positions);
        if residual.is_nan() || residual > RESIDUAL_MAX {
            return Err(Error::check(format!(
                "{} pressed by {depth_m} m: the equilibrium has a relative residual of \
                 {residual:e}",
                body.case.mesh
            )));
        }
        (u, before_m) = (fields(&end.positions, -1.0, &body.rest_m), depth_m);
        let force = elastic.force(&end.positions, &body.pressed);
        found.push(Found {
            displacement_m: u.clone(),
            force_n: -unit_n * dot(force, body.direction),
            in_band: in_band(&end.positions),
            residual: Some(residual),
            iterations: Some(end.iterations),
            seconds: Some(seconds),
        });
    }
    Ok(found)
}

/// Residual of the free nodes over that of the others, L2.
fn residual<E: Elastic>(elastic: &E, held: &Held, positions: &[[f64; 3]]) -> f64 {
    let (mut free, mut all) = (elastic.free(held).into_iter(), vec![[0.0; 3]; positions.len()]);
    elastic.residual(positions, &mut all);
    let (free, held): (Vec<_>, Vec<_>) = all.into_iter().partition(|_| free.next() == Some(true));
    size(&free) / size(&held)
}
