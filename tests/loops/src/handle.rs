//! A modelled haptic device in a hand: what closes the loop around a tissue.
//!
//! The handle is a mass with viscous damping, the hand a spring and a damper from the handle to
//! where it wants to be. Both move continuously (semi-implicit steps of 50 us, in
//! double precision) under the force that the device holds for a tick; what is measured of them is
//! quantised. All energies are those of the continuous motion.

use chaincell_kernel::ToolPose;
use nalgebra::{Rotation3, Vector3};

type V = Vector3<f64>;

/// Longest step of the motion \[s\].
const STEP_S: f64 = 5.0e-5;
/// Time of a tick \[s\].
pub const TICK_S: f64 = 1.0e-3;

/// A handle and its encoder.
#[derive(Debug, Clone, Copy)]
pub struct Handle {
    /// Mass \[kg\].
    pub mass_kg: f64,
    /// Viscous damping [N s/m].
    pub damping_n_s_per_m: f64,
    /// Step of the measured position along the encoders' axes, 0 for none \[m\].
    pub count_m: f64,
    /// From the axes of space to those of the encoders.
    pub axes: Rotation3<f64>,
    /// Ticks between an answer and its force.
    pub delay_ticks: usize,
}

/// A hand that holds the handle.
#[derive(Debug, Clone, Copy)]
pub struct Hand {
    /// Stiffness \[N/m\].
    pub stiffness_n_per_m: f64,
    /// Damping [N s/m].
    pub damping_n_s_per_m: f64,
    /// Whether it holds at all.
    pub holds: bool,
    /// Where it wants to be \[m\].
    pub at: V,
}

/// Device and hand, moving.
#[derive(Debug, Clone)]
pub struct Moving {
    handle: Handle,
    /// Where the handle is \[m\].
    pub position: V,
    /// Its velocity \[m/s\].
    pub velocity: V,
    /// Forces on their way to the device, the next one last.
    queue: Vec<V>,
    /// The hand's work on the handle so far \[J\].
    pub hand_j: f64,
    /// What the device has given to the handle so far \[J\].
    pub port_j: f64,
    /// What the handle's damping has taken so far \[J\].
    pub lost_j: f64,
}

impl Moving {
    /// At rest.
    #[must_use]
    pub fn new(handle: Handle, position: V) -> Self {
        Self {
            handle,
            position,
            velocity: V::zeros(),
            queue: vec![V::zeros(); handle.delay_ticks],
            hand_j: 0.0,
            port_j: 0.0,
            lost_j: 0.0,
        }
    }

    /// What the device measures.
    #[must_use]
    pub fn sample(&self, engaged: bool) -> ToolPose {
        let Handle { count_m: count, axes, .. } = self.handle;
        let read = |x: f64| if count > 0.0 { (x / count).round() * count } else { x };
        let measured = axes.inverse() * (axes * self.position).map(read);
        ToolPose::at(measured.map(|x| x as f32), u32::from(engaged))
    }

    /// One tick under a new answer: it acts after the delay.
    pub fn tick(&mut self, force_n: Vector3<f32>, hand: &Hand) {
        self.queue.insert(0, force_n.map(f64::from));
        let force = self.queue.pop().unwrap_or_else(V::zeros);
        self.go(force, hand, TICK_S);
    }

    /// Moves under a force of the device for so long, a whole number of steps.
    pub fn go(&mut self, force: V, hand: &Hand, time_s: f64) {
        let steps = (time_s / STEP_S).round().max(1.0);
        let step_s = time_s / steps;
        for _ in 0..steps as u32 {
            let grip = if hand.holds {
                hand.stiffness_n_per_m * (hand.at - self.position)
                    - hand.damping_n_s_per_m * self.velocity
            } else {
                V::zeros()
            };
            let drag = -self.handle.damping_n_s_per_m * self.velocity;
            self.velocity += (force + grip + drag) * (step_s / self.handle.mass_kg);
            let way = self.velocity * step_s;
            self.position += way;
            self.hand_j += grip.dot(&way);
            self.port_j += force.dot(&way);
            self.lost_j -= drag.dot(&way);
        }
    }

    /// What hand and handle have got out of nothing so far, or rather put in \[J\].
    #[must_use]
    pub fn got_j(&self) -> f64 {
        self.port_j - self.lost_j
    }

    /// Energy of motion \[J\].
    #[must_use]
    pub fn kinetic_j(&self) -> f64 {
        0.5 * self.handle.mass_kg * self.velocity.norm_squared()
    }
}
