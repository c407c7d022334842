//! The model's own error: its exact equilibrium against finite elements.

mod body;
mod write;

use std::path::Path;
use std::time::Instant;

use serde::Serialize;

use crate::reference::nodal::{BAND_FROM, Law, Volume};
use crate::reference::vectors::{distance, dot, fields, minus, norm, plus, size};
use crate::reference::{Elastic, Held, Links, Nodal, minimum};
use body::{Body, Case, Data, Press, YOUNG_PA};
use chaincell_host::error::{Error, Result};
pub use write::{CSV, PICTURE, bars, charts, markdown};

/// Largest residual of a free node, in Young's modulus times a link length times the depth.
const TOLERANCE: f64 = 1e-10;
/// Largest residual of all free nodes together over that of the held ones.
const RESIDUAL_MAX: f64 = 1e-8;

const fn case(mesh: &'static str, poisson_percent: u8, data: Data) -> Case {
    Case { mesh, poisson_percent, data }
}

/// The bodies, those of few nodes first.
const CASES: [Case; 8] = [
    case("liver_181", 30, Data::SmallRing),
    case("liver_181", 45, Data::SmallRing),
    case("liver_500", 30, Data::SmallRing),
    case("liver_500", 45, Data::SmallRing),
    case("box_uns", 30, Data::Large),
    case("box_uns", 45, Data::Small),
    case("liver_5762", 30, Data::Large),
    case("liver_5762", 45, Data::Large),
];
/// Bodies of the quick form.
const QUICK: usize = 4;

/// What is compared with quadratic elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Model {
    /// Links of one stiffness.
    EvenLinks,
    /// Links by the volume around them.
    VolumeLinks,
    /// Linear tetrahedra, as the data have them.
    Linear,
    Nodal(Volume, bool),
}

const MODELS: [Model; 7] = [
    Model::EvenLinks,
    Model::VolumeLinks,
    Model::Linear,
    Model::Nodal(Volume::Det1, false),
    Model::Nodal(Volume::Det1, true),
    Model::Nodal(Volume::Trace, false),
    Model::Nodal(Volume::Trace, true),
];

impl Model {
    const fn words(self) -> &'static str {
        match self {
            Self::EvenLinks => "links, one stiffness",
            Self::VolumeLinks => "links, E sum V / l^2",
            Self::Linear => "linear tetrahedra",
            Self::Nodal(Volume::Det1, false) => "nodal, det1",
            Self::Nodal(Volume::Det1, true) => "nodal, det1, band",
            Self::Nodal(Volume::Trace, false) => "nodal, trace",
            Self::Nodal(Volume::Trace, true) => "nodal, trace, band",
        }
    }
}

/// A body at a depth under a model, against quadratic elements on the same mesh.
#[derive(Debug, Clone, Serialize)]
pub struct ModelRow {
    /// Name of the mesh.
    pub body: &'static str,
    /// Its nodes.
    pub nodes: usize,
    /// Poisson's ratio in percent.
    pub poisson_percent: u8,
    /// The elements of the reference.
    pub against: &'static str,
    /// The model.
    pub model: &'static str,
    /// Depth of the press.
    pub depth_mm: f64,
    /// Error of the displacement over the free nodes, L2 weighted by their volumes, relative.
    pub field: f64,
    /// Largest error of a node over the depth.
    pub worst: f64,
    /// Force over that of the reference.
    pub force: f64,
    /// Tetrahedra inside out.
    pub inverted: usize,
    /// The same of the reference, by the corners of its elements.
    pub inverted_reference: usize,
    /// Nodes with a stretch below the band.
    pub in_band: Option<usize>,
    /// Residual of the free nodes over that of the held ones, L2.
    pub residual: Option<f64>,
    /// Steps of Newton's method.
    pub iterations: Option<usize>,
    /// Time for the equilibrium.
    pub seconds: Option<f64>,
}

/// Equilibrium of a body at a depth.
struct Found {
    displacement_m: Vec<[f64; 3]>,
    force_n: f64,
    in_band: Option<usize>,
    residual: Option<f64>,
    iterations: Option<usize>,
    seconds: Option<f64>,
}

/// Bodies that are compared.
const fn cases(quick: bool) -> usize {
    if quick { QUICK } else { CASES.len() }
}

/// Pieces of work.
#[must_use]
pub const fn pieces(quick: bool) -> usize {
    cases(quick) * MODELS.len()
}

/// Every body with every model; `after` is called behind each piece.
///
/// # Errors
/// Reference data that cannot be read; an equilibrium that was not reached; what `after` says.
pub fn run(
    reference: &Path,
    quick: bool,
    mut after: impl FnMut() -> Result<()>,
) -> Result<Vec<ModelRow>> {
    let mut rows = Vec::new();
    for &case in CASES.iter().take(cases(quick)) {
        let body = Body::read(reference, case)?;
        let weights = weights(&body)?;
        for model in MODELS {
            for (press, found) in body.quadratic.iter().zip(follow(&body, model)?) {
                rows.push(row(&body, &weights, model, press, &found)?);
            }
            after()?;
        }
    }
    Ok(rows)
}

