//! How a tool begins that is engaged in contact with the tissue or inside it.
//!
//! **Inside the tissue** a tool would push the surface that is over it outwards, and be drawn in. It waits:
//! it has no contact and no force, marked by flag 2048 ([`Flags::STARTS_INSIDE`](crate::Flags)), until a
//! tick finds all of it outside.
//!
//! **In contact** a tool of its whole size would press in its first tick on tissue that has had no time
//! to give way, with up to twice the force that stays. It begins with so small a share of its radius
//! that it hardly touches, and grows. Where the tissue closes over it before it is whole it waits.

/// Growth a tick, in shares of the whole radius.
const GROWTH: f32 = 0.01;
/// Share from which on a tool touches the surface within rounding: it is whole at once.
const TOUCHES: f32 = 0.999;

/// Stands for the share of a tool that is engaged in this tick.
pub(super) const NEW: f32 = -1.0;
/// Share of a tool that waits.
pub(super) const WAITS: f32 = 0.0;

/// Whether a tool touches nothing, the surface being so many radii away from its core.
pub(super) fn is_clear(nearest: f32) -> bool {
    nearest >= TOUCHES
}

/// The share with which a tool begins: the surface is so many radii away from its core.
pub(super) fn begins(nearest: f32) -> f32 {
    if is_clear(nearest) { 1.0 } else { grown(nearest) }
}

/// The share that a tool has grown to a tick later.
pub(super) fn grown(share: f32) -> f32 {
    let grown = share + GROWTH;
    if grown < 1.0 { grown } else { 1.0 }
}
