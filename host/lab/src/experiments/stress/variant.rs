//! Every scheme in every number type that it has, `track` with and without hats.

use std::fmt;

use chaincell_kernel::Choice;

use super::energy::FIXED_RESOLUTION;
use super::watch::Certificate;
use chaincell_host::engine::{Arithmetic, Scheme};

/// A way to compute a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// The scheme.
    pub scheme: Scheme,
    /// The numbers.
    pub numbers: Arithmetic,
    /// Whether the model has a coarse level.
    pub hats: bool,
}

impl Variant {
    /// All of them, `track` with hats first.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let of = |scheme, numbers| Self { scheme, numbers, hats: false };
        let default = Self { hats: true, ..of(Scheme::Track, Arithmetic::F32) };
        let plain = Scheme::ALL.iter().map(|&scheme| of(scheme, Arithmetic::F32));
        let others = [Scheme::Track, Scheme::Euler]
            .map(|scheme| [Arithmetic::Fixed, Arithmetic::F64].map(|numbers| of(scheme, numbers)));
        std::iter::once(default).chain(plain).chain(others.concat()).collect()
    }

    /// What the numbers leave open of a length, beyond rounding [mean link lengths].
    #[must_use]
    pub fn resolution(&self) -> f64 {
        if self.numbers == Arithmetic::Fixed { FIXED_RESOLUTION } else { 0.0 }
    }

    /// What the scheme's level says.
    #[must_use]
    pub fn certificate(&self) -> Certificate {
        match self.scheme {
            Scheme::Euler => Certificate::Behind,
            // Its level is reckoned over many sweeps from one measurement: each step rounds.
            Scheme::GaussSeidel => Certificate::Above(2.0),
            _ => Certificate::Above(1.0),
        }
    }

    /// Link passes a tick: a super-step takes several.
    #[must_use]
    pub fn sweeps(&self) -> u16 {
        if self.scheme.goes_by_tick() { 9 } else { 4 }
    }
}

impl fmt::Display for Variant {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hats = if self.hats { "+hats" } else { "" };
        write!(f, "{}{hats} {}", self.scheme.name(), self.numbers.name())
    }
}
