//! What the kernel computes in.

use chaincell_scenes::Tier;

use crate::case::Case;
use crate::target::Target;

/// Number types of a target's images of a case: single precision, in software where there is no
/// FPU; there fixed point too, for bodies without a coarse level.
pub fn tiers(target: &Target, case: &Case) -> &'static [Tier] {
    let both = !target.fpu && case.bake.contains(&"--coarse=none");
    if both { &[Tier::F32, Tier::Fixed] } else { &[Tier::F32] }
}
