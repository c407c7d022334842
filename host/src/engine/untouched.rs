//! A sphere that never touched the body: its smallest distance.
//!
//! A body that no tool touched is at rest to the last bit, so the distances are those from the body at rest,
//! and they are computed once, after the run.
//!
//! **Bounded cost.** Between two positions the distance changes by at most the distance between them. So the
//! positions of the run are bisected: a part is evaluated at its middle, and skipped if nothing in it can be
//! nearer than the nearest so far by more than `GRAIN_M`. At most `LOOKS` positions are evaluated, each
//! against every triangle; if that does not suffice, the nearest one found is the result.

use std::collections::VecDeque;
use std::fmt;

use nalgebra::Vector3;
use serde::Serialize;

use super::Engine;
use super::motion::Pose;
use super::reach::Reach;

/// Largest number of evaluated positions.
const LOOKS: usize = 1000;
/// Tolerance of the distance \[m\].
const GRAIN_M: f64 = 1e-5;

/// Smallest distance of a sphere that never touched.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Untouched {
    /// Distance from the sphere to the surface at rest \[m\]; `None` if it was never engaged.
    pub nearest_m: Option<f64>,
    /// Tick of that distance.
    pub tick: Option<u64>,
    /// True if all or a part of it was inside the body then.
    pub is_inside: bool,
    /// True if its first position was inside too: a tool has no contact there before it was outside. One that began
    /// outside went less deep than the points of the surface lie apart.
    pub began_inside: bool,
}

impl Untouched {
    /// Evaluates a run: the executed poses, and whether one of them had a contact. `None` if one had, if the
    /// tool holds cells, and if there were no poses.
    #[must_use]
    pub fn of(engine: &Engine<'_>, poses: &[Pose], has_touched: bool) -> Option<Self> {
        let radius_m = engine.contact().radius_m()?;
        if has_touched || poses.is_empty() {
            return None;
        }
        // Keep the good engaged poses.
        let is_good = |pose: &&Pose| pose.position_m.iter().all(|x| x.is_finite());
        let engaged = poses.iter().filter(|pose| pose.engaged == 1).filter(is_good);
        let engaged: Vec<(u64, Vector3<f64>)> = engaged
            .map(|pose| (pose.tick, Vector3::from(pose.position_m.map(f64::from))))
            .collect();
        // Find the nearest one.
        let reach = Reach::of(engine.network().model());
        let found = nearest(&engaged, |point| reach.distance_m(point.into()));
        let radius_m = f64::from(radius_m);
        let is_in =
            |at: Vector3<f64>, distance_m: f64| distance_m < radius_m || reach.is_around(at.into());
        let first =
            engaged.first().and_then(|(_, at)| Some((*at, reach.distance_m((*at).into())?)));
        Some(Self {
            nearest_m: found.map(|(_, _, distance_m)| (distance_m - radius_m).max(0.0)),
            tick: found.map(|(tick, ..)| tick),
            is_inside: found.is_some_and(|(_, at, distance_m)| is_in(at, distance_m)),
            began_inside: first.is_some_and(|(at, distance_m)| is_in(at, distance_m)),
        })
    }
}

impl fmt::Display for Untouched {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the tool never touched the body: ")?;
        let (Some(nearest_m), Some(tick)) = (self.nearest_m, self.tick) else {
            return write!(f, "it was never engaged");
        };
        write!(f, "nearest {:.1} mm at tick {tick}", 1e3 * nearest_m)?;
        match (self.is_inside, self.began_inside) {
            (false, _) => Ok(()),
            (true, true) => write!(f, ", inside the body"),
            (true, false) => write!(f, ", between the points at which its surface is felt"),
        }
    }
}

/// The nearest of these positions, with its tick and its distance \[m\].
fn nearest(
    positions: &[(u64, Vector3<f64>)],
    distance_m: impl Fn(Vector3<f64>) -> Option<f64>,
) -> Option<(u64, Vector3<f64>, f64)> {
    let mut best: Option<(u64, Vector3<f64>, f64)> = None;
    let mut parts = VecDeque::from([(positions, 0.0)]);
    let mut looks = 0;
    while let Some((part, least_m)) = parts.pop_front() {
        // Skip a part that cannot be nearer.
        let may_be_nearer = best.is_none_or(|(.., best_m)| least_m < best_m - GRAIN_M);
        if !may_be_nearer || looks == LOOKS {
            continue;
        }
        // Evaluate its middle.
        let middle = part.len() / 2;
        let Some(&(tick, at)) = part.get(middle) else { continue };
        looks += 1;
        let here_m = distance_m(at)?;
        if best.is_none_or(|(.., best_m)| here_m < best_m) {
            best = Some((tick, at, here_m));
        }
        // Bound the distance of both halves.
        let (before, rest) = part.split_at(middle);
        for half in [before, rest.get(1..).unwrap_or(&[])] {
            let way_m = half.iter().map(|(_, other)| (other - at).norm()).fold(0.0, f64::max);
            parts.push_back((half, here_m - way_m));
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    /// A path past a point at a distance of 3 mm, in steps of 0.1 mm, then away for long.
    #[test]
    fn the_nearest_of_many_positions_takes_few_looks() {
        let at = |tick: u64| Vector3::new(1e-4 * tick as f64 - 0.3, 0.003, 0.0);
        let positions: Vec<_> = (0..100_000).map(|tick| (tick, at(tick))).collect();
        let looks = Cell::new(0);
        let found = nearest(&positions, |point| {
            looks.set(looks.get() + 1);
            Some(point.norm())
        });
        let (tick, _, nearest_m) = found.unwrap();
        assert!((nearest_m - 0.003).abs() < GRAIN_M && tick.abs_diff(3000) < 10, "{tick}");
        assert!(looks.get() < 200, "{}", looks.get());
    }

    #[test]
    fn a_tool_that_stands_still_takes_a_bounded_number_of_looks() {
        // All equal within the tolerance, except one that is nearer.
        let at = |tick: u64| Vector3::new(0.0, 0.0, if tick == 777 { 0.01 } else { 0.02 });
        let positions: Vec<_> = (0..1000).map(|tick| (tick, at(tick))).collect();
        let found = nearest(&positions, |point| Some(point.norm()));
        assert_eq!(found.unwrap().0, 777);
        assert_eq!(nearest(&[], |_| Some(0.0)), None);
    }

    #[test]
    fn it_is_said_in_one_line() {
        let of = |nearest_m, is_inside| {
            let (tick, began_inside) = (Some(120), is_inside);
            Untouched { nearest_m, tick, is_inside, began_inside }.to_string()
        };
        assert_eq!(
            of(Some(0.0041), false),
            "the tool never touched the body: nearest 4.1 mm at tick 120"
        );
        assert!(of(Some(0.0041), true).ends_with("at tick 120, inside the body"));
        assert!(of(None, false).ends_with("it was never engaged"));
        let shallow = Untouched {
            nearest_m: Some(0.0),
            tick: Some(120),
            is_inside: true,
            began_inside: false,
        };
        assert!(shallow.to_string().ends_with("between the points at which its surface is felt"));
    }
}
