//! The checks of a tick on plain numbers, and how close a run came to their bounds.

use chaincell_kernel::Flags;
use serde::Serialize;

use crate::reference::vectors::norm;
use chaincell_host::engine::Scheme;

/// Rounding of a bound that is computed in single precision.
const SINGLE: f64 = 1e-4;
/// Rounding of the certified level.
const LEVEL: f64 = 1e-6;
/// Rounding of a coordinate at its bound K.
const RANGE: f64 = 1e-6;

/// The flags that a tissue sets, not what is around it.
const OF_TISSUE: u32 = 511 | Flags::STARTS_INSIDE.0;

/// Whether all flags are such as a tissue sets.
#[must_use]
pub fn is_of_tissue(flags: Flags) -> bool {
    flags.0 & !OF_TISSUE == 0
}

/// What a published level says of the energy.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Certificate {
    /// The energy exceeds the level by at most the allowance, and the level never rises by
    /// itself.
    Above,
    /// The level is that of the last pass, one step behind the published positions: their own
    /// energy never rises by itself.
    Behind,
    /// Nothing: the model's coarse level may be wrong.
    None,
}

impl Certificate {
    /// What the level of a scheme says.
    #[must_use]
    pub fn of(scheme: Scheme) -> Self {
        match scheme {
            Scheme::Euler => Self::Behind,
            _ => Self::Above,
        }
    }
}

/// Bounds of a body under a scheme.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Largest coordinate K [mean link lengths].
    pub saturation: f64,
    /// What the level certifies.
    pub certificate: Certificate,
}

/// The numbers of a tick.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// Published level \[J\].
    pub level_j: f64,
    /// Energy of the published positions in double precision \[J\].
    pub energy_j: f64,
    /// How far rounding may move it \[J\].
    pub allowance_j: f64,
    /// Largest energy that a tool may load into the body, or that it started with \[J\].
    pub energy_max_j: f64,
    /// Whether anything acted from outside: a tool that moved, a band that opened or closed.
    pub acts: bool,
    /// Force \[N\].
    pub force_n: [f64; 3],
    /// 2 `k_ref` sqrt(W E) \[N\].
    pub force_bound_n: f64,
    /// Published positions [mean link lengths from the centre].
    pub positions: &'a [[f64; 3]],
}

/// What is checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Check {
    /// Force, level, energy and every coordinate are finite.
    Finite,
    /// Every coordinate is within K.
    Range,
    /// The energy is at most the certified level.
    Certified,
    /// The level does not rise while nothing acts from outside.
    Rise,
    /// The energy is at most what a tool may load.
    EnergyMax,
    /// The force is at most 2 `k_ref` sqrt(W E) and the largest force that is set.
    Force,
    /// The flags are known ones, the contacts are cells, no force without a contact or in the safe
    /// state, no contact of a tool that is away; the contacts of a tool add up to its force.
    Answer,
    /// As many sweeps as are asked for; a late tick repeats the force.
    Sweeps,
    /// A second run and the scalar loops give the same bits.
    SameBits,
    /// A body at rest stays as it was to the last bit.
    Rest,
    /// A body that is let go comes back to rest.
    Return,
    /// What must be admitted is admitted, and what must be refused is refused.
    Admission,
    /// The answer to bad samples: the last good one, then the safe state in which no bit changes, then
    /// back.
    Safe,
    /// What is left of a quantity after long is what it was.
    Drift,
    /// Number types agree.
    Agreement,
}

/// A check that failed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Failure {
    /// Which.
    pub check: Check,
    /// The first tick that shows it.
    pub tick: u64,
    /// The figures.
    pub what: String,
}

/// How close a run came to its bounds; 1 is the bound.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Worst {
    /// Ticks.
    pub ticks: u64,
    /// Energy after the first tick \[J\].
    pub energy_start_j: f64,
    /// Largest energy \[J\].
    pub energy_peak_j: f64,
    /// Energy after the last tick \[J\].
    pub energy_end_j: f64,
    /// Level after the last tick \[J\].
    pub level_end_j: f64,
    /// Largest force \[N\].
    pub force_max_n: f64,
    /// Largest part of the rounding's allowance by which the energy lay above the level.
    pub rounding_used: f64,
    /// Largest coordinate over K.
    pub coordinate_over_k: f64,
    /// Largest energy over what a tool may load.
    pub energy_over_bound: f64,
    /// Largest force over its bound.
    pub force_over_bound: f64,
}

