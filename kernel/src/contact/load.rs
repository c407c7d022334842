//! Chosen cells that a tool loads by a current, see [`current`](crate::energy::current).

use super::Acting;
use super::context::Context;
use super::held::{note_origins, output_of};
use super::output::ToolOutput;
use crate::energy::current::{self, admitted, rounded_up};
use crate::energy::held::Contact;
use crate::number::cell::{from_single, single};
use crate::solver::Dynamics;
use crate::solver::coarse::Coarse;

/// Cells that a tool loads.
pub(crate) struct Load<'a, D: Dynamics> {
    pub cells: &'a mut [Contact<D::Number>],
}

impl<D: Dynamics> Load<'_, D> {
    /// Starts, moves or stops the current.
    pub fn advance(&mut self, context: &mut Context<'_, '_, D>) {
        if context.is_engaged && !context.was_engaged {
            note_origins(context.terms.model, context.state, self.cells);
            context.level.begin_work();
        }
        if context.is_engaged {
            self.let_in(context);
        } else if context.level.is_driven() {
            // The current stops at once; the cells continue from where they are.
            context.level.end_work();
            context.dynamics.pushed();
            self.wake(context);
        }
    }

    pub fn acting(&self, context: &Context<'_, '_, D>) -> Acting<'_, D::Number> {
        let contacts = if context.is_engaged { &*self.cells } else { &[] };
        let (applied, current) = (*context.applied, context.is_engaged.then_some(*context.applied));
        Acting { contacts, applied, current, coarse: Some(Coarse::Corrected(0)), ..Acting::NONE }
    }

    /// Moves the current towards the value that the tool asks for, as far as the energy bound allows.
    fn let_in(&self, context: &mut Context<'_, '_, D>) {
        let from = *context.applied;
        let wished = context.step_towards();
        // Rounded to the number type of the cells: work and residual must mean the same current.
        let wished = single(from_single::<D::Number>(wished));
        // Cut the current at the energy bound.
        let model = context.terms.model;
        let energy = context.level.energy().into();
        let to = admitted(model, [from, wished], energy, context.state, self.cells);
        let to = single(from_single::<D::Number>(to));
        context.is_clamped |= to != wished;
        // Book the change of the load's work.
        if to != from {
            let [old, new] = [from, to].map(|current| self.work(context, current));
            *context.applied = to;
            context.level.shift(rounded_up(old - new));
            context.level.note_work(rounded_up(new));
            context.dynamics.pushed();
        }
        if to != [0.0; 3] {
            self.wake(context);
        }
    }

    /// Books the current's work after the sweeps.
    pub fn book(&self, context: &mut Context<'_, '_, D>) {
        let work = self.work(context, *context.applied);
        context.level.note_work(rounded_up(work));
    }

    /// Work of a current since the tool engaged.
    fn work(&self, context: &Context<'_, '_, D>, current: [f32; 3]) -> f64 {
        let load = current::Load { current: Some(current), cells: self.cells };
        load.work(&context.terms.published(context.state))
    }

    /// The force on the cells; no motion of the tool stretches their links.
    pub fn output(&self, context: &Context<'_, '_, D>) -> ToolOutput {
        output_of(context, self.cells)
    }

    fn wake(&self, context: &mut Context<'_, '_, D>) {
        for contact in &*self.cells {
            context.awake.wake_around(context.terms.model, contact.cell());
        }
    }
}
