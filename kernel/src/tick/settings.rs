//! Settings of a run, checked once against the model.

use super::choices::{Drive, Unloading};
use crate::model::Model;

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
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Sweeps per tick, at least 1.
    pub sweeps: u16,
    /// Common step of `euler` per sweep, at most [`Model::step_max`] [dimensionless time].
    pub step: f32,
    /// Time that `rkl2` advances per tick, at least [`Model::tick_time_min`] [dimensionless time].
    pub tick_time: f32,
    /// Largest motion of the contact cells per tick, or largest change of the current per tick \[m\].
    pub max_tool_step_m: f32,
    /// How the tool's displacement acts on chosen cells, from the next time that the tool engages.
    pub drive: Drive,
    /// Rule by which the bands close.
    pub unloading: Unloading,
    /// Largest magnitude of the force; infinite means no limit \[N\].
    /// A limit below 1e-15 N admits no force.
    pub max_force_n: f32,
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
    #[error("the time a tick must be finite and at least {min}")]
    TickTime {
        /// The smallest time.
        min: f32,
    },
    /// The tool's largest step is not positive and finite.
    #[error("the largest tool step must be positive and finite")]
    MaxToolStep,
    /// The largest force is not positive.
    #[error("the largest force must be positive")]
    MaxForce,
}

impl Settings {
    /// The defaults for a model: 4 sweeps, nine tenths of the step bound, that bound as the time per tick,
    /// one mean link length of tool motion per tick, prescribed positions, unloading on release, no force
    /// limit.
    #[must_use]
    pub fn for_model(model: &Model<'_>) -> Self {
        Self {
            sweeps: 4,
            step: 0.9 * model.step_max(),
            tick_time: model.step_max(),
            max_tool_step_m: model.unit_m(),
            drive: Drive::Position,
            unloading: Unloading::Release,
            max_force_n: f32::INFINITY,
        }
    }
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
        let (max, min) = (model.step_max(), model.tick_time_min());
        if settings.sweeps == 0 {
            Err(SettingsError::Sweeps)
        } else if !(settings.step > 0.0 && settings.step <= max) {
            Err(SettingsError::Step { max })
        } else if !(settings.tick_time >= min && settings.tick_time.is_finite()) {
            Err(SettingsError::TickTime { min })
        } else if !(settings.max_tool_step_m > 0.0 && settings.max_tool_step_m.is_finite()) {
            Err(SettingsError::MaxToolStep)
        } else if settings.max_force_n.is_nan() || settings.max_force_n <= 0.0 {
            Err(SettingsError::MaxForce)
        } else {
            Ok(Self { model, settings })
        }
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
