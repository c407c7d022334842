//! What every tick must keep to, whatever went before it.

use chaincell_host::engine::{Arithmetic, Engine, Scheme};
use chaincell_kernel::{Flags, TickOutput, ToolSample};

use crate::graph::energy_j;

/// What fixed point leaves open of a length [mean link lengths].
const FIXED_RESOLUTION: f64 = 8.0 / 16_777_216.0;

/// The state of affairs after a tick.
#[derive(Clone, Copy)]
struct Before {
    output: TickOutput,
    /// Energy in double precision, without its allowance \[J\].
    energy_j: f64,
}

/// Follows an engine tick by tick.
pub struct Watch {
    scheme: Scheme,
    resolution: f64,
    /// Whether the certificate of the level is the kernel's own, not the bake's word.
    certified: bool,
    before: Option<Before>,
}

impl Watch {
    /// Of an engine under `scheme` in `numbers`.
    pub fn new(scheme: Scheme, numbers: Arithmetic, certified: bool) -> Self {
        let resolution = if numbers == Arithmetic::Fixed { FIXED_RESOLUTION } else { 0.0 };
        Self { scheme, resolution, certified, before: None }
    }

    /// Something outside acts between two ticks.
    pub fn interfere(&mut self) {
        self.before = None;
    }

    /// One tick, checked.
    pub fn tick(&mut self, engine: &mut Engine<'_>, sample: &ToolSample) -> TickOutput {
        let output = engine.tick(sample);
        let model = *engine.network().model();
        let safe = output.flags.contains(Flags::SAFE_STATE);
        let magnitude = output.force_n.cast::<f64>().norm();
        assert!(output.force_n.iter().all(|x| x.is_finite()), "{output:?}");
        assert!(output.energy_j.is_finite() && output.energy_j >= 0.0, "{output:?}");
        assert!(magnitude == 0.0 || (!safe && output.contacts > 0), "{output:?}");
        let most = f64::from(engine.network().settings().max_force_n);
        assert!(magnitude <= most * 1.00001 + 1e-30, "{output:?} with at most {most} N");
        assert!(output.flags.0 < 256 && output.contacts as usize <= model.cells());
        let k_m = f64::from(model.saturation()) * f64::from(model.unit_m()) * 1.000_001;
        for position_m in engine.positions_m() {
            for (axis, x) in position_m.iter().enumerate() {
                let centre_m = f64::from(model.centre_m()[axis]);
                let rounding_m = 4.0 * f64::EPSILON * centre_m.abs();
                assert!((x - centre_m).abs() <= k_m + rounding_m, "{position_m:?}");
            }
        }
        if self.certified {
            self.energy(engine, &output);
        }
        output
    }

    /// The level bounds the energy and never rises while nothing outside acts.
    fn energy(&mut self, engine: &mut Engine<'_>, output: &TickOutput) {
        let (energy, mut allowance) = energy_j(engine, self.resolution);
        if self.scheme == Scheme::GaussSeidel {
            // Its level is reckoned over many sweeps from one measurement: each step rounds.
            allowance *= 2.0;
        }
        let level = f64::from(output.energy_j);
        // The level of `euler` is that of its last link pass.
        let bounded = self.scheme == Scheme::Euler || energy <= level * (1.0 + 1e-6) + allowance;
        assert!(energy.is_finite() && bounded, "{energy:e} J above {output:?}, {allowance:e}");
        let band = |output: &TickOutput| output.flags.contains(Flags::BAND_CLOSED);
        if let Some(before) = self.before
            && before.output.contacts == 0
            && output.contacts == 0
            && band(&before.output) == band(output)
        {
            if self.scheme != Scheme::Euler {
                let most = before.output.energy_j;
                assert!(output.energy_j <= most, "level {:e} after {most:e}", output.energy_j);
            } else if !band(output) {
                // What is measured is the energy of open bands.
                let most = before.energy_j + allowance;
                assert!(energy <= most, "{energy:e} J after {:e}", before.energy_j);
            }
        }
        self.before = Some(Before { output: *output, energy_j: energy });
    }
}
