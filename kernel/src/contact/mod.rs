//! The contact of tools with the body: what a tool does before the sweeps of a tick, and the force after them.
//!
//! | contact | the tool | file |
//! |---|---|---|
//! | `Held` | holds chosen cells and prescribes their positions | `held` |
//! | `Load` | loads chosen cells by a current | `load` |
//! | `Tools` | presses on the triangles of the surface, rubs and grips | `tools` |
//!
//! Each works on a `Context`, which the tick gives it, with the same verbs: `advance` moves the tool towards
//! its poses, within the limits of step and energy; `acting` is its part in the sweeps; `book` takes the tools'
//! contact and work after them; `output` is the force on a tool.
//!
//! - `context`: the part of a tick that a contact works on.
//! - [`pose`], [`output`], [`error`]: poses and parts of tools, outputs, why a choice is refused.
//! - [`memory`]: memory for tools on the surface.
//! - `inside`: test of whether a point lies in the tissue.

pub(crate) mod context;
pub mod error;
pub(crate) mod held;
mod inside;
pub(crate) mod load;
pub mod memory;
pub mod output;
pub mod pose;
pub(crate) mod tools;

use crate::energy::held::Contact;
use crate::energy::links::number::LinkNumber;
use crate::energy::surface::Touch;
use crate::solver::Dynamics;
use crate::solver::coarse::{Coarse, CoarseTouch};
use context::Context;
use held::Held;
use load::Load;
use output::ToolOutput;
use pose::ToolPose;
use tools::Tools;

/// The effect of the tools on the body in a tick.
pub(crate) enum ToolContact<'a, D: Dynamics> {
    Held(Held<'a, D>),
    Load(Load<'a, D>),
    Tools(Tools<'a>),
}

/// A contact's part in the sweeps of a tick.
pub(crate) struct Acting<'a, N: LinkNumber> {
    /// Cells that the tool acts on.
    pub contacts: &'a [Contact<N>],
    /// Their displacement if it holds them.
    pub applied: [f32; 3],
    /// The current into the cells that it acts on.
    pub current: Option<[f32; 3]>,
    /// Method by which a coarse level takes the contact into account; `None` if it cannot.
    pub coarse: Option<Coarse>,
    pub touch: Touch<'a>,
    /// Effect of tools on an elastic coarse level.
    pub coarse_touch: Option<&'a CoarseTouch>,
}

impl<N: LinkNumber> Acting<'_, N> {
    /// No contact.
    const NONE: Self = Self {
        contacts: &[],
        applied: [0.0; 3],
        current: None,
        coarse: None,
        touch: Touch::NONE,
        coarse_touch: None,
    };
}

impl<D: Dynamics> ToolContact<'_, D> {
    /// Moves the tools towards their poses; without poses tools on the surface keep their last ones.
    #[inline(always)]
    pub fn advance(&mut self, context: &mut Context<'_, '_, D>, poses: &[ToolPose]) {
        match self {
            Self::Held(held) => held.advance(context),
            Self::Load(load) => load.advance(context),
            Self::Tools(tools) => tools.advance(context, poses),
        }
    }

    /// Its part in the sweeps.
    #[inline(always)]
    pub fn acting(&mut self, context: &Context<'_, '_, D>) -> Acting<'_, D::Number> {
        match self {
            Self::Held(held) => held.acting(context),
            Self::Load(load) => load.acting(context),
            Self::Tools(tools) => tools.acting(context),
        }
    }

    /// Takes contact and work after the sweeps.
    #[inline(always)]
    pub fn book(&mut self, context: &mut Context<'_, '_, D>) {
        match self {
            Self::Held(held) => held.book(context),
            Self::Load(load) => load.book(context),
            Self::Tools(tools) => tools.book(context),
        }
    }

    /// Output of an engaged tool; its force is that of the last tick with a sweep.
    #[inline(always)]
    pub fn output(&self, context: &Context<'_, '_, D>, tool: usize) -> ToolOutput {
        match self {
            Self::Held(held) => held.output(context),
            Self::Load(load) => load.output(context),
            Self::Tools(tools) => tools.memory.output(context.model(), tool),
        }
    }

    /// Returns true if an engaged tool waits inside the tissue without contact.
    #[inline(always)]
    pub fn waits(&self) -> bool {
        matches!(self, Self::Tools(tools) if tools.memory.waits())
    }
}
