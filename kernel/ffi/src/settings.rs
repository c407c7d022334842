//! Schemes and the parameters of a run.

pub use chaincell_kernel::PlainSettings as Settings;
use chaincell_kernel::{Arithmetic, Model, Network};

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

/// The defaults of a scheme: what 4 sweeps cover where it goes by the tick's time.
fn defaults(model: &Model<'_>, scheme: Scheme) -> Settings {
    let sweeps = chaincell_kernel::Settings::for_model(model).sweeps;
    scheme.kernel().0.settings(model, sweeps).plain()
}

/// The network of these settings, if they fit the model.
pub(crate) fn network(
    settings: &Settings,
    model: Model<'static>,
) -> Result<Network<'static>, Refusal> {
    let settings = settings.settings().map_err(|name| match name {
        "sweeps" => Code::SettingsSweeps,
        "unloading" => Code::SettingsUnloading,
        "drive" => Code::SettingsDrive,
        "cut" => Code::SettingsCut,
        _ => Code::Range,
    })?;
    Ok(Network::new(model, settings)?)
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
        let value = defaults(&model, Scheme::of(scheme)?);
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(settings, value) }
    }))
}
