//! Prescribed contact: the cells that a tool holds, the limits of their motion, and the force on them.
//!
//! When the tool engages at p0, each contact cell is at its own c0. While it holds them, the tool at p
//! prescribes c0 + (p - p0) for every cell: all move by the same displacement, and engaging makes no force.
//! Two limits shorten that displacement, which flag 1 reports:
//!
//! - the applied displacement changes by at most
//!   [`Settings::max_tool_step_m`](crate::Settings::max_tool_step_m) per tick;
//! - a displacement D that raises the energy E obeys |D| <= 2 (sqrt(`E_max`) - sqrt(E)) / sqrt(W), with W the
//!   weight of the links between held and other cells. Then E stays at most `E_max`, the model's largest
//!   energy. A displacement that lowers E is not shortened, so the tool can always come back.
//!
//! The cells do not move during the sweeps. The force on the tool is the sum of the link forces on them;
//! links between two held cells do not count. When the tool releases, the cells are free in that tick and the
//! force is 0.
//!
//! Cost per tick: the links of the held cells once for the force, and at most three times more while the tool
//! moves.

use super::Acting;
use super::context::{Context, approach};
use super::error::ContactError;
use super::output::ToolOutput;
use crate::energy::held::{Contact, Touched, is_among};
use crate::energy::links::number::LinkNumber;
use crate::energy::residual::Terms;
use crate::energy::term::Term;
use crate::model::Model;
use crate::model::terms::TermData;
use crate::number::cell::{Cell, add, dot, from_single, output, scale, sub};
use crate::number::clamp::finite;
use crate::number::sqrt::sqrt;
use crate::number::two_float::TwoFloat;
use crate::solver::Dynamics;
use crate::solver::coarse::Coarse;

/// Cells that a tool holds.
pub(crate) struct Held<'a, D: Dynamics> {
    pub cells: &'a mut [Contact<D::Number>],
    /// Weight of the links between held and other cells.
    pub outer_weight: &'a mut f32,
}

/// Change of E by a motion of the tool.
#[derive(Debug, Clone, Copy)]
struct Change {
    exact: TwoFloat,
    rounding: f32,
}

impl Change {
    /// Change rounded up: the level stays an upper bound if two large energies almost cancel.
    fn bound(&self) -> TwoFloat {
        self.exact.plus(self.rounding.into())
    }
}

