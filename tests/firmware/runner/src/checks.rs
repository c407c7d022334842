//! What images built with the feature `checks` try beside the measured parts.

use std::path::Path;

use anyhow::{Result, bail, ensure};
use chaincell_kernel::Choice;
use chaincell_scenes::Tier;
use chaincell_scenes::adverse::STATES;

use crate::case::Ready;
use crate::emulate::Said;
use crate::host;
use crate::target::Target;
use crate::trace;

/// The images that are built with it, one a target and number type.
const IMAGES: [&str; 5] = [
    "m7-organ500_track-f32",
    "m4-plane8_track-f32",
    "m3-plane8_track-f32",
    "m3-plane8_track-fixed",
    "rv32-organ500_track-f32",
];

/// Whether an image is one of those.
pub fn wanted(target: &Target, ready: &Ready, tier: Tier) -> bool {
    IMAGES.contains(&&*format!("{}-{}-{}", target.name, ready.case.name, tier.name()))
}

/// Holds what the image said of its checks against this machine; `stem` is where its trace goes.
///
/// # Errors
/// The first thing that is not as here.
pub fn hold(ready: &Ready, tier: Tier, said: &Said, chaincell: &Path, stem: &Path) -> Result<()> {
    if let Ok(tick) = said.number("differs_at") {
        bail!("a trace of this machine: tick {tick} is the first that differs");
    }
    let ticks = u64::from(trace::TICKS);
    // REQ-TRC-01
    for name in ["replayed", "compared"] {
        let count = said.number(name)?;
        ensure!(count == ticks, "a trace of this machine: {count} ticks {name}, not {ticks}");
    }
    // REQ-TRC-04
    let named = said.number("altered_differs_at")?;
    let altered = u64::from(trace::ALTERED);
    ensure!(named == altered, "tick {altered} of a trace is altered, the image names {named}");
    trace::replay(ready, &said.bytes("trace")?, chaincell, stem)?;
    // REQ-SMP-03
    if let Ok(what) = said.text("wrong") {
        bail!("state {}, tick {}: {what}", said.text("wrong_state")?, said.number("wrong_tick")?);
    }
    let digests = host::endure(ready, tier)?;
    ensure!(digests.len() == STATES.len(), "{} states", digests.len());
    for (state, digest) in digests {
        let own = said.bits(state)?;
        ensure!(own == digest, "state {state}: digest {own:016x}, on this machine {digest:016x}");
    }
    Ok(())
}
