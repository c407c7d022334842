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

use super::contact::{Contact, Touched, is_among};
use super::links::number::LinkNumber;
use super::residual::Terms;
use super::term::Term;
use crate::model::Model;
use crate::model::terms::TermData;
use crate::number::Number;
use crate::number::cell::{Cell, add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::TwoFloat;

/// Why a list of contact cells is refused; the position is that in the list.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, Tissue, Track, include_model};
/// use chaincell_kernel::ContactError;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
/// let border = model.fixed()[0];
/// let refused = tissue.choose_contacts(&network, &[border]);
/// assert_eq!(refused, Err(ContactError::Fixed(0)));
/// assert_eq!(tissue.choose_contacts(&network, &[46, 47]), Ok(())); // ascending
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ContactError {
    /// The tissue has memory for fewer contact cells.
    #[error("{needed} contact cells, room for {capacity}: raise the capacity")]
    Capacity {
        /// Cells asked for.
        needed: usize,
        /// Cells that the memory holds.
        capacity: usize,
    },
    /// The cell is not in the model.
    #[error("contact cell at position {0} is not in the model")]
    Unknown(usize),
    /// The cell's state is fixed.
    #[error("contact cell at position {0} is fixed")]
    Fixed(usize),
    /// The ids must ascend without repeats.
    #[error("contact cell at position {0} is not above the last")]
    Order(usize),
    /// The tissue was not reset to this network.
    #[error("the tissue belongs to another network: reset it first")]
    Model,
    /// The tissue has too little memory to hold that many cells against the model's coarse level: size it
    /// with [`coarse_room`](crate::coarse_room), or [`elastic_held_room`](crate::elastic_held_room) for nodal
    /// shapes.
    #[error(
        "holding these cells needs {needed} blocks of eight f32 for the coarse level, there is \
         room for {room}"
    )]
    CoarseRoom {
        /// Blocks needed.
        needed: usize,
        /// Blocks that the tissue has.
        room: usize,
    },
    /// The tool is engaged: contacts can be chosen only while it is not.
    #[error("the tool is engaged: release it first")]
    Engaged,
    /// Tools need a contact surface, and the model has none.
    #[error(
        "the model has no contact surface: bake a mesh with triangles or tetrahedra, a lean model with \
         `contact_surface` yes"
    )]
    NoContactSurface,
    /// The number of tools is 0 or above the tissue's capacity.
    #[error("{needed} tools: there must be 1 to {capacity}, as many as the tissue has room for")]
    Tools {
        /// Tools asked for.
        needed: usize,
        /// Most tools.
        capacity: usize,
    },
    /// A tool has no parts, or too many.
    #[error("tool {tool} must have 1 to {most} parts")]
    Parts {
        /// The tool, from 0.
        tool: usize,
        /// Most parts.
        most: usize,
    },
    /// The shape of a tool's part is invalid.
    #[error(
        "part {part} of tool {tool}: its radius must be above 0, its lengths finite and not \
         negative, its turn a unit quaternion"
    )]
    Part {
        /// The tool, from 0.
        tool: usize,
        /// The part, from 0.
        part: usize,
    },
    /// The coefficient of friction is out of its range.
    #[error("friction must be 0 to {max}")]
    Friction {
        /// Largest coefficient.
        max: f32,
    },
    /// Friction holds samples, and the tissue has no memory for anchors.
    #[error("friction needs room for anchors: give the tissue some")]
    AnchorRoom,
    /// The tissue has too little memory for tools and the model's coarse level: size it with
    /// [`tool_room`](crate::tool_room).
    #[error(
        "tools need {needed} blocks of eight f32 for the coarse level, there is room for \
         {room}: size it with tool_room, or bake it with `coarse` none"
    )]
    ToolRoom {
        /// Blocks needed.
        needed: usize,
        /// Blocks that the tissue has.
        room: usize,
    },
    /// This kernel is built without the feature `surface`.
    #[error(
        "this program has no contact with tools: build it with the feature `surface`, or hold cells"
    )]
    SurfaceUnbuilt,
    /// The scheme has no contact on surfaces.
    #[error(
        "tools touch tissue under track and predict in single precision alone: take one of them, or \
         hold cells"
    )]
    SurfaceScheme,
    /// The radius needs more samples than a triangle can have.
    #[error("the radius of a tool's part must be at least {min_m} m on this model's surface")]
    RadiusMin {
        /// Smallest radius \[m\].
        min_m: f32,
    },
    /// The tissue has too little memory for tools on the surface.
    #[error("tools on the surface need room for {needed} cells, there is room for {capacity}")]
    SurfaceRoom {
        /// Cells of the model.
        needed: usize,
        /// Cells that the memory holds.
        capacity: usize,
    },
}

