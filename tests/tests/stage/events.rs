//! All that may happen to a served session, one after the other and at random, on a simulated clock: what
//! a modelled hand gets out of nothing, which presses by 20 mm and comes back, twice.
//! `CHAINCELL_SLOW=1` plays ten thousand sequences.
#![allow(clippy::unwrap_used)]

use std::collections::VecDeque;

use chaincell_host::bake::ImageBytes;
use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::snapshot::Saved;
use chaincell_host::session::ipc::tools::Answer;
use chaincell_host::session::loops::serve::{
    Behind, Charge, Resumed, ServeOptions, Session, Shared, Voice,
};
use chaincell_kernel::TOOLS_MAX;
use chaincell_kernel::trace::Command;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use crate::served::{MS_NS, Server, World, plane, premium, smooth, tissue};

/// Ticks of a press and the way back.
const CYCLE: u64 = 900;
/// Ticks of a session: two presses.
const TICKS: u64 = 2 * CYCLE;
/// Most energy out of nothing of a pair of events, of a sequence, and where the tool takes hold inside the
/// tissue \[J\].
const PAIR_MAX_J: f64 = 1.0e-3;
const MADE_MAX_J: f64 = 1.1e-3;
const INSIDE_MAX_J: f64 = 13.0e-3;
/// States that are kept for a server that is killed.
const SAVED: usize = 60;

/// What happens to a session.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Event {
    /// A number of poses lie elsewhere, by a distance in metres.
    Glitch(u64, f64),
    /// The server falls behind for a number of ticks, then keeps up.
    Overload(u64),
    /// A pause of a number of ticks.
    Pause(u64),
    /// Another program publishes, in a frame that lies deeper by so much \[m\].
    Takeover(f64),
    /// The server is killed, and another one continues from the state a number of ticks ago.
    Restore(u64),
    /// No pose comes for a number of ticks, and those in between are lost.
    Lost(u64),
    /// Poses of a number of ticks come at once.
    Burst(u64),
    /// The server stands still for a number of ticks, and finds all their poses.
    Stop(u64),
    /// A tick does not end for a number of milliseconds.
    SlowTick(u64),
    /// Commands.
    Sweeps(u16),
    MaxForce(f32),
    Reset,
    /// The tool is released for a number of ticks.
    Clutch(u64),
}

const EVENTS: [Event; 25] = [
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
    Event::Burst(30),
    Event::Burst(60),
    Event::Stop(15),
    Event::Stop(120),
    Event::Stop(200),
    Event::SlowTick(50),
    Event::Sweeps(2),
    Event::MaxForce(0.5),
    Event::MaxForce(20.0),
    Event::Reset,
    Event::Clutch(40),
];

/// Where the hand wants to be at a tick of its cycle, below the start \[m\].
fn depth_m(tick: u64) -> f64 {
    let at = tick as f64 / CYCLE as f64;
    0.02 * (smooth((at - 0.2) / 0.2) - smooth((at - 0.7) / 0.2))
}

/// A session under way: the hand, the program that publishes its poses, and what goes on.
struct Play {
    world: World,
    tick: u64,
    /// The program, the number of its next tick, and how much deeper its frame lies \[m\].
    publisher: u128,
    number: u64,
    frame_m: f64,
    /// Poses that wait for the server.
    queue: Vec<Pose>,
    /// The last states, and the one from which the next server goes on.
    saved: VecDeque<Saved>,
    restored: Option<Saved>,
    /// First ticks at which each of these is over, and where the wrong poses lie \[m\].
    glitch: u64,
    glitch_m: f64,
    overload: u64,
    pause: u64,
    lost: u64,
    burst: u64,
    stop: u64,
    slow: u64,
    clutch: u64,
}

impl Play {
    fn new() -> Self {
        Self {
            world: World::new(),
            tick: 0,
            publisher: 1,
            number: 1,
            frame_m: 0.0,
            queue: Vec::new(),
            saved: VecDeque::new(),
            restored: None,
            glitch: 0,
            glitch_m: 0.0,
            overload: 0,
            pause: 0,
            lost: 0,
            burst: 0,
            stop: 0,
            slow: 0,
            clutch: 0,
        }
    }

