//! Time to equilibrium: one cell pressed by a tenth of the body's height in one step and held,
//! until the field stays within 5 % and the force within 1 % of what the method converges to.

use std::time::Instant;

use chaincell_kernel::Model;
use serde::Serialize;

use super::exact::RESIDUAL;
use super::press::{engine, field, sample};
use super::scene::Scene;
use super::setting::Setting;
use crate::baseline::Baseline;
use crate::reference::vectors::{distance, fields, minus, norm, plus, size};
use crate::reference::{Links, minimum};
use chaincell_host::engine::Engine;
use chaincell_host::error::{Error, Result};
use chaincell_host::session::timing::histogram::{Latencies, Summary};

/// Bounds of the errors, as fractions.
const FIELD: f64 = 0.05;
const FORCE: f64 = 0.01;
/// Sweeps after which a method counts as converged.
const CONVERGED: usize = 6000;

/// How long one method takes.
#[derive(Debug, Clone, Serialize)]
pub struct Settled {
    /// Name of the scene.
    pub scene: &'static str,
    /// Scheme or baseline.
    pub method: String,
    /// Sweeps until field and force stay within their bounds.
    pub sweeps: usize,
    /// Whether it settles within the sweeps that were tried.
    pub settles: bool,
    /// Sweeps until the field does.
    pub field_sweeps: usize,
    /// Sweeps until the force does.
    pub force_sweeps: usize,
    /// Time of so many sweeps from rest, median of several runs \[ms\].
    pub ms: f64,
    /// Time of so many sweeps, 99 % of the runs \[ms\].
    pub ms_p99: f64,
    /// Its converged field off the exact minimum, as a fraction.
    pub off_minimum: f64,
}

/// A method under test: one cell pressed at once, then sweep after sweep.
trait Method {
    /// Back to rest, then pressed.
    fn press(&mut self) -> Result<()>;
    /// One sweep.
    fn sweep(&mut self);
    /// Displacements [mean link lengths].
    fn field(&mut self) -> Vec<[f64; 3]>;
    /// Presses from rest and sweeps so often, returning the time of the sweeps \[ns\].
    fn timed(&mut self, sweeps: usize) -> Result<u64>;
}

struct Kernel<'s> {
    scene: &'s Scene,
    setting: Setting,
    engine: Engine<'s>,
    depth_links: f64,
}

impl Kernel<'_> {
    fn tick(engine: &mut Engine<'_>, scene: &Scene, depth_links: f64) {
        let unit_m = engine.network().model().unit_m();
        engine.tick(&sample(scene, unit_m, depth_links));
    }
}

impl Method for Kernel<'_> {
    fn press(&mut self) -> Result<()> {
        self.engine.reset()?;
        Self::tick(&mut self.engine, self.scene, 0.0);
        Ok(())
    }

    fn sweep(&mut self) {
        Self::tick(&mut self.engine, self.scene, self.depth_links);
    }

    fn field(&mut self) -> Vec<[f64; 3]> {
        field(&mut self.engine)
    }

    fn timed(&mut self, sweeps: usize) -> Result<u64> {
        let per_tick = u16::try_from(sweeps).map_err(Error::check)?;
        let mut engine = engine(self.scene, self.setting, per_tick)?;
        Self::tick(&mut engine, self.scene, 0.0);
        let start = Instant::now();
        Self::tick(&mut engine, self.scene, self.depth_links);
        Ok(start.elapsed().as_nanos() as u64)
    }
}

struct Plain<'m, B> {
    model: Model<'m>,
    body: B,
    cell: usize,
    to: [f32; 3],
}

impl<B: Baseline> Method for Plain<'_, B> {
    fn press(&mut self) -> Result<()> {
        self.body = B::new(&self.model);
        self.body.hold(self.cell, self.to);
        Ok(())
    }

    fn sweep(&mut self) {
        self.body.step();
    }

    fn field(&mut self) -> Vec<[f64; 3]> {
        let wide = |p: [f32; 3]| p.map(f64::from);
        let cells = self.body.positions().iter().enumerate();
        cells.map(|(cell, p)| minus(wide(*p), wide(self.model.rest_position(cell)))).collect()
    }

    fn timed(&mut self, sweeps: usize) -> Result<u64> {
        self.press()?;
        let start = Instant::now();
        for _ in 0..sweeps {
            self.body.step();
        }
        Ok(start.elapsed().as_nanos() as u64)
    }
}

