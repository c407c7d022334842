//! Both sides on one simulated clock, over a link that delays, loses and holds back. The hand's own clock is another.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::atomic::{AtomicU8, Ordering};

use chaincell_client::clock::MILLISECOND_NS as MS;
use chaincell_client::tools::{ToolForces, ToolPoses};
use chaincell_client::{Flags, Notes};

use super::*;
use crate::agent::{Agent, FREE_NS, LIMIT_NS, News};
use crate::trips::FIRST;

/// Step of the simulation, a tick of the tissue, and the difference of the clocks [ns].
const STEP_NS: u64 = MS / 10;
const TISSUE_NS: u64 = 4 * STEP_NS;
const CLOCK_NS: u64 = 987_654_321;
const STIFFNESS_N_PER_M: f32 = 100.0;

fn key(digits: &str) -> Key {
    Key::from_hex(&digits.repeat(32)).unwrap()
}

fn address(port: u16) -> SocketAddr {
    SocketAddr::from(([10, 0, 0, 2], port))
}

fn fresh() -> Nonce {
    static NEXT: AtomicU8 = AtomicU8::new(1);
    [NEXT.fetch_add(1, Ordering::Relaxed).max(1); 16]
}

fn agent() -> Agent {
    Agent::new(key("5a"), LIMIT_NS, fresh)
}

/// Depth of a pose: 10 mm and back, twice a second [m].
fn depth_m(number: u64) -> f32 {
    0.01 * (1.0 - (number as f32 * std::f32::consts::TAU / 500.0).cos()) / 2.0
}

fn pose(number: u64) -> ToolPose {
    ToolPose::at([0.0, 0.0, -depth_m(number)].into(), u32::from(number > 1))
}

/// One way of the link.
#[derive(Debug, Default)]
struct Way {
    delay_ns: u64,
    under_way: VecDeque<(u64, Vec<u8>)>,
    sent: u64,
    /// Of ten datagrams these many at the end are lost.
    lost_of_ten: u64,
    /// All are lost, or all are kept until this is false again.
    is_cut: bool,
    is_held: bool,
}

impl Way {
    fn send(&mut self, bytes: Vec<u8>, now_ns: u64) {
        self.sent += 1;
        if !self.is_cut && self.sent % 10 < 10 - self.lost_of_ten {
            self.under_way.push_back((now_ns + self.delay_ns, bytes));
        }
    }

    fn take(&mut self, now_ns: u64) -> Option<Vec<u8>> {
        let is_there = self.under_way.front().is_some_and(|(due_ns, _)| *due_ns <= now_ns);
        (is_there && !self.is_held).then(|| self.under_way.pop_front().unwrap().1)
    }
}

struct World {
    now_ns: u64,
    agent: Agent,
    hand: Controller,
    from: SocketAddr,
    there: Way,
    back: Way,
    sends_poses: bool,
    /// Poses that the tissue got, each with its time, and its answers under way.
    tissue: Vec<(u64, ToolPoses)>,
    answers: VecDeque<(u64, ToolForces)>,
    news: Vec<News>,
    /// Numbers and round trips of the answers that the hand took, and the size of the force after each step.
    answered: Vec<(u64, u64)>,
    shown_n: Vec<f32>,
    /// All datagrams of the hand.
    recorded: Vec<Vec<u8>>,
}

impl World {
    fn new(delay_ns: u64) -> Self {
        Self::with(agent(), address(7), 5_000 * MS, delay_ns)
    }

    fn with(agent: Agent, from: SocketAddr, now_ns: u64, delay_ns: u64) -> Self {
        let way = || Way { delay_ns, ..Way::default() };
        Self {
            now_ns,
            agent,
            hand: Controller::new(key("5a"), fresh(), 20, 20, now_ns + CLOCK_NS),
            from,
            there: way(),
            back: way(),
            sends_poses: true,
            tissue: Vec::new(),
            answers: VecDeque::new(),
            news: Vec::new(),
            answered: Vec::new(),
            shown_n: Vec::new(),
            recorded: Vec::new(),
        }
    }

    fn run(&mut self, ms: u64) {
        for _ in 0..ms * MS / STEP_NS {
            self.step();
        }
    }