    fn happens(&mut self, event: Event, server: &mut Server<'_>) {
        let tick = self.tick;
        match event {
            Event::Glitch(ticks, by_m) => (self.glitch, self.glitch_m) = (tick + ticks, by_m),
            Event::Overload(ticks) => self.overload = tick + ticks,
            Event::Pause(ticks) => {
                self.pause = tick + ticks;
                server.command(Command::Pause);
            }
            Event::Takeover(deeper_m) => {
                (self.publisher, self.number, self.frame_m) = (self.publisher + 1, 1, deeper_m);
            }
            Event::Restore(ticks) => {
                let back = self.saved.len().saturating_sub(1 + ticks as usize);
                self.restored = self.saved.get(back).cloned();
            }
            Event::Lost(ticks) => self.lost = tick + ticks,
            Event::Burst(ticks) => self.burst = tick + ticks,
            Event::Stop(ticks) => self.stop = tick + ticks,
            Event::SlowTick(ticks) => self.slow = tick + ticks,
            Event::Sweeps(sweeps) => server.command(Command::Sweeps(sweeps)),
            Event::MaxForce(most_n) => server.command(Command::MaxForceN(most_n)),
            Event::Reset => server.command(Command::Reset),
            Event::Clutch(ticks) => self.clutch = tick + ticks,
        }
    }

    /// The hand moves under the force that its device has, and its program publishes where it is.
    fn publishes(&mut self, stiffness_n_per_m: f64) {
        let cycle = self.tick % CYCLE;
        self.world.go(depth_m(cycle), stiffness_n_per_m);
        // A tissue that nobody holds gives nothing back.
        if cycle == 0 && self.world.last.force.energy_j < 1.0e-6 {
            self.world.base_j = self.world.moving.got_j() - self.world.held_j;
        }
        let engaged = (40..CYCLE - 20).contains(&cycle) && self.tick >= self.clutch;
        let mut sample = self.world.moving.sample(engaged);
        let wrong_m = if self.tick < self.glitch { self.glitch_m } else { 0.0 };
        sample.position_m.z -= (self.frame_m + wrong_m) as f32;
        if self.tick >= self.lost {
            self.queue.push(Pose::of(self.number, &sample));
        }
        self.number += 1;
    }

    /// The server's turn: poses, and what it publishes without one.
    fn serves(&mut self, server: &mut Server<'_>) {
        let (tick, now_ns) = (self.tick, self.tick * MS_NS);
        if tick >= self.pause && server.session.is_paused() {
            server.command(Command::Resume);
        }
        if server.publisher != self.publisher {
            server.publisher = self.publisher;
            server.session.take_charge(self.publisher);
        }
        if tick >= self.burst.max(self.stop).max(self.slow) {
            self.queue.drain(..).for_each(|pose| server.take(pose, now_ns));
            let behind = if tick < self.overload { Behind::Far } else { Behind::No };
            server.execute(now_ns, behind, &mut self.world);
        }
        if tick >= self.stop {
            let said = if tick < self.slow {
                server.shared.voice().falling_in_tick(now_ns)
            } else {
                server.session.silence(now_ns)
            };
            said.into_iter().for_each(|answer| self.world.hear(answer));
        }
    }

    /// A server's life, up to the end or to its killing; `events` are those to come.
    fn life(
        &mut self,
        image: &ImageBytes,
        events: &mut VecDeque<(u64, Event)>,
        charge: Charge,
        stiffness_n_per_m: f64,
    ) {
        let stage = premium();
        let max_slew_n_per_s = stage.max_slew_n_per_s;
        let options = ServeOptions { max_slew_n_per_s, hash_every: 0, ..ServeOptions::default() };
        let mut staged = tissue(image, Some(stage));
        if let Some(saved) = self.restored.take() {
            staged.restore(&saved).unwrap();
        }
        let shared = Shared::new(Voice::new(&options, self.tick * MS_NS));
        let session = Session::new(&mut staged, &shared, &options, (charge, false));
        let mut server = Server::new(session, &shared);
        let keeps = events.iter().any(|(_, event)| matches!(event, Event::Restore(_)));
        self.world.last = Answer::default();
        self.queue.clear();
        while self.tick < TICKS {
            while let Some((_, event)) = events.pop_front_if(|(at, _)| *at <= self.tick) {
                self.happens(event, &mut server);
            }
            self.publishes(stiffness_n_per_m);
            if self.restored.is_some() {
                self.tick += 1;
                return;
            }
            self.serves(&mut server);
            if keeps {
                self.saved.extend(server.session.saved());
                if self.saved.len() > SAVED {
                    self.saved.pop_front();
                }
            }
            self.tick += 1;
        }
    }
}

