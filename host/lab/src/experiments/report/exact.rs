//! What a press should give: the path of energy minima under the tool, followed tick by tick.

use super::scene::Scene;
use super::snaps::Snaps;
use crate::reference::vectors::{distance, fields, plus};
use crate::reference::{Links, minimum};
use chaincell_host::error::{Error, Result};

/// Ticks in which the press reaches its depth: 300 ms.
pub const PRESS_TICKS: usize = 300;
/// Ticks after it that are looked at.
pub const HOLD_TICKS: usize = 100;
/// Depth of the press [mean link lengths].
pub const DEPTH_LINKS: f64 = 3.0;
/// Largest residual of a free cell at a reference [mean link lengths].
pub const RESIDUAL: f64 = 1e-10;

/// A move so many times that of the stretch before is looked at tick by tick.
const SUDDEN: f64 = 1.3;
/// Ticks after such a move that are followed one by one.
const FINE_TICKS: usize = 30;

/// A minimum on the path.
pub struct Moment {
    /// Tick of the press, at most [`PRESS_TICKS`].
    pub tick: usize,
    /// Displacements of all cells [mean link lengths].
    pub field: Vec<[f64; 3]>,
    /// Force of the tissue on the tool \[N\].
    pub force_n: [f64; 3],
    /// Energy in internal units.
    pub energy: f64,
}

/// The path of minima of a press.
pub struct ExactPress {
    /// The links.
    pub links: Links,
    /// Moments in ascending order of ticks, the last one at the end of the press.
    pub moments: Vec<Moment>,
    /// Where the path jumps from one equilibrium to another.
    pub snaps: Snaps,
    /// Largest residual left at any moment [mean link lengths].
    pub residual_max: f64,
}

/// Displacement of the tool at a tick along the direction of the press [mean link lengths].
#[must_use]
pub fn depth(tick: usize) -> f64 {
    DEPTH_LINKS * tick.min(PRESS_TICKS) as f64 / PRESS_TICKS as f64
}

/// Follows the minimum under the tool of a scene.
struct Follower<'a> {
    scene: &'a Scene,
    links: &'a Links,
    contacts: Vec<usize>,
    force_unit_n: f64,
    at: Vec<[f64; 3]>,
    residual_max: f64,
}

impl Follower<'_> {
    fn moment(&mut self, tick: usize) -> Moment {
        let rest = self.links.rest();
        let way = depth(tick);
        let pressed = |&cell: &usize| (cell, plus(rest[cell], way, self.scene.direction));
        let held: Vec<(usize, [f64; 3])> = self.contacts.iter().map(pressed).collect();
        let found = minimum(self.links, &held, &self.at, RESIDUAL);
        let force = self.links.force(&found.positions, &self.contacts);
        self.residual_max = self.residual_max.max(found.residual_max);
        let moment = Moment {
            tick,
            field: fields(&found.positions, -1.0, rest),
            force_n: force.map(|f| self.force_unit_n * f),
            energy: found.energy,
        };
        self.at = found.positions;
        moment
    }
}

impl ExactPress {
    /// Follows the minimum through a press, a moment every `stride` ticks and every tick around a
    /// snap.
    ///
    /// # Errors
    /// A scene whose model is refused; a minimum that was not reached; what `after` says.
    pub fn follow(
        scene: &Scene,
        stride: usize,
        mut after: impl FnMut(u64) -> Result<()>,
    ) -> Result<Self> {
        let model = scene.model()?;
        let links = Links::of_model(&model);
        let mut follower = Follower {
            scene,
            links: &links,
            contacts: scene.contacts.iter().map(|&cell| usize::from(cell)).collect(),
            force_unit_n: f64::from(model.force_unit_n()),
            at: links.rest().to_vec(),
            residual_max: 0.0,
        };
        let rest = follower.moment(0);
        let (mut moments, mut moves) = (vec![rest], Vec::<f64>::new());
        let mut fine_until = 0;
        while let Some(last) = moments.last().filter(|last| last.tick < PRESS_TICKS) {
            let from = last.tick;
            let step = if from < fine_until { 1 } else { stride - from % stride };
            let before = follower.at.clone();
            let moment = follower.moment(from + step);
            let way = distance(&moment.field, &last.field) / step as f64;
            let sudden = moves.last().is_some_and(|before| way > SUDDEN * before);
            if sudden && step > 1 {
                // Once more, tick by tick, from where it was still smooth.
                follower.at = before;
                fine_until = from + step + FINE_TICKS;
                continue;
            }
            after(step as u64)?;
            moves.push(way);
            moments.push(moment);
        }
        let residual_max = follower.residual_max;
        if residual_max > 10.0 * RESIDUAL {
            return Err(Error::check(format!(
                "{}: a reference has a residual of {residual_max:e} mean link lengths",
                scene.name
            )));
        }
        let path: Vec<_> = moments.iter().map(|moment| (moment.tick, moment.force_n)).collect();
        let snaps = Snaps::of(&path);
        moments.remove(0);
        Ok(Self { links, moments, snaps, residual_max })
    }

    /// The last moment: the press held at its depth.
    #[must_use]
    pub fn last(&self) -> &Moment {
        &self.moments[self.moments.len() - 1]
    }

    /// The moment of a tick, where there is one; after the press the last.
    #[must_use]
    pub fn at(&self, tick: usize) -> Option<&Moment> {
        let tick = tick.min(PRESS_TICKS);
        let found = self.moments.binary_search_by_key(&tick, |moment| moment.tick);
        found.ok().map(|at| &self.moments[at])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::vectors::norm;

    #[test]
    fn a_path_has_its_moments_and_the_last_one_stands_for_what_follows() {
        let exact = ExactPress::follow(&Scene::plane(true).unwrap(), 50, |_| Ok(())).unwrap();
        let ticks: Vec<usize> = exact.moments.iter().map(|moment| moment.tick).collect();
        assert_eq!(ticks, [50, 100, 150, 200, 250, 300]);
        assert!(exact.at(60).is_none() && exact.residual_max <= RESIDUAL);
        assert_eq!(exact.at(320).map(|moment| moment.tick), Some(300));
        // The held cell itself has the depth of the press.
        let deepest = exact.last().field.iter().map(|u| norm(*u)).fold(0.0, f64::max);
        assert!((deepest - DEPTH_LINKS).abs() < 1e-12, "{deepest}");
    }
}
