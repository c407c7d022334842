//! The current drive: a tool that loads its contact cells instead of holding them.
//!
//! The paper's Eq. 2 and 4 drive the network by a current `I_i`, the input displacement at the
//! contact cells and 0 elsewhere:
//!
//! ```text
//! C dP_i/dt = sum of w mu (P_j - P_i) + I
//! ```
//!
//! I is the tool's displacement since it engaged, per unit of network time, the same at each contact cell. It
//! is a load, not a position: the cells settle at r + I = 0, a stiffer body moves less, and a body without
//! fixed cells drifts (up to K). As a force it is 2 `k_ref` I on each contact cell [N], with I in metres per
//! unit of network time; at equilibrium the links pull back by the same force.
//!
//! **The guard.** The falling quantity is E - W, with W = sum of I . (`P_i` - `O_i`) over the contact cells,
//! O their positions when the tool engaged. W is linear, so the curvature bound of E is that of E - W, its
//! residual is r + I, and every certificate of a scheme holds for it. A change of I changes the level by
//! -(change of I) . (P - O). The energy itself is at most the level plus W.
//!
//! **The energy bound.** Outputs stay within K, so with constant I the energy E can grow by at most
//!
//! ```text
//! X(I) = sum over contact cells and axes of |I_a| K - I_a y_a >= 0
//! ```
//!
//! because E(P') <= level + I . (y' - O) and I . y' <= |I|_1 K at every later P'. So E + X(I) <= `E_max`
//! bounds E for all time, and sweeps lower E + X, since that is the level plus a constant. X is convex in I,
//! so a change of I that would break the bound is cut at the share at which the chord from the old value
//! meets it. A change that lowers X is never cut: the tool can always reduce its load.
//!
//! Only chosen cells can be loaded, not the contacts of tools, and there is no output stage with coupling or
//! passivity control: both rely on the work of a prescribed motion.
//!
//! Cost: 3 additions per contact cell and pass, and W once per pass. W is summed in `f64`, so that its
//! rounding does not affect the guard.

use crate::backend::f32x8::{Chunk, F32x8};
use crate::energy::held::Contact;
use crate::energy::links::number::LinkNumber;
use crate::energy::state::StatesOf;
use crate::energy::term::{Here, Pass, Term, change_lane};
use crate::model::Model;
use crate::model::terms::Keeps;
use crate::number::Number;
use crate::number::cell::{Cell, add, from_single, output};
use crate::number::two_float::{LANES, TwoFloat};

/// Margin for the rounding of a current that was cut at the energy bound.
const SHORT: f64 = 0.999;

/// A sum as two single-precision numbers, rounded up.
pub(crate) fn rounded_up(sum: f64) -> TwoFloat {
    const ROUNDING: f64 = 1.0 / (1_u64 << 44) as f64;
    let sum = sum + ROUNDING * if sum < 0.0 { -sum } else { sum };
    let hi = sum as f32;
    TwoFloat { hi, lo: (sum - f64::from(hi)) as f32 }
}

/// The load on the contact cells: the current into each of them, `None` if the tool holds them.
#[derive(Clone, Copy)]
pub(crate) struct Load<'a, N> {
    pub current: Option<[f32; 3]>,
    pub cells: &'a [Contact<N>],
}

impl<N: Number> Load<'_, N> {
    /// W = sum of I . (y - O) over the contact cells, whose outputs are y.
    pub fn work(self, y: &impl Fn(usize) -> [N; 3]) -> f64 {
        let mut sum = 0.0;
        for contact in self.cells {
            let each = self.current.unwrap_or_default().into_iter().zip(y(contact.cell()));
            for ((i, y), o) in each.zip(contact.origin) {
                sum += f64::from(i) * (y.double() - o.double());
            }
        }
        sum
    }
}

impl<N: Number> Keeps for Load<'_, N> {}