/// Plays a session with these events at these ticks in a hand of this stiffness.
fn play(image: &ImageBytes, events: &[(u64, Event)], stiffness_n_per_m: f64) -> World {
    let mut play = Play::new();
    let mut events: VecDeque<(u64, Event)> = events.iter().copied().collect();
    let mut charge = Charge::new();
    while play.tick < TICKS {
        play.life(image, &mut events, charge, stiffness_n_per_m);
        charge = Charge::resuming(Resumed {
            tick: play.number,
            publisher: play.publisher,
            released: [true; TOOLS_MAX],
            is_paused: false,
        });
    }
    play.world
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
fn hold(name: &str, most_j: f64, cases: impl Iterator<Item = (Vec<(u64, Event)>, f64)>) {
    let image = plane();
    let mut most = [(0.0, String::new()), (0.0, String::new())];
    for (events, stiffness) in cases {
        let World { made_j, most_n, .. } = play(&image, &events, stiffness);
        let most = &mut most[usize::from(takes_hold_inside(&events))];
        if made_j > most.0 {
            *most = (made_j, format!("{events:?} in a hand of {stiffness} N/m, up to {most_n} N"));
        }
    }
    for ((made_j, what), bound_j) in most.iter().zip([most_j, INSIDE_MAX_J]) {
        println!("EVENTS | {name} | {made_j:.2e} of {bound_j:.0e} J | {what}");
    }
    assert!(most[0].0 <= most_j && most[1].0 <= INSIDE_MAX_J, "{most:?}");
}

#[test]
fn an_undisturbed_session_makes_nothing() {
    for stiffness in [100.0, 1000.0] {
        let World { made_j, most_n, step_n, .. } = play(&plane(), &[], stiffness);
        println!("EVENTS | none | {stiffness} N/m | {made_j:.2e} J, {most_n} N, steps {step_n} N");
        assert!(made_j < 1.0e-4 && most_n > 0.5 && step_n < 0.5);
    }
}

// REQ-STG-16, REQ-COS-10
#[test]
fn no_pair_of_events_gives_a_hand_energy_out_of_nothing() {
    let pairs = EVENTS.iter().flat_map(|&first| EVENTS.map(|second| (first, second)));
    let cases = pairs.enumerate().map(|(at, (first, second))| {
        // In mid-press, held, or on the way back.
        let start = 250 + 83 * (at as u64 % 5);
        let apart = [0, 7, 60, 140][at % 4];
        (vec![(start, first), (start + apart, second)], [1000.0, 100.0, 300.0][at % 3])
    });
    hold("pairs", PAIR_MAX_J, cases);
}

// REQ-STG-16
#[test]
fn no_sequence_of_events_gives_a_hand_energy_out_of_nothing() {
    let is_long = std::env::var_os("CHAINCELL_SLOW").is_some();
    let sequences: u64 = if is_long { 10_000 } else { 500 };
    let mut random = Pcg64::seed_from_u64(7);
    let cases = (0..sequences).map(|_| {
        let mut below = |most: u64| u64::from(random.next_u32()) % most;
        let count = 1 + below(6);
        let mut event = || (60 + below(TICKS - 60), EVENTS[below(EVENTS.len() as u64) as usize]);
        let mut events: Vec<(u64, Event)> = (0..count).map(|_| event()).collect();
        events.sort_by_key(|&(at, _)| at);
        (events, [1000.0, 300.0, 100.0, 50.0][below(4) as usize])
    });
    hold("sequences", MADE_MAX_J, cases);
}
