//! Settings of the output stage, and their check.

use super::device::Device;
use crate::number::kept::{Kept, kept};
use crate::tick::settings::{SettingField, Word};

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

/// Defines the settings in one table, in the order of traces and of C. A line is `name: type = value without its
/// limit, check, error;` after its meaning. A part may be absent: it is a struct of its own, whose lines are `field
/// as name in C: type, check;`. In traces and in C its fields follow a number that says whether it is there.
macro_rules! stage_settings {
    (
        $(#[doc = $of_all:literal])+ $all:ident, $plain:ident;
        first { $($(#[doc = $first_meaning:literal])+ $first:ident: $first_type:ty
            = $first_none:expr, $first_check:expr, $first_error:expr;)+ }
        $(part {
            $(#[doc = $of_part:literal])+ $name:ident: $part:ident, $error:expr;
            $($(#[doc = $meaning:literal])+ $field:ident as $flat:ident: $type:ty, $check:expr;)+
        })+
        last { $($(#[doc = $last_meaning:literal])+ $last:ident: $last_type:ty
            = $last_none:expr, $last_check:expr, $last_error:expr;)+ }
    ) => {
        $(kept! {
            $(#[doc = $of_part])+
            #[derive(Debug, Clone, Copy, PartialEq)]
            pub struct $part {
                $($(#[doc = $meaning])+ pub $field: $type,)+
            }
        })+

        kept! {
            $(#[doc = $of_all])+
            #[derive(Debug, Clone, Copy, PartialEq)]
            pub struct $all {
                $($(#[doc = $first_meaning])+ pub $first: $first_type,)+
                $($(#[doc = $of_part])+ pub $name: Option<$part>,)+
                $($(#[doc = $last_meaning])+ pub $last: $last_type,)+
            }
        }

        /// The settings as numbers, in the layout of C: before the fields of a part a number that is not 0 if the
        /// part is there.
        ///
        /// ```
        /// use chaincell_kernel::stage::{Device, PlainStageSettings, StageError, StageSettings};
        ///
        /// let settings = StageSettings::for_device(Device::Omega);
        /// let plain = settings.plain();
        /// assert_eq!((plain.coupling, plain.coupling_n_per_m), (1, 2000.0));
        /// assert_eq!(plain.settings(), Ok(settings));
        /// let long = PlainStageSettings { ramp_ticks: 100_000, ..plain };
        /// assert_eq!(long.settings(), Err(StageError::Ticks));
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        #[repr(C)]
        pub struct $plain {
            $($(#[doc = $first_meaning])+ pub $first: <$first_type as Word>::Plain,)+
            $($(#[doc = $of_part])+ pub $name: u32,
            $($(#[doc = $meaning])+ pub $flat: <$type as Word>::Plain,)+)+
            $($(#[doc = $last_meaning])+ pub $last: <$last_type as Word>::Plain,)+
        }

        impl $all {
            /// Only the finite check, at 1 kHz.
            pub const NONE: Self =
                Self { $($first: $first_none,)+ $($name: None,)+ $($last: $last_none,)+ };

            /// The lines of the table.
            pub const FIELDS: &'static [SettingField] = &[
                $(line::<$first_type>(stringify!($first), concat!($($first_meaning, "\n"),+)),)+
                $(line::<u32>(stringify!($name), concat!($($of_part, "\n",)+ " Other than 0 if it is there.\n")),
                $(line::<$type>(stringify!($flat), concat!($($meaning, "\n"),+)),)+)+
                $(line::<$last_type>(stringify!($last), concat!($($last_meaning, "\n"),+)),)+
            ];

            /// Checks the range of every setting.
            ///
            /// # Errors
            /// The first setting that is out of range.
            pub fn check(&self) -> Result<(), StageError> {
                $(checked($first_check, self.$first, self, $first_error)?;)+
                $(if let Some(part) = self.$name {
                    $(checked($check, part.$field, self, $error)?;)+
                })+
                $(checked($last_check, self.$last, self, $last_error)?;)+
                Ok(())
            }

            /// Returns the settings as numbers.
            #[must_use]
            pub fn plain(&self) -> $plain {
                $(let $name = self.$name.unwrap_or(Kept::BLANK);)+
                $plain {
                    $($first: self.$first.plain(),)+
                    $($name: self.$name.is_some().into(), $($flat: $name.$field.plain(),)+)+
                    $($last: self.$last.plain(),)+
                }
            }
        }

        impl $plain {
            /// Returns the settings of numbers. [`Stage::new`](super::Stage::new) checks the ranges.
            ///
            /// # Errors
            /// The first setting whose number is beyond its type.
            pub fn settings(&self) -> Result<$all, StageError> {
                Ok($all {
                    $($first: Word::of_plain(self.$first).ok_or($first_error)?,)+
                    $($name: match self.$name {
                        0 => None,
                        _ => Some($part {
                            $($field: Word::of_plain(self.$flat).ok_or($error)?,)+
                        }),
                    },)+
                    $($last: Word::of_plain(self.$last).ok_or($last_error)?,)+
                })
            }
        }
    };
}

stage_settings! {
    /// Settings of the output stage; each part may be absent.
    StageSettings, PlainStageSettings;
    first {
        /// Time of a tick, 1e-5 to 1 \[s\].
        tick_s: f32 = 1.0e-3, |tick_s, _| TICK_S.contains(&tick_s), StageError::Tick;
    }
    part {
        /// A spring and damper between the device and the tool in the tissue.
        coupling: Coupling, StageError::Coupling;
        /// Stiffness, 1 to 1e6 \[N/m\].
        stiffness_n_per_m as coupling_n_per_m: f32,
            |stiffness, _| (COUPLING_MIN..=COUPLING_MAX).contains(&stiffness);
        /// Damping, 0 to 1e6 \[N s/m\].
        damping_n_s_per_m as coupling_n_s_per_m: f32, |damping, _| is_damping(damping);
    }
    part {
        /// Assumptions of the passivity observer about the device. If the controller cannot compensate the
        /// generated energy, the force is lowered along the ramp, which needs `ramp_ticks` of 2 or more.
        passivity: Passivity, StageError::Passivity;
        /// Damping that the device's mechanics have at least, 0 to 1e6 \[N s/m\].
        device_damping_n_s_per_m as device_damping_n_s_per_m: f32, |damping, _| is_damping(damping);
        /// Ticks between an answer and the device's force, 0 to 16, without a coupling 0 or 1: 0 if the force of
        /// a tick acts from that tick's sample to the next, 1 if it acts a tick later. From 2 on the coupling
        /// shows at most 0.65 of the stiffness that is passive with this delay.
        delay_ticks as delay_ticks: u8, |ticks, settings: &StageSettings| {
            ticks <= if settings.coupling.is_some() { DELAY_MAX } else { 1 }
        };
    }
    last {
        /// Largest change of the force, infinite for none \[N/s\].
        max_slew_n_per_s: f32 = f32::INFINITY, |slew, _| slew > 0.0, StageError::Slew;
        /// Largest force, infinite for none \[N\].
        max_force_n: f32 = f32::INFINITY, |force_n, _| force_n > 0.0, StageError::MaxForce;
        /// Largest speed of the hand, infinite for none: an engaged pose that is farther from the last one than
        /// this allows is a bad sample \[m/s\].
        max_speed_m_per_s: f32 = f32::INFINITY, |speed, _| speed > 0.0, StageError::MaxSpeed;
        /// Ticks in which the force rises to its full value after engaging and after a silence, and in which it
        /// falls to zero when samples stop; 0 for none, at most 60,000.
        ramp_ticks: u16 = 0, |ticks, _| ticks <= TICKS_MAX, StageError::Ticks;
        /// Ticks without a sample after which the force falls to zero, 0 for never, at most 60,000.
        watchdog_ticks: u16 = 0, |ticks, _| ticks <= TICKS_MAX, StageError::Ticks;
    }
}

impl StageSettings {
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
}

/// A line of the table.
const fn line<T: Word>(name: &'static str, meaning: &'static str) -> SettingField {
    SettingField { name, kind: T::KIND, meaning, value: "", default: "" }
}

/// Checks a setting.
fn checked<T>(
    is_in_range: impl Fn(T, &StageSettings) -> bool,
    value: T,
    settings: &StageSettings,
    error: StageError,
) -> Result<(), StageError> {
    if is_in_range(value, settings) { Ok(()) } else { Err(error) }
}

/// Returns true for a damping in its range.
fn is_damping(damping_n_s_per_m: f32) -> bool {
    (0.0..=COUPLING_MAX).contains(&damping_n_s_per_m)
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
