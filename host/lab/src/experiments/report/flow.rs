//! The paper's relaxation in time: `euler` and `rkl2` against the exact trajectory of the plane.

use chaincell_kernel::{Settings, ToolPose};
use nalgebra::Vector3;
use serde::Serialize;

use super::press::field;
use super::scene::Scene;
use super::setting::Setting;
use crate::bodies::Variant;
use crate::reference::vectors::{farthest, fields, plus};
use crate::reference::{Links, trajectory};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::Result;

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
    /// Time that a sweep of `euler`, or a tick of the others, advances [dimensionless time].
    pub step: f64,
    /// Moment [dimensionless time].
    pub t: f64,
    /// Link passes until then.
    pub passes: usize,
    /// Largest distance of a cell from the exact trajectory, as a fraction of the depth.
    pub error: f64,
}

/// Sweeps in which `rkl2` goes to each moment in one tick.
const PASSES: [[u16; 4]; 3] = [[8, 13, 20, 40], [25, 45, 80, 160], [70, 140, 280, 560]];

/// A plane whose centre is held 50 mm below from t = 0 on, with its exact trajectory.
struct Plane<'s> {
    scene: &'s Scene,
    links: Links,
    depth_links: f64,
    exact: Vec<Vec<[f64; 3]>>,
}

impl<'s> Plane<'s> {
    fn new(scene: &'s Scene) -> Result<Self> {
        let model = scene.model()?;
        let links = Links::of_model(&model);
        let depth_links = DEPTH_M / f64::from(model.unit_m());
        let held: Vec<(usize, [f64; 3])> = (scene.contacts.iter())
            .map(|&cell| {
                let cell = usize::from(cell);
                (cell, plus(links.rest()[cell], depth_links, scene.direction))
            })
            .collect();
        let exact = trajectory(&links, &held, &MOMENTS, TOLERANCE);
        Ok(Self { scene, links, depth_links, exact })
    }

    /// An engine with the tool in contact at rest.
    fn engine(&self, scheme: Scheme, sweeps: u16, step: f64) -> Result<Engine<'s>> {
        let by_tick = scheme != Scheme::Euler;
        let contact = Contact::Cells(self.scene.contacts.clone());
        let variant = Variant::plain(scheme, Arithmetic::F32);
        let model = self.scene.model()?;
        let mut engine = variant.unlimited(model, contact, sweeps, |settings| Settings {
            step: if by_tick { settings.step } else { step as f32 },
            tick_time: if by_tick { step as f32 } else { settings.tick_time },
            ..settings
        })?;
        engine.tick(&self.sample(0.0));
        Ok(engine)
    }

    fn sample(&self, depth_m: f64) -> ToolPose {
        let position_m = Vector3::from(self.scene.direction.map(|x| (depth_m * x) as f32));
        ToolPose::at(position_m, 1)
    }

    /// The row of an engine that has come to a moment.
    fn row(
        &self,
        engine: &mut Engine<'_>,
        scheme: Scheme,
        at: usize,
        run: (f64, usize),
    ) -> FlowRow {
        let now = fields(self.links.rest(), 1.0, &field(engine));
        FlowRow {
            scene: self.scene.name,
            scheme: Setting { scheme, hats: true },
            step: run.0,
            t: MOMENTS[at],
            passes: run.1,
            error: farthest(&now, &self.exact[at]) / self.depth_links,
        }
    }
}

/// Runs `euler` with steps of several sizes, and super-steps with several numbers of passes.
///
/// # Errors
/// As the engine.
pub fn run(scene: &Scene, steps: &[f64]) -> Result<Vec<FlowRow>> {
    let plane = Plane::new(scene)?;
    let step_max = f64::from(scene.model()?.step_max());
    let mut rows = Vec::new();
    for &step in steps.iter().filter(|&&step| step <= step_max) {
        let mut engine = plane.engine(Scheme::Euler, 1, step)?;
        let mut passes = 0;
        for (at, t) in MOMENTS.into_iter().enumerate() {
            while (passes as f64 + 0.5) * step < t {
                engine.tick(&plane.sample(DEPTH_M));
                passes += 1;
            }
            rows.push(plane.row(&mut engine, Scheme::Euler, at, (step, passes)));
        }
    }
    for (at, t) in MOMENTS.into_iter().enumerate() {
        for sweeps in PASSES[at] {
            let mut engine = plane.engine(Scheme::Rkl2, sweeps, t)?;
            engine.tick(&plane.sample(DEPTH_M));
            rows.push(plane.row(&mut engine, Scheme::Rkl2, at, (t, sweeps.into())));
        }
    }
    Ok(rows)
}
