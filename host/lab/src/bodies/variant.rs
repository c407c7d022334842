//! The ways to compute a body: every scheme in every number type that it has.

use std::fmt;

use super::body::Body;
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_host::error::{Error, Result};
use chaincell_kernel::{Choice, Model, Network, Settings, Unloading};

/// A scheme in a number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// The scheme.
    pub scheme: Scheme,
    /// The numbers.
    pub numbers: Arithmetic,
    /// Whether the model has a coarse level.
    pub coarse: bool,
}

impl Variant {
    /// A variant without a coarse level.
    #[must_use]
    pub fn plain(scheme: Scheme, numbers: Arithmetic) -> Self {
        Self { scheme, numbers, coarse: false }
    }

    /// A scheme in single precision, with a coarse level or without.
    #[must_use]
    pub const fn single(scheme: Scheme, coarse: bool) -> Self {
        Self { scheme, numbers: Arithmetic::F32, coarse }
    }

    /// Every scheme in single precision, then those that have fixed point in it; none with a
    /// coarse level.
    #[must_use]
    pub fn plain_ones() -> Vec<Self> {
        let schemes = Scheme::ALL.iter();
        let others =
            [Scheme::Track, Scheme::Euler].map(|scheme| Self::plain(scheme, Arithmetic::Fixed));
        schemes.map(|&scheme| Self::single(scheme, false)).chain(others).collect()
    }

    /// All of them, `track` with a coarse level first.
    #[must_use]
    pub fn all() -> Vec<Self> {
        std::iter::once(Self::single(Scheme::Track, true)).chain(Self::plain_ones()).collect()
    }

    /// Those that compute nodal shapes.
    #[must_use]
    pub fn of_shapes() -> Vec<Self> {
        let schemes = [Scheme::Track, Scheme::Predict];
        schemes
            .iter()
            .flat_map(|&one| [true, false].map(|coarse| Self::single(one, coarse)))
            .collect()
    }

    /// Whether it moves a body of nodal shapes: the others move links alone.
    #[must_use]
    pub fn takes_shapes(&self) -> bool {
        Self::of_shapes().contains(self)
    }

    /// Those that move a body.
    ///
    /// # Errors
    /// As [`Body::plain`].
    pub fn of_body(body: &Body) -> Result<Vec<Self>> {
        Ok(if body.plain()?.is_nodal() { Self::of_shapes() } else { Self::all() })
    }

    /// Those without a coarse level that move a model.
    #[must_use]
    pub fn plain_of(model: &Model<'_>) -> Vec<Self> {
        let all = Self::plain_ones().into_iter();
        all.filter(|one| !model.is_nodal() || one.takes_shapes()).collect()
    }

    /// Those of them in single precision.
    #[must_use]
    pub fn singles_of(model: &Model<'_>) -> Vec<Self> {
        let all = Self::plain_of(model).into_iter();
        all.filter(|one| one.numbers == Arithmetic::F32).collect()
    }

    /// An engine at rest with the scheme's settings for so many `sweeps` a tick, `change`d.
    ///
    /// # Errors
    /// As [`Engine::with_contact`]; settings that do not fit the model.
    pub fn engine<'m>(
        &self,
        model: Model<'m>,
        contact: Contact,
        sweeps: u16,
        change: impl FnOnce(Settings) -> Settings,
    ) -> Result<Engine<'m>> {
        let settings = change(self.scheme.settings(&model, sweeps));
        let network = Network::new(model, settings).map_err(Error::check)?;
        Engine::with_contact(network, self.scheme, self.numbers, contact)
    }

    /// The same with a tool that is never slowed down and bands that stay as they are.
    ///
    /// # Errors
    /// As [`Self::engine`].
    pub fn unlimited<'m>(
        &self,
        model: Model<'m>,
        contact: Contact,
        sweeps: u16,
        change: impl FnOnce(Settings) -> Settings,
    ) -> Result<Engine<'m>> {
        let max_tool_step_m = 1e3 * model.unit_m();
        self.engine(model, contact, sweeps, |settings| {
            change(Settings { max_tool_step_m, unloading: Unloading::Off, ..settings })
        })
    }

    /// Link passes a tick: a super-step takes several.
    #[must_use]
    pub fn sweeps(&self) -> u16 {
        if self.scheme.goes_by_tick() { 9 } else { 4 }
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let coarse = if self.coarse { "+coarse" } else { "" };
        write!(f, "{}{coarse} {}", self.scheme.name(), self.numbers.name())
    }
}