impl Worst {
    /// The worse of two runs.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            ticks: self.ticks + other.ticks,
            energy_start_j: self.energy_start_j.max(other.energy_start_j),
            energy_peak_j: self.energy_peak_j.max(other.energy_peak_j),
            energy_end_j: self.energy_end_j.max(other.energy_end_j),
            level_end_j: self.level_end_j.max(other.level_end_j),
            force_max_n: self.force_max_n.max(other.force_max_n),
            rounding_used: self.rounding_used.max(other.rounding_used),
            coordinate_over_k: self.coordinate_over_k.max(other.coordinate_over_k),
            energy_over_bound: self.energy_over_bound.max(other.energy_over_bound),
            force_over_bound: self.force_over_bound.max(other.force_over_bound),
        }
    }

    /// Part of the largest energy that is left at the end.
    #[must_use]
    pub fn left(&self) -> f64 {
        if self.energy_peak_j > 0.0 { self.energy_end_j / self.energy_peak_j } else { 0.0 }
    }
}

/// Checks every tick of a run.
#[derive(Debug, Clone)]
pub struct Checks {
    bounds: Bounds,
    tick: u64,
    last: Option<(f64, f64)>,
    /// How close the run came to its bounds.
    pub worst: Worst,
    /// The first failure of each check.
    pub failures: Vec<Failure>,
}

impl Checks {
    /// Before the first tick.
    #[must_use]
    pub fn new(bounds: Bounds) -> Self {
        Self { bounds, tick: 0, last: None, worst: Worst::default(), failures: Vec::new() }
    }

    /// The run goes on from another state, which stores `start_j`.
    pub fn start(&mut self, start_j: f64) {
        self.last = None;
        self.worst.energy_start_j = start_j;
        self.worst.energy_peak_j = self.worst.energy_peak_j.max(start_j);
    }

    /// Notes a failure, the first of each check.
    pub fn fail(&mut self, check: Check, what: impl FnOnce() -> String) {
        if self.failures.iter().all(|known| known.check != check) {
            self.failures.push(Failure { check, tick: self.tick, what: what() });
        }
    }

    /// A check that holds or does not.
    pub fn hold(&mut self, check: Check, holds: bool, what: impl FnOnce() -> String) {
        if !holds {
            self.fail(check, what);
        }
    }

    /// The next tick.
    pub fn look(&mut self, seen: &Seen<'_>) {
        let Seen { level_j, energy_j, energy_max_j: bound_j, force_n, positions, .. } = *seen;
        let force = norm(force_n);
        let coordinates = positions.as_flattened();
        let finite = [level_j, energy_j, force].iter().chain(coordinates).all(|x| x.is_finite());
        self.hold(Check::Finite, finite && level_j >= 0.0, || {
            format!("force {force_n:?} N, level {level_j:e} J")
        });
        let farthest = coordinates.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let k = self.bounds.saturation;
        let over_k = farthest / k;
        self.hold(Check::Range, over_k <= 1.0 + RANGE, || {
            format!("a coordinate of {farthest} mean link lengths, K is {k}")
        });
        let within = energy_j <= bound_j * (1.0 + SINGLE) + seen.allowance_j;
        let trusted = self.bounds.certificate != Certificate::None;
        self.hold(Check::EnergyMax, within || !trusted, || {
            format!("{energy_j:e} J, bound {bound_j:e} J")
        });
        let force_bound = seen.force_bound_n * (1.0 + SINGLE);
        self.hold(Check::Force, force <= force_bound, || {
            format!("{force:e} N, bound {force_bound:e} N")
        });
        self.certify(seen);
        self.last = Some((level_j, energy_j));
        self.tick += 1;
        let over = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let worst = &mut self.worst;
        worst.ticks += 1;
        worst.energy_peak_j = worst.energy_peak_j.max(energy_j);
        (worst.energy_end_j, worst.level_end_j) = (energy_j, level_j);
        worst.force_max_n = worst.force_max_n.max(force);
        worst.coordinate_over_k = worst.coordinate_over_k.max(over_k);
        worst.energy_over_bound = worst.energy_over_bound.max(over(energy_j, bound_j));
        worst.force_over_bound = worst.force_over_bound.max(over(force, seen.force_bound_n));
    }