    /// A session that is open, with a press under way.
    fn pressed(delay_ns: u64) -> Self {
        let mut world = Self::new(delay_ns);
        world.run(FIRST as u64 + 300);
        assert_eq!(world.hand.state(), State::Open);
        assert!(world.shown_n.last().unwrap() > &0.3);
        world
    }

    fn step(&mut self) {
        self.now_ns += STEP_NS;
        let (now_ns, hand_ns) = (self.now_ns, self.now_ns + CLOCK_NS);
        if now_ns.is_multiple_of(MS) {
            let bytes = match self.hand.state() {
                State::Open if self.sends_poses => {
                    let next = self.hand.number + 1;
                    self.hand.poses(&[pose(next)], hand_ns).unwrap().1
                }
                _ => self.hand.hello(hand_ns),
            };
            self.recorded.push(bytes.clone());
            self.there.send(bytes, now_ns);
        }
        while let Some(bytes) = self.there.take(now_ns) {
            let reply = self.agent.take(&bytes, self.from, now_ns);
            reply.into_iter().for_each(|reply| self.back.send(reply, now_ns));
        }
        for poses in self.agent.poses() {
            self.tissue.push((now_ns, poses));
            self.answers.push_back((now_ns + TISSUE_NS, answer(&poses)));
        }
        while self.answers.front().is_some_and(|(due_ns, _)| *due_ns <= now_ns) {
            let (_, forces) = self.answers.pop_front().unwrap();
            if let Some((to, bytes)) = self.agent.answer(&forces, now_ns) {
                assert_eq!(to, self.from);
                belongs_to_its_pose(&bytes);
                self.back.send(bytes, now_ns);
            }
        }
        self.agent.look(now_ns);
        self.news.extend(self.agent.news());
        while let Some(bytes) = self.back.take(now_ns) {
            if let Came::Answer { number, round_trip_ns } = self.hand.take(&bytes, hand_ns) {
                self.answered.push((number, round_trip_ns));
            }
        }
        self.shown_n.push(self.hand.shown(hand_ns).tools[0].force_n[2]);
    }

    fn ticks(&self) -> Vec<u64> {
        self.tissue.iter().map(|(_, poses)| poses.tick).collect()
    }
}

fn answer(poses: &ToolPoses) -> ToolForces {
    let (tick, send_ns) = (poses.tick, poses.send_ns);
    let mut forces =
        ToolForces { tick, session_id: 7, force_tick: tick, send_ns, ..Default::default() };
    forces.tools = 1;
    let pose = poses.each[0];
    forces.each[0].force_n[2] = -STIFFNESS_N_PER_M * pose.position_m[2] * f32::from(pose.engaged);
    forces
}

/// The force in a datagram of the first session is that of the pose that it names.
fn belongs_to_its_pose(bytes: &[u8]) {
    let Ok((_, Message::Forces(forces))) = open(&key("5a"), bytes) else { panic!("no forces") };
    let wanted_n = STIFFNESS_N_PER_M * depth_m(forces.tick) * f32::from(u8::from(forces.tick > 1));
    assert_eq!((forces.each[0].force_n[2], forces.force_tick), (wanted_n, forces.tick));
}

// REQ-COS-14
#[test]
fn after_a_second_of_echoes_each_pose_is_answered_by_its_own_force() {
    let mut world = World::new(MS);
    world.run(FIRST as u64 - 2);
    assert_eq!((world.hand.state(), world.tissue.len()), (State::Measuring, 0));
    world.run(500);
    assert!(world.news.contains(&News::Opened(2 * MS)), "{:?}", world.news);
    let numbers: Vec<u64> = world.answered.iter().map(|(number, _)| *number).collect();
    let in_order: Vec<u64> = (1..=numbers.len() as u64).collect();
    assert_eq!(numbers, in_order);
    assert!(numbers.len() > 480, "{}", numbers.len());
    // The round trip is the way there and back, and the tissue.
    assert!(world.answered.iter().all(|(_, trip_ns)| *trip_ns == 2 * MS + TISSUE_NS));
    // The server sees the way there by its own clock.
    assert!(world.tissue.iter().all(|(at_ns, poses)| at_ns - poses.send_ns == MS));
    let largest_n = world.shown_n.iter().copied().fold(0.0, f32::max);
    assert!((largest_n - 1.0).abs() < 1e-3, "{largest_n}");
}

