//! What a user chooses between: a scheme, and for `track` whether the body has its coarse level.

use std::fmt;

use chaincell_kernel::Choice;
use serde::{Serialize, Serializer};

use chaincell_host::engine::Scheme;

/// A scheme on a body with or without hats.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// The scheme.
    pub scheme: Scheme,
    /// Whether the body keeps the coarse level that the bake gives it by its size.
    pub hats: bool,
}

impl Setting {
    /// `track` as it comes.
    pub const TRACK: Self = Self { scheme: Scheme::Track, hats: true };

    /// `predict` as it comes.
    pub const PREDICT: Self = Self { scheme: Scheme::Predict, hats: true };

    /// Those that the tables of a moving tool compare; the first one is the engine's default.
    pub const COMPARED: [Self; 4] = [
        Self::TRACK,
        Self::PREDICT,
        Self { hats: false, ..Self::PREDICT },
        Self { hats: false, ..Self::TRACK },
    ];

    /// Every scheme on a body, and `track` once more without the hats where it has some.
    #[must_use]
    pub fn all(has_hats: bool) -> Vec<Self> {
        let schemes = Scheme::ALL.iter();
        let mut all: Vec<Self> = schemes.map(|&scheme| Self { scheme, hats: true }).collect();
        if has_hats {
            all.push(Self { scheme: Scheme::Track, hats: false });
        }
        all
    }
}

impl Default for Setting {
    fn default() -> Self {
        Self::TRACK
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.scheme.name())?;
        if self.hats { Ok(()) } else { f.write_str(" without hats") }
    }
}

impl Serialize for Setting {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
