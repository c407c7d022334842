//! `gauss-seidel`: one cell after the other, in place, over-relaxed: the scheme for small RAM.
//!
//! Of all cells but i held, half the squared distance of its links to their bands curves upwards by
//! at most their weight: for every move d of the cell
//!
//! ```text
//! E(P + d) <= E(P) - r_i . d + W_i |d|^2 / 4          r_i = -dE/dP_i, W_i = sum of its links' w
//! ```
//!
//! in every state, inverted and coincident cells included (L, the Laplacian of weight w / 2, has
//! `W_i` / 2 on its diagonal). The step d = omega (2 / `W_i`) `r_i` lowers E by at least omega (2 -
//! omega) |`r_i`|^2 / `W_i`, for 0 < omega < 2: in any order, with no second array and no guard.
//! omega = [`OMEGA`] looks ahead like momentum does. Clamping the new position to K keeps the
//! bound: D, the clamped move, is the projection of d, so d . D >= |D|^2 and the fall is at least
//! `W_i` |D|^2 (2 - omega) / (4 omega). So outputs are what is moved, and nothing saturates.
//!
//! **The level** falls by the sum of `r_i` . D - `W_i` |D|^2 / 4 over the moves as rounded, less
//! what rounding has made of `r_i`: a quarter of eps times the sum of w u over its links, whose
//! errors add up like a random walk, as in the guards' tolerance. A move that is not sure to lower
//! E is tried with omega = 1 and else left out: a body comes to a standstill. Since links resist
//! along their direction only, E falls faster than the level; every [`MEASURE`]th sweep measures E
//! instead of moving cells, and so does the first one after positions were set or bands changed.
//! Where all cells found their links slack, E = 0.
//!
//! **Order.** By the colours of the bake, each free cell once; no two cells of a colour are linked,
//! so a colour's cells may be moved at the same time with the same bits. Asleep and held cells are
//! left out. Sleep needs to know where all links are slack, and there is no residual: the fourth
//! lane of a cell's state keeps the sum of w d^2 that it saw last.
//!
//! Cost: one link pass a sweep, every link at both ends; no array besides the state, one fewer than
//! `euler`. Converges to the minimum as `track` does, more slowly; time has no meaning here.
//!
//! Source: D. M. Young, Iterative methods for solving partial difference equations of elliptic
//! type, 1954 (over-relaxation, colouring); the bound is that of
//! [`link`](crate::terms::links::law).

use super::Dynamics;
use super::scheme::{Body, Scheme};
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::model::{Model, range};
use crate::number::cell::{Cell, add, dot, output, scale, sub};
use crate::number::kept::kept;
use crate::number::two_float::Eight;
use crate::number::two_float::{LANES, Lanes, TwoFloat};
use crate::terms::held::Contact;
use crate::terms::term::CellTerm;

/// Over-relaxation.
const OMEGA: f32 = 1.9;
/// Sweeps from one measured energy to the next.
const MEASURE: u16 = 32;
/// Rounding of a residual over the sum of w u of its links.
const ROUNDING: f32 = 0.25 * f32::EPSILON;

/// State of the scheme: sweeps since the energy was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaussSeidel {
    sweeps: u16,
}

kept!(GaussSeidel { sweeps: u16 });

impl Dynamics for GaussSeidel {
    const NAME: &'static str = "gauss-seidel";
    const REST: Self = Self { sweeps: 0 };
    const RESIDUALS: usize = 0;
    const IS_ANYTIME: bool = true;
    const ARRAYS: usize = 0;
    type Residual<const CELLS: usize> = [[Cell; CELLS]; 0];
    type Arrays<const CELLS: usize> = [[Cell; CELLS]; 0];
    type Room = [Eight; 0];
}

/// Adds the current into a cell to its residual.
fn let_in(at: &mut CellTerm, current: Option<[f32; 3]>) {
    let Some([x, y, z]) = current else { return };
    at.residual = add(at.residual, [x, y, z]);
    // For the rounding of this sum.
    at.length += 4.0 * (x.abs() + y.abs() + z.abs());
}

/// The move of a cell and what it lowers the energy by for sure; `None` where no move does.
fn relax(here: [f32; 3], at: &CellTerm, mobility: f32, k: f32) -> Option<([f32; 3], f32)> {
    [OMEGA, 1.0].into_iter().find_map(|omega| {
        let to = output(add(here, scale(2.0 * omega * mobility, at.residual)), k);
        let way = sub(to, here);
        let rounding = ROUNDING * at.length * (way[0].abs() + way[1].abs() + way[2].abs());
        let falls = dot(at.residual, way) - 0.25 * dot(way, way) / mobility - rounding;
        (falls > 0.0).then_some((to, falls))
    })
}

/// Moves the awake, free cells of every colour; what that lowers the energy by, and where.
fn relax_all(body: &mut Body<'_, '_>) -> (TwoFloat, SliceSet) {
    let model = body.terms.model;
    let k = model.saturation();
    let (mut falls, mut moved) = (TwoFloat::ZERO, SliceSet::EMPTY);
    let Some(colours) = model.colours else { return (falls, moved) };
    for colour in 0..colours.rows.len().saturating_sub(1) {
        let mut contacts = body.contacts.iter().map(Contact::cell).peekable();
        for &cell in colours.cells.get(range(colours.rows, colour)).unwrap_or(&[]) {
            let cell = usize::from(cell);
            while contacts.next_if(|&contact| contact < cell).is_some() {}
            let is_contact = contacts.peek() == Some(&cell);
            let current = body.terms.current.filter(|_| is_contact);
            let is_held = is_contact && current.is_none();
            if !body.awake.set.contains(cell / LANES) || is_held {
                continue;
            }
            let (Some(v), Some(&mobility)) = (body.state.get(cell), model.mobility.get(cell))
            else {
                continue;
            };
            let here = output(v.xyz(), k);
            let mut at = body.terms.cell(body.state, cell, here);
            let_in(&mut at, current);
            let way = if at.wd2 > 0.0 || current.is_some() {
                relax(here, &at, mobility, k)
            } else {
                None
            };
            if let Some((_, fall)) = way {
                falls = falls.plus(fall.into());
                // At once: a later colour of this sweep may be linked to it.
                if !body.awake.spread.contains(cell / LANES) {
                    moved.insert(cell / LANES);
                    body.awake.wake_around(model, cell);
                }
            }
            let [x, y, z] = way.map_or(here, |(to, _)| to);
            if let Some(v) = body.state.get_mut(cell) {
                *v = Cell([x, y, z, at.wd2]);
            }
        }
    }
    (falls, moved)
}