#[test]
fn a_lost_datagram_loses_no_tick_and_a_longer_gap_is_seen() {
    for (lost_of_ten, has_gaps) in [(3, false), (5, true)] {
        let mut world = World::new(MS / 2);
        world.run(FIRST as u64 + 10);
        world.there.lost_of_ten = lost_of_ten;
        world.run(1000);
        let counts = world.agent.counts();
        assert!(world.ticks().is_sorted_by(|a, b| a < b), "no pose after a newer one");
        let gaps = world.ticks().windows(2).filter(|pair| pair[1] != pair[0] + 1).count();
        assert_eq!((gaps > 90, counts.lost > 150), (has_gaps, has_gaps), "{counts:?}");
        assert!(counts.recovered > 250 && (has_gaps || gaps + counts.lost as usize == 0));
        // A recovered pose is as old as it is.
        let oldest = world.tissue.iter().map(|(at_ns, poses)| at_ns - poses.send_ns).max();
        assert_eq!(oldest, Some(3 * MS + MS / 2));
        assert_eq!(world.hand.silences(), 0);
    }
}

// REQ-COS-15
#[test]
fn a_slow_link_is_refused_before_the_first_pose() {
    // Six ticks with the tissue: it is known after the first answers.
    for (delay_ns, is_open) in [(2_700_000, true), (3_100_000, false)] {
        let mut world = World::new(delay_ns);
        world.run(FIRST as u64 + 200);
        assert_eq!(world.hand.state() == State::Open, is_open);
        assert_eq!(world.tissue.is_empty(), !is_open);
    }
    let mut world = World::new(2_900_000);
    world.run(FIRST as u64 + 200);
    assert!(matches!(world.hand.state(), State::Refused(p999_ns) if p999_ns > LIMIT_NS));
    assert!(world.tissue.len() < 30, "with the tissue above six ticks: {}", world.tissue.len());
}

// REQ-COS-15
#[test]
fn a_link_that_gets_slow_ends_the_session_and_the_force_falls_to_zero() {
    let mut world = World::pressed(MS);
    let before = world.shown_n.len();
    (world.there.delay_ns, world.back.delay_ns) = (4 * MS, 4 * MS);
    world.run(100);
    assert!(matches!(world.hand.state(), State::Refused(_)), "{:?}", world.hand.state());
    assert!(world.news.iter().any(|news| matches!(news, News::Refused(_))));
    let handed_on = world.tissue.len();
    world.run(2000);
    assert_eq!(world.tissue.len(), handed_on, "the session does not come back");
    let shown_n = &world.shown_n[before - 1..];
    let step_n = shown_n.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
    assert!(step_n < 0.06, "along a ramp: {step_n}");
    assert!(shown_n[800..].iter().all(|force_n| *force_n == 0.0), "0 within 80 ms");
    // A new session may begin at once, and is measured anew.
    let mut next = World::with(world.agent, address(8), world.now_ns, MS);
    next.run(50);
    assert_eq!(next.hand.state(), State::Measuring);
}

// REQ-COS-15
#[test]
fn a_cut_is_a_silence_and_no_old_force_comes_after_it() {
    let mut world = World::pressed(MS);
    (world.there.is_cut, world.back.is_cut) = (true, true);
    world.run(300);
    let handed_on = world.tissue.len();
    let from = world.shown_n.len() - 2500;
    assert!(world.shown_n[from..].iter().all(|force_n| *force_n == 0.0), "0 within 50 ms");
    assert_eq!((world.hand.silences(), world.hand.state()), (1, State::Open));
    (world.there.is_cut, world.back.is_cut) = (false, false);
    world.run(150);
    // The gap is a gap for the server, too: it goes on with the newest four.
    assert!(world.ticks()[handed_on] > world.ticks()[handed_on - 1] + 250);
    assert!(world.agent.counts().lost > 250);
    assert!(world.shown_n.last().unwrap() > &0.0);
    let rise_n = world.shown_n.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f32::max);
    assert!(rise_n < 0.06, "along a ramp: {rise_n}");
}

