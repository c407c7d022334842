//! All that may happen to a served session, one after the other and at random, on a simulated clock: what
//! a modelled hand gets out of nothing.
//!
//! The session is the one of `serve` (`chaincell_host::session::loops::serve::Session`); its ports, its
//! clock and its machine are played here. While no message comes, or none but those of a silence, or bad
//! poses, the device holds a force or lets it fall: what a hand that moves meanwhile gets of that is not
//! counted. A handle of the Premium (100 g, 30 um) in a hand presses a plane of links by 20 mm and comes
//! back, twice. `CHAINCELL_SLOW=1` plays ten thousand sequences.

use std::collections::VecDeque;

use chaincell_host::bake::{BakeOptions, ImageBytes, PerCell, bake};
use chaincell_host::engine::order::TickPlace;
use chaincell_host::engine::staged::Staged;
use chaincell_host::engine::tissue::Sweeps;
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_host::session::ipc::payload::ToolPose;
use chaincell_host::session::ipc::tools::Answer;
use chaincell_host::session::loops::serve::{
    Arrived, Behind, Charge, Resumed, ServeOptions, Session, Shared, Voice,
};
use chaincell_kernel::stage::{Device, StageSettings};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{Flags, Model, Network, Settings, TOOLS_MAX};
use chaincell_tests::closed_loop::handle;
use chaincell_tests::handle::{Hand, Moving};
use nalgebra::{Rotation3, Vector3};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

/// Ticks of a press and the way back.
const CYCLE: u64 = 900;
/// Cycles of a session.
const CYCLES: u64 = 2;
const MS_NS: u64 = 1_000_000;
/// Place of the Premium in the list of devices.
const PREMIUM: usize = 1;
/// Most energy out of nothing, and where the tool takes hold inside the tissue \[J\].
const MADE_MAX_J: f64 = 1.0e-3;
const INSIDE_MAX_J: f64 = 13.0e-3;

/// What happens to a session.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Event {
    /// So many poses lie elsewhere by so many metres.
    Glitch(u64, f64),
    /// The server falls behind for so many ticks, then keeps up.
    Overload(u64),
    /// Paused for so many ticks.
    Pause(u64),
    /// Another program publishes, in a frame that lies deeper by so much \[m\].
    Takeover(f64),
    /// The server is killed, and another one goes on from the state of so many ticks ago.
    Restore(u64),
    /// No pose comes for so many ticks, and those in between are lost.
    Lost(u64),
    /// Poses of so many ticks come at once.
    Burst(u64),
    /// The server stands still for so many ticks, and finds all their poses.
    Stop(u64),
    /// A tick does not end for so many milliseconds.
    SlowTick(u64),
    /// Commands.
    Sweeps(u16),
    MaxForce(f32),
    Reset,
    /// The tool is released for so many ticks.
    Clutch(u64),
}

const EVENTS: [Event; 23] = [
    Event::Glitch(1, 300.0),
    Event::Glitch(1, -0.02),
    Event::Glitch(3, 1.0),
    Event::Glitch(80, 0.03),
    Event::Overload(5),
    Event::Overload(150),
    Event::Pause(30),
    Event::Pause(200),
    Event::Takeover(0.0),
    Event::Takeover(0.03),
    Event::Restore(40),
    Event::Lost(10),
    Event::Lost(60),
    Event::Burst(8),
    Event::Burst(60),
    Event::Stop(15),
    Event::Stop(120),
    Event::SlowTick(50),
    Event::Sweeps(2),
    Event::MaxForce(0.5),
    Event::MaxForce(20.0),
    Event::Reset,
    Event::Clutch(40),
];

/// A plane of links of 1 kN/m, as `bake plane:5x5x0.01 --alpha 0 --stiffness-n-per-m 1000` makes it.
fn plane() -> ImageBytes {
    let mesh = load("plane:5x5x0.01", &MeshOptions::default()).unwrap();
    let uniform = PerCell::Uniform;
    let options = BakeOptions {
        alpha: uniform(0.0),
        stiffness_n_per_m: uniform(1000.0),
        ..BakeOptions::default()
    };
    bake(&mesh, &mesh.default_fixed, &options).unwrap()
}

