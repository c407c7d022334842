//! The kernel's number types under the same press: what they cost, and how far fixed point is from
//! single precision.

use nalgebra::Vector3;
use serde::Serialize;

use super::exact::{DEPTH_LINKS, depth};
use super::press::{field, sample};
use super::scene::Scene;
use super::setting::Setting;
use crate::bodies::Variant;
use crate::reference::vectors::farthest;
use chaincell_host::choice;
use chaincell_host::engine::{Arithmetic, Contact, Scheme};
use chaincell_host::error::Result;
use chaincell_host::session::timing::histogram::Latencies;

/// Sweeps a tick.
const SWEEPS: u16 = 4;
/// Ticks of press and hold together.
pub const TICKS: usize = 2000;

/// A number type under a scheme.
#[derive(Debug, Clone, Serialize)]
pub struct NumberRow {
    /// Name of the scene.
    pub scene: &'static str,
    /// Scheme; without hats, which only single precision has.
    #[serde(serialize_with = "choice::serialize")]
    pub scheme: Scheme,
    /// Number type.
    #[serde(serialize_with = "choice::serialize")]
    pub number: Arithmetic,
    /// Sweeps a tick: link passes.
    pub sweeps: u16,
    /// Ticks.
    pub ticks: usize,
    /// Median tick \[ns\].
    pub tick_ns_p50: u64,
    /// Largest distance of a cell from single precision after the last tick, over the depth.
    pub field: f64,
    /// Difference of the force after the last tick, over the largest force.
    pub force: f64,
    /// The same at most from tick to tick.
    pub force_max: f64,
}

/// A press through an engine.
struct Press {
    field: Vec<[f64; 3]>,
    forces: Vec<Vector3<f64>>,
    tick_ns_p50: u64,
}

fn press(scene: &Scene, scheme: Scheme, numbers: Arithmetic) -> Result<Press> {
    let model = scene.model_for(Setting { scheme, hats: false })?;
    let contact = Contact::Cells(scene.contacts.clone());
    let variant = Variant::plain(scheme, numbers);
    let mut engine = variant.unlimited(model, contact, SWEEPS, |settings| settings)?;
    let (mut forces, mut times) = (Vec::with_capacity(TICKS), Latencies::new()?);
    for tick in 0..TICKS {
        let sample = sample(scene, model.unit_m(), depth(tick));
        let output = times.time(|| engine.tick(&sample));
        forces.push(output.force_n.map(f64::from));
    }
    Ok(Press { field: field(&mut engine), forces, tick_ns_p50: times.summary().p50 })
}

/// Every number type under `euler` and `track`.
///
/// # Errors
/// As the engine.
pub fn run(scene: &Scene) -> Result<Vec<NumberRow>> {
    let mut rows = Vec::new();
    for scheme in [Scheme::Euler, Scheme::Track] {
        let single = press(scene, scheme, Arithmetic::F32)?;
        let largest = single.forces.iter().map(|force| force.norm()).fold(0.0, f64::max);
        for number in [Arithmetic::F32, Arithmetic::Fixed] {
            let press = press(scene, scheme, number)?;
            let forces = press.forces.iter().zip(&single.forces);
            let off: Vec<f64> = forces.map(|(a, b)| (a - b).norm() / largest).collect();
            rows.push(NumberRow {
                scene: scene.name,
                scheme,
                number,
                sweeps: SWEEPS,
                ticks: TICKS,
                tick_ns_p50: press.tick_ns_p50,
                field: farthest(&press.field, &single.field) / DEPTH_LINKS,
                force: off.last().copied().unwrap_or_default(),
                force_max: off.iter().copied().fold(0.0, f64::max),
            });
        }
    }
    Ok(rows)
}