// REQ-COS-15
#[test]
fn what_a_link_held_back_is_neither_handed_on_nor_shown() {
    // Poses: all of 100 ms at once.
    let mut world = World::pressed(MS);
    world.there.is_held = true;
    world.run(100);
    let handed_on = world.tissue.len();
    world.there.is_held = false;
    world.run(50);
    assert_eq!(world.tissue.len(), handed_on);
    assert!(matches!(world.hand.state(), State::Refused(_)));
    // One that is 40 ms late, among good ones.
    let mut world = World::pressed(MS);
    world.there.delay_ns = 40 * MS;
    world.run(1);
    world.there.is_cut = true;
    world.run(5);
    let handed_on = world.tissue.len();
    world.run(37);
    assert_eq!((world.agent.counts().late, world.tissue.len()), (1, handed_on));
    assert_eq!(world.hand.state(), State::Open);
    // Forces: none older than 20 ms is shown.
    let mut world = World::pressed(MS);
    world.back.is_held = true;
    world.run(100);
    let (answered, shown) = (world.answered.len(), world.shown_n.len());
    assert_eq!(world.shown_n[shown - 1], 0.0);
    world.back.is_held = false;
    world.step();
    assert!(world.hand.dropped().late > 70, "{:?}", world.hand.dropped());
    assert!(world.answered[answered..].iter().all(|(_, trip_ns)| *trip_ns <= LATE_NS));
    assert!(world.shown_n[shown] < 0.06);
}

// REQ-COS-14
#[test]
fn one_hand_at_a_time() {
    let mut first = World::pressed(MS / 2);
    let (mut second, other) = (Controller::new(key("5a"), fresh(), 20, 20, 0), address(8));
    let mut greet = |agent: &mut Agent, now_ns: u64| {
        let hello = second.hello(now_ns);
        let reply = agent.take(&hello, other, now_ns);
        reply.map(|reply| second.take(&reply, now_ns));
        second.state()
    };
    for _ in 0..10 {
        assert_eq!(greet(&mut first.agent, first.now_ns), State::Occupied);
    }
    first.run(50);
    assert_eq!(first.hand.state(), State::Open);
    // The first is silent for a second: the second may begin.
    let now_ns = first.now_ns + FREE_NS;
    first.agent.look(now_ns);
    assert!(first.agent.news().contains(&News::Silent));
    let states: Vec<State> = (1..4).map(|ms| greet(&mut first.agent, now_ns + ms * MS)).collect();
    assert_eq!(states.last(), Some(&State::Measuring), "{states:?}");
    // Nothing of the first counts any more, its answers under way neither.
    assert!(first.agent.take(&first.recorded[1200], first.from, now_ns + 5 * MS).is_none());
    let late = answer(&first.tissue.last().unwrap().1);
    assert!(first.agent.answer(&late, now_ns + 5 * MS).is_none());
}

// REQ-COS-14
#[test]
fn a_replay_moves_nothing() {
    let mut world = World::pressed(MS);
    // Without those under way, which have not come once.
    let recorded = world.recorded[..world.recorded.len() - 2].to_vec();
    let before = world.agent.counts();
    let replay = |agent: &mut Agent, now_ns: u64| {
        let replies = recorded.iter().filter_map(|bytes| agent.take(bytes, address(7), now_ns));
        // A first word alone is answered, by a number that fits no other.
        for reply in replies {
            assert_eq!(open(&key("5a"), &reply).unwrap().1, Message::Challenge);
        }
        assert!(agent.poses().is_empty());
    };
    replay(&mut world.agent, world.now_ns);
    assert!(world.agent.counts().old - before.old > 1200);
    world.run(20);
    assert_eq!(world.hand.state(), State::Open, "the session goes on");
    // After it, and at another agent.
    let later_ns = world.now_ns + 2 * FREE_NS;
    world.agent.look(later_ns);
    let _ = world.agent.news();
    replay(&mut world.agent, later_ns);
    replay(&mut agent(), later_ns);
    assert!(world.agent.news().is_empty());
    // From another place, while the session is open.
    let mut world = World::pressed(MS);
    let bytes = world.hand.poses(&[pose(1)], world.now_ns + CLOCK_NS).unwrap().1;
    assert!(world.agent.take(&bytes, address(9), world.now_ns).is_none());
    assert!(world.agent.poses().is_empty());
}