/// Volumes of the free nodes, zero for the others.
fn weights(body: &Body) -> Result<Vec<f64>> {
    let nodal = nodal(body, Volume::Det1, false)?;
    let held: Vec<_> = body.pressed.iter().map(|&node| (node, [0.0; 3])).collect();
    let volume = |(i, free): (usize, bool)| if free { nodal.shape().volume_m3(i) } else { 0.0 };
    Ok(nodal.free(&held).into_iter().enumerate().map(volume).collect())
}

fn nodal(body: &Body, volume: Volume, band: bool) -> Result<Nodal> {
    let law = Law { young_pa: YOUNG_PA, poisson: body.case.poisson(), volume, band };
    Nodal::new(&body.rest_m, &body.tetrahedra, &body.fixed, law)
}

/// The equilibria of a model from depth to depth.
fn follow(body: &Body, model: Model) -> Result<Vec<Found>> {
    match model {
        Model::Linear => Ok(body.linear.iter().map(given).collect()),
        Model::EvenLinks | Model::VolumeLinks => {
            let all = body.links();
            let (ends, volumes): (Vec<_>, Vec<_>) = all.into_iter().unzip();
            let links = Links::from_edges(&body.rest_m, &ends, 0.0, &body.fixed)?;
            // One stiffness with the same mean modulus: the same sum of k l^2.
            let squares = links.rest_lengths().iter().map(|l| l * l);
            let even = squares.clone().zip(&volumes).map(|(l, v)| l * v).sum::<f64>()
                / squares.sum::<f64>();
            let mean = match model {
                Model::EvenLinks => even,
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

fn row(
    body: &Body,
    weights: &[f64],
    model: Model,
    press: &Press,
    found: &Found,
) -> Result<ModelRow> {
    let scaled = |field: &[[f64; 3]]| -> Vec<[f64; 3]> {
        field.iter().zip(weights).map(|(u, w)| u.map(|u| w.sqrt() * u)).collect()
    };
    let exact = scaled(&press.displacement_m);
    let offs = found.displacement_m.iter().zip(&press.displacement_m).zip(weights);
    let offs = offs.filter(|(_, w)| **w > 0.0).map(|((u, exact), _)| norm(minus(*u, *exact)));
    let at = |u: &[[f64; 3]]| fields(&body.rest_m, 1.0, u);
    Ok(ModelRow {
        body: body.case.mesh,
        nodes: body.rest_m.len(),
        poisson_percent: body.case.poisson_percent,
        against: body.case.data.words(),
        model: model.words(),
        depth_mm: 1e3 * press.depth_m,
        field: distance(&scaled(&found.displacement_m), &exact) / size(&exact),
        worst: offs.fold(0.0, f64::max) / press.depth_m,
        force: found.force_n / press.force_n,
        inverted: body.inverted(&at(&found.displacement_m)),
        inverted_reference: body.inverted(&at(&press.displacement_m)),
        in_band: found.in_band,
        residual: found.residual,
        iterations: found.iterations,
        seconds: found.seconds,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_small_bodies_keep_their_bars() {
        let Some(folder) = std::env::var_os("CHAINCELL_REFERENCE") else {
            println!("SKIPPED: CHAINCELL_REFERENCE names no folder of reference data");
            return;
        };
        let mut done = 0;
        let rows = run(Path::new(&folder), true, || {
            done += 1;
            Ok(())
        });
        let rows = rows.unwrap();
        assert_eq!(done, pieces(true));
        let judged = bars(&rows);
        assert_eq!(judged.len(), 2);
        for bar in &judged {
            assert!(bar.holds(), "{bar:?}");
        }
        // Links know no Poisson's ratio but 1/4, so they are farther off at 0.45 than at 0.3.
        let field = |poisson_percent: u8, model: Model| {
            let is = |row: &&ModelRow| {
                (row.body, row.poisson_percent, row.model)
                    == ("liver_500", poisson_percent, model.words())
            };
            rows.iter().find(is).unwrap().field
        };
        let nodal = Model::Nodal(Volume::Det1, true);
        assert!(field(45, Model::VolumeLinks) > 1.2 * field(30, Model::VolumeLinks));
        assert!(field(45, nodal) < 0.5 * field(45, Model::VolumeLinks));
        let text = markdown(&rows, "");
        assert!(text.contains("| nodal, det1, band |") && text.contains("nu 0.45"), "{text}");
    }

    #[test]
    fn without_reference_data_the_section_says_so() {
        assert!(markdown(&[], "").contains("SKIPPED"));
        assert!(charts(&[]).is_empty() && bars(&[]).is_empty());
    }
}
