//! Follows an engine tick by tick.

use chaincell_kernel::{Budget, Drive, Flags, Model, TickOutput, ToolPose, Unloading};

use super::checks::{Bounds, Certificate, Check, Checks, Failure, Seen, Worst, is_of_tissue};
use super::energy::{Energy, energy, energy_of_shapes};
use crate::reference::{Links, Nodal, Stiffening};
use chaincell_host::engine::{Arithmetic, Engine, Scheme};

/// How far fixed point may move a length [mean link lengths].
const FIXED_RESOLUTION: f64 = 8.0 / 16_777_216.0;

/// The tick before.
#[derive(Debug, Clone, Copy)]
struct Before {
    sample: ToolPose,
    contacts: u32,
    flags: Flags,
}

/// What the energy is computed with, in double precision.
#[derive(Debug, Clone)]
enum Exact {
    Links(Links),
    /// Nodal shapes, what stiffens them, and the bounds of the cells.
    Shapes(Box<(Nodal, Stiffening)>, Vec<f64>),
    /// Shapes that the reference does not know: nothing is compared with the level.
    Unknown,
}

impl Exact {
    fn of(model: &Model<'_>) -> Self {
        if !model.is_nodal() {
            return Self::Links(Links::of_model(model));
        }
        let bounds = (0..model.cells()).map(|cell| f64::from(model.cell_bound(cell))).collect();
        match Nodal::of_model(model) {
            Ok(Some(shapes)) => {
                Self::Shapes(Box::new((shapes, Stiffening::of_model(model))), bounds)
            }
            _ => Self::Unknown,
        }
    }
}

/// Ticks an engine and checks each tick.
#[derive(Debug, Clone)]
pub struct Monitor<'m> {
    model: Model<'m>,
    exact: Exact,
    /// How far the numbers may move a length, beyond rounding [mean link lengths].
    resolution: f64,
    /// Whether the tool loads its cells with a current: the drive of a hold is that of its start.
    driven: bool,
    /// Weight of the links between held and other cells.
    weight: f64,
    /// Square root of the energy that bands load into the links when they close \[J\].
    slack_root: f64,
    /// Energy before the first tick \[J\]; none until it is measured.
    start_j: Option<f64>,
    before: Option<Before>,
    last: Energy,
    checks: Checks,
}

impl<'m> Monitor<'m> {
    /// Of an engine that runs `scheme` in `numbers`.
    #[must_use]
    pub fn new(engine: &Engine<'m>, scheme: Scheme, numbers: Arithmetic) -> Self {
        let model = *engine.network().model();
        let weight = outer_weight(&model, engine.contacts());
        let exact = Exact::of(&model);
        let slack = (0..model.links()).map(|link| {
            let slack = f64::from(model.link_alpha(link)) * f64::from(model.rest_lengths()[link]);
            0.25 * f64::from(model.link_weight(link)) * slack * slack
        });
        let certificate = match exact {
            Exact::Unknown => Certificate::None,
            _ => Certificate::of(scheme),
        };
        let saturation = f64::from(model.saturation());
        Self {
            model,
            resolution: if numbers == Arithmetic::Fixed { FIXED_RESOLUTION } else { 0.0 },
            driven: false,
            weight,
            slack_root: (slack.sum::<f64>() * f64::from(model.energy_unit_j())).sqrt(),
            exact,
            start_j: None,
            before: None,
            last: Energy::default(),
            checks: Checks::new(Bounds { saturation, certificate }),
        }
    }

    /// The same without the checks of level and energy, for a model whose coarse level may be
    /// wrong: the kernel takes it as it is.
    #[must_use]
    pub fn without_certificate(mut self) -> Self {
        let saturation = f64::from(self.model.saturation());
        self.checks = Checks::new(Bounds { saturation, certificate: Certificate::None });
        self
    }

    /// Something other than the tool acts before the next tick: positions, settings, a reset.
    pub fn interfere(&mut self) {
        (self.start_j, self.before) = (None, None);
    }

    /// One tick, checked.
    pub fn tick(&mut self, engine: &mut Engine<'m>, sample: &ToolPose) -> TickOutput {
        self.tick_again(engine, sample, None)
    }