fn tissue(image: &ImageBytes, stage: Option<StageSettings>) -> Staged<'_> {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let network = Network::new(model, Settings { sweeps: 4, ..Settings::for_model(&model) });
    let middle = model.cell_of_input(12).unwrap();
    let engine = Engine::new(network.unwrap(), Scheme::Track, &[middle]).unwrap();
    Staged::new(engine, stage).unwrap()
}

/// The stage that `serve --device premium` has.
fn premium() -> StageSettings {
    StageSettings { watchdog_ticks: 0, ..StageSettings::for_device(Device::Premium) }
}

/// Device and hand, and what they see of the server.
struct World {
    moving: Moving,
    /// The newest message, the ticks since it came, and the ticks of the device's own ramp.
    last: Answer,
    silent: u32,
    ramp: u32,
    /// Energy that hand and handle had got when the tool was last away from the tissue, the most since
    /// \[J\], the largest force and the largest step of it \[N\].
    base_j: f64,
    made_j: f64,
    /// What forces gave to the hand that the device held since no newer one was computed \[J\].
    held_j: f64,
    most_n: f32,
    step_n: f32,
}

/// How the device's own watchdog and ramp go \[ticks\].
const RAMP: u32 = 20;

impl World {
    fn new() -> Self {
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

    fn hear(&mut self, answer: Answer) {
        let [before, now] = [self.last, answer].map(|of| Vector3::from(of.force.force_n));
        self.step_n = self.step_n.max((now - before).norm());
        self.most_n = self.most_n.max(now.norm());
        (self.last, self.silent) = (answer, 0);
    }

    /// A tick of the device: the force that it has, and the hand's way.
    fn go(&mut self, depth_m: f64, stiffness_n_per_m: f64) {
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

/// Where the hand wants to be at a tick of its cycle, below the start \[m\].
fn depth_m(tick: u64) -> f64 {
    let at = tick as f64 / CYCLE as f64;
    let smooth = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    0.02 * (smooth((at - 0.2) / 0.2) - smooth((at - 0.7) / 0.2))
}

/// What came of a session.
#[derive(Debug)]
struct Came {
    made_j: f64,
    most_n: f32,
    step_n: f32,
}

/// A server's life, up to its end or its killing.
struct Server<'a> {
    session: Session<'a>,
    shared: &'a Shared,
    publisher: u128,
    inbox: VecDeque<Arrived>,
    /// How long a tick takes \[ns\].
    tick_ns: u64,
}

impl Server<'_> {
    /// A pose comes in.
    fn take(&mut self, pose: ToolPose, now_ns: u64) {
        let (place, steps) = self.session.place(pose.tick);
        if place == TickPlace::Next {
            let arrived = Arrived { pose, at_ns: now_ns, ..Arrived::default() };
            self.inbox.push_back(self.session.accept(arrived, steps));
        }
    }

    /// All that waits is executed: the newest with sweeps, the others late.
    fn execute(&mut self, now_ns: u64, behind: Behind, world: &mut World) {
        while let Some(mut arrived) = self.inbox.pop_front() {
            let is_late = !self.inbox.is_empty() && !self.session.is_paused();
            self.session.prepare(&mut arrived, None);
            let sweeps = if is_late { Sweeps::LATE } else { Sweeps::ALL };
            let output = self.session.tick(&arrived, sweeps);
            let answer = self.session.answer(&arrived, &output, 0);
            world.hear(self.session.publish(answer, now_ns));
            if !is_late {
                self.session.judge(behind, [now_ns.saturating_sub(self.tick_ns), now_ns]);
            }
        }
    }

    /// All that waits is late.
    fn execute_late(&mut self, now_ns: u64, world: &mut World) {
        for mut arrived in std::mem::take(&mut self.inbox) {
            self.session.prepare(&mut arrived, None);
            let output = self.session.tick(&arrived, Sweeps::LATE);
            let answer = self.session.answer(&arrived, &output, 0);
            world.hear(self.session.publish(answer, now_ns));
        }
    }

    fn command(&mut self, command: Command) {
        self.session.obey(&command).unwrap();
    }
}

/// What goes on at a tick.
#[derive(Debug, Default)]
struct Now {
    /// First tick at which each of these is over.
    glitch: (u64, f64),
    overload: u64,
    resume: u64,
    lost: u64,
    burst: u64,
    stop: u64,
    slow: u64,
    released: u64,
    frame_m: f64,
}

/// Plays a session with these events at these ticks in a hand of this stiffness.
fn play(
    image: &ImageBytes,
    stage: Option<StageSettings>,
    events: &[(u64, Event)],
    stiffness_n_per_m: f64,
) -> Came {
    let options = ServeOptions {
        max_slew_n_per_s: stage.map_or(f32::INFINITY, |stage| stage.max_slew_n_per_s),
        max_speed_m_per_s: if stage.is_some() { f32::INFINITY } else { 5.0 },
        hash_every: 0,
        ..ServeOptions::default()
    };
    let mut world = World::new();
    let mut now = Now::default();
    let (mut tick, mut publisher, mut number) = (0, 1_u128, 1);
    let mut saved: VecDeque<chaincell_host::engine::snapshot::Saved> = VecDeque::new();
    let mut charge = Charge::new();
    let mut next = 0;
    let restores = events.iter().any(|(_, event)| matches!(event, Event::Restore(_)));
    let mut restored = None;
    while tick < CYCLE * CYCLES {
        // A server begins.
        let mut staged = tissue(image, stage);
        if let Some(saved) = restored.take() {
            staged.restore(&saved).unwrap();
        }
        let shared = Shared::new(Voice::new(&options, tick * MS_NS));
        let session = Session::new(&mut staged, &shared, &options, (charge, false));
        let inbox = VecDeque::new();
        let mut server = Server { session, shared: &shared, publisher: 0, inbox, tick_ns: 0 };
        let mut queue = Vec::new();
        while tick < CYCLE * CYCLES {
            let now_ns = tick * MS_NS;
            let mut is_killed = false;
            while let Some(&(_, event)) = events.get(next).filter(|&&(at, _)| at <= tick) {
                next += 1;
                match event {
                    Event::Glitch(ticks, by_m) => now.glitch = (tick + ticks, by_m),
                    Event::Overload(ticks) => now.overload = tick + ticks,
                    Event::Pause(ticks) => {
                        now.resume = tick + ticks;
                        server.command(Command::Pause);
                    }
                    Event::Takeover(deeper_m) => {
                        (publisher, number, now.frame_m) = (publisher + 1, 1, deeper_m);
                    }
                    Event::Restore(ticks) => {
                        let back = saved.len().saturating_sub(1 + ticks as usize);
                        restored = saved.get(back).cloned();
                        is_killed = restored.is_some();
                    }
                    Event::Lost(ticks) => now.lost = tick + ticks,
                    Event::Burst(ticks) => now.burst = tick + ticks,
                    Event::Stop(ticks) => now.stop = tick + ticks,
                    Event::SlowTick(ticks) => now.slow = tick + ticks,
                    Event::Sweeps(sweeps) => server.command(Command::Sweeps(sweeps)),
                    Event::MaxForce(most_n) => server.command(Command::MaxForceN(most_n)),
                    Event::Reset => server.command(Command::Reset),
                    Event::Clutch(ticks) => now.released = tick + ticks,
                }
            }
            if tick == now.resume && server.session.is_paused() {
                server.command(Command::Resume);
            }
            // The device's pose, as the program publishes it.
            let cycle = tick % CYCLE;
            let depth = depth_m(cycle);
            world.go(depth, stiffness_n_per_m);
            // A tissue that nobody holds gives nothing back.
            if cycle == 0 && world.last.force.energy_j < 1.0e-6 {
                world.base_j = world.moving.got_j() - world.held_j;
            }
            let engaged = cycle >= 40 && cycle < CYCLE - 20 && tick >= now.released;
            let mut sample = world.moving.sample(engaged);
            sample.position_m.z -= now.frame_m as f32;
            if tick < now.glitch.0 {
                sample.position_m.z -= now.glitch.1 as f32;
            }
            let pose = ToolPose {
                tick: number,
                position_m: sample.position_m.into(),
                engaged: sample.engaged,
            };
            number += 1;
            if server.publisher != publisher {
                server.publisher = publisher;
                server.session.take_charge(publisher);
            }
            if is_killed {
                charge = Charge::resuming(Resumed {
                    tick: number,
                    publisher,
                    released: [true; TOOLS_MAX],
                    is_paused: false,
                });
                saved.clear();
                tick += 1;
                break;
            }
            if tick >= now.lost {
                queue.push(pose);
            }
            let waits = tick < now.burst || tick < now.stop;
            if !waits && tick >= now.slow {
                queue.drain(..).for_each(|pose| server.take(pose, now_ns));
                let is_behind = tick < now.overload;
                let behind = if is_behind { Behind::Far } else { Behind::No };
                server.execute(now_ns, behind, &mut world);
            }
            if tick >= now.stop {
                let said = if tick < now.slow {
                    server.shared.voice().falling_in_tick(now_ns)
                } else {
                    server.session.silence(now_ns)
                };
                said.into_iter().for_each(|answer| world.hear(answer));
            }
            if restores {
                saved.extend(server.session.saved());
                if saved.len() > 60 {
                    saved.pop_front();
                }
            }
            tick += 1;
        }
    }
    Came { made_j: world.made_j, most_n: world.most_n, step_n: world.step_n }
}

/// Sweeps of a budget that take longer than a pose period, from tick 300 on, in a tool that stands
/// pressed: the milliseconds until the published force is 0.
fn until_zero_ms(sweep_ns: u64, stage: Option<StageSettings>) -> u64 {
    let image = plane();
    let options = ServeOptions { hash_every: 0, ..ServeOptions::default() };
    let mut staged = tissue(&image, stage);
    let shared = Shared::new(Voice::new(&options, 0));
    let session = Session::new(&mut staged, &shared, &options, (Charge::new(), false));
    let inbox = VecDeque::new();
    let mut server = Server { session, shared: &shared, publisher: 1, inbox, tick_ns: sweep_ns };
    server.session.take_charge(1);
    let (slow_ns, mut world, mut sent, mut due_ns) = (300 * MS_NS, World::new(), 0, 0);
    let mut under_way: Option<(u64, Arrived)> = None;
    // A tenth of a millisecond a step.
    for step in 0..20_000 {
        let now_ns = step * MS_NS / 10;
        if step % 10 == 0 {
            sent += 1;
            let depth_m = 1.0e-4 * (sent as f32 - 50.0).clamp(0.0, 200.0);
            let pose = ToolPose {
                tick: sent,
                position_m: [0.0, 0.0, -depth_m],
                engaged: u32::from(sent > 20),
            };
            server.take(pose, now_ns);
        }
        let takes_ns = if now_ns < slow_ns { MS_NS / 10 } else { sweep_ns };
        match under_way {
            Some((begun_ns, _)) if now_ns >= begun_ns + takes_ns => {
                let behind = if takes_ns > MS_NS { Behind::Yes } else { Behind::No };
                server.tick_ns = takes_ns;
                let newer = std::mem::take(&mut server.inbox);
                let (_, arrived) = under_way.take().unwrap();
                server.inbox.push_back(arrived);
                server.execute(now_ns, behind, &mut world);
                server.inbox = newer;
            }
            // The watcher speaks while a tick is under way.
            Some(_) if now_ns >= due_ns => {
                let said = shared.voice().falling_in_tick(now_ns);
                said.into_iter().for_each(|answer| world.hear(answer));
                due_ns = now_ns + MS_NS;
            }
            Some(_) => {}
            None => {
                let newest = server.inbox.pop_back();
                server.tick_ns = 0;
                server.execute_late(now_ns, &mut world);
                under_way = newest.map(|arrived| (now_ns, arrived));
            }
        }
        let force_n = Vector3::from(world.last.force.force_n).norm();
        assert!(now_ns != slow_ns || force_n > 0.1, "{force_n} N when the sweeps began to be slow");
        if now_ns > slow_ns && force_n == 0.0 {
            return (now_ns - slow_ns) / MS_NS;
        }
    }
    u64::MAX
}

#[test]
fn a_sweep_above_the_pose_period_takes_the_force_away_within_forty_milliseconds() {
    for stage in [None, Some(premium())] {
        for periods in [1.1, 1.5, 2.0, 3.0, 6.0] {
            let ms = until_zero_ms((periods * MS_NS as f64) as u64, stage);
            println!("OVERLOAD | {periods} | force 0 after {ms} ms |");
            assert!(ms <= 40, "{periods}: {ms} ms");
        }
    }
}

/// Whether the tool takes hold within the tissue: after a release, or in a frame that lies elsewhere.
fn takes_hold_inside(events: &[(u64, Event)]) -> bool {
    let inside = |event: Event| match event {
        Event::Clutch(_) => true,
        Event::Glitch(ticks, _) => ticks > 50,
        _ => false,
    };
    events.iter().any(|&(_, event)| inside(event))
}

/// Plays sessions behind a stage, and holds the largest energy out of nothing against its bound: where
/// the tool takes hold within the tissue, and of all others.
fn hold(name: &str, cases: impl Iterator<Item = (Vec<(u64, Event)>, f64)>) {
    let image = plane();
    let mut most = [(0.0, String::new()), (0.0, String::new())];
    for (events, stiffness) in cases {
        let came = play(&image, Some(premium()), &events, stiffness);
        let most = &mut most[usize::from(takes_hold_inside(&events))];
        if came.made_j > most.0 {
            *most = (came.made_j, format!("{events:?} in a hand of {stiffness} N/m: {came:?}"));
        }
    }
    for ((made_j, what), bound_j) in most.iter().zip([MADE_MAX_J, INSIDE_MAX_J]) {
        println!("EVENTS | {name} | {made_j:.2e} of {bound_j:.0e} J | {what}");
    }
    assert!(most[0].0 <= MADE_MAX_J && most[1].0 <= INSIDE_MAX_J, "{most:?}");
}

#[test]
fn an_undisturbed_session_makes_nothing() {
    for stiffness in [100.0, 1000.0] {
        let came = play(&plane(), Some(premium()), &[], stiffness);
        println!("EVENTS | none | {stiffness} N/m | {came:?}");
        assert!(came.made_j < 1.0e-4 && came.most_n > 0.5 && came.step_n < 0.5, "{came:?}");
    }
}

#[test]
fn no_pair_of_events_gives_a_hand_energy_out_of_nothing() {
    let pairs = EVENTS.iter().flat_map(|&first| EVENTS.map(|second| (first, second)));
    let cases = pairs.enumerate().map(|(at, (first, second))| {
        // In mid-press, held, or on the way back.
        let start = 250 + 83 * (at as u64 % 5);
        let apart = [0, 7, 60, 140][at % 4];
        (vec![(start, first), (start + apart, second)], [1000.0, 100.0, 300.0][at % 3])
    });
    hold("pairs", cases);
}

#[test]
fn no_sequence_of_events_gives_a_hand_energy_out_of_nothing() {
    let is_long = std::env::var_os("CHAINCELL_SLOW").is_some();
    let sequences: u64 = if is_long { 10_000 } else { 500 };
    let mut random = Pcg64::seed_from_u64(7);
    let cases = (0..sequences).map(|_| {
        let mut below = |most: u64| u64::from(random.next_u32()) % most;
        let count = 1 + below(6);
        let mut events: Vec<(u64, Event)> = (0..count)
            .map(|_| (60 + below(CYCLE * CYCLES - 60), EVENTS[below(EVENTS.len() as u64) as usize]))
            .collect();
        events.sort_by_key(|&(at, _)| at);
        (events, [1000.0, 300.0, 100.0, 50.0][below(4) as usize])
    });
    hold("sequences", cases);
}
