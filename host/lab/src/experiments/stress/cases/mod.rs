//! The cases, by what is hard about them.

mod drift;
mod elements;
mod extent;
mod floats;
mod material;
mod range;
mod rest;
mod shapes;
mod states;
mod supports;
mod surface;
mod tiers;
mod tool;

use super::case::Case;
use super::trial::Pose;

/// All of them, in the order of the table.
pub fn all() -> impl Iterator<Item = Case> {
    let groups: [&[Case]; 13] = [
        states::CASES,
        elements::CASES,
        material::CASES,
        shapes::CASES,
        surface::CASES,
        supports::CASES,
        tool::CASES,
        range::CASES,
        extent::CASES,
        floats::CASES,
        rest::CASES,
        tiers::CASES,
        drift::CASES,
    ];
    groups.concat().into_iter()
}

/// Ticks of a press of [`pressing`].
pub const PRESS_TICKS: u32 = 80;

/// Down by `depth_m` in 40 ticks, there for 40, then gone.
pub fn pressing(depth_m: f32) -> impl Fn(u32) -> Pose {
    move |tick| {
        let part = tick.saturating_sub(1).min(39) as f32 / 39.0;
        ([0.0, 0.0, -part * depth_m], tick < PRESS_TICKS)
    }
}

/// Away, holding still, away again, a third of the ticks each.
pub fn touching_once(ticks: u32) -> impl Fn(u32) -> Pose {
    move |tick| ([0.0; 3], (ticks / 3..2 * ticks / 3).contains(&tick))
}