/// Checks a list of contact cells against the model.
pub(crate) fn check(model: &Model<'_>, ids: &[u16], capacity: usize) -> Result<(), ContactError> {
    if ids.len() > capacity {
        return Err(ContactError::Capacity { needed: ids.len(), capacity });
    }
    let mut next = 0;
    for (at, &id) in ids.iter().enumerate() {
        if usize::from(id) >= model.cells() {
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
pub(crate) fn outer_weight<N: Number>(model: &Model<'_>, held: &[Contact<N>]) -> f32 {
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
pub(crate) fn touched<N: LinkNumber>(
    terms: Terms<'_, '_, N>,
    v: &[Cell<N>],
    held: &[Contact<N>],
) -> Touched {
    let mut sums = Touched { wd2: TwoFloat::ZERO, scale: 0.0 };
    terms.list().touched(held, &terms.published(v), terms.states.all(), &mut sums);
    sums
}

/// Force of the terms on the held cells, in internal units.
pub(crate) fn force<N: LinkNumber>(
    terms: Terms<'_, '_, N>,
    v: &[Cell<N>],
    held: &[Contact<N>],
) -> [f32; 3] {
    let (at, list, states) = (terms.published(v), terms.list(), terms.states.all());
    let cells = held.iter().map(Contact::cell);
    cells.fold([0.0; 3], |sum, cell| list.cell(cell, held, &at, states, sum))
}

/// The longest displacement that keeps the energy within `energy_max`: a displacement D raises sqrt(E) by at
/// most sqrt(W) |D| / 2, W = [`outer_weight`].
pub(crate) fn move_max(energy_max: f32, level: f32, outer_weight: f32) -> f32 {
    let room = sqrt(energy_max) - sqrt(if level > 0.0 { level } else { 0.0 });
    if outer_weight <= 0.0 {
        f32::INFINITY
    } else if room > 0.0 {
        2.0 * room / sqrt(outer_weight)
    } else {
        0.0
    }
}

/// Length along `way` over which the energy certainly falls: the force F pulls along it, and a displacement D
/// changes the energy by at most W |D|^2 / 4 - F . D.
pub(crate) fn fall_max(force: [f32; 3], way: [f32; 3], outer_weight: f32) -> f32 {
    let (drawn, length) = (dot(force, way), sqrt(dot(way, way)));
    let least = outer_weight * length;
    if drawn > 0.0 && least > 0.0 { 2.0 * drawn / least } else { 0.0 }
}

/// Moves `from` towards `to` by at most `limit`; true if the limit shortened it.
pub(crate) fn approach(from: [f32; 3], to: [f32; 3], limit: f32) -> ([f32; 3], bool) {
    let way = sub(to, from);
    let length = sqrt(dot(way, way));
    if length <= limit {
        return (to, false);
    }
    (add(from, scale(limit / length, way)), true)
}

#[cfg(test)]
mod tests {
    use super::*;

    // REQ-FOR-04
    #[test]
    fn approach_stops_at_the_limit_or_the_target() {
        assert_eq!(approach([1.0, 0.0, 0.0], [1.0, 3.0, 4.0], 5.0), ([1.0, 3.0, 4.0], false));
        let (at, bit) = approach([0.0; 3], [0.0, 3.0, 4.0], 1.0);
        assert!(bit && (at[1] - 0.6).abs() < 1e-6 && (at[2] - 0.8).abs() < 1e-6);
        assert_eq!(approach([1.0; 3], [2.0; 3], 0.0), ([1.0; 3], true));
    }

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
