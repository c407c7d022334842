//! Tearing: the cell whose load most exceeds its strength parts across its largest stretch.
//!
//! A tick looks at every eighth slice of the cells, in turn. Among these it finds the cell with the largest ratio of
//! load over strength ([`TearLimit`]). If that is at least 1, the faces at the cell open that lie between tetrahedra
//! on both sides of a plane: through the cell's rest position, across the line that is stretched most there, in the
//! rest shape. The cell then splits as any other, see `split`, and the load goes to the cells beside it. So a tear
//! runs by at most a cell in a tick.
//!
//! A fixed cell, one that a tool holds, one that waits for a split and one with an offset do not tear: the stress of
//! a copy with an offset is still that of the cell before its split.
//!
//! **The account.** A decay of the offsets may raise the energy, and in a tear no hand pays for that. So the body has
//! a credit: after the sweeps of a tick it is the energy by which they have lowered the level, less a debt if there
//! is one. The next tick first pays the rounding of its splits from it, which may leave a debt. Then the offsets
//! decay as far as the credit allows; what is left lapses with the next sweeps. The level of a body that is left
//! alone therefore never exceeds that before the last sweeps, except for a debt of one tick's rounding.
//!
//! Cost: a look at a cell goes over its half-links once, 1,700 instructions, with stiffening bands twice, of a body of
//! links also over its tetrahedra ([`load`](super::load)); eigenvalues are computed only near the strength. A tick of a
//! body of 364 cells takes 0.08 million, a sixth of a sweep, and while offsets decay 0.14 million more. RAM: twelve
//! bytes, and four for each cell.

use super::body::CutBody;
use super::memory::{CREDIT, TORN, TURN};
use super::shares::rounded_down;
use crate::energy::nodal::{largest_stretch, stretch_bound};
use crate::energy::state::States;
use crate::model::rest_length;
use crate::model::tearing::TearLimit;
use crate::number::cell::{dot, sub};
use crate::number::two_float::LANES;

/// Ticks in which all cells are looked at once.
pub(super) const TURNS: u32 = 8;

/// A cell that tears, and the line in the rest shape across which it does.
struct Tear {
    cell: usize,
    line: [f32; 3],
    /// Load over strength.
    ratio: f32,
}

impl CutBody<'_, '_> {
    /// Opens the faces of the cell whose load most exceeds its strength, if there is one among those of this tick.
    pub fn tear(
        &mut self,
        is_held: &impl Fn(usize) -> bool,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) {
        let Some(limit) = self.cut.tear_limit else { return };
        if let Some(tear) = self.most_loaded(limit, is_held, at, states) {
            self.each_face(&tear, |body, tetrahedron, corner| {
                body.open_face(tetrahedron, corner);
            });
            if let Some(torn) = self.arrays.tear.get_mut(TORN) {
                *torn = torn.saturating_add(1);
            }
        }
        if let Some(turn) = self.arrays.tear.get_mut(TURN) {
            *turn = (*turn + 1) % TURNS;
        }
    }

    /// The cell with the largest ratio of load over strength, at least 1, of those of this tick.
    fn most_loaded(
        &mut self,
        limit: TearLimit,
        is_held: &impl Fn(usize) -> bool,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) -> Option<Tear> {
        let cells = self.bodily + self.used();
        let turn = self.arrays.tear.get(TURN).map_or(0, |&turn| turn as usize);
        let (mut most, mut found) = (1.0, None);
        for slice in (turn..cells.div_ceil(LANES)).step_by(TURNS as usize) {
            for cell in slice * LANES..cells.min((slice + 1) * LANES) {
                if !self.may_tear(cell) || is_held(cell) {
                    continue;
                }
                let Some(tear) = self.loaded(limit, cell, most, at, states) else { continue };
                // A cell at which no face is left to open is torn already.
                let mut is_whole = false;
                if tear.ratio > most || found.is_none() {
                    self.each_face(&tear, |_, _, _| is_whole = true);
                }
                if is_whole {
                    (most, found) = (tear.ratio, Some(tear));
                }
            }
        }
        found
    }

    /// Returns true for a cell that can move, that no split awaits, and whose stress is that of its shape.
    fn may_tear(&self, cell: usize) -> bool {
        let is_free = self.arrays.mobility.get(cell).is_some_and(|&mobility| mobility > 0.0);
        let is_waiting = self.arrays.marks.get(cell) == Some(&1);
        is_free && !is_waiting && self.offset(cell) == [[0.0; 3]; 3]
    }