impl<D: Dynamics> Held<'_, D> {
    /// Takes hold of the cells, or moves them towards the tool.
    pub fn advance(&mut self, context: &mut Context<'_, '_, D>) {
        let before = context.touched.take();
        if context.is_engaged && !context.was_engaged {
            note_origins(context.terms.model, context.state, self.cells);
            *self.outer_weight = outer_weight(context.terms.model, self.cells);
            self.place(context);
        }
        // The memory of a body that relaxes takes late ticks and the next one as one, with an even motion.
        let waits = context.is_late && context.model().relaxes();
        if context.is_engaged && !waits {
            self.follow(context, before);
        }
    }

    pub fn acting(&self, context: &Context<'_, '_, D>) -> Acting<'_, D::Number> {
        let held = if context.is_engaged { &*self.cells } else { &[] };
        let (applied, coarse) = (*context.applied, Some(Coarse::Corrected(held.len())));
        Acting { contacts: held, applied, coarse, ..Acting::NONE }
    }

    /// Computes energy and force of nodal shapes after the sweeps: the force is the output of this tick, the
    /// energy that before the motion of the next one.
    pub fn book(&self, context: &mut Context<'_, '_, D>) {
        if context.model().is_nodal() {
            *context.touched = Some(touched(context.terms, context.state, self.cells));
        }
    }

    /// The force that the terms exert on the cells; a late tick leaves it out. E curves by at most half the
    /// weight of the links that a motion of the tool stretches.
    pub fn output(&self, context: &Context<'_, '_, D>) -> ToolOutput {
        let model = context.model();
        let stiffness = model.stiffness_n_per_m() * *self.outer_weight;
        ToolOutput { stiffness_n_per_m: finite(stiffness), ..output_of(context, self.cells) }
    }

    /// Moves the held cells towards the tool, as far as the limits allow. `before` is the energy at them, if it
    /// is known.
    fn follow(&self, context: &mut Context<'_, '_, D>, before: Option<Touched>) {
        let from = *context.applied;
        let to = context.step_towards();
        if to == from {
            return;
        }
        // Try the whole move.
        let (most, leading) = (context.model().energy_max(), context.level.leading());
        let length = move_max(most, leading, *self.outer_weight);
        let (_, beyond) = approach(from, to, length);
        let before = before.unwrap_or_else(|| touched(context.terms, context.state, self.cells));
        let mut change = self.displace(context, to, before);
        // A move that lowers the energy is not shortened: the tool can always come back.
        if beyond && change.bound().hi > 0.0 {
            change = self.shorten(context, to, from, length, before);
            context.is_clamped = true;
        }
        // Book the tool's work.
        if *context.applied != from {
            context.level.shift(change.bound());
            context.work = change.exact;
            context.dynamics.follow(sub(*context.applied, from));
        }
    }

    /// Moves the held cells as far as the energy bound allows: by `length`, or farther if the tissue pulls them
    /// that way and this lowers the energy.
    fn shorten(
        &self,
        context: &mut Context<'_, '_, D>,
        to: [f32; 3],
        from: [f32; 3],
        length: f32,
        before: Touched,
    ) -> Change {
        self.displace(context, from, before);
        let force = force(context, self.cells);
        let drawn = fall_max(force, sub(to, from), *self.outer_weight);
        if drawn > length {
            let change = self.displace(context, approach(from, to, drawn).0, before);
            if change.bound().hi <= 0.0 {
                return change;
            }
        }
        self.displace(context, approach(from, to, length).0, before)
    }

    /// Moves the held cells to a displacement and returns the change of the energy of their links.
    fn displace(&self, context: &mut Context<'_, '_, D>, to: [f32; 3], before: Touched) -> Change {
        *context.applied = to;
        self.place(context);
        context.dynamics.pushed();
        let after = touched(context.terms, context.state, self.cells);
        let rounding = f32::EPSILON * (before.scale + after.scale);
        Change { exact: after.wd2.minus(before.wd2).times_power_of_two(0.25), rounding }
    }

    /// Sets the held cells to the tool's displacement, in every copy of the state.
    fn place(&self, context: &mut Context<'_, '_, D>) {
        let model = context.terms.model;
        let k = model.saturation();
        let applied = from_single(*context.applied);
        for contact in &*self.cells {
            let position = Cell::at(add(contact.origin, applied));
            if let Some(v) = context.state.get_mut(contact.cell()) {
                *v = position;
            }
            context.dynamics.place(context.scheme_arrays, contact.cell(), position, k);
            context.awake.wake_around(model, contact.cell());
        }
    }
}

/// Notes where the cells are as the tool engages.
pub(super) fn note_origins<N: LinkNumber>(
    model: &Model<'_>,
    state: &[Cell<N>],
    cells: &mut [Contact<N>],
) {
    let k = N::from_single(model.saturation());
    for contact in cells {
        if let Some(v) = state.get(contact.cell()) {
            contact.origin = output(v.xyz(), k);
        }
    }
}

/// Force on chosen cells, if the tick has a sweep, and the work.
pub(super) fn output_of<D: Dynamics>(
    context: &Context<'_, '_, D>,
    cells: &[Contact<D::Number>],
) -> ToolOutput {
    let model = context.model();
    let force_n =
        if context.is_late { [0.0; 3] } else { scale(model.force_unit_n(), force(context, cells)) };
    ToolOutput {
        force_n: force_n.into(),
        work_j: finite(context.work.hi * model.energy_unit_j()),
        contacts: cells.len() as u32,
        ..ToolOutput::NONE
    }
}

/// Checks a list of contact cells against the model.
pub(crate) fn check(model: &Model<'_>, ids: &[u16], capacity: usize) -> Result<(), ContactError> {
    if ids.len() > capacity {
        return Err(ContactError::Capacity { needed: ids.len(), capacity });
    }
    let mut next = 0;
    for (at, &id) in ids.iter().enumerate() {
        if usize::from(id) >= model.body_cells() {
            return Err(ContactError::Unknown(at));
        }
        if usize::from(id) < next {
            return Err(ContactError::Order(at));
        }
        if model.is_fixed(id) {
            return Err(ContactError::Fixed(at));
        }
        next = usize::from(id) + 1;
    }
    Ok(())
}

