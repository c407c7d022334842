//! Settings of a run, checked once against the model.

use super::choice::Choice;
use super::choices::{Cutting, Drive, Scheme, Unloading};
use crate::model::Model;
use crate::solver::{Dynamics, Rkl2};

/// Defines the settings in one table: each line is `name: type, value of the option, default in words = default,
/// check;` after its meaning. An empty value stands for no option. The C struct, the options, the reference's table and
/// Python's arguments are made from the same lines; traces and snapshots hold [`Settings::words`].
macro_rules! settings {
    ($(#[doc = $of_all:literal])+ $all:ident, $plain:ident {
        $($(#[doc = $meaning:literal])+ $name:ident: $type:ty, $value:literal, $words:literal
            = $default:expr, $check:expr;)+
    }) => {
        $(#[doc = $of_all])+
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $all {
            $($(#[doc = $meaning])+ pub $name: $type,)+
        }

        /// The settings as numbers, in the layout of C. Choices stand there with their codes.
        ///
        /// ```
        /// # use chaincell_kernel::{Model, include_model};
        /// use chaincell_kernel::{PlainSettings, Settings};
        /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
        /// # let model = Model::from_bytes(image)?;
        ///
        /// let plain = Settings::for_model(&model).plain();
        /// assert_eq!(plain.settings(), Ok(Settings::for_model(&model)));
        /// assert_eq!(PlainSettings { drive: 2, ..plain }.settings(), Err("drive"));
        /// # Ok::<(), chaincell_kernel::ModelError>(())
        /// ```
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        #[repr(C)]
        pub struct $plain {
            $($(#[doc = $meaning])+ pub $name: <$type as Word>::Plain,)+
        }

        impl $all {
            /// Number of settings.
            pub const COUNT: usize = [$(stringify!($name)),+].len();

            /// The lines of the table.
            pub const FIELDS: [SettingField; Self::COUNT] = [$(SettingField {
                name: stringify!($name),
                kind: <$type as Word>::KIND,
                meaning: concat!($($meaning, "\n"),+),
                value: $value,
                default: $words,
            }),+];

            /// The defaults for a model: 4 sweeps, nine tenths of the step bound, that bound as the time per
            /// tick, one mean link length of tool motion per tick, prescribed positions, unloading on release,
            /// no force limit.
            #[must_use]
            pub fn for_model(model: &Model<'_>) -> Self {
                Self { $($name: of_model($default, model)),+ }
            }

            /// Checks every setting against the model.
            fn check(&self, model: &Model<'_>) -> Result<(), SettingsError> {
                $(checked($check, self.$name, model)?;)+
                Ok(())
            }

            /// Returns a word for each setting, in the order of [`Self::FIELDS`].
            #[must_use]
            pub fn each(&self) -> [u32; Self::COUNT] {
                [$(self.$name.word()),+]
            }

            /// Returns the settings of a word for each; `None` if one has no meaning. [`Network::new`] checks the
            /// ranges.
            #[must_use]
            pub fn from_each([$($name),+]: [u32; Self::COUNT]) -> Option<Self> {
                Some(Self { $($name: Word::of_word($name)?),+ })
            }

            /// Returns the settings as numbers.
            #[must_use]
            pub fn plain(&self) -> $plain {
                $plain { $($name: self.$name.plain()),+ }
            }
        }

        impl $plain {
            /// Returns the settings of numbers. [`Network::new`] checks the ranges.
            ///
            /// # Errors
            /// The name of the first setting whose number has no meaning.
            pub fn settings(&self) -> Result<$all, &'static str> {
                Ok($all { $($name: Word::of_plain(self.$name).ok_or(stringify!($name))?),+ })
            }
        }
    };
}

settings! {
    /// Parameters of a run.
    ///
    /// ```
    /// # use chaincell_kernel::{Model, Network, include_model};
    /// use chaincell_kernel::Settings;
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    ///
    /// let settings = Settings { sweeps: 1, max_force_n: 3.0, ..Settings::for_model(&model) };
    /// assert_eq!(settings.max_tool_step_m, model.unit_m()); // [m] a tick: one mean link length
    /// assert!(Network::new(model, settings).is_ok());
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    Settings, PlainSettings {
        /// Sweeps per tick, 1 to 65,535.
        sweeps: u16, "N", "4" = |_| 4, |sweeps, _| unless(sweeps > 0, SettingsError::Sweeps);
        /// Time that `euler` advances per sweep, at most the model's bound `step_max`; on the command line and in
        /// Python also the time that `rkl2` advances per tick \[dimensionless\].
        step: f32, "H", "0.9 of the bound; for rkl2 what the sweeps cover"
            = |model| 0.9 * model.step_max(), |step, model| {
                let max = model.step_max();
                unless(step > 0.0 && step <= max, SettingsError::Step { max })
            };
        /// Time that `rkl2` advances per tick, at least 1e-12 of `step_max` \[dimensionless\].
        tick_time: f32, "", "what the sweeps cover" = |model| model.step_max(), |time, model| {
            let min = model.tick_time_min();
            unless(time >= min && time.is_finite(), SettingsError::TickTime { min })
        };
        /// Largest motion of the contact cells per tick, or largest change of the current per tick \[m\].
        max_tool_step_m: f32, "D", "one mean link length" = |model| model.unit_m(), |step_m, _| {
            unless(step_m > 0.0 && step_m.is_finite(), SettingsError::MaxToolStep)
        };
        /// Largest magnitude of the force; a larger one is shortened and flagged. A limit below 1e-15 N admits no
        /// force, an infinite one is none \[N\].
        max_force_n: f32, "F", "no limit" = |_| f32::INFINITY, |force_n, _| {
            unless(force_n > 0.0, SettingsError::MaxForce)
        };
        /// When the links' bands close to their rest lengths. Those of links that relax stay open: unloading lies
        /// below loading by itself.
        unloading: Unloading, "UNLOADING", "release, of links that relax off"
            = |model| if model.keeps_bands() { Unloading::Off } else { Unloading::default() },
            |unloading, model| {
                unless(!model.keeps_bands() || unloading == Unloading::Off, SettingsError::Unloading)
            };
        /// How the tool's displacement acts on chosen cells, from the next time that the tool engages.
        drive: Drive, "DRIVE", "position" = |_| Drive::default(), |_, _| Ok(());
        /// Cutting by blades and tearing; off, a blade feels nothing and no body tears.
        cut: Cutting, "CUT", "on" = |_| Cutting::default(), |_, _| Ok(());
    }
}

impl Settings {
    /// Number of words in traces and snapshots.
    pub const WORDS: usize = Self::COUNT - 1;

    /// Returns the settings as words of traces and snapshots: one for each, but `cut` in the upper half of the word of
    /// `drive`, where 0 is on.
    #[must_use]
    pub fn words(&self) -> [u32; Self::WORDS] {
        let [sweeps, step, time, step_m, force_n, unloading, drive, cut] = self.each();
        [sweeps, step, time, step_m, force_n, unloading, drive | cut << 16]
    }

    /// Returns the settings of such words; `None` if one has no meaning. [`Network::new`] checks the ranges.
    #[must_use]
    pub fn from_words(words: [u32; Self::WORDS]) -> Option<Self> {
        let [sweeps, step, time, step_m, force_n, unloading, last] = words;
        let (drive, cut) = (last & 0xffff, last >> 16);
        Self::from_each([sweeps, step, time, step_m, force_n, unloading, drive, cut])
    }
}

/// A setting as front ends show it: a line of the table.
///
/// ```
/// use chaincell_kernel::{SettingKind, Settings};
///
/// let [sweeps, ..] = Settings::FIELDS;
/// assert_eq!((sweeps.name, sweeps.kind, sweeps.default), ("sweeps", SettingKind::Whole, "4"));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SettingField {
    /// Its name, as the field of [`Settings`].
    pub name: &'static str,
    /// Its values.
    pub kind: SettingKind,
    /// Its meaning, with the unit in brackets.
    pub meaning: &'static str,
    /// How help names the value of its option; empty if it has none.
    pub value: &'static str,
    /// Its default in words.
    pub default: &'static str,
}

/// The values of a setting.
///
/// ```
/// use chaincell_kernel::{Choice, Drive, SettingKind, Settings};
///
/// let drive = Settings::FIELDS.into_iter().find(|field| field.name == "drive");
/// assert_eq!(drive.map(|field| field.kind), Some(SettingKind::Choice(Drive::TABLE)));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SettingKind {
    /// Whole numbers.
    Whole,
    /// Numbers, which may be infinite.
    Real,
    /// The lines of a [`Choice`].
    Choice(&'static [(u16, &'static str, &'static str)]),
}

impl Scheme {
    /// The defaults of a scheme with `sweeps` sweeps per tick. A scheme that uses [`Settings::tick_time`]
    /// gets the time that those sweeps cover.
    ///
    /// ```
    /// # use chaincell_kernel::{Model, include_model};
    /// use chaincell_kernel::Scheme;
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    ///
    /// let settings = Scheme::Rkl2.settings(&model, 8);
    /// // Eight sweeps of `euler` cover at most eight times its largest step.
    /// assert!(settings.tick_time > 1.5 * 8.0 * model.step_max()); // [dimensionless time]
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    #[must_use]
    pub fn settings(self, model: &Model<'_>, sweeps: u16) -> Settings {
        let defaults = Settings::for_model(model);
        let tick_time = match self {
            Self::Rkl2 => Rkl2::tick_time(model, sweeps),
            Self::Euler | Self::Track | Self::Predict => defaults.tick_time,
        };
        Settings { sweeps, tick_time, ..defaults }
    }
}

/// A setting's default.
fn of_model<T>(default: impl Fn(&Model<'_>) -> T, model: &Model<'_>) -> T {
    default(model)
}

/// The check of a setting.
fn checked<T>(
    check: impl Fn(T, &Model<'_>) -> Result<(), SettingsError>,
    value: T,
    model: &Model<'_>,
) -> Result<(), SettingsError> {
    check(value, model)
}

/// Refuses a value unless it is in its range.
fn unless(is_in_range: bool, why: SettingsError) -> Result<(), SettingsError> {
    if is_in_range { Ok(()) } else { Err(why) }
}

/// A setting as a word, and as a number of C.
///
/// ```
/// use chaincell_kernel::Drive;
/// use chaincell_kernel::tick::settings::Word;
///
/// assert_eq!((Drive::Current.word(), Drive::Current.plain()), (1, 1));
/// assert_eq!(Drive::of_plain(-1), None);
/// ```
pub trait Word: Sized {
    /// The type in C.
    type Plain;
    /// The values.
    const KIND: SettingKind;
    /// Returns the word of a value.
    fn word(self) -> u32;
    /// Returns the value of a word, if it has one.
    fn of_word(word: u32) -> Option<Self>;
    /// Returns the number of a value.
    fn plain(self) -> Self::Plain;
    /// Returns the value of a number, if it has one.
    fn of_plain(plain: Self::Plain) -> Option<Self>;
}

/// Whole numbers, which are `uint32_t` in C.
macro_rules! whole {
    ($($type:ty),+) => {$(
        impl Word for $type {
            type Plain = u32;
            const KIND: SettingKind = SettingKind::Whole;

            fn word(self) -> u32 {
                self.into()
            }

            fn of_word(word: u32) -> Option<Self> {
                Self::try_from(word).ok()
            }

            fn plain(self) -> u32 {
                self.into()
            }

            fn of_plain(plain: u32) -> Option<Self> {
                Self::try_from(plain).ok()
            }
        }
    )+};
}
whole!(u8, u16, u32);

impl Word for f32 {
    type Plain = Self;
    const KIND: SettingKind = SettingKind::Real;

    fn word(self) -> u32 {
        self.to_bits()
    }

    fn of_word(word: u32) -> Option<Self> {
        Some(Self::from_bits(word))
    }

    fn plain(self) -> Self {
        self
    }

    fn of_plain(plain: Self) -> Option<Self> {
        Some(plain)
    }
}

impl<T: Choice> Word for T {
    type Plain = i32;
    const KIND: SettingKind = SettingKind::Choice(T::TABLE);

    fn word(self) -> u32 {
        self.code().into()
    }

    fn of_word(word: u32) -> Option<Self> {
        Self::from_code(u16::try_from(word).ok()?)
    }

    fn plain(self) -> i32 {
        self.code().into()
    }

    fn of_plain(plain: i32) -> Option<Self> {
        Self::from_code(u16::try_from(plain).ok()?)
    }
}

/// Which setting is out of range.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, include_model};
/// use chaincell_kernel::SettingsError;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
///
/// let step = 2.0 * model.step_max(); // beyond it `euler` may make energy
/// let refused = Network::new(model, Settings { step, ..Settings::for_model(&model) });
/// assert_eq!(refused.err(), Some(SettingsError::Step { max: 0.25 }));
/// # Ok::<(), chaincell_kernel::ModelError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum SettingsError {
    /// There must be at least one sweep per tick.
    #[error("sweeps must be at least 1")]
    Sweeps,
    /// The step is not in (0, the bound]: beyond it the energy may grow.
    #[error("step must be above 0 and at most {max}, the model's proven bound")]
    Step {
        /// The proven bound.
        max: f32,
    },
    /// The time per tick is too small or not finite: if it is lost in rounding, no pass is made and the
    /// energy stays unknown.
    #[error("tick_time must be finite and at least {min}")]
    TickTime {
        /// The smallest time.
        min: f32,
    },
    /// The tool's largest step is not positive and finite.
    #[error("max_tool_step_m must be above 0 and finite")]
    MaxToolStep,
    /// The bands of links that relax do not close.
    #[error(
        "unloading must be off: the body's links relax, so unloading lies below loading by itself"
    )]
    Unloading,
    /// The largest force is not positive.
    #[error("max_force_n must be above 0")]
    MaxForce,
}

/// A model together with settings that fit it: all that a tick reads and never writes.
///
/// ```
/// # use chaincell_kernel::{Model, include_model};
/// use chaincell_kernel::{Network, Settings};
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
///
/// let network = Network::new(model, Settings::for_model(&model))?;
/// assert_eq!(network.settings().sweeps, 4); // link passes a tick
/// assert_eq!(network.model().cells(), 81);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Network<'m> {
    model: Model<'m>,
    settings: Settings,
}

impl<'m> Network<'m> {
    /// Checks the settings against the model.
    ///
    /// # Errors
    /// The first setting that is out of range, with the range.
    pub fn new(model: Model<'m>, settings: Settings) -> Result<Self, SettingsError> {
        settings.check(&model)?;
        Ok(Self { model, settings })
    }

    /// The same settings for the same body with cuts.
    #[cfg(any(feature = "cut", feature = "relax"))]
    pub(super) fn of_model<'a>(&self, model: Model<'a>) -> Network<'a> {
        Network { model, settings: self.settings }
    }

    /// The model.
    #[must_use]
    pub fn model(&self) -> &Model<'m> {
        &self.model
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &Settings {
        &self.settings
    }
}
