//! A server that stands by goes on in the place of one that is killed: the same session, and no jump in a hand.
//!
//! Plain `cargo test` kills 2 servers, 50 with `CHAINCELL_SLOW=1`, and then judges the hand's energy, which
//! needs a machine that is not busy.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;
use std::time::Duration;

use chaincell_client::clock::{PERIOD_NS, now_ns, sleep_until_ns};
use chaincell_client::services::Domain;
use chaincell_client::{Client, Options, Outcome, ToolPose, recording};
use chaincell_host::files::recording::start_mark;
use chaincell_kernel::Flags;
use chaincell_kernel::trace::Reader;
use chaincell_loops::handle::{Hand, Handle, Moving};
use chaincell_tests::files::text;
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};
use nalgebra::{Rotation3, Vector3};

/// Largest force of a session \[N\], and the time of a ramp \[ms\].
const MAX_N: f32 = 4.0;
const RAMP_MS: f32 = 20.0;
/// Where the hand wants to be in the press \[m\].
const DEPTH_M: f64 = 0.02;
/// Largest step of a shown force \[N\]: that of a ramp from the session's largest force. A ramp takes a twentieth of
/// the force on it in a millisecond. The hand presses with about a third of the largest force, so such a step is some
/// 0.07 N; the rest is more than the tissue's own change between two ticks, which needs no allowance.
const RAMP_STEP_N: f32 = MAX_N / RAMP_MS;

/// A hand with a device, in front of a scene, once a millisecond.
struct Holder {
    client: Client,
    moving: Moving,
    hand: Hand,
    next_ns: u64,
    largest_n: f32,
    /// The last force, and whether it was that of a late tick.
    last: (Vector3<f32>, bool),
    /// Largest step of the force between two ticks \[N\]. Behind a late tick, of which a busy machine makes some, the
    /// force goes back to the tissue's at once.
    step_n: f32,
}

impl Holder {
    fn new(place: &Place) -> Self {
        let options = Options { scene: Some(place.scene.clone()), ..Options::default() };
        let handle = Handle {
            mass_kg: 0.1,
            damping_n_s_per_m: 1.0,
            count_m: 2.0e-5,
            axes: Rotation3::identity(),
            delay_ticks: 1,
        };
        let at = Vector3::new(0.0, 0.001, 0.0);
        let hand = Hand { stiffness_n_per_m: 300.0, damping_n_s_per_m: 5.0, holds: true, at };
        Self {
            client: Client::open(&options).unwrap(),
            moving: Moving::new(handle, at),
            hand,
            next_ns: now_ns(),
            largest_n: 0.0,
            last: (Vector3::zeros(), false),
            step_n: 0.0,
        }
    }

    /// One tick with the hand at a depth. Returns true if it was answered.
    fn tick(&mut self, depth_m: f64, engaged: bool) -> bool {
        self.hand.at.z = -depth_m;
        self.next_ns = now_ns().max(self.next_ns + PERIOD_NS);
        sleep_until_ns(self.next_ns);
        let sample: ToolPose = self.moving.sample(engaged);
        let (outcome, answer) = self.client.step(&[sample], PERIOD_NS * 9 / 10).unwrap();
        let force_n = Vector3::from(answer.tools[0].force_n);
        self.largest_n = self.largest_n.max(force_n.norm());
        let is_late = Flags(answer.flags).contains(Flags::LATE);
        let (before_n, was_late) = std::mem::replace(&mut self.last, (force_n, is_late));
        if !is_late && !was_late {
            self.step_n = self.step_n.max((force_n - before_n).norm());
        }
        self.moving.tick(force_n, &self.hand);
        outcome == Outcome::Answered
    }

    fn ticks(&mut self, count: u32, depth_m: f64, engaged: bool) -> u32 {
        (0..count).map(|_| u32::from(self.tick(depth_m, engaged))).sum()
    }
}

fn served(place: &Place, out: &Path, options: &[&str]) -> Running {
    let max_n = MAX_N.to_string();
    let contact = ["--contact", "40", "--device", "omega", "--max-force-n", &max_n];
    let always = ["--json", "--late-share", "off", "--out", text(out)];
    let args = ["serve", text(&place.model), "--scene", &place.scene];
    Running::chaincell([&args[..], &contact, &always, options].concat())
}

/// Hash of the snapshot that a trace begins from, and the tick before it.
fn start(session: &Path) -> (String, u64) {
    let bytes = std::fs::read(session.join("session.trace")).unwrap();
    let mark = start_mark(&Reader::open(&bytes).unwrap()).unwrap();
    (format!("{:016x}", mark.state_hash.unwrap()), mark.tick)
}

