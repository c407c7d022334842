//! Start of a tool that engages in contact with the tissue or inside it.
//!
//! **Inside the tissue** a tool would push the surface above it outwards and be drawn in. So it waits without
//! contact and force, marked by flag 2048 ([`Flags::STARTS_INSIDE`](crate::Flags)), until a tick finds all of
//! it outside.
//!
//! **In contact** a tool of its full size would press in its first tick on tissue that has had no time to
//! give way, with up to twice the final force. So it starts with a share of its radius at which it hardly
//! touches, and grows. If the tissue closes over it before it has its full size, it waits.

/// Growth per tick, in shares of the full radius.
const GROWTH: f32 = 0.01;
/// From this share on a tool touches the surface only within rounding and gets its full size at once.
const TOUCHES: f32 = 0.999;

/// Share of a tool that waits inside the tissue.
pub(super) const WAITS: f32 = 0.0;

/// Returns true if a tool touches nothing; the surface is `nearest` radii away from its core.
pub(super) fn is_clear(nearest: f32) -> bool {
    nearest >= TOUCHES
}

/// The share with which a tool starts; the surface is `nearest` radii away from its core.
pub(super) fn begins(nearest: f32) -> f32 {
    if is_clear(nearest) { 1.0 } else { grown(nearest) }
}

/// The share of a growing tool a tick later.
pub(super) fn grown(share: f32) -> f32 {
    let grown = share + GROWTH;
    if grown < 1.0 { grown } else { 1.0 }
}
