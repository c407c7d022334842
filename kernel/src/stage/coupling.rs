//! Virtual coupling: the tissue's tool is a massless proxy on a spring and a damper.
//!
//! The proxy p is connected to the device x by `k_c` and `b_c`; together with the tissue it has the energy
//! E(p) + `k_c` |x - p|^2 / 2. Each tick takes one damped step along its gradient,
//!
//! ```text
//! (b_c / h + k_c + k_t / theta) dp = k_c (x - p) + F + (b_c / h) dx
//! ```
//!
//! F is the tissue's force in the last tick and `k_t` the largest bound of the stiffness within a tick that
//! it reported in this contact. E curves upwards by at most `k_t`, so for theta <= 2 and a device at rest no
//! step raises the joint energy, however stiff the tissue is against the coupling; the plain p = x + F /
//! `k_c` diverges where it is stiffer. Before a tool touches, the tissue reports no stiffness: the first
//! step into it is the device's. Out of contact `k_t` fades, since a step may take the proxy out of a stiff
//! tissue for a tick or two; on the way out it is ignored. So in free air p = x, and no force is shown. The
//! device shows `k_c` (p - x) + `b_c` (dp - dx) / h: at rest exactly F, and never stiffer than the coupling.
//!
//! If the tissue has cut the tool's motion short (flag 1), the proxy does not continue in that direction: it
//! stays within one step of the tool.
//!
//! Source: J. E. Colgate, M. C. Stanley, J. M. Brown, Issues in the haptic display of tool use
//! (1995); R. J. Adams, B. Hannaford, Stable haptic interaction with virtual environments (1999).

use crate::number::cell::{add, dot, scale, sub};
use crate::number::kept::kept;
use crate::stage::settings::Coupling;

/// Share of the largest step that cannot raise the joint energy: 2 is the bound, 1 the safest.
const THETA: f32 = 1.5;

/// Share of the stiffness kept after a tick without contact. Without it, a proxy that a stiff tissue has
/// pushed out by a step would plunge into it again.
const FORGOTTEN: f32 = 1.0 - 1.0 / 16.0;

kept! {
    /// The proxy.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub(super) struct Proxy {
        /// Position of the tool \[m\].
        at: [f32; 3],
        /// Motion in this tick, and the last motion that was not zero \[m\].
        moved: [f32; 3],
        way: [f32; 3],
        /// The tissue's force in the last tick, and the last one that was not zero \[N\].
        force: [f32; 3],
        out: [f32; 3],
        /// The largest bound of the tissue's stiffness in this contact, fading out of contact \[N/m\].
        stiffness: f32,
        /// True if the tissue cut the last motion short.
        is_cut: bool,
    }
}

impl Proxy {
    pub(super) const NEW: Self = Self {
        at: [0.0; 3],
        moved: [0.0; 3],
        way: [0.0; 3],
        force: [0.0; 3],
        out: [0.0; 3],
        stiffness: 0.0,
        is_cut: false,
    };

    /// Puts the proxy at the device.
    pub(super) fn follow(&mut self, device: [f32; 3]) {
        *self = Self { at: device, ..Self::NEW };
    }

    pub(super) fn at(&self) -> [f32; 3] {
        self.at
    }

    /// Notes the tissue's answer.
    pub(super) fn feel(&mut self, force: [f32; 3], stiffness: f32, is_cut: bool) {
        (self.force, self.is_cut) = (force, is_cut);
        if force != [0.0; 3] {
            self.out = force;
        }
        if stiffness > self.stiffness {
            self.stiffness = stiffness;
        } else if stiffness == 0.0 {
            self.stiffness *= FORGOTTEN;
        }
    }

    /// Takes one step; the device is at `device` after a motion of `dx`, and `tick_s` is h.
    pub(super) fn step(&mut self, of: &Coupling, tick_s: f32, device: [f32; 3], dx: [f32; 3]) {
        let damping = of.damping_n_s_per_m / tick_s;
        let spring = scale(of.stiffness_n_per_m, sub(device, self.at));
        let acting = add(add(spring, self.force), scale(damping, dx));
        // On its way out of a tissue that it has left, no stiffness limits the step.
        let leaves = self.force == [0.0; 3] && dot(acting, self.out) > 0.0;
        let tissue = if leaves { 0.0 } else { self.stiffness / THETA };
        let against = damping + of.stiffness_n_per_m + tissue;
        let step = scale(1.0 / against, acting);
        // Do not continue in a direction that the tissue has cut short.
        let goes_on = self.is_cut && dot(step, self.way) > 0.0;
        let to = if goes_on { self.at } else { add(self.at, step) };
        self.moved = sub(to, self.at);
        if self.moved != [0.0; 3] {
            self.way = self.moved;
        }
        self.at = to;
    }

    /// Force of the coupling on the device, `time_s` after the last sample \[N\].
    pub(super) fn force(
        &self,
        of: &Coupling,
        time_s: f32,
        device: [f32; 3],
        dx: [f32; 3],
    ) -> [f32; 3] {
        let spring = scale(of.stiffness_n_per_m, sub(self.at, device));
        add(spring, scale(of.damping_n_s_per_m / time_s, sub(self.moved, dx)))
    }

    /// Energy in the coupling's spring with the device at `device` \[J\].
    pub(super) fn stored(&self, of: &Coupling, device: [f32; 3]) -> f32 {
        let apart = sub(self.at, device);
        0.5 * of.stiffness_n_per_m * dot(apart, apart)
    }
}
