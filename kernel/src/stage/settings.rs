//! Settings of the output stage, and their check.

use crate::number::kept::kept;
use crate::tick::choice::choices;

/// Largest ramp or watchdog \[ticks\].
pub const TICKS_MAX: u16 = 60_000;

/// Largest delay of a device's force that the settings accept \[ticks\].
pub const DELAY_MAX: u8 = 16;

/// Range of a tick's time \[s\].
pub const TICK_S: core::ops::RangeInclusive<f32> = 1.0e-5..=1.0;
/// Least stiffness of a coupling \[N/m\].
pub const COUPLING_MIN: f32 = 1.0;
/// Largest stiffness of a coupling \[N/m\], and largest damping \[N s/m\].
pub const COUPLING_MAX: f32 = 1.0e6;

/// Largest speed of a hand; the fastest arm strokes are slower [m/s].
pub const HAND_SPEED_MAX_M_PER_S: f32 = 5.0;

kept! {
    /// A spring and damper between the device and the tool in the tissue.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Coupling {
        /// Stiffness, [`COUPLING_MIN`] to [`COUPLING_MAX`] \[N/m\].
        pub stiffness_n_per_m: f32,
        /// Damping, 0 to [`COUPLING_MAX`] [N s/m].
        pub damping_n_s_per_m: f32,
    }
}

kept! {
    /// Assumptions of the passivity observer about the device.
    ///
    /// If the controller cannot compensate the generated energy, the force is lowered along the ramp. That needs
    /// [`StageSettings::ramp_ticks`] of 2 or more.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Passivity {
        /// Damping that the device's mechanics have at least, 0 to [`COUPLING_MAX`] [N s/m].
        pub device_damping_n_s_per_m: f32,
        /// Ticks between an answer and the device's force, at most [`DELAY_MAX`]: 0 if the force of a tick acts
        /// from that tick's sample to the next, 1 if it acts a tick later. From 2 on the coupling shows at most
        /// 0.65 of [`passive_stiffness_n_per_m`](super::passive_stiffness_n_per_m).
        pub delay_ticks: u8,
    }
}

choices! {
    /// A haptic device by its published limits.
    Device {
        /// 3D Systems Touch: 3.3 N, 400 N/m.
        Touch = 0, "touch";
        /// 3D Systems Phantom Premium 3.0: 22 N, 1000 N/m.
        Premium = 1, "premium";
        /// Novint Falcon: 8 N, 3000 N/m.
        Falcon = 2, "falcon";
        /// Force Dimension omega: 12 N, 5000 N/m.
        Omega = 3, "omega";
        /// Force Dimension sigma.7: 12 N, 4000 N/m.
        Sigma = 4, "sigma";
    }
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

    /// Largest stiffness that the device can show \[N/m\].
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

    /// Stiffness of the default coupling: the device's, or the most at which the controller keeps a handle of
    /// its mass quiet in a loose hand, despite the encoder's quantisation \[N/m\].
    #[must_use]
    pub const fn coupling_n_per_m(self) -> f32 {
        match self {
            Self::Touch => 400.0,
            Self::Premium | Self::Falcon => 1000.0,
            Self::Omega | Self::Sigma => 2000.0,
        }
    }

    /// Damping of the default coupling, which keeps a soft hand from oscillating; 0 where the encoder's
    /// counts are too coarse to be damped [N s/m].
    #[must_use]
    pub const fn coupling_n_s_per_m(self) -> f32 {
        match self {
            Self::Touch | Self::Premium | Self::Falcon => 0.0,
            Self::Omega | Self::Sigma => 0.5,
        }
    }
}

kept! {
    /// Settings of the output stage; each part may be absent.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct StageSettings {
        /// Time of a tick, within [`TICK_S`] \[s\].
        pub tick_s: f32,
        /// Virtual coupling.
        pub coupling: Option<Coupling>,
        /// Passivity observer and controller.
        pub passivity: Option<Passivity>,
        /// Largest change of the force, infinite for none [N/s].
        pub max_slew_n_per_s: f32,
        /// Largest force, infinite for none \[N\].
        pub max_force_n: f32,
        /// Largest speed of the hand, infinite for none: an engaged pose that is farther from the last one than
        /// this allows is a bad sample [m/s].
        pub max_speed_m_per_s: f32,
        /// Ticks in which the force rises to its full value after engaging and after a silence, and in
        /// which it falls to zero when samples stop; 0 for none.
        pub ramp_ticks: u16,
        /// Ticks without a sample after which the force falls to zero, 0 for never.
        pub watchdog_ticks: u16,
    }
}

