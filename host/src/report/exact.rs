//! What a press should give: the path of energy minima under the tool, followed tick by tick.

use super::scene::Scene;
use crate::error::{Error, Result};
use crate::reference::{Links, minimum};

/// Ticks in which the press reaches its depth: 300 ms.
pub const PRESS_TICKS: usize = 300;
/// Ticks after it that are looked at.
pub const HOLD_TICKS: usize = 100;
/// Depth of the press [mean link lengths].
pub const DEPTH_LINKS: f64 = 3.0;
/// Largest residual of a free cell at a reference [mean link lengths].
pub const RESIDUAL: f64 = 1e-10;

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
    /// Ticks from one moment to the next.
    pub stride: usize,
    /// Largest residual left at any moment [mean link lengths].
    pub residual_max: f64,
    /// Newton steps in all.
    pub iterations: usize,
}

/// Displacement of the tool at a tick along the direction of the press [mean link lengths].
#[must_use]
pub fn depth(tick: usize) -> f64 {
    DEPTH_LINKS * tick.min(PRESS_TICKS) as f64 / PRESS_TICKS as f64
}

impl ExactPress {
    /// Follows the minimum through a press, a moment every `stride` ticks.
    ///
    /// # Errors
    /// A scene whose model is refused.
    pub fn follow(scene: &Scene, stride: usize, mut after: impl FnMut()) -> Result<Self> {
        let model = scene.model()?;
        let links = Links::of_model(&model);
        let contacts: Vec<usize> = scene.contacts.iter().map(|&cell| usize::from(cell)).collect();
        let mut path =
            Self { links, moments: Vec::new(), stride, residual_max: 0.0, iterations: 0 };
        let mut at = path.links.rest().to_vec();
        for tick in (stride..=PRESS_TICKS).step_by(stride) {
            let held: Vec<(usize, [f64; 3])> = (contacts.iter())
                .map(|&cell| {
                    let rest = path.links.rest()[cell];
                    let way = depth(tick);
                    (cell, std::array::from_fn(|x| rest[x] + way * scene.direction[x]))
                })
                .collect();
            let found = minimum(&path.links, &held, &at, RESIDUAL);
            let unit_n = f64::from(model.force_unit_n());
            path.moments.push(Moment {
                tick,
                field: (found.positions.iter().zip(path.links.rest()))
                    .map(|(p, rest)| std::array::from_fn(|x| p[x] - rest[x]))
                    .collect(),
                force_n: path.links.force(&found.positions, &contacts).map(|f| unit_n * f),
                energy: found.energy,
            });
            path.residual_max = path.residual_max.max(found.residual_max);
            path.iterations += found.iterations;
            at = found.positions;
            after();
        }
        if path.moments.is_empty() {
            return Err(Error::check(format!("no moment in a press at a stride of {stride}")));
        }
        Ok(path)
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
        if tick == 0 || !tick.is_multiple_of(self.stride) {
            return None;
        }
        self.moments.get(tick / self.stride - 1)
    }
}

/// L2 norm of a field over the cells.
#[must_use]
pub fn norm(field: &[[f64; 3]]) -> f64 {
    field.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// L2 norm of the difference of two fields.
#[must_use]
pub fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}