// REQ-COS-14
#[test]
fn strangers_get_no_answer() {
    let mut world = World::pressed(MS);
    let mut stranger = Controller::new(key("5b"), fresh(), 20, 20, 0);
    let before = world.agent.counts();
    assert!(world.agent.take(&stranger.hello(1), address(8), world.now_ns).is_none());
    assert_eq!(world.agent.counts().forged, before.forged + 1);
    // Its own datagrams, sent back to it.
    for (_, bytes) in world.back.under_way.clone() {
        assert!(world.agent.take(&bytes, world.from, world.now_ns).is_none());
        assert_eq!(stranger.take(&bytes, 1), Came::Word);
    }
    assert!(world.agent.counts().foreign > before.foreign && stranger.dropped().forged > 0);
    // Those of another hand, and those that came already.
    let mut other = Controller::new(key("5a"), fresh(), 20, 20, 0);
    let bytes = world.back.under_way.front().unwrap().1.clone();
    other.take(&bytes, 1);
    assert_eq!(other.dropped().foreign, 1);
    let mut third = Controller::new(key("5a"), fresh(), 20, 20, 0);
    let reply = world.agent.take(&third.hello(1), address(9), world.now_ns).unwrap();
    other.take(&reply, 1);
    assert_eq!((other.dropped().foreign, other.state()), (2, State::Greeting));
    third.take(&reply, 1);
    assert_eq!(third.state(), State::Occupied);
    assert!(other.shown(2).notes.contains(Notes::NOTHING_YET));
    let now_ns = world.now_ns + CLOCK_NS;
    world.hand.take(&bytes, now_ns);
    let old = world.hand.dropped().old;
    world.hand.take(&bytes, now_ns);
    assert_eq!(world.hand.dropped().old, old + 1);
}

#[test]
fn a_tool_is_taken_after_it_was_released_once() {
    let mut world = World::new(MS);
    world.sends_poses = false;
    world.run(FIRST as u64 + 10);
    let send = |world: &mut World, engaged: u32| {
        let pose = ToolPose::at([0.0; 3].into(), engaged);
        let now_ns = world.now_ns;
        let bytes = world.hand.poses(&[pose, pose], now_ns + CLOCK_NS).unwrap().1;
        assert!(world.agent.take(&bytes, world.from, now_ns).is_none());
        let poses = *world.agent.poses().last().unwrap();
        let (_, bytes) = world.agent.answer(&answer(&poses), now_ns).unwrap();
        let Ok((_, Message::Forces(forces))) = open(&key("5a"), &bytes) else {
            panic!("no forces")
        };
        let must_release = Flags(forces.flags).contains(Flags::RELEASE_FIRST);
        (poses.each[0].engaged, poses.each[1].engaged, must_release)
    };
    assert_eq!(send(&mut world, 1), (0, 0, true));
    assert_eq!(send(&mut world, 0), (0, 0, false));
    assert_eq!(send(&mut world, 1), (1, 1, false));
}

#[test]
fn the_servers_falling_force_is_no_answer_and_its_end_is_news_once() {
    let mut world = World::pressed(MS);
    let last = answer(&world.tissue.last().unwrap().1);
    let _ = world.agent.news();
    let stale = ToolForces { flags: Flags::STALE.0, ..last };
    assert!(world.agent.answer(&stale, world.now_ns).is_none() && world.agent.news().is_empty());
    let fallen = ToolForces { flags: Flags::STALE.0 + Flags::SAFE_STATE.0, ..last };
    for wanted in [&[News::Fallen][..], &[]] {
        assert!(world.agent.answer(&fallen, world.now_ns).is_none());
        assert_eq!(world.agent.news(), wanted);
    }
}

#[test]
fn no_number_of_a_hand_with_the_key_is_too_large() {
    let mut world = World::pressed(MS);
    let handed_on = world.tissue.len();
    world.hand.number = u64::MAX - 5;
    world.sends_poses = false;
    let bytes = world.hand.poses(&[pose(2)], world.now_ns + CLOCK_NS).unwrap().1;
    world.agent.take(&bytes, world.from, world.now_ns);
    assert!(world.agent.poses().is_empty());
    assert_eq!(world.tissue.len(), handed_on);
    // What is no pose is not sent.
    let bad = [ToolPose { engaged: 2, ..pose(1) }, ToolPose { orientation: [0.0; 4], ..pose(1) }];
    for bad in bad {
        let refused = world.hand.poses(&[pose(1), bad], 1).unwrap_err();
        assert!(refused.kind() == Kind::Pose && refused.to_string().starts_with("tool 1: "));
    }
    assert!(world.hand.poses(&[], 1).is_err() && world.hand.poses(&[pose(1); 9], 1).is_err());
}
