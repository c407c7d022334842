//! A session of `serve` on a simulated clock, and the device and the hand at its other end.
//!
//! The session is the one of `serve` (`chaincell_host::session::loops::serve::Session`); its ports, its
//! clock and its machine are played. A handle of the Premium (100 g, 30 um) in a hand presses a plane of
//! links. While no message comes, or none but those of a silence, or bad poses, the device holds a force
//! or lets it fall: what a hand that moves meanwhile gets of that is not counted.
#![allow(clippy::unwrap_used)]

use std::collections::VecDeque;

use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell};
use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::order::TickPlace;
use chaincell_host::engine::staged::Staged;
use chaincell_host::engine::tools::Poses;
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::session::ipc::tools::Answer;
use chaincell_host::session::loops::serve::{Arrived, Behind, Session, Shared};
use chaincell_kernel::Budget;
use chaincell_kernel::stage::{Device, StageSettings};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{Flags, Model, Network, Settings};
use chaincell_loops::closed_loop::handle;
use chaincell_loops::handle::{Hand, Moving};
use chaincell_tests::bodies::baked;
use nalgebra::{Rotation3, Vector3};

/// A tick \[ns\].
pub const MS_NS: u64 = 1_000_000;
/// Place of the Premium in the list of devices.
const PREMIUM: usize = 1;

/// A plane of links of 1 kN/m, as `bake plane:5x5x0.01 --alpha 0 --stiffness-n-per-m 1000` makes it.
pub fn plane() -> ImageBytes {
    let uniform = PerCell::Uniform;
    let options = BakeOptions {
        alpha: uniform(0.0),
        stiffness_n_per_m: uniform(1000.0),
        ..BakeOptions::default()
    };
    baked("plane:5x5x0.01", &options)
}

pub fn tissue(image: &ImageBytes, stage: Option<StageSettings>) -> Staged<'_> {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let network = Network::new(model, Settings { sweeps: 4, ..Settings::for_model(&model) });
    let middle = model.cell_of_input(12).unwrap();
    let engine = Engine::new(network.unwrap(), Scheme::Track, &[middle]).unwrap();
    Staged::new(engine, stage).unwrap()
}

/// The stage that `serve --device premium` has.
pub fn premium() -> StageSettings {
    StageSettings { watchdog_ticks: 0, ..StageSettings::for_device(Device::Premium) }
}

/// From 0 to 1 without a jump of the speed.
pub fn smooth(share: f64) -> f64 {
    let share = share.clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// Device and hand, and what they see of the server.
pub struct World {
    pub moving: Moving,
    /// The newest message, the ticks since it came, and the ticks of the device's own ramp.
    pub last: Answer,
    pub silent: u32,
    pub ramp: u32,
    /// Energy that hand and handle had got when the tool was last away from the tissue, the most since
    /// \[J\], the largest force and the largest step of it \[N\].
    pub base_j: f64,
    pub made_j: f64,
    /// What forces gave to the hand that the device held since no newer one was computed \[J\].
    pub held_j: f64,
    pub most_n: f32,
    pub step_n: f32,
}

/// How the device's own watchdog and ramp go \[ticks\].
const RAMP: u32 = 20;

impl World {
    pub fn new() -> Self {
        let moving = Moving::new(handle(PREMIUM, Rotation3::identity()), Vector3::zeros());
        Self {
            moving,
            last: Answer::default(),
            silent: 0,
            ramp: 0,
            base_j: 0.0,
            made_j: 0.0,
            held_j: 0.0,
            most_n: 0.0,
            step_n: 0.0,
        }
    }

    pub fn hear(&mut self, answer: Answer) {
        let [before, now] = [self.last, answer].map(|of| Vector3::from(of.force.force_n));
        self.step_n = self.step_n.max((now - before).norm());
        self.most_n = self.most_n.max(now.norm());
        (self.last, self.silent) = (answer, 0);
    }

    /// A tick of the device: the force that it has, and the hand's way.
    pub fn go(&mut self, depth_m: f64, stiffness_n_per_m: f64) {
        self.silent += 1;
        self.ramp = match self.silent > RAMP {
            true => self.ramp.saturating_sub(1),
            false => (self.ramp + 1).min(RAMP),
        };
        let force_n = Vector3::from(self.last.force.force_n) * (self.ramp as f32 / RAMP as f32);
        let at = Vector3::new(0.0, 0.0, -depth_m);
        let hand = Hand { stiffness_n_per_m, damping_n_s_per_m: 0.5, holds: true, at };
        let before_j = self.moving.port_j;
        self.moving.tick(force_n, &hand);
        let said = Flags(self.last.force.flags);
        let is_held = said.contains(Flags::BAD_SAMPLE) || said.contains(Flags::STALE);
        if self.silent > 1 || is_held {
            self.held_j += (self.moving.port_j - before_j).max(0.0);
        }
        self.made_j = self.made_j.max(self.moving.got_j() - self.held_j - self.base_j);
    }
}

/// A server's life, up to its end or its killing.
pub struct Server<'a> {
    pub session: Session<'a>,
    pub shared: &'a Shared,
    pub publisher: u128,
    pub inbox: VecDeque<Arrived>,
    /// How long a tick takes \[ns\].
    pub tick_ns: u64,
}

impl<'a> Server<'a> {
    pub fn new(session: Session<'a>, shared: &'a Shared) -> Self {
        Self { session, shared, publisher: 0, inbox: VecDeque::new(), tick_ns: 0 }
    }

    /// A pose comes in.
    pub fn take(&mut self, pose: Pose, now_ns: u64) {
        let (place, steps) = self.session.place(pose.tick);
        if place == TickPlace::Next {
            let (tick, poses) = (pose.tick, Poses::of(&[pose.into()]));
            let arrived = Arrived { tick, poses, at_ns: now_ns, ..Arrived::default() };
            self.inbox.push_back(self.session.accept(arrived, steps));
        }
    }

    /// All that waits is executed: the newest with sweeps, the others late.
    pub fn execute(&mut self, now_ns: u64, behind: Behind, world: &mut World) {
        while let Some(mut arrived) = self.inbox.pop_front() {
            let is_late = !self.inbox.is_empty() && !self.session.is_paused();
            self.session.prepare(&mut arrived, None);
            let sweeps = if is_late { Budget::LATE } else { Budget::All };
            let output = self.session.tick(&arrived, sweeps);
            let answer = self.session.answer(&arrived, &output, 0);
            world.hear(self.session.publish(answer, now_ns));
            if !is_late {
                self.session.judge(behind, [now_ns.saturating_sub(self.tick_ns), now_ns]);
            }
        }
    }

    /// All that waits is late.
    pub fn execute_late(&mut self, now_ns: u64, world: &mut World) {
        for mut arrived in std::mem::take(&mut self.inbox) {
            self.session.prepare(&mut arrived, None);
            let output = self.session.tick(&arrived, Budget::LATE);
            let answer = self.session.answer(&arrived, &output, 0);
            world.hear(self.session.publish(answer, now_ns));
        }
    }

    pub fn command(&mut self, command: Command) {
        self.session.obey(&command).unwrap();
    }
}
