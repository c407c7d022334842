//! Tools inside the body, see [`begin`](crate::tick::begin).

use super::{energy_of, places};
use crate::energy::inside;
use crate::energy::surface::{Meeting, NearTriangle, Proxy, ToolState};
use crate::model::Model;
use crate::number::two_float::TwoFloat;
use crate::solver::Dynamics;
use crate::tick::begin;
use crate::tick::order::Tick;
use crate::tick::touch_room::TouchArrays;

/// Least share of its radii with which a tool starts: the tissue would close over a smaller one.
const LEAST: f32 = 0.04;

/// Least distance of a core's middle from the body for a tool that starts or grows, as a share of its radius.
const OUT: f32 = 1.0 / 16.0;

/// Returns true if a core of a tool lies at least partly in the body, or if its middle is nearer to it than
/// `margin` radii. A half space has no inside: it pushes all tissue in one direction.
fn is_inside(
    model: &Model<'_>,
    (tool, number): (&ToolState, usize),
    margin: f32,
    near: &[NearTriangle],
    at: &impl Fn(usize) -> [f32; 3],
) -> bool {
    let mut parts = tool.proxy.parts().iter().enumerate();
    parts.any(|(part, solid)| {
        let own = |near: &&NearTriangle| near.tool() == number && near.part() == part;
        let is_crossed =
            |near: &NearTriangle| solid.is_crossed(near.corners.map(|cell| at(cell.into())));
        !solid.is_endless()
            && (near.iter().filter(own).any(is_crossed)
                || inside::is_inside(model, at, (solid.middle(), margin * solid.whole)))
    })
}

/// The starting tool and its contact, with an energy within `room`. `waited`: the tool has waited inside.
pub(super) fn begun(
    model: &Model<'_>,
    (tool, number): (&ToolState, usize),
    (waited, room): (bool, f32),
    near: &[NearTriangle],
    at: &impl Fn(usize) -> [f32; 3],
) -> (Proxy, Meeting) {
    let proxy = &tool.proxy;
    let met = |proxy: &Proxy| Meeting::of((proxy, number), (near, &[]), at);
    let with = |share| proxy.at(proxy.pivot, proxy.turn, share);
    let nearest = met(proxy).nearest;
    let is_clear = begin::is_clear(nearest);
    if (waited && !is_clear) || nearest < LEAST || is_inside(model, (tool, number), OUT, near, at) {
        return (with(begin::WAITS), Meeting::NONE);
    }
    let begun = with(begin::begins(nearest));
    let meets = met(&begun);
    if meets.energy.hi <= room { (begun, meets) } else { (with(nearest), Meeting::NONE) }
}

/// Makes growing tools wait if the tissue has closed over them. Returns the change of the energy, `None` if
/// there is none.
fn closed_over(
    model: &Model<'_>,
    arrays: &mut TouchArrays<'_>,
    at: &impl Fn(usize) -> [f32; 3],
) -> Option<TwoFloat> {
    let grows = |tool: &ToolState| tool.is_in && !tool.waits() && tool.proxy.share < 1.0;
    let mut before = None;
    for number in 0..arrays.tools.len() {
        let Some(tool) = arrays.tools.get(number).filter(|tool| grows(tool)) else { continue };
        if !is_inside(model, (tool, number), OUT, arrays.near(), at) {
            continue;
        }
        before = before.or_else(|| Some(energy_of(arrays, at)));
        if let Some(tool) = arrays.tools.get_mut(number) {
            tool.proxy = tool.proxy.at(tool.proxy.pivot, tool.proxy.turn, begin::WAITS);
        }
    }
    let (before, after) = (before?, energy_of(arrays, at));
    let rounding = f32::EPSILON * (before.hi + after.hi);
    Some(after.minus(before).plus(rounding.into()))
}

impl<D: Dynamics> Tick<'_, '_, D> {
    /// Makes tools wait that the sweeps of this tick have left inside the body.
    pub(super) fn leave_inside(&mut self) {
        let model = self.network.model();
        let at = places(model, &*self.state);
        let Some(mut arrays) = self.touch.arrays(self.state.len()) else { return };
        if let Some(change) = closed_over(model, &mut arrays, &at) {
            self.head.level.shift(change);
            self.head.awake.wake_all(model);
            self.head.dynamics.pushed();
        }
    }
}
