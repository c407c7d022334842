//! What the kernel computes in.

use crate::case::Case;
use crate::target::Target;

/// A number type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tier {
    /// Single precision; in software where there is no FPU.
    F32,
    /// Fixed point, 8.24 bits.
    Fixed,
}

impl Tier {
    /// Name in tables, budgets and `--only`, and what `image/build.rs` reads.
    pub fn name(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::Fixed => "fixed",
        }
    }

    /// Those of a target's images of a case: fixed point where there is no FPU and no hats.
    pub fn of(target: &Target, case: &Case) -> &'static [Self] {
        let both = !target.fpu && case.bake.contains(&"--hats=none");
        if both { &[Self::F32, Self::Fixed] } else { &[Self::F32] }
    }
}
