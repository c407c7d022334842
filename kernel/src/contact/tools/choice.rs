//! Tools are chosen.

use crate::contact::error::ContactError;
use crate::contact::memory::TouchRoom;
use crate::contact::pose::ToolPart;
use crate::energy::surface::{Edge, IS_BUILT, PARTS_MAX, Proxy, TOOLS_MAX, ToolState};
use crate::model::{COORDINATE_MAX, Model};
use crate::solver::Dynamics;

/// Largest coefficient of friction.
pub const FRICTION_MAX: f32 = 10.0;

/// Checks that build, model, scheme and memory admit these tools.
pub(crate) fn check<D: Dynamics>(
    model: &Model<'_>,
    memory: &TouchRoom<'_>,
    coarse_blocks: usize,
    tools: &[&[ToolPart]],
    friction: f32,
) -> Result<(), ContactError> {
    // Check build, model and memory.
    if !IS_BUILT {
        return Err(ContactError::SurfaceUnbuilt);
    }
    let Some(radius_min) = model.tool_radius_min() else {
        return Err(ContactError::NoContactSurface);
    };
    let (capacity, anchors) = memory.tool_capacity();
    let capacity = capacity.min(TOOLS_MAX);
    if tools.is_empty() || tools.len() > capacity {
        return Err(ContactError::Tools { needed: tools.len(), capacity });
    }
    if !(0.0..=FRICTION_MAX).contains(&friction) {
        return Err(ContactError::Friction { max: FRICTION_MAX });
    }
    if friction > 0.0 && anchors == 0 {
        return Err(ContactError::AnchorRoom);
    }
    // Check every part of every tool.
    for (tool, parts) in tools.iter().enumerate() {
        if parts.is_empty() || parts.len() > PARTS_MAX {
            return Err(ContactError::Parts { tool, most: PARTS_MAX });
        }
        for (part, shape) in parts.iter().enumerate() {
            let edge = shape.edge_in_links(model.unit_m(), COORDINATE_MAX);
            let solid = shape.solid(model.unit_m(), COORDINATE_MAX);
            if edge.is_none() && solid.is_none() {
                return Err(ContactError::Part { tool, part });
            }
            if !D::TAKES_SURFACES {
                return Err(ContactError::SurfaceScheme);
            }
            if edge.is_some() && part + 1 < parts.len() {
                return Err(ContactError::Edge { tool, part });
            }
            if solid.is_some_and(|solid| solid.sampled < radius_min) {
                return Err(ContactError::RadiusMin { min_m: radius_min * model.unit_m() });
            }
            let (needed, capacity) = (model.cells(), memory.capacity());
            if needed > capacity {
                return Err(ContactError::SurfaceRoom { needed, capacity });
            }
        }
    }
    let (needed, room) = (D::tool_room(model), coarse_blocks);
    if needed > room {
        return Err(ContactError::ToolRoom { needed, room });
    }
    Ok(())
}

/// Takes over checked tools, at no contact.
pub(crate) fn choose(
    model: &Model<'_>,
    memory: &mut TouchRoom<'_>,
    tools: &[&[ToolPart]],
    friction: f32,
) {
    let Some(arrays) = memory.whole() else { return };
    for (slot, parts) in arrays.tools.iter_mut().zip(tools) {
        let edge = parts.iter().find_map(|part| part.edge_in_links(model.unit_m(), COORDINATE_MAX));
        let parts = parts.iter().filter_map(|part| part.solid(model.unit_m(), COORDINATE_MAX));
        let proxy = Proxy::with_edge(parts, edge.unwrap_or(Edge::NONE));
        *slot = ToolState { proxy, ..ToolState::NONE };
    }
    let holds_pins = !arrays.pins().is_empty();
    for state in &mut *arrays.state {
        state.pins_changed |= holds_pins;
        (state.tools, state.friction) = (tools.len(), friction);
        (state.count, state.anchors) = (0, 0);
    }
}
