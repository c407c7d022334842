//! The paper's relaxation in time: `euler` against the exact trajectory of the plane.

use chaincell_kernel::{Network, Settings, ToolSample, Unloading};
use nalgebra::Vector3;
use serde::Serialize;

use super::exact::norm;
use super::press::field;
use super::scene::Scene;
use super::setting::Setting;
use crate::engine::{Engine, Scheme};
use crate::error::{Error, Result};
use crate::reference::{Links, trajectory};

/// Moments that are compared [dimensionless time].
const MOMENTS: [f64; 3] = [1.0, 10.0, 100.0];
/// Depth of the press, from t = 0 on \[m\].
const DEPTH_M: f64 = 0.05;
/// What a step of the reference may add to its error [mean link lengths].
const TOLERANCE: f64 = 1e-10;

/// A step size on a plane.
#[derive(Debug, Clone, Serialize)]
pub struct FlowRow {
    /// Name of the scene.
    pub scene: &'static str,
    /// Scheme.
    pub scheme: Setting,
    /// Step [dimensionless time].
    pub step: f64,
    /// Moment [dimensionless time].
    pub t: f64,
    /// Link passes until then.
    pub passes: usize,
    /// Largest distance of a cell from the exact trajectory, as a fraction of the depth.
    pub error: f64,
}

/// Runs steps of several sizes over a plane whose centre is held 50 mm below from t = 0 on.
///
/// # Errors
/// As the engine.
pub fn run(scene: &Scene, steps: &[f64]) -> Result<Vec<FlowRow>> {
    let model = scene.model()?;
    let links = Links::of_model(&model);
    let depth_links = DEPTH_M / f64::from(model.unit_m());
    let held: Vec<(usize, [f64; 3])> = (scene.contacts.iter())
        .map(|&cell| {
            let rest = links.rest()[usize::from(cell)];
            let to = std::array::from_fn(|x| rest[x] + depth_links * scene.direction[x]);
            (usize::from(cell), to)
        })
        .collect();
    let exact = trajectory(&links, &held, &MOMENTS, TOLERANCE);
    let mut rows = Vec::new();
    for &step in steps.iter().filter(|&&step| step <= f64::from(model.step_max())) {
        let settings = Settings {
            sweeps: 1,
            step: step as f32,
            max_tool_step_m: 2.0 * DEPTH_M as f32,
            unloading: Unloading::Off,
            ..Settings::for_model(&model)
        };
        let network = Network::new(model, settings).map_err(Error::check)?;
        let mut engine = Engine::new(network, Scheme::Euler, &scene.contacts)?;
        let at = |depth_m: f64| ToolSample {
            position_m: Vector3::from(scene.direction.map(|x| (depth_m * x) as f32)),
            engaged: 1,
        };
        engine.tick(&at(0.0));
        let mut passes = 0;
        for (t, exact) in MOMENTS.into_iter().zip(&exact) {
            while (passes as f64 + 0.5) * step < t {
                engine.tick(&at(DEPTH_M));
                passes += 1;
            }
            let u = field(&mut engine);
            let cells = u.iter().zip(exact).zip(links.rest());
            let largest =
                cells.map(|((u, p), rest)| norm(&[std::array::from_fn(|x| rest[x] + u[x] - p[x])]));
            let error = largest.fold(0.0, f64::max) / depth_links;
            let scheme = Setting { scheme: Scheme::Euler, hats: true };
            let scene = scene.name;
            rows.push(FlowRow { scene, scheme, step, t, passes, error });
        }
    }
    Ok(rows)
}