impl<N: LinkNumber> Term<N> for Load<'_, N> {
    #[inline(always)]
    fn accumulate<const CLAMPED: bool>(
        self,
        _: &Pass<'_, N, CLAMPED>,
        residual: &mut [Cell<N>],
        _: &mut N::Tally,
        _: StatesOf<'_>,
    ) {
        let Some(current) = self.current else { return };
        for contact in self.cells {
            if let Some(r) = residual.get_mut(contact.cell()) {
                let [x, y, z] = add(r.xyz(), from_single(current));
                *r = Cell([x, y, z, r.w()]);
            }
        }
    }

    #[inline(always)]
    fn slice<V: F32x8>(
        self,
        here: Here<'_, V>,
        _: &impl Fn() -> Chunk,
        sum: &mut [V; 4],
        _: StatesOf<'_>,
    ) {
        let Some(current) = self.current else { return };
        let first = here.slice * LANES;
        let next = self.cells.partition_point(|contact| contact.cell() < first);
        let lanes = self.cells.iter().skip(next).map(|contact| contact.cell() - first);
        for lane in lanes.take_while(|&lane| lane < LANES) {
            change_lane(sum, lane, |r| {
                let [x, y, z] = add(r.xyz(), current);
                Cell([x, y, z, r.w()])
            });
        }
    }

    fn potential(self, energy: TwoFloat, at: &impl Fn(usize) -> [N; 3]) -> TwoFloat {
        match self.current {
            Some(_) => energy.plus(rounded_up(-self.work(at))),
            None => energy,
        }
    }
}

/// The part of a change between two currents that keeps E within `energy_max` for all time.
pub(crate) fn admitted<N: Number>(
    model: &Model<'_>,
    [from, to]: [[f32; 3]; 2],
    energy: f64,
    v: &[Cell<N>],
    contacts: &[Contact<N>],
) -> [f32; 3] {
    let k = N::from_single(model.saturation());
    let room = |current: [f32; 3]| {
        let mut sum = energy;
        for v in contacts.iter().filter_map(|contact| v.get(contact.cell())) {
            for (i, y) in current.into_iter().zip(output(v.xyz(), k)) {
                let i = f64::from(i);
                sum += if i < 0.0 { -i } else { i } * k.double() - i * y.double();
            }
        }
        f64::from(model.energy_max()) - sum
    };
    let [before, after] = [from, to].map(room);
    if after >= 0.0 || after >= before {
        return to;
    }
    let share = if before > 0.0 { SHORT * before / (before - after) } else { 0.0 } as f32;
    [0, 1, 2].map(|axis| match (from.get(axis), to.get(axis)) {
        (Some(from), Some(to)) => from + share * (to - from),
        _ => 0.0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's plane of 9 x 9 nodes.
    static PLANE: &[u8] = crate::include_model!("../../../tests/data/plane9.chaincell");

    fn room(model: &Model<'_>, current: [f32; 3], energy: f64, v: &[Cell]) -> f64 {
        let k = f64::from(model.saturation());
        let cells = v.iter().map(|v| {
            let terms = current.iter().zip(v.xyz());
            terms.map(|(&i, y)| f64::from(i.abs()) * k - f64::from(i) * f64::from(y)).sum::<f64>()
        });
        f64::from(model.energy_max()) - energy - cells.sum::<f64>()
    }

    #[test]
    fn a_sum_is_rounded_up_and_hardly() {
        for sum in [0.0, 1.0, -1.0, 1.0 / 3.0, -1.0e9 / 7.0] {
            let TwoFloat { hi, lo } = rounded_up(sum);
            let up = f64::from(hi) + f64::from(lo) - sum;
            assert!((0.0..=1e-13 * sum.abs()).contains(&up), "{sum}: {up:e}");
        }
    }

    // REQ-ENE-04
    #[test]
    fn a_current_beyond_the_energy_bound_is_cut_and_can_come_back() {
        let model = Model::from_bytes(PLANE).unwrap();
        let v = [Cell::at([1.0, -2.0, 0.5]), Cell::at([0.0, 3.0, 0.0])];
        let contacts = [Contact::new(0), Contact::new(1)];
        let energy = 0.25 * f64::from(model.energy_max());
        let cut = |from, to, energy| admitted(&model, [from, to], energy, &v, &contacts);
        let small = [0.01, -0.02, 0.0];
        assert_eq!(cut([0.0; 3], small, energy), small);
        let far = cut(small, [1e6, 2e6, -1e6], energy);
        let left = room(&model, far, energy, &v);
        assert!((0.0..0.01 * f64::from(model.energy_max())).contains(&left), "{far:?}: {left}");
        // At or above the bound: the current cannot grow, but it can fall.
        let full = 2.0 * f64::from(model.energy_max());
        assert_eq!(cut(small, [1.0, -0.02, 0.0], full), small);
        assert_eq!(cut(far, small, full), small);
    }
}
