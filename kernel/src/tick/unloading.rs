//! Unloading: closes the links' bands (the paper's Fig. 5b).
//!
//! Closed bands admit only the rest length, so every link restores the rest shape. Flag 32 is set while they
//! are closed.
//!
//! | unloading | bands are closed |
//! |---|---|
//! | `off` | never |
//! | `release` | from the tool's release until it engages again |
//! | `retreat` | also while the tool has retreated by more than 0.1 mean link lengths from its deepest point, until it passes that point |
//!
//! Closing a band may raise the energy: it is the only external action besides a motion of the tool. With
//! `release` it acts on a free body. With `retreat` it acts on the tool, which then gets back more energy
//! than it gave: 2.4 to 4.8 mJ on the paper's plane (`chaincell paper`). With alpha 0 the bands admit only
//! the rest length anyway, and unloading changes no force. Every change of the bands computes the certified
//! level anew and wakes the whole body.

use super::choices::Unloading;

/// Distance by which the tool retreats from its deepest point before the bands close [mean link lengths].
const RETREAT: f32 = 0.1;

impl Unloading {
    /// Returns true if the bands are closed from now on, for a tool that was `released` or is at a `depth`;
    /// `is_closed` if they were.
    pub(super) fn closes(self, released: bool, depth: f32, deepest: f32, is_closed: bool) -> bool {
        match self {
            Self::Off => false,
            Self::Release => released,
            Self::Retreat if released => true,
            Self::Retreat if depth > deepest => false,
            Self::Retreat => is_closed || depth < deepest - RETREAT,
        }
    }
}
