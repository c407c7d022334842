//! The same trials under what others run: explicit mass-spring dynamics and link-order
//! position-based dynamics, one step a link pass, as many passes a tick as `track` has sweeps.
//!
//! Mass-spring takes a step of 1 ms, as usual, and its largest stable step; position-based dynamics
//! small steps of 1 ms with one iteration each, compliance 1 / k. Both lose a tenth of a velocity a
//! step. The tool is the same: it holds the same cells, goes as far a tick, and a probe projects
//! the same surface cells onto its sphere. A body with inertia that is pulled stores more than one
//! that settles; so energies are parts of E0, the largest of what the body starts with, what
//! `track` had and what the tool could load into cells that stand still. Beyond ten times that it
//! counts as blown up.

use std::fmt;

use chaincell_kernel::Model;
use nalgebra::Vector3;
use serde::Serialize;

use super::trial::{Pose, Touch, Trial};
use crate::baseline::{Baseline, MassSpring, Movable, Xpbd};
use crate::reference::Links;
use chaincell_host::error::Result;
use chaincell_host::interrupt;

/// Steps a tick.
const STEPS: u32 = 4;
/// The usual step of mass-spring codes \[s\].
const USUAL_STEP_S: f32 = 1e-3;
/// Growth of the energy that counts as blowing up.
const GROWTH: f64 = 10.0;
/// Largest coordinate before a body counts as blown up [mean link lengths], or so many times the
/// largest at the start.
const FAR: [f64; 2] = [1e3, 4.0];
/// Least energy that is compared [k u^2 of the mean link].
const ENERGY_MIN: f64 = 1e-6;
/// Part of the energy that counts as stalled, where the network has left less than half of it.
const STALLED: f64 = 0.05;
/// What counts as more than there was.
const RISEN: f64 = 1.01;

/// A method.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BaselineKind {
    /// Explicit mass-spring dynamics at 1 ms.
    MassSpring,
    /// The same at its largest stable step.
    MassSpringStable,
    /// Position-based dynamics.
    PositionBased,
}

impl BaselineKind {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::MassSpring, Self::MassSpringStable, Self::PositionBased];

    /// Name in figures.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::MassSpring => "mass_spring",
            Self::MassSpringStable => "mass_spring_stable",
            Self::PositionBased => "position_based",
        }
    }
}

/// What became of a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "verdict")]
pub enum Verdict {
    /// It stays within bounds.
    Stays {
        /// Part of E0 left at the end.
        left: f64,
        /// Largest energy over E0.
        peak: f64,
    },
    /// It stays, and far from where the network settles.
    Stalls {
        /// As above.
        left: f64,
        /// As above.
        peak: f64,
    },
    /// Not finite, or beyond all bounds.
    BlowsUp {
        /// The first such tick.
        tick: u32,
    },
}

impl Verdict {
    /// Whether this is the worse of two.
    #[must_use]
    pub fn is_worse(&self, than: &Self) -> bool {
        let rank = |verdict: &Self| match *verdict {
            Self::Stays { left, peak } => (0, left.max(peak - RISEN)),
            Self::Stalls { left, .. } => (1, left),
            Self::BlowsUp { tick } => (2, -f64::from(tick)),
        };
        rank(self) > rank(than)
    }

    /// Its figures, by name.
    #[must_use]
    pub fn figures(&self) -> Vec<(&'static str, f64)> {
        match *self {
            Self::Stays { left, peak } | Self::Stalls { left, peak } => {
                vec![("energy_left", left), ("energy_peak", peak)]
            }
            Self::BlowsUp { tick } => vec![("blows_up_tick", f64::from(tick))],
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Stays { left, .. } => write!(f, "stays {left:.0e}"),
            Self::Stalls { left, .. } if left > RISEN => write!(f, "GAINS {left:.1}"),
            Self::Stalls { left, .. } => write!(f, "stalls {left:.2}"),
            Self::BlowsUp { tick } => write!(f, "BLOWS UP @{tick}"),
        }
    }
}

/// What the network did in the same trial.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measure {
    /// Largest energy under `track` \[J\].
    pub peak_j: f64,
    /// Energy that it has left at the end \[J\].
    pub end_j: f64,
}

/// Plays a trial under a method; none where there is no energy to compare with.
///
/// # Errors
/// [`Error::Interrupted`](chaincell_host::error::Error::Interrupted).
pub fn play(
    trial: &Trial<'_>,
    baseline: BaselineKind,
    measure: Measure,
) -> Result<Option<Verdict>> {
    let model = trial.body.plain()?;
    let least_j = ENERGY_MIN * f64::from(model.energy_unit_j());
    if measure.peak_j <= least_j || model.fixed().len() == model.cells() {
        return Ok(None);
    }
    let verdict = match baseline {
        BaselineKind::MassSpring => {
            run(trial, &model, MassSpring::new(&model).with_step(USUAL_STEP_S), measure)
        }
        BaselineKind::MassSpringStable => run(trial, &model, MassSpring::new(&model), measure),
        BaselineKind::PositionBased => run(trial, &model, Xpbd::new(&model), measure),
    };
    verdict.map(Some)
}