/// Margin for the rounding of a sum.
const ROUNDED_UP: f32 = 1.001;

/// Weight of the links between held and other cells, and of the other terms at the held cells: twice the sum
/// of the elements of L between held cells, since all of them move alike.
pub(crate) fn outer_weight<N: LinkNumber>(model: &Model<'_>, held: &[Contact<N>]) -> f32 {
    let mut weight = 0.0;
    for cell in held.iter().map(Contact::cell) {
        for (link, other) in model.neighbours(cell) {
            weight += if is_among(held, other) { 0.0 } else { model.link_weight(link) };
        }
    }
    for cell in held.iter().map(Contact::cell) {
        model.others.each_of_row(cell, &mut |other, element| {
            if is_among(held, other) {
                weight += 2.0 * element;
            }
        });
    }
    if model.is_nodal() { ROUNDED_UP * weight } else { weight }
}

/// Energy of the terms at the held cells.
fn touched<N: LinkNumber>(terms: Terms<'_, '_, N>, v: &[Cell<N>], held: &[Contact<N>]) -> Touched {
    let mut sums = Touched::NONE;
    terms.list().touched(held, &terms.published(v), terms.states.all(), &mut sums);
    sums
}

/// Force of the terms on the held cells, in internal units.
fn force<D: Dynamics>(context: &Context<'_, '_, D>, held: &[Contact<D::Number>]) -> [f32; 3] {
    let (terms, state) = (context.terms, &*context.state);
    let of_shapes = match *context.touched {
        Some(touched) => touched.force,
        None if terms.model.is_nodal() => touched(terms, state, held).force,
        None => [0.0; 3],
    };
    let (at, list, states) = (terms.published(state), terms.list(), terms.states.all());
    let cells = held.iter().map(Contact::cell);
    cells.fold(of_shapes, |sum, cell| list.cell(cell, held, &at, states, sum))
}

/// The longest displacement that keeps the energy within `energy_max`: a displacement D raises sqrt(E) by at
/// most sqrt(W) |D| / 2, W = [`outer_weight`].
fn move_max(energy_max: f32, level: f32, outer_weight: f32) -> f32 {
    let margin = sqrt(energy_max) - sqrt(if level > 0.0 { level } else { 0.0 });
    if outer_weight <= 0.0 {
        f32::INFINITY
    } else if margin > 0.0 {
        2.0 * margin / sqrt(outer_weight)
    } else {
        0.0
    }
}

/// Length along `step` over which the energy certainly falls: the force F pulls along it, and a displacement D
/// changes the energy by at most W |D|^2 / 4 - F . D.
fn fall_max(force: [f32; 3], step: [f32; 3], outer_weight: f32) -> f32 {
    let (drawn, length) = (dot(force, step), sqrt(dot(step, step)));
    let least = outer_weight * length;
    if drawn > 0.0 && least > 0.0 { 2.0 * drawn / least } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    // REQ-ENE-03
    #[test]
    fn a_full_body_lets_the_tool_move_no_further() {
        assert_eq!(move_max(9.0, 4.0, 16.0), 0.5);
        assert_eq!(move_max(9.0, 9.0, 16.0), 0.0);
        assert_eq!(move_max(9.0, 90.0, 16.0), 0.0);
        assert_eq!(move_max(9.0, 0.0, 0.0), f32::INFINITY);
    }

    // REQ-ENE-04
    #[test]
    fn a_tool_may_follow_a_pull_to_where_the_energy_is_least() {
        assert_eq!(fall_max([3.0, 4.0, 0.0], [0.0, 2.0, 0.0], 16.0), 0.5);
        for (force, weight) in [([0.0, -4.0, 0.0], 16.0), ([0.0, 4.0, 0.0], 0.0)] {
            assert_eq!(fall_max(force, [0.0, 2.0, 0.0], weight), 0.0);
        }
        assert_eq!(fall_max([1.0; 3], [0.0; 3], 16.0), 0.0);
    }
}
