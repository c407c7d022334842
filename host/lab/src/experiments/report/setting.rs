//! What a user chooses between: a scheme, and for `track` whether the body has its coarse level.

use std::fmt;

use chaincell_kernel::Choice;
use serde::{Serialize, Serializer};

use chaincell_host::engine::Scheme;

/// A scheme on a body with or without a coarse level.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Setting {
    /// The scheme.
    pub scheme: Scheme,
    /// Whether the body keeps the coarse level that the bake gives it by its size.
    pub coarse: bool,
}

impl Setting {
    /// `track` as it comes.
    pub const TRACK: Self = Self { scheme: Scheme::Track, coarse: true };

    /// `predict` as it comes.
    pub const PREDICT: Self = Self { scheme: Scheme::Predict, coarse: true };

    /// Those that the tables of a moving tool compare; the first one is the engine's default.
    pub const COMPARED: [Self; 4] = [
        Self::TRACK,
        Self::PREDICT,
        Self { coarse: false, ..Self::PREDICT },
        Self { coarse: false, ..Self::TRACK },
    ];

    /// Every scheme on a body, and `track` once more without a coarse level where it has some.
    #[must_use]
    pub fn all(is_coarse: bool) -> Vec<Self> {
        let schemes = Scheme::ALL.iter();
        let mut all: Vec<Self> = schemes.map(|&scheme| Self { scheme, coarse: true }).collect();
        if is_coarse {
            all.push(Self { scheme: Scheme::Track, coarse: false });
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
        if self.coarse { Ok(()) } else { f.write_str(" without a coarse level") }
    }
}

impl Serialize for Setting {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