    /// The ratio of a cell's load to its strength, with the line of its largest stretch; `None` for one below
    /// `least`, and for one that is nowhere stretched.
    fn loaded(
        &self,
        limit: TearLimit,
        cell: usize,
        least: f32,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) -> Option<Tear> {
        let strength = *self.arrays.strengths.get(self.origin(cell))?;
        // A bound of the load that takes no eigenvalues.
        let shape = || self.shape_of(cell, at);
        let bound = match limit {
            TearLimit::Toughness => self.energy_density(cell, at, states),
            TearLimit::Stretch(_) => stretch_bound(shape()) - 1.0,
        };
        if bound < least * strength {
            return None;
        }
        let (stretch, line) = largest_stretch(shape());
        let load = match limit {
            TearLimit::Toughness => bound,
            TearLimit::Stretch(_) => stretch - 1.0,
        };
        let ratio = load / strength;
        (stretch > 1.0 && ratio >= least).then_some(Tear { cell, line, ratio })
    }

    /// Calls `visit(body, tetrahedron, corner)` for each closed face at the cell of a tear between tetrahedra on both
    /// sides of it, once.
    fn each_face(&mut self, tear: &Tear, mut visit: impl FnMut(&mut Self, usize, usize)) {
        let cell = tear.cell;
        for index in 0..self.star(cell).len() {
            let Some(tetrahedron) = self.tetrahedron_at(cell, index) else { continue };
            if !self.is_beyond(tear, tetrahedron) {
                continue;
            }
            for corner in 0..4 {
                let names = self.arrays.corners.get(tetrahedron);
                let opposite = names.and_then(|names| names.get(corner)).map(|&id| id.into());
                let is_closed = opposite != Some(cell) && !self.is_open(tetrahedron, corner);
                let other = is_closed.then(|| self.across(tetrahedron, corner)).flatten();
                if other.is_some_and(|(other, _)| !self.is_beyond(tear, other)) {
                    visit(self, tetrahedron, corner);
                }
            }
        }
    }

    /// Returns true if the middle of a tetrahedron at rest lies on the positive side of a tear.
    fn is_beyond(&self, tear: &Tear, tetrahedron: usize) -> bool {
        let Some(corners) = self.corners_at_rest(tetrahedron) else { return false };
        let from = self.model.rest_position(self.origin(tear.cell));
        let along = corners.map(|corner| dot(sub(corner, from), tear.line));
        let [a, b, c, d] = along;
        a + b + (c + d) > 0.0
    }

    /// Sets the strengths of the cells: those of the loads of [`load`](super::load), or strains.
    pub(super) fn derive_strengths(&mut self) {
        let Some(limit) = self.cut.tear_limit else { return };
        let model = self.model;
        for cell in 0..self.arrays.strengths.len() {
            let here = model.rest_position(cell);
            let (mut sum, mut count) = (0.0, 0.0);
            for (_, other) in model.neighbours(cell) {
                sum += rest_length(here, model.rest_position(other));
                count += 1.0;
            }
            // Every cell has a tetrahedron, so links.
            let edge = if count > 0.0 { sum / count } else { 1.0 };
            let toughness = self.cut.cell_toughness_j_per_m2(cell);
            let strength = limit.strength(toughness, edge * model.unit_m());
            let unit = match limit {
                TearLimit::Toughness if self.is_of_links() => {
                    model.stress_unit_pa() * self.thrice_young_around(cell)
                }
                TearLimit::Toughness => model.stress_unit_pa(),
                TearLimit::Stretch(_) => 1.0,
            };
            if let Some(slot) = self.arrays.strengths.get_mut(cell) {
                *slot = strength / unit;
            }
        }
    }

    /// Most by which the decay of the offsets may raise the energy in this tick, in internal units.
    pub fn credit(&self) -> f64 {
        let Some(&credit) = self.arrays.tear.get(CREDIT) else { return f64::INFINITY };
        let credit = f32::from_bits(credit).into();
        if credit > 0.0 { credit } else { 0.0 }
    }

    /// Pays for a rise of the energy.
    pub fn pay(&mut self, rise: f64) {
        let Some(slot) = self.arrays.tear.get_mut(CREDIT) else { return };
        let exact = f64::from(f32::from_bits(*slot)) - if rise > 0.0 { rise } else { 0.0 };
        // -0.0 becomes +0.0.
        *slot = (rounded_down(exact) + 0.0).to_bits();
    }

    /// Replaces the credit by the energy by which sweeps have lowered the level, less a debt.
    pub fn earn(&mut self, lowered: f32) {
        let Some(slot) = self.arrays.tear.get_mut(CREDIT) else { return };
        let debt = f32::from_bits(*slot);
        *slot = (if debt < 0.0 { debt + lowered } else { lowered } + 0.0).to_bits();
    }
}