fn run(
    trial: &Trial<'_>,
    model: &Model<'_>,
    mut body: impl Movable,
    measure: Measure,
) -> Result<Verdict> {
    let links = Links::of_model(model);
    let unit_j = f64::from(model.energy_unit_j());
    if let Some(positions) = trial.start(model) {
        body.set_positions(&positions);
    }
    let farthest = wide(&body).as_flattened().iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let far = FAR[0].max(FAR[1] * farthest);
    let loaded = loaded(trial, model, &links, body.positions())?;
    let reference = loaded.max(measure.peak_j / unit_j);
    let end = measure.end_j / unit_j / reference;
    let mut tool = Tool::new(trial, model);
    let (mut left, mut peak) = (0.0, 0.0_f64);
    for tick in 0..trial.ticks {
        interrupt::check()?;
        tool.put(&mut body, (trial.script)(tick));
        (0..STEPS).for_each(|_| body.step());
        let positions = wide(&body);
        let energy = links.energy(&positions) / reference;
        let bounded = positions.as_flattened().iter().all(|x| x.abs() <= far);
        if !(bounded && energy <= GROWTH) {
            return Ok(Verdict::BlowsUp { tick });
        }
        (left, peak) = (energy, peak.max(energy));
    }
    let stalls = left > STALLED && left > 2.0 * end;
    Ok(if stalls { Verdict::Stalls { left, peak } } else { Verdict::Stays { left, peak } })
}

/// The largest energy of cells that stand still, but for those that the tool moves, the start
/// included.
fn loaded(trial: &Trial<'_>, model: &Model<'_>, links: &Links, start: &[[f32; 3]]) -> Result<f64> {
    let mut body = Still { start: start.to_vec(), now: start.to_vec() };
    let mut tool = Tool::new(trial, model);
    let mut most = links.energy(&wide(&body));
    for tick in 0..trial.ticks {
        interrupt::check()?;
        tool.put(&mut body, (trial.script)(tick));
        most = most.max(links.energy(&wide(&body)));
    }
    Ok(most)
}

/// Cells that go where the tool puts them and nowhere else.
struct Still {
    start: Vec<[f32; 3]>,
    now: Vec<[f32; 3]>,
}

impl Baseline for Still {
    const NAME: &'static str = "still";

    fn new(model: &Model<'_>) -> Self {
        let rest: Vec<_> = (0..model.cells()).map(|cell| model.rest_position(cell)).collect();
        Self { now: rest.clone(), start: rest }
    }

    fn hold(&mut self, cell: usize, position: [f32; 3]) {
        self.now[cell] = position;
    }

    fn step(&mut self) {}

    fn positions(&self) -> &[[f32; 3]] {
        &self.now
    }
}

impl Movable for Still {
    fn set_positions(&mut self, positions: &[[f32; 3]]) {
        self.now.copy_from_slice(positions);
    }

    fn release(&mut self, cell: usize) {
        self.now[cell] = self.start[cell];
    }
}

fn wide(body: &impl Movable) -> Vec<[f64; 3]> {
    body.positions().iter().map(|p| p.map(f64::from)).collect()
}

/// The tool on cells that others move [mean link lengths].
struct Tool {
    unit_m: f32,
    centre_m: Vector3<f32>,
    /// Way that it may go in a tick.
    step: f32,
    probe: Option<f32>,
    /// Cells that it holds, or may push.
    cells: Vec<usize>,
    origins: Vec<Vector3<f32>>,
    origin: Vector3<f32>,
    applied: Vector3<f32>,
    engaged: bool,
}

impl Tool {
    fn new(trial: &Trial<'_>, model: &Model<'_>) -> Self {
        let unit_m = model.unit_m();
        let cells = match trial.touch {
            Touch::Cells => trial.body.held(model),
            Touch::Probe(_) => {
                let of = model.surface().iter().copied();
                of.filter(|&cell| !model.is_fixed(cell)).collect()
            }
        };
        Self {
            unit_m,
            centre_m: model.centre_m().into(),
            step: if trial.leaps { f32::INFINITY } else { 1.0 },
            probe: match trial.touch {
                Touch::Cells => None,
                Touch::Probe(radius_m) => Some(radius_m / unit_m),
            },
            cells: cells.into_iter().map(usize::from).collect(),
            origins: Vec::new(),
            origin: Vector3::zeros(),
            applied: Vector3::zeros(),
            engaged: false,
        }
    }

    /// Puts the cells where the tool has them in this tick.
    fn put(&mut self, body: &mut impl Movable, (position_m, touches): Pose) {
        let takes = touches && !self.engaged;
        if !touches && self.engaged || self.probe.is_some() {
            self.cells.iter().for_each(|&cell| body.release(cell));
        }
        self.engaged = touches;
        if !touches {
            return;
        }
        if let Some(radius) = self.probe {
            return self.push(body, radius, position_m);
        }
        if takes {
            let at = |&cell: &usize| Vector3::from(body.positions()[cell]);
            self.origins = self.cells.iter().map(at).collect();
            (self.origin, self.applied) = (position_m.into(), Vector3::zeros());
        }
        let way = (Vector3::from(position_m) - self.origin) / self.unit_m - self.applied;
        let length = way.norm();
        let part = if length > self.step { self.step / length } else { 1.0 };
        self.applied += part * way;
        for (&cell, origin) in self.cells.iter().zip(&self.origins) {
            body.hold(cell, (origin + self.applied).into());
        }
    }

    /// Pushes the cells inside the sphere onto it.
    fn push(&self, body: &mut impl Movable, radius: f32, position_m: [f32; 3]) {
        let centre = (Vector3::from(position_m) - self.centre_m) / self.unit_m;
        for &cell in &self.cells {
            let way = Vector3::from(body.positions()[cell]) - centre;
            let length = way.norm();
            if length > 0.0 && length < radius {
                body.hold(cell, (centre + radius / length * way).into());
            }
        }
    }
}
