//! Schemes and the parameters of a run.

use chaincell_kernel::{Arithmetic, Choice, Model, Network};

use crate::code::{Code, Refusal};
use crate::memory;
use crate::model::{ModelStorage, load};

/// The scheme that moves the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum Scheme {
    /// Follows the equilibrium: conjugate directions under an energy guard, with the model's coarse functions.
    Track = 0,
    /// One explicit step of common size a sweep: relaxation in time, 32 bytes a cell.
    Euler = 1,
    /// Runge-Kutta-Legendre super-steps of second order: the trajectory in time beyond the bound of
    /// euler.
    Rkl2 = 3,
    /// Track in fixed point, for targets without an FPU; without a coarse level.
    TrackFixed = 5,
    /// Euler in fixed point.
    EulerFixed = 6,
    /// Track that knows how the body answers a move of the chosen cells: 112 bytes a cell. Not in a
    /// library that was built without the feature `predict`.
    Predict = 7,
}

impl Scheme {
    /// Every scheme.
    pub(crate) const ALL: [Self; 6] =
        [Self::Track, Self::Euler, Self::Rkl2, Self::TrackFixed, Self::EulerFixed, Self::Predict];

    /// The scheme of a number from C.
    pub(crate) fn of(number: i32) -> Result<Self, Code> {
        let is_built = |scheme: &Self| *scheme != Self::Predict || cfg!(feature = "predict");
        let found = Self::ALL.into_iter().find(|&scheme| scheme as i32 == number);
        found.filter(is_built).ok_or(Code::Scheme)
    }

    /// The kernel's scheme, and what it computes in.
    pub(crate) const fn kernel(self) -> (chaincell_kernel::Scheme, Arithmetic) {
        use chaincell_kernel::Scheme;
        match self {
            Self::Track => (Scheme::Track, Arithmetic::F32),
            Self::Euler => (Scheme::Euler, Arithmetic::F32),
            Self::Rkl2 => (Scheme::Rkl2, Arithmetic::F32),
            Self::TrackFixed => (Scheme::Track, Arithmetic::Fixed),
            Self::EulerFixed => (Scheme::Euler, Arithmetic::Fixed),
            Self::Predict => (Scheme::Predict, Arithmetic::F32),
        }
    }
}

/// The value of a code from C.
pub(crate) fn chosen<T: Choice>(code: i32) -> Option<T> {
    u16::try_from(code).ok().and_then(T::from_code)
}

/// When the links' bands close to their rest lengths.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum UnloadingMode {
    /// Never.
    Off = 0,
    /// From the tool's release until it takes hold again.
    Release = 1,
    /// As release, and while the tool has come back by more than a tenth of a mean link length
    /// from its deepest point, until it passes that.
    Retreat = 2,
}

/// What the tool's displacement does to its contact cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(i32)]
pub enum DriveMode {
    /// It prescribes their positions.
    Position = 0,
    /// It is the current into each of them, a load of 2 k times the displacement \[N\]: Eq. 2 of
    /// the paper.
    Current = 1,
}

/// Parameters of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct Settings {
    /// Sweeps a tick, 1 to 65,535.
    pub sweeps: u32,
    /// When the bands close, one of `chaincell_unloading`.
    pub unloading: i32,
    /// Common step of euler a sweep, at most the model's `step_max` \[dimensionless time\].
    pub step: f32,
    /// Time that rkl2 advances a tick \[dimensionless time\].
    pub tick_time: f32,
    /// Largest motion of the contact cells, or change of the current, a tick \[m\].
    pub max_tool_step_m: f32,
    /// Largest magnitude of the force; infinite means no limit \[N\].
    pub max_force_n: f32,
    /// What the tool's displacement does, one of `chaincell_drive`; counts from the next time the
    /// tool takes hold.
    pub drive: i32,
}

impl Settings {
    /// The defaults of a scheme: what 4 sweeps cover where it goes by the tick's time.
    fn defaults(model: &Model<'_>, scheme: Scheme) -> Self {
        let sweeps = chaincell_kernel::Settings::for_model(model).sweeps;
        let kernel = scheme.kernel().0.settings(model, sweeps);
        Self {
            sweeps: u32::from(kernel.sweeps),
            unloading: kernel.unloading.code().into(),
            step: kernel.step,
            tick_time: kernel.tick_time,
            max_tool_step_m: kernel.max_tool_step_m,
            max_force_n: kernel.max_force_n,
            drive: kernel.drive.code().into(),
        }
    }

    /// The network of these settings, if they fit the model.
    pub(crate) fn network(self, model: Model<'static>) -> Result<Network<'static>, Refusal> {
        let unloading = chosen(self.unloading).ok_or(Code::SettingsUnloading)?;
        let drive = chosen(self.drive).ok_or(Code::SettingsDrive)?;
        let settings = chaincell_kernel::Settings {
            sweeps: u16::try_from(self.sweeps).map_err(|_| Code::SettingsSweeps)?,
            step: self.step,
            tick_time: self.tick_time,
            max_tool_step_m: self.max_tool_step_m,
            drive,
            unloading,
            max_force_n: self.max_force_n,
        };
        Ok(Network::new(model, settings)?)
    }
}

/// The defaults for a model and a scheme (one of `chaincell_scheme`): 4 sweeps, nine tenths of the
/// step bound, for rkl2 the time that 4 sweeps cover, one mean link length a tick,
/// prescribed positions, unloading on release, no force limit.
///
/// # Safety
/// `model` is storage for a model, `settings` storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_settings_default(
    model: *const ModelStorage,
    scheme: i32,
    settings: *mut Settings,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { load(model) }.and_then(|model| {
        memory::check(settings)?;
        let value = Settings::defaults(&model, Scheme::of(scheme)?);
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(settings, value) }
    }))
}
