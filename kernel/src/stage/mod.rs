//! The output stage: what stands between a tissue's answer and a hand.

mod settings;

pub use settings::{Coupling, Device, Passivity, StageError, StageSettings, TICKS_MAX};

use crate::sample::{TickOutput, ToolSample};

/// The output stage of one device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    settings: StageSettings,
}

impl Stage {
    /// A stage at rest.
    ///
    /// # Errors
    /// The first setting that is out of range.
    pub fn new(settings: StageSettings) -> Result<Self, StageError> {
        Ok(Self { settings })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &StageSettings {
        &self.settings
    }

    /// What the tissue is given for what the device has measured: the tool behind the coupling.
    pub fn sample(&mut self, device: &ToolSample) -> ToolSample {
        *device
    }

    /// What the device is given for what the tissue has answered to [`Self::sample`].
    pub fn output(&mut self, tissue: &TickOutput) -> TickOutput {
        *tissue
    }

    /// What the device is given in a tick without a sample; the tissue has no tick then.
    pub fn missed(&mut self) -> TickOutput {
        TickOutput {
            force_n: nalgebra::Vector3::zeros(),
            energy_j: 0.0,
            contacts: 0,
            flags: crate::sample::Flags::default(),
        }
    }
}
