//! The part of a tick that a contact works on.

use crate::energy::held::Touched;
use crate::energy::residual::Terms;
use crate::model::Model;
use crate::number::cell::{Cell, add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::two_float::{Eight, TwoFloat};
use crate::solver::Dynamics;
use crate::solver::awake::Awake;
use crate::solver::level::Level;

/// Bound of a coordinate of the tool's displacement, so that its square stays finite.
const DISPLACEMENT_MAX: f32 = 1.0e6;

/// The body that a contact changes in a tick, and the tool's motion.
pub(crate) struct Context<'a, 'm, D: Dynamics> {
    /// The terms without the contact.
    pub terms: Terms<'a, 'm, D::Number>,
    /// State v of every cell.
    pub state: &'a mut [Cell<D::Number>],
    /// The scheme's arrays.
    pub scheme_arrays: &'a mut [Cell<D::Number>],
    /// Memory for a coarse level.
    pub coarse_memory: &'a mut [Eight],
    pub dynamics: &'a mut D,
    pub level: &'a mut Level,
    /// r . z of the last pass, see [`Body::off_balance`](crate::solver::scheme::Body).
    pub off_balance: &'a mut f32,
    pub awake: &'a mut Awake,
    /// Position of the first tool, the last good one \[m\].
    pub position_m: [f32; 3],
    /// Its position when it engaged \[m\].
    pub origin_m: [f32; 3],
    /// Its displacement since then, within the limits [mean link lengths].
    pub applied: &'a mut [f32; 3],
    /// Energy of nodal shapes at the held cells in the present state, and the force on them, if they are known.
    pub touched: &'a mut Option<Touched>,
    /// Largest motion of a tool in a tick [mean link lengths].
    pub step_max: f32,
    /// True if the tool was engaged in the last tick.
    pub was_engaged: bool,
    /// True if it is engaged.
    pub is_engaged: bool,
    /// True if the tick makes no sweep.
    pub is_late: bool,
    /// Work of the tool's motion on the tissue, the change of E.
    pub work: TwoFloat,
    /// Energy that the tools give the body in this tick, see [`given_j`](crate::TissueMut::given_j).
    pub given: &'a mut f32,
    /// True if a limit shortened the tool's motion.
    pub is_clamped: bool,
    /// True if triangles or samples found no memory.
    pub is_full: bool,
}

impl<'m, D: Dynamics> Context<'_, 'm, D> {
    pub fn model(&self) -> &Model<'m> {
        self.terms.model
    }

    /// Displacement of the tool after this tick: towards its position, within the step limit.
    pub fn step_towards(&mut self) -> [f32; 3] {
        let unit_m = self.model().unit_m();
        let wished = sub(self.position_m, self.origin_m)
            .map(|x| (x / unit_m).clamp(-DISPLACEMENT_MAX, DISPLACEMENT_MAX));
        let (to, is_short) = approach(*self.applied, wished, self.step_max);
        self.is_clamped |= is_short;
        to
    }

    /// Books a change of the energy that the tools make at the present positions.
    pub fn disturb(&mut self, change: TwoFloat) {
        self.level.shift(change);
        self.awake.wake_all(self.terms.model);
        self.dynamics.pushed();
    }
}

/// Moves `from` towards `to` by at most `limit`; true if the limit shortened it.
pub(crate) fn approach(from: [f32; 3], to: [f32; 3], limit: f32) -> ([f32; 3], bool) {
    let step = sub(to, from);
    let length = sqrt(dot(step, step));
    if length <= limit {
        return (to, false);
    }
    (add(from, scale(limit / length, step)), true)
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
}
