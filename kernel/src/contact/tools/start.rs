//! Start of a tool that engages in contact with the tissue or inside it.
//!
//! **Inside the tissue** a tool would push the surface above it outwards and be drawn in. So it waits without
//! contact and force, marked by flag 2048 ([`STARTS_INSIDE`](crate::Flags)), until a tick finds all of
//! it outside.
//!
//! **In contact** a tool of its full size would press in its first tick on tissue that has had no time to
//! give way, with up to twice the final force. So it starts with a share of its radius at which it hardly
//! touches, and grows. If the tissue closes over it before it has its full size, it waits.

use super::energies::{energy_of, rise};
use crate::contact::inside;
use crate::contact::memory::TouchArrays;
use crate::energy::surface::{Meeting, NearTriangle, Proxy, ToolState};
use crate::model::Model;
use crate::number::two_float::TwoFloat;

/// Growth per tick, in shares of the full radius.
const GROWTH: f32 = 0.01;
/// From this share on a tool touches the surface only within rounding and gets its full size at once.
const TOUCHES: f32 = 0.999;

/// Share of a tool that waits inside the tissue.
const WAITS: f32 = 0.0;

/// Returns true if a tool touches nothing; the surface is `nearest` radii away from its core.
fn is_clear(nearest: f32) -> bool {
    nearest >= TOUCHES
}

/// The share with which a tool starts; the surface is `nearest` radii away from its core.
fn begins(nearest: f32) -> f32 {
    if is_clear(nearest) { 1.0 } else { grown(nearest) }
}

/// The share of a growing tool a tick later.
pub(super) fn grown(share: f32) -> f32 {
    let grown = share + GROWTH;
    if grown < 1.0 { grown } else { 1.0 }
}

/// Least share of its radii with which a tool starts: the tissue would close over a smaller one.
const LEAST: f32 = 0.04;

/// Least distance of a core's middle from the body for a tool that starts or grows, as a share of its radius.
const OUT: f32 = 1.0 / 16.0;

/// Returns true if a core of a tool lies at least partly in the body, or if its middle is nearer to it than
/// [`OUT`]. A half space has no inside: it pushes all tissue in one direction.
fn is_inside(
    model: &Model<'_>,
    tool: &ToolState,
    number: usize,
    near: &[NearTriangle],
    at: &impl Fn(usize) -> [f32; 3],
) -> bool {
    let mut parts = tool.proxy.parts().iter().enumerate();
    parts.any(|(part, solid)| {
        let is_of_part = |near: &&NearTriangle| near.tool() == number && near.part() == part;
        let is_crossed =
            |near: &NearTriangle| solid.is_crossed(near.corners.map(|cell| at(cell.into())));
        !solid.is_endless()
            && (near.iter().filter(is_of_part).any(is_crossed)
                || inside::is_inside(model, at, solid.middle(), OUT * solid.whole))
    })
}

/// The starting tool and its contact, with an energy within `energy_max`. `waited`: the tool has waited inside.
pub(super) fn begun(
    model: &Model<'_>,
    tool: &ToolState,
    number: usize,
    waited: bool,
    energy_max: f32,
    near: &[NearTriangle],
    at: &impl Fn(usize) -> [f32; 3],
) -> (Proxy, Meeting) {
    let proxy = &tool.proxy;
    let met = |proxy: &Proxy| Meeting::of((proxy, number), (near, &[]), at);
    let with = |share| proxy.at(proxy.pivot, proxy.turn, share);
    let nearest = met(proxy).nearest;
    let is_clear = is_clear(nearest);
    if (waited && !is_clear) || nearest < LEAST || is_inside(model, tool, number, near, at) {
        return (with(WAITS), Meeting::NONE);
    }
    let begun = with(begins(nearest));
    let meets = met(&begun);
    if meets.energy.hi <= energy_max {
        return (begun, meets);
    }
    // At most as far as the surface: a tool that is clear of it has its full size.
    let touching = if nearest < 1.0 { nearest } else { 1.0 };
    (with(touching), Meeting::NONE)
}

/// Makes growing tools wait if the tissue has closed over them. Returns the change of the energy, `None` if
/// there is none.
pub(super) fn closed_over(
    model: &Model<'_>,
    arrays: &mut TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
) -> Option<TwoFloat> {
    let grows = |tool: &ToolState| tool.is_in && !tool.waits() && tool.proxy.share < 1.0;
    let mut before = None;
    for number in 0..arrays.tools.len() {
        let Some(tool) = arrays.tools.get(number).filter(|tool| grows(tool)) else { continue };
        if !is_inside(model, tool, number, arrays.near(), at) {
            continue;
        }
        before = before.or_else(|| Some(energy_of(arrays, at)));
        if let Some(tool) = arrays.tools.get_mut(number) {
            tool.proxy = tool.proxy.at(tool.proxy.pivot, tool.proxy.turn, WAITS);
        }
    }
    Some(rise(before?, energy_of(arrays, at)))
}
