//! What the output stage does, checked once.

/// Largest ramp or watchdog [ticks].
pub const TICKS_MAX: u16 = 60_000;

/// A spring and damper between the device and the tool in the tissue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// Stiffness, above 0 \[N/m\].
    pub stiffness_n_per_m: f32,
    /// Damping, at least 0 [N s/m].
    pub damping_n_s_per_m: f32,
}

/// What the passivity observer may count on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passivity {
    /// Damping that the device's own mechanics have for sure, at least 0 [N s/m].
    pub device_damping_n_s_per_m: f32,
    /// Ticks between an answer and the device's pushing with it: 0 where the force of a tick acts
    /// from that tick's sample to the next, 1 where it acts a tick later.
    pub delay_ticks: u8,
}

/// A haptic device by its published limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Device {
    /// 3D Systems Touch: 3.3 N, 400 N/m.
    Touch,
    /// 3D Systems Phantom Premium 3.0: 22 N, 1000 N/m.
    Premium,
    /// Novint Falcon: 8 N, 3000 N/m.
    Falcon,
    /// Force Dimension omega: 12 N, 5000 N/m.
    Omega,
    /// Force Dimension sigma.7: 12 N, 4000 N/m.
    Sigma,
}

impl Device {
    /// Largest force \[N\].
    #[must_use]
    pub const fn max_force_n(self) -> f32 {
        match self {
            Self::Touch => 3.3,
            Self::Premium => 22.0,
            Self::Falcon => 8.0,
            Self::Omega | Self::Sigma => 12.0,
        }
    }

    /// Largest stiffness that it can show \[N/m\].
    #[must_use]
    pub const fn max_stiffness_n_per_m(self) -> f32 {
        match self {
            Self::Touch => 400.0,
            Self::Premium => 1000.0,
            Self::Falcon => 3000.0,
            Self::Omega => 5000.0,
            Self::Sigma => 4000.0,
        }
    }
}

/// The stages between a tissue and a device; each may be absent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StageSettings {
    /// Time of a tick, above 0 \[s\].
    pub tick_s: f32,
    /// Virtual coupling.
    pub coupling: Option<Coupling>,
    /// Passivity observer and controller.
    pub passivity: Option<Passivity>,
    /// Largest change of the force, infinite for none [N/s].
    pub max_slew_n_per_s: f32,
    /// Largest force, infinite for none \[N\].
    pub max_force_n: f32,
    /// Ticks in which the force rises to its full value after engaging and after a silence, and in
    /// which it falls to zero when samples stop; 0 for none.
    pub ramp_ticks: u16,
    /// Ticks without a sample after which the force falls to zero, 0 for never.
    pub watchdog_ticks: u16,
}

impl StageSettings {
    /// Every stage absent but the finite check, at 1 kHz.
    pub const NONE: Self = Self {
        tick_s: 1.0e-3,
        coupling: None,
        passivity: None,
        max_slew_n_per_s: f32::INFINITY,
        max_force_n: f32::INFINITY,
        ramp_ticks: 0,
        watchdog_ticks: 0,
    };
}

/// Which setting of a stage is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StageError {
    /// The time of a tick is not positive and finite.
    Tick,
    /// The coupling's stiffness is not positive and finite, or its damping negative or not finite.
    Coupling,
    /// The device's damping is negative or not finite, or the delay above 1 tick.
    Passivity,
    /// The slew limit is not positive.
    Slew,
    /// The largest force is not positive.
    MaxForce,
    /// A ramp or a watchdog above [`TICKS_MAX`].
    Ticks,
}

impl core::fmt::Display for StageError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Tick => "the time of a tick must be positive and finite",
            Self::Coupling => {
                "the coupling's stiffness must be positive, its damping at least 0, both finite"
            }
            Self::Passivity => {
                "the device's damping must be at least 0 and finite, the delay 0 or 1 tick"
            }
            Self::Slew => "the slew limit must be positive",
            Self::MaxForce => "the largest force must be positive",
            Self::Ticks => "ramp and watchdog must be at most 60000 ticks",
        })
    }
}

impl core::error::Error for StageError {}