/// Notes at held cells whether their links are slack.
fn mark_held(body: &mut Body<'_, '_>) {
    let k = body.terms.model.saturation();
    for contact in body.held {
        let cell = contact.cell();
        let Some(here) = body.state.get(cell).map(|v| output(v.xyz(), k)) else { continue };
        let wd2 = body.terms.cell(body.state, cell, here).wd2;
        if let Some(Cell([_, _, _, mark])) = body.state.get_mut(cell) {
            *mark = wd2;
        }
    }
}

/// The energy of the outputs, in internal units; notes at every awake cell whether its links are
/// slack.
fn measure(body: &mut Body<'_, '_>) -> TwoFloat {
    let model = body.terms.model;
    let (k, cells) = (model.saturation(), body.state.len());
    for slice in body.awake.set.iter(model.slice_count()) {
        for cell in cells_of(slice, cells) {
            let Some(here) = body.state.get(cell).map(|v| output(v.xyz(), k)) else { continue };
            let wd2 = body.terms.cell(body.state, cell, here).wd2;
            if let Some(Cell([_, _, _, mark])) = body.state.get_mut(cell) {
                *mark = wd2;
            }
        }
    }
    // Links of sleeping cells are slack, and their marks 0.
    let mut sum = Lanes::ZERO;
    for (cell, v) in body.state.iter().enumerate() {
        sum.add_to(cell, v.w());
    }
    sum.total().times_power_of_two(0.125)
}

impl Scheme for GaussSeidel {
    type Number = f32;

    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_>) -> bool {
        let model = body.terms.model;
        // The count goes on in sleep: the bits must not depend on which slices slept.
        self.sweeps = (self.sweeps + 1) % MEASURE;
        if body.awake.set.is_empty(model.slice_count()) {
            return false;
        }
        body.terms.update(&body.awake.set, body.state);
        if body.level.forgotten || self.sweeps == 0 {
            let energy = measure(body);
            body.level.certify(body.terms.potential(energy, body.state, body.contacts));
            return false;
        }
        let (falls, moved) = relax_all(body);
        let level = body.level.value().minus(falls);
        body.level.certify(level);
        mark_held(body);
        let state = &*body.state;
        // Where a current flows, cells whose links were slack have moved.
        if !body.terms.is_loaded() && state.iter().all(|v| v.w() == 0.0) {
            let potential = body.terms.potential(TwoFloat::ZERO, state, body.contacts);
            body.level.certify(potential);
        }
        let has_moved = |cell: usize| state.get(cell).is_some_and(|v| v.w() != 0.0);
        body.awake.wake_neighbours(model, &moved, has_moved);
        false
    }

    fn place(&mut self, _own: &mut [Cell], _cell: usize, _position: Cell, _k: f32) {}

    fn has_moved(state: &[Cell], _own: &[Cell], _residual: &[Cell], cell: usize) -> bool {
        state.get(cell).is_some_and(|v| v.w() != 0.0)
    }

    fn needs_colours(model: &Model<'_>) -> bool {
        model.colours.is_none()
    }

    fn interrupt(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    const K: f32 = 100.0;

    fn at(residual: [f32; 3]) -> CellTerm {
        CellTerm { residual, wd2: 1.0, length: 4.0 }
    }

    #[test]
    fn a_move_lowers_the_energy_by_the_proven_share() {
        let (to, falls) = relax([1.0; 3], &at([0.5, 0.0, 0.0]), 0.25, K).unwrap();
        assert_eq!(to, [1.0 + 2.0 * OMEGA * 0.25 * 0.5, 1.0, 1.0]);
        let proven = OMEGA * (2.0 - OMEGA) * 0.25 * 0.25;
        assert!((falls - proven).abs() < 1e-4 * proven, "{falls} {proven}");
    }

    #[test]
    fn what_rounding_may_undo_is_left_out() {
        // Sure with omega = 1 only, then not at all.
        let (to, _) = relax([1.0; 3], &at([1e-6, 0.0, 0.0]), 0.25, K).unwrap();
        assert!((to[0] - 1.0 - 5e-7).abs() < 2e-7, "{}", to[0] - 1.0);
        assert!(relax([1.0; 3], &at([1e-7, 0.0, 0.0]), 0.25, K).is_none());
        assert!(relax([1.0; 3], &at([0.0; 3]), 0.25, K).is_none());
    }

    #[test]
    fn the_range_is_never_left() {
        let (to, falls) = relax([99.0, 0.0, 0.0], &at([40.0, 0.0, 0.0]), 0.25, K).unwrap();
        assert!(to == [K, 0.0, 0.0] && falls > 0.0);
        assert!(relax([K, 0.0, 0.0], &at([40.0, 0.0, 0.0]), 0.25, K).is_none());
    }
}