// REQ-COS-13
#[test]
fn a_killed_servers_session_goes_on_without_a_jump() {
    let _turn = turn();
    let is_slow = std::env::var_os("CHAINCELL_SLOW").is_some();
    let (mut worst_j, mut worst_step_n, mut longest) = (0.0_f64, 0.0_f32, 0);
    for round in 0..if is_slow { 50 } else { 2 } {
        let place = Place::stiff("stand-by");
        let [first, second] = ["first", "second"].map(|name| place.file(name));
        let mut server = served(&place, &first, &[]);
        server.wait_for_line("ready");
        // By its folder, and by its scene.
        let session = if round % 2 == 0 { text(&first) } else { &place.scene };
        let mut other = served(&place, &second, &["--stand-by", session]);
        other.wait_for_line("standing by");
        // A press; the server is killed in it.
        let mut holder = Holder::new(&place);
        holder.ticks(20, 0.0, false);
        holder.ticks(150 + 7 * round, DEPTH_M, true);
        assert!(holder.largest_n > 0.2, "{} N", holder.largest_n);
        server.kill();
        // The hand stays, until the other one answers.
        let mut silent = 0;
        while !holder.tick(DEPTH_M, true) {
            silent += 1;
            assert!(silent < SHORT.as_millis() as u32, "nobody took over");
        }
        longest = longest.max(silent);
        holder.ticks(100, DEPTH_M, true);
        let recorded = recording::of(Some(&place.scene), &Domain::default()).unwrap();
        assert_eq!(recorded, Some(second.join("session.trace")));
        // The force comes back after a release alone.
        assert_eq!(holder.client.shown().unwrap().tools[0].force_n, [0.0; 3]);
        holder.ticks(40, 0.0, false);
        holder.largest_n = 0.0;
        holder.ticks(150, DEPTH_M, true);
        assert!(holder.largest_n > 0.2, "{} N", holder.largest_n);
        let step_n = holder.step_n;
        assert!(step_n <= RAMP_STEP_N, "{step_n} N");
        worst_step_n = worst_step_n.max(step_n);
        worst_j = worst_j.max(holder.moving.got_j());
        // Nothing is lost, and both traces play to the same bits: the second goes on where the first ends.
        let ended = other.interrupt().with(130).json();
        let killed = run(["replay", text(&first), "--json"]).with(0).json();
        let (hash, tick) = start(&second);
        assert_eq!(killed["state_hash"], hash, "round {round}, tick {tick}");
        let replayed = run(["replay", text(&second), "--json"]).with(0).json();
        assert_eq!(replayed["state_hash"], ended["state_hash"]);
        assert_eq!(replayed["ticks"], ended["ticks_executed"]);
    }
    let energy_mj = 1e3 * worst_j;
    println!("{energy_mj:.3} mJ, largest step {worst_step_n:.3} N, silent for {longest} ticks");
    assert!(!is_slow || energy_mj <= 1.0, "{energy_mj} mJ");
}

#[test]
fn a_server_that_ends_by_itself_is_not_replaced() {
    let _turn = turn();
    let place = Place::stiff("stand-by-end");
    let [first, second] = ["first", "second"].map(|name| place.file(name));
    let mut server = served(&place, &first, &[]);
    server.wait_for_line("ready");
    // With other options it is another session.
    let ended = served(&place, &second, &["--stand-by", text(&first), "--sweeps", "3"]).end(SHORT);
    let ended = ended.with(2);
    assert!(ended.err.contains("other options"), "{}", ended.err);
    let mut other = served(&place, &second, &["--stand-by", text(&first)]);
    other.wait_for_line("standing by");
    std::thread::sleep(Duration::from_millis(50));
    server.interrupt().with(130);
    let ended = other.end(SHORT).with(0);
    assert!(ended.out.contains("nothing to take over"), "{}", ended.out);
    assert_eq!(std::fs::read_dir(&second).unwrap().count(), 0);
    // One that comes afterwards has no server to stand by for.
    let late = served(&place, &second, &["--stand-by", text(&first)]).end(SHORT).with(2);
    assert!(late.err.contains("has ended or was killed already"), "{}", late.err);
}

#[test]
fn one_that_cannot_write_its_record_leaves_nothing_of_it() {
    let _turn = turn();
    for name in ["session.trace.start.snapshot", "session.trace"] {
        let place = Place::stiff("stand-by-unwritten");
        let [first, second] = ["first", "second"].map(|name| place.file(name));
        let mut server = served(&place, &first, &[]);
        server.wait_for_line("ready");
        let mut other = served(&place, &second, &["--stand-by", text(&first)]);
        other.wait_for_line("standing by");
        // A folder is in the place of the file.
        let blocked = second.join(name);
        std::fs::create_dir(&blocked).unwrap();
        server.kill();
        let ended = other.end(SHORT).with(2);
        assert!(ended.err.contains(&format!("cannot write {}", text(&blocked))), "{}", ended.err);
        let left = std::fs::read_dir(&second).unwrap().map(|entry| entry.unwrap().path());
        assert_eq!(left.collect::<Vec<_>>(), [blocked]);
    }
}

#[test]
fn a_session_whose_record_was_full_is_not_taken_over() {
    let _turn = turn();
    let place = Place::stiff("stand-by-full");
    let [first, second] = ["first", "second"].map(|name| place.file(name));
    let mut server = served(&place, &first, &["--record-ticks", "30"]);
    server.wait_for_line("ready");
    // Only on the scene of its server.
    let elsewhere =
        ["serve", text(&place.model), "--scene", "stand-by-elsewhere", "--contact", "40"];
    let options = ["--device", "omega", "--max-force-n", "4", "--stand-by", text(&first)];
    let ended = run([&elsewhere[..], &options].concat()).with(2);
    assert!(ended.err.contains("--scene of that server"), "{}", ended.err);
    let mut other = served(&place, &second, &["--stand-by", text(&first)]);
    other.wait_for_line("standing by");
    let mut holder = Holder::new(&place);
    assert!(holder.ticks(60, 0.0, false) > 40);
    server.notes_until(FULL);
    server.kill();
    let ended = other.end(SHORT).with(1);
    assert!(ended.err.contains("its record was full after tick"), "{}", ended.err);
}

/// Said by a server whose record is full.
const FULL: &str = "note: the record is full; the session goes on without, and nobody can follow it or take it over";
