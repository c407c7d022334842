//! `euler`: the paper's dynamics (Eq. 2, 12, 15), one explicit step of common size per sweep.
//!
//! ```text
//! C dv_i/dt = -(v_i - y_i) / R_x + sum of w mu (y_j - y_i),   y = clamp(v, -K, K)
//! ```
//!
//! which is Eq. 2 with the templates of Eq. 15: inside the linear range the state is the position
//! and the leak vanishes. With h <= 2 C / b and h <= `R_x` C no step raises the energy of y, from
//! any state. Time is physical: choose h = 1 ms / time constant for stress relaxation.
//!
//! Cost: one link pass and one pass over the cells, no array besides state and residual.

use core::marker::PhantomData;

use super::Dynamics;
use super::scheme::{Body, Scheme};
use crate::number::cell::{Cell, add, output, peak, scale, sub};
use crate::number::kept::kept;
use crate::number::two_float::Eight;
use crate::number::two_float::TwoFloat;
use crate::solver::loops::{Loops, Moved};

kept! {
    /// State of the scheme: whether any state is beyond K.
    ///
    /// ```
    /// # use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, include_model};
    /// use chaincell_kernel::Euler;
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// # let network = Network::new(model, Settings::for_model(&model))?;
    /// let mut tissue = Tissue::<128, Euler>::new();
    /// # tissue.reset(&network)?;
    /// # tissue.choose_contacts(&network, &[47])?;
    /// # tissue.tick(&network, &[ToolPose::at([0.0; 3].into(), 1)], Budget::All);
    /// // The tool goes 2 mm aside and stays: the stress relaxes.
    /// let pose = [ToolPose::at([0.002, 0.0, 0.0].into(), 1)];
    /// let first_n = tissue.tick(&network, &pose, Budget::All).force_n.x;
    /// let later_n = (0..50).fold(0.0, |_, _| tissue.tick(&network, &pose, Budget::All).force_n.x);
    /// assert!(first_n < -0.11 && (later_n + 0.0879).abs() < 2e-4); // [N], down to the settled force
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Euler<N = f32> {
        saturated: bool,
        number: PhantomData<N>,
    }
}

impl<N: Loops> Dynamics for Euler<N> {
    const NAME: &'static str = "euler";
    const REST: Self = Self { saturated: false, number: PhantomData };
    const ARRAYS: usize = 0;
    type Arrays<const CELLS: usize> = [[Cell<N>; CELLS]; 0];
    type Room = [Eight; 0];
}

/// A step of the outputs, with the leak of states beyond K. Returns the guarded quantity before the step, in
/// internal units, and whether some state is still beyond K. Held cells return to the tool's displacement.
pub(super) fn saturated_step<N: Loops>(body: &mut Body<'_, '_, N>, step: f32) -> (TwoFloat, bool) {
    let model = body.terms.model;
    body.awake.wake_all(model);
    // The leak also moves cells without a link force.
    body.awake.postpone_sleep();
    let energy = body.terms.saturated_energy(&body.awake.set, body.state, body.residual);
    let potential = body.terms.potential(energy, body.state);
    let step = step / model.capacitance();
    let leak = N::from_single(step / model.resistance());
    let (step, k) = (N::from_single(step), N::from_single(model.saturation()));
    let mut highest = N::ZERO;
    for ((v, r), &mobility) in body.state.iter_mut().zip(&*body.residual).zip(model.mobility) {
        if mobility > 0.0 {
            let next = add(v.xyz(), scale(step, r.xyz()));
            *v = Cell::at(sub(next, scale(leak, sub(v.xyz(), output(v.xyz(), k)))));
        }
        let here = peak(v.xyz());
        highest = if here > highest { here } else { highest };
    }
    (potential, body.restore_held() | (highest > k))
}

/// A step within K from existing residuals. Returns true if some state is beyond K after it.
pub(super) fn linear_step<N: Loops>(body: &mut Body<'_, '_, N>, step: f32) -> bool {
    let model = body.terms.model;
    let step = step / model.capacitance();
    let (awake, residual) = (&*body.awake, &*body.residual);
    let mut moved = Moved::NOTHING;
    N::euler_step(body.terms, awake, body.state, residual, step, &mut moved);
    let has_moved = |cell: usize| residual.get(cell).is_some_and(|r| r.xyz() != [N::ZERO; 3]);
    body.awake.wake_neighbours(model, &moved.slices, has_moved);
    body.restore_held() | moved.beyond
}

impl<N: Loops> Scheme for Euler<N> {
    type Number = N;

    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_, N>) -> bool {
        let step = body.pace.step;
        self.saturated = if self.saturated {
            let (potential, beyond) = saturated_step(body, step);
            body.level.set(potential);
            beyond
        } else {
            let set = &body.awake.set;
            let energy = N::residual(body.terms, set, set, body.state, body.residual);
            body.level.set(body.terms.potential(energy, body.state));
            linear_step(body, step)
        };
        false
    }

    fn place(&mut self, _own: &mut [Cell<N>], _cell: usize, position: Cell<N>, k: f32) {
        self.saturated |= peak(position.xyz()) > N::from_single(k);
    }

    fn interrupt(&mut self) {}
}