impl StageSettings {
    /// Only the finite check, at 1 kHz.
    pub const NONE: Self = Self {
        tick_s: 1.0e-3,
        coupling: None,
        passivity: None,
        max_slew_n_per_s: f32::INFINITY,
        max_force_n: f32::INFINITY,
        max_speed_m_per_s: f32::INFINITY,
        ramp_ticks: 0,
        watchdog_ticks: 0,
    };

    /// All parts, for a device at 1 kHz whose force acts a tick late: [`Device::coupling_n_per_m`] and
    /// [`Device::coupling_n_s_per_m`], 0.5 N s/m of mechanical damping, full force in 10 ms, hand speeds up
    /// to [`HAND_SPEED_MAX_M_PER_S`], a ramp of 100 ms, and a watchdog of 20 ms.
    #[must_use]
    pub const fn for_device(device: Device) -> Self {
        Self {
            coupling: Some(Coupling {
                stiffness_n_per_m: device.coupling_n_per_m(),
                damping_n_s_per_m: device.coupling_n_s_per_m(),
            }),
            passivity: Some(Passivity { device_damping_n_s_per_m: 0.5, delay_ticks: 1 }),
            max_slew_n_per_s: 100.0 * device.max_force_n(),
            max_force_n: device.max_force_n(),
            max_speed_m_per_s: HAND_SPEED_MAX_M_PER_S,
            ramp_ticks: 100,
            watchdog_ticks: 20,
            ..Self::NONE
        }
    }

    /// Checks the range of every setting.
    ///
    /// # Errors
    /// The first setting that is out of range.
    pub fn check(&self) -> Result<(), StageError> {
        let above_0 = |x: f32| x > 0.0;
        let damping = |x: f32| (0.0..=COUPLING_MAX).contains(&x);
        let coupling = self.coupling.is_none_or(|of| {
            let stiffness = of.stiffness_n_per_m;
            (COUPLING_MIN..=COUPLING_MAX).contains(&stiffness) && damping(of.damping_n_s_per_m)
        });
        let delay_max = if self.coupling.is_some() { DELAY_MAX } else { 1 };
        let passivity = self
            .passivity
            .is_none_or(|of| damping(of.device_damping_n_s_per_m) && of.delay_ticks <= delay_max);
        if !TICK_S.contains(&self.tick_s) {
            Err(StageError::Tick)
        } else if !coupling {
            Err(StageError::Coupling)
        } else if !passivity {
            Err(StageError::Passivity)
        } else if !above_0(self.max_slew_n_per_s) {
            Err(StageError::Slew)
        } else if !above_0(self.max_force_n) {
            Err(StageError::MaxForce)
        } else if !above_0(self.max_speed_m_per_s) {
            Err(StageError::MaxSpeed)
        } else if self.ramp_ticks > TICKS_MAX || self.watchdog_ticks > TICKS_MAX {
            Err(StageError::Ticks)
        } else {
            Ok(())
        }
    }
}

/// The setting of a stage that is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum StageError {
    /// The time of a tick is not within [`TICK_S`].
    #[error("the time of a tick must be 1e-5 to 1 s")]
    Tick,
    /// The coupling's stiffness is below [`COUPLING_MIN`], its damping negative, or one above
    /// [`COUPLING_MAX`].
    #[error("the coupling's stiffness must be 1 to 1e6 N/m, its damping 0 to 1e6 N s/m")]
    Coupling,
    /// The device's damping is negative or above [`COUPLING_MAX`], or the delay above [`DELAY_MAX`],
    /// or above 1 tick without a coupling.
    #[error(
        "the device's damping must be 0 to 1e6 N s/m, the delay 0 to 16 ticks, \
             without a coupling 0 or 1"
    )]
    Passivity,
    /// The slew limit is not positive.
    #[error("the slew limit must be positive")]
    Slew,
    /// The largest force is not positive.
    #[error("the largest force must be positive")]
    MaxForce,
    /// The hand's largest speed is not positive.
    #[error("the hand's largest speed must be positive")]
    MaxSpeed,
    /// A ramp or a watchdog above [`TICKS_MAX`].
    #[error("ramp and watchdog must be at most 60000 ticks")]
    Ticks,
}