    /// One tick with so many sweeps, 0 for a late one, `None` for the settings' count; checked.
    pub fn tick_again(
        &mut self,
        engine: &mut Engine<'m>,
        sample: &ToolPose,
        sweeps: Option<u16>,
    ) -> TickOutput {
        let known_j = self.start_j;
        let mut start_j = known_j.unwrap_or_else(|| {
            let start_j = self.energy(&engine.positions(), false).energy;
            self.checks.start(start_j);
            start_j
        });
        let output = engine.tick_by(&[*sample], Budget::again(sweeps));
        // The rotations and shapes that the kernel keeps may store more than the nearest ones: the first
        // level bounds it.
        if known_j.is_none() && !matches!(self.exact, Exact::Links(_)) {
            start_j = start_j.max(output.energy_j.into());
        }
        self.start_j = Some(start_j);
        self.answer(engine, &output);
        let closed = output.flags.contains(Flags::BAND_CLOSED);
        let positions = engine.positions();
        self.last = self.energy(&positions, closed);
        let asked = engine.network().settings().drive == Drive::Current;
        self.driven = output.contacts > 0 && (self.driven || asked);
        let unit_j = f64::from(self.model.energy_unit_j());
        // Forces of shapes follow from the rotations and shapes that the kernel keeps, with which the
        // energy is higher, up to the level.
        let energy_j = match self.exact {
            Exact::Links(_) => self.last.energy,
            _ => self.last.energy.max(output.energy_j.into()),
        };
        let stored = (energy_j + self.last.allowance) / unit_j;
        let force_n: [f32; 3] = output.force_n.into();
        let settings = engine.network().settings();
        // Bands that close load their own slack.
        let may_close = closed || settings.unloading != Unloading::Off;
        let slack_root = if may_close { self.slack_root } else { 0.0 };
        let most_j = start_j.max(f64::from(self.model.energy_max()) * unit_j);
        self.checks.look(&Seen {
            level_j: output.energy_j.into(),
            energy_j: self.last.energy,
            allowance_j: self.last.allowance,
            energy_max_j: (most_j.sqrt() + slack_root).powi(2),
            acts: self.acts(sample, &output),
            force_n: force_n.map(f64::from),
            // The force of a late tick is an earlier one's.
            force_bound_n: if output.flags.contains(Flags::LATE) {
                f64::INFINITY
            } else {
                f64::from(self.model.force_unit_n())
                    * ((self.weight * stored).sqrt() + self.last.force_allowance)
            },
            positions: &positions,
        });
        let TickOutput { contacts, flags, .. } = output;
        self.before = Some(Before { sample: *sample, contacts, flags });
        output
    }

    /// Energy of the last tick's positions in double precision, and how far rounding may move it
    /// \[J\].
    #[must_use]
    pub fn stored(&self) -> Energy {
        self.last
    }

    /// Notes a check that the caller made.
    pub fn hold(&mut self, check: Check, holds: bool, what: impl FnOnce() -> String) {
        self.checks.hold(check, holds, what);
    }

    /// The first failure of each check.
    #[must_use]
    pub fn failures(&self) -> &[Failure] {
        &self.checks.failures
    }

    /// How close the run came to its bounds.
    #[must_use]
    pub fn worst(&self) -> &Worst {
        &self.checks.worst
    }

    fn energy(&self, positions: &[[f64; 3]], closed: bool) -> Energy {
        let error = |_: &[f64; 3]| 0.5 * self.resolution;
        let energy = match &self.exact {
            Exact::Links(links) => energy(links, positions, closed, error),
            Exact::Shapes(shapes, bounds) => {
                let (shapes, stiffening) = &**shapes;
                energy_of_shapes(shapes, stiffening, positions, bounds)
            }
            Exact::Unknown => Energy::default(),
        };
        energy.times(self.model.energy_unit_j().into())
    }

    /// What the answer must be whatever the energy is.
    fn answer(&mut self, engine: &Engine<'_>, output: &TickOutput) {
        let force_n = output.force_n.cast::<f64>().norm();
        let most_n = f64::from(engine.network().settings().max_force_n);
        self.hold(Check::Force, force_n <= most_n, || {
            format!("{force_n:e} N, at most {most_n:e} N are set")
        });
        let safe = output.flags.contains(Flags::SAFE_STATE);
        let known = is_of_tissue(output.flags) && output.contacts as usize <= self.model.cells();
        // A late tick repeats a force.
        let late = output.flags.contains(Flags::LATE);
        let touches = force_n == 0.0 || (!safe && (late || output.contacts > 0));
        self.hold(Check::Answer, known && touches, || format!("{output:?}"));
    }

    /// Whether anything acted from outside in this tick. Taking hold and letting go do not.
    fn acts(&self, sample: &ToolPose, output: &TickOutput) -> bool {
        let Some(before) = &self.before else { return true };
        let has = |flag| output.flags.contains(flag) || before.flags.contains(flag);
        let in_one = |flag| output.flags.contains(flag) != before.flags.contains(flag);
        let moves =
            *sample != before.sample || has(Flags::MOTION_CLAMPED) || has(Flags::BAD_SAMPLE);
        let tool = self.driven || output.contacts > 0 && before.contacts > 0 && moves;
        tool || in_one(Flags::BAND_CLOSED)
    }
}

/// Weight of the links between the cells `held` (ascending) and others; of nodal shapes, twice what
/// the bound of the curvature gives a common move of them.
fn outer_weight(model: &Model<'_>, held: &[u16]) -> f64 {
    let is_held = |cell: usize| held.binary_search(&(cell as u16)).is_ok();
    if model.is_nodal() {
        let mut sum = 0.0;
        for &cell in held {
            model.each_of_bound_row(cell.into(), |other, element| {
                sum += if is_held(other) { 2.0 * f64::from(element) } else { 0.0 };
            });
        }
        return sum;
    }
    let outer = held.iter().flat_map(|&cell| model.neighbours(cell.into()));
    outer
        .filter(|&(_, other)| !is_held(other))
        .map(|(link, _)| f64::from(model.link_weight(link)))
        .sum()
}