    /// Energy and level.
    fn certify(&mut self, seen: &Seen<'_>) {
        let Seen { level_j, energy_j, allowance_j, acts, .. } = *seen;
        let above = match (self.bounds.certificate, self.last) {
            (Certificate::Above, last) => {
                let rises = last.is_some_and(|(before, _)| !acts && level_j > before);
                self.hold(Check::Rise, !rises, || {
                    format!("level {level_j:e} J after {:e} J", last.unwrap_or_default().0)
                });
                energy_j - level_j * (1.0 + LEVEL)
            }
            (Certificate::Behind, Some((_, before))) if !acts => energy_j - before,
            (Certificate::Behind | Certificate::None, _) => return,
        };
        self.hold(Check::Certified, above <= allowance_j, || {
            format!(
                "{energy_j:e} J, level {level_j:e} J: {above:e} J above, {allowance_j:e} J allowed"
            )
        });
        if above > 0.0 && allowance_j > 0.0 {
            self.worst.rounding_used = self.worst.rounding_used.max(above / allowance_j);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds { saturation: 4.0, certificate: Certificate::Above };
    const SEEN: Seen<'static> = Seen {
        level_j: 0.5,
        energy_j: 0.5,
        allowance_j: 1e-6,
        energy_max_j: 1.0,
        acts: false,
        force_n: [0.0, 3.0, 4.0],
        force_bound_n: 6.0,
        positions: &[[4.0, -4.0, 0.0]],
    };

    /// The checks that fail when a good tick is followed by `seen`.
    fn failing(bounds: Bounds, seen: Seen<'_>) -> Vec<Check> {
        let mut checks = Checks::new(bounds);
        checks.look(&SEEN);
        assert!(checks.failures.is_empty(), "{:?}", checks.failures);
        checks.look(&seen);
        assert!(checks.failures.iter().all(|failure| failure.tick == 1));
        checks.failures.iter().map(|failure| failure.check).collect()
    }

    // REQ-HRD-01
    #[test]
    fn what_is_within_its_bounds_passes_and_what_is_not_is_named() {
        assert_eq!(failing(BOUNDS, SEEN), []);
        let nothing = Seen { energy_j: 0.5 + 1e-6, ..SEEN };
        assert_eq!(failing(BOUNDS, nothing), []);
        let rising = Seen { level_j: 0.500_001, ..SEEN };
        assert_eq!(failing(BOUNDS, rising), [Check::Rise]);
        assert_eq!(failing(BOUNDS, Seen { acts: true, ..rising }), []);
        let beyond = Seen { positions: &[[0.0, 4.001, 0.0]], ..SEEN };
        assert_eq!(failing(BOUNDS, beyond), [Check::Range]);
        let lost = Seen { positions: &[[0.0, f64::NAN, 0.0]], ..SEEN };
        assert_eq!(failing(BOUNDS, lost), [Check::Finite]);
        assert!(failing(BOUNDS, Seen { force_n: [f64::NAN; 3], ..SEEN }).contains(&Check::Finite));
        assert_eq!(failing(BOUNDS, Seen { energy_j: 0.501, ..SEEN }), [Check::Certified]);
        let loaded = Seen { energy_j: 1.001, level_j: 1.002, acts: true, ..SEEN };
        assert_eq!(failing(BOUNDS, loaded), [Check::EnergyMax]);
        assert_eq!(failing(BOUNDS, Seen { force_n: [6.1, 0.0, 0.0], ..SEEN }), [Check::Force]);
    }

    #[test]
    fn behind_its_level_the_energy_itself_must_fall() {
        let bounds = Bounds { certificate: Certificate::Behind, ..BOUNDS };
        assert_eq!(failing(bounds, Seen { level_j: 0.6, ..SEEN }), []);
        assert_eq!(failing(bounds, Seen { energy_j: 0.6, ..SEEN }), [Check::Certified]);
        let bounds = Bounds { certificate: Certificate::None, ..BOUNDS };
        assert_eq!(failing(bounds, Seen { energy_j: 1.6, level_j: 0.6, ..SEEN }), []);
    }

    #[test]
    fn after_another_state_the_level_may_be_higher() {
        let mut checks = Checks::new(BOUNDS);
        checks.look(&SEEN);
        checks.start(0.6);
        checks.look(&Seen { level_j: 0.6, energy_j: 0.6, ..SEEN });
        assert!(checks.failures.is_empty(), "{:?}", checks.failures);
        assert_eq!(checks.worst.energy_peak_j, 0.6);
    }

    #[test]
    fn the_figures_are_the_worst() {
        let mut checks = Checks::new(BOUNDS);
        checks.start(0.25);
        checks.look(&SEEN);
        checks.look(&Seen { energy_j: 0.1, positions: &[[2.0; 3]], ..SEEN });
        let worst = checks.worst;
        assert_eq!((worst.energy_peak_j, worst.energy_end_j), (0.5, 0.1));
        assert_eq!((worst.coordinate_over_k, worst.force_max_n), (1.0, 5.0));
        assert_eq!(worst.left(), 0.2);
    }
}