/// A pressed body with its exact minimum.
pub struct Press<'s> {
    scene: &'s Scene,
    model: Model<'s>,
    links: Links,
    depth_links: f64,
    exact: Vec<[f64; 3]>,
    /// Times each figure is measured.
    rounds: usize,
}

impl<'s> Press<'s> {
    /// A scene pressed by `depth_m`.
    ///
    /// # Errors
    /// A minimum that was not reached.
    pub fn new(scene: &'s Scene, depth_m: f64, rounds: usize) -> Result<Self> {
        let model = scene.model()?;
        let links = Links::of_model(&model);
        let depth_links = depth_m / f64::from(model.unit_m());
        let mut at = links.rest().to_vec();
        for &cell in &scene.contacts {
            let cell = usize::from(cell);
            let to = plus(links.rest()[cell], depth_links, scene.direction);
            let found = minimum(&links, &[(cell, to)], &at, RESIDUAL);
            if found.residual_max > RESIDUAL {
                return Err(Error::check(format!("{}: no minimum was reached", scene.name)));
            }
            at = found.positions;
        }
        let exact = fields(&at, -1.0, links.rest());
        Ok(Self { scene, model, links, depth_links, exact, rounds })
    }

    /// Cells that the exact minimum moves by more than a hundredth of the depth.
    #[must_use]
    pub fn moved(&self) -> usize {
        self.exact.iter().filter(|u| norm(**u) > 0.01 * self.depth_links).count()
    }

    /// A setting of the kernel.
    ///
    /// # Errors
    /// As the engine.
    pub fn setting(&self, setting: Setting) -> Result<Settled> {
        let engine = engine(self.scene, setting, 1)?;
        let (scene, depth_links) = (self.scene, self.depth_links);
        let mut kernel = Kernel { scene, setting, engine, depth_links };
        self.measure(&mut kernel, setting.to_string())
    }

    /// A baseline.
    ///
    /// # Errors
    /// As [`Self::setting`].
    pub fn baseline<B: Baseline>(&self) -> Result<Settled> {
        let cell = self.scene.contacts.first().copied().map_or(0, usize::from);
        let rest = self.model.rest_position(cell);
        let to =
            std::array::from_fn(|x| rest[x] + (self.depth_links * self.scene.direction[x]) as f32);
        let body = B::new(&self.model);
        self.measure(&mut Plain { model: self.model, body, cell, to }, B::NAME.into())
    }

    /// Force on the pressed cell in internal units, of any method's positions alike.
    fn force(&self, field: &[[f64; 3]]) -> [f64; 3] {
        let at = fields(self.links.rest(), 1.0, field);
        let cells: Vec<usize> = self.scene.contacts.iter().map(|&cell| cell.into()).collect();
        self.links.force(&at, &cells)
    }

    fn measure(&self, method: &mut dyn Method, name: String) -> Result<Settled> {
        method.press()?;
        (0..CONVERGED).for_each(|_| method.sweep());
        let last = method.field();
        let force = self.force(&last);
        let (mut field_sweeps, mut force_sweeps) = (0, 0);
        method.press()?;
        for sweep in 1..=CONVERGED {
            method.sweep();
            let now = method.field();
            if distance(&now, &last) > FIELD * size(&last) {
                field_sweeps = sweep + 1;
            }
            if norm(minus(self.force(&now), force)) > FORCE * norm(force) {
                force_sweeps = sweep + 1;
            }
            // Long within both bounds: it stays there.
            if sweep > 3 * field_sweeps.max(force_sweeps) + 200 {
                break;
            }
        }
        let sweeps = field_sweeps.max(force_sweeps);
        // What still moves out of the bounds halfway to the end has no converged value to settle at.
        let settles = sweeps <= CONVERGED / 2;
        let mut times = Latencies::new()?;
        for _ in 0..self.rounds {
            times.record(method.timed(sweeps)?);
        }
        let Summary { p50, p99, .. } = times.summary();
        Ok(Settled {
            scene: self.scene.name,
            method: name,
            sweeps,
            settles,
            field_sweeps,
            force_sweeps,
            ms: p50 as f64 * 1e-6,
            ms_p99: p99 as f64 * 1e-6,
            off_minimum: distance(&last, &self.exact) / size(&self.exact),
        })
    }
}
