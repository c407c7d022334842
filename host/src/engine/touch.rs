//! The tool's contact, and memory for tools on a model with a contact surface.

use chaincell_kernel::{
    Anchor, Cell, CoarseTouch, Model, NearTriangle, PinSample, TOOLS_MAX, ToolPart, ToolState,
    TouchArrays, TouchRoom, TouchState,
};

/// Contact of the tool while engaged.
#[derive(Debug, Clone, PartialEq)]
pub enum Contact {
    /// Cells that the tool holds: ascending, none fixed.
    Cells(Vec<u16>),
    /// Tools on a model with a contact surface.
    Tools {
        /// The parts of each tool.
        tools: Vec<Vec<ToolPart>>,
        /// Coefficient of friction.
        friction: f32,
    },
}

impl Contact {
    /// One tool, a sphere around its position, with this coefficient of friction.
    #[must_use]
    pub fn sphere(radius_m: f32, friction: f32) -> Self {
        Self::Tools { tools: vec![vec![ToolPart::sphere(radius_m)]], friction }
    }

    /// Radius \[m\] of the touching sphere; `None` if the contact is no single sphere.
    #[must_use]
    pub fn radius_m(&self) -> Option<f32> {
        match self {
            Self::Cells(_) => None,
            Self::Tools { tools, .. } => only_sphere(tools),
        }
    }

    /// Parts of the first tool, which the built-in press moves; `None` if cells are held.
    #[must_use]
    pub fn first_tool(&self) -> Option<&[ToolPart]> {
        let Self::Tools { tools, .. } = self else { return None };
        tools.first().map(Vec::as_slice)
    }

    /// Returns true if a tool cuts.
    #[must_use]
    pub fn has_blade(&self) -> bool {
        let Self::Tools { tools, .. } = self else { return false };
        tools.iter().flatten().any(ToolPart::is_edge)
    }

    /// The option that names it.
    pub(super) fn option(&self) -> &'static str {
        if matches!(self, Self::Cells(_)) { "contact" } else { "tool" }
    }

    /// Number of tools, 0 if cells are held.
    #[must_use]
    pub fn tools(&self) -> usize {
        if let Self::Tools { tools, .. } = self { tools.len() } else { 0 }
    }

    /// Number of contact slots that the tissue needs.
    pub(super) fn slots(&self) -> usize {
        if let Self::Cells(cells) = self { cells.len() } else { 0 }
    }
}

/// The radius \[m\] if there is one tool and it is a sphere around its position.
#[must_use]
pub fn only_sphere(tools: &[Vec<ToolPart>]) -> Option<f32> {
    let [parts] = tools else { return None };
    let [part] = parts.as_slice() else { return None };
    (*part == ToolPart::sphere(part.radius_m)).then_some(part.radius_m)
}

/// Largest number of triangles in reach of the tools; if more are in reach, the nearest ones are kept.
pub const TRIANGLES: usize = 1024;
/// Largest number of samples that friction or grips hold.
const SAMPLES: usize = 2048;
/// Largest number of samples that pins hold.
const PINNED: usize = 2048;

/// The arrays; empty if no tool touches a surface.
#[derive(Default)]
pub struct TouchMemory {
    mobility: Vec<f32>,
    factors: Vec<f32>,
    pulls: Vec<Cell>,
    near: Vec<NearTriangle>,
    coarse: Vec<CoarseTouch>,
    anchors: Vec<Anchor>,
    pins: Vec<PinSample>,
    tools: Vec<ToolState>,
    state: Vec<TouchState>,
}

impl TouchMemory {
    /// Memory for tools on a model with a contact surface.
    pub fn for_contact(model: &Model<'_>, contact: &Contact) -> Self {
        if !model.has_contact_surface() || matches!(contact, Contact::Cells(_)) {
            return Self::default();
        }
        let cells = model.cells();
        Self {
            mobility: vec![0.0; cells],
            factors: vec![0.0; cells],
            pulls: vec![Cell::ZERO; cells],
            near: vec![NearTriangle::NONE; TRIANGLES],
            coarse: vec![CoarseTouch::NONE],
            anchors: vec![Anchor::NONE; 2 * SAMPLES],
            pins: vec![PinSample::NONE; PINNED],
            tools: vec![ToolState::NONE; TOOLS_MAX],
            state: vec![TouchState::AWAY],
        }
    }

    pub fn room(&mut self) -> TouchRoom<'_> {
        TouchRoom::new(TouchArrays {
            mobility: &mut self.mobility,
            factors: &mut self.factors,
            pulls: &mut self.pulls,
            near: &mut self.near,
            coarse: &mut self.coarse,
            anchors: &mut self.anchors,
            pins: &mut self.pins,
            tools: &mut self.tools,
            state: &mut self.state,
        })
    }

    pub fn ram_bytes(&self) -> usize {
        size_of_val(&*self.mobility)
            + size_of_val(&*self.factors)
            + size_of_val(&*self.pulls)
            + size_of_val(&*self.near)
            + size_of_val(&*self.coarse)
            + size_of_val(&*self.anchors)
            + size_of_val(&*self.pins)
            + size_of_val(&*self.tools)
            + size_of_val(&*self.state)
    }
}
