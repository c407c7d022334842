//! Hand and agent over loopback, with a real `chaincell serve`.
//!
//! No time is asserted. The agent's program refuses a machine that is late, as it should; each such run says so. Where
//! round trips are not the question, the agent is a thread that takes longer ones.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a failing helper fails its test")]

mod relay;

use std::net::UdpSocket;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use chaincell_client::clock::{MILLISECOND_NS, SECOND_NS, now_ns};
use chaincell_client::{Kind, ToolPose};
use chaincell_kernel::trace::{Reader, Record};
use chaincell_lan::agent::{Agent, News};
use chaincell_lan::controller::State;
use chaincell_lan::datagram::{Head, Message, seal};
use chaincell_lan::hand::{Hand, Options};
use chaincell_lan::key::{Key, random};
use chaincell_lan::play::play;
use chaincell_lan::report::AgentReport;
use chaincell_lan::run::{Scene, run};
use chaincell_lan::socket::Socket;
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, turn};
use relay::Relay;

fn lan(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_chaincell-lan"));
    command.args(arguments);
    command
}

/// Makes a key by the command.
fn key(place: &Place, name: &str) -> PathBuf {
    let file = place.file(name);
    let made = Running::start(&mut lan(&["key", file.to_str().unwrap()])).end(SHORT).with(0);
    assert!(made.out.contains("copy it to the other machine"));
    file
}

/// A running agent of a served scene, and its address.
struct Program {
    running: Running,
    address: String,
}

impl Program {
    fn start(place: &Place, key: &Path) -> Self {
        // A port that was free a moment ago.
        let free = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let address = free.to_string();
        let key = key.to_str().unwrap();
        let options =
            ["agent", "--listen", &address, "--key", key, "--scene", &place.scene, "--json"];
        let mut running = Running::start(&mut lan(&options));
        running.notes_until(&format!("chaincell-lan: listens at {address}"));
        Self { running, address }
    }

    fn end(self) -> serde_json::Value {
        self.running.interrupt().with(0).json()
    }
}

/// Longest round trip for an agent that takes any but a machine that stands still [ns].
const LENIENT_NS: u64 = SECOND_NS;

/// An agent in a thread, and its news.
struct Lenient {
    address: String,
    stop: Arc<AtomicBool>,
    news: Receiver<News>,
    thread: JoinHandle<AgentReport>,
}

impl Lenient {
    fn start(place: &Place, key: &Path) -> Self {
        let socket = Socket::listen("127.0.0.1:0").unwrap();
        let address = socket.address().unwrap().to_string();
        let (key, scene) = (Key::read(key).unwrap(), place.scene.clone());
        let stop = Arc::new(AtomicBool::new(false));
        let (asked, (say, news)) = (Arc::clone(&stop), channel());
        let thread = std::thread::spawn(move || {
            let mut scene = Scene::open(Some(&scene), 10 * SECOND_NS, || false).unwrap();
            let mut agent = Agent::new(key, LENIENT_NS, || random().unwrap());
            let stop = || asked.load(Relaxed);
            run(&mut agent, &socket, &mut scene, stop, |news| _ = say.send(news)).unwrap()
        });
        Self { address, stop, news, thread }
    }

    fn wait_for(&self, is: impl Fn(&News) -> bool) {
        while !is(&self.news.recv_timeout(SHORT).unwrap()) {}
    }

    fn end(self) -> AgentReport {
        self.stop.store(true, Relaxed);
        self.thread.join().unwrap()
    }
}

/// A session with the agent; none, with a line that says so, where the machine is too late for one.
fn begin(test: &str, address: &str, key: &Path) -> Option<Hand> {
    match Hand::open(Options::new(address.to_owned(), Key::read(key).unwrap()), || false) {
        Ok(hand) => Some(hand),
        Err(why)
            if why.kind() == Kind::Refused || why.to_string().contains("too few datagrams") =>
        {
            println!("SKIPPED {test}: the machine is late, {why}");
            None
        }
        Err(why) => panic!("{why}"),
    }
}

/// 5 mm and back, twice a second; the tool holds on from the second pose on.
fn press(poses: u32) -> Vec<ToolPose> {
    let depth_m = |at: u32| 0.0025 * (1.0 - (at as f32 * std::f32::consts::TAU / 500.0).cos());
    (0..poses).map(|at| ToolPose::at([0.0, 0.0, -depth_m(at)].into(), u32::from(at > 0))).collect()
}

fn records(trace: &Path) -> Vec<Record> {
    let (bytes, mut records) = (std::fs::read(trace).unwrap(), Vec::new());
    let end = Reader::open(&bytes).unwrap().records(|_, record: &Record| {
        records.push(*record);
        Ok::<(), ()>(())
    });
    end.unwrap();
    records
}

fn size_n(force_n: [f32; 3]) -> f32 {
    force_n.iter().map(|x| x * x).sum::<f32>().sqrt()
}

// REQ-COS-14
#[test]
fn every_answered_force_belongs_to_its_pose_and_the_server_sees_the_way() {
    let _turn = turn();
    let test = "every_answered_force_belongs_to_its_pose";
    let place = Place::stiff("lan-press");
    let (key, trace) = (key(&place, "lan.key"), place.file("lan.trace"));
    let record = ["--record", trace.to_str().unwrap(), "--hash-every", "1", "--budget-us", "off"];
    let auto = ["--device", "omega", "--delay-ticks", "auto", "--json"];
    let serve = place.serve(&[&record[..], &auto].concat());
    let agent = Lenient::start(&place, &key);
    // 2 ms each way, and three of ten poses come with a later datagram.
    let relay = Relay::start(&agent.address, 2000);
    let Some(mut hand) = begin(test, &relay.address, &key) else { return };
    relay.weather.lost_of_ten.store(3, Relaxed);
    let (poses, mut seen) = (press(2000), Vec::new());
    let report = play(
        &mut hand,
        &poses,
        || false,
        |number, answer| {
            assert_eq!(answer.tick, number);
            seen.push((number, answer.state_hash));
        },
    );
    let report = report.unwrap();
    let counts = agent.end().counts;
    serve.interrupt().with(130);
    // Each tick of the tissue has the pose that the hand sent by this number, each answer the state after it.
    let records = records(&trace);
    assert_eq!(counts.poses, records.len() as u64);
    let sent = |number: u64| {
        number.checked_sub(2).map_or(ToolPose { engaged: 0, ..poses[0] }, |at| poses[at as usize])
    };
    for record in &records {
        assert_eq!(record.sample.position_m, sent(record.tick).position_m, "{}", record.tick);
        assert_eq!(record.sample.engaged, sent(record.tick).engaged, "{}", record.tick);
        // 4 ms at least, and the tissue.
        assert!(record.delay_ticks.is_some_and(|ticks| ticks >= 5), "{record:?}");
    }
    assert!(!seen.is_empty() && seen.len() as u64 == report.answered);
    for (number, state_hash) in seen {
        let at = records.binary_search_by_key(&number, |record| record.tick).unwrap();
        assert_eq!(records[at].state_hash, Some(state_hash), "{number}");
    }
    assert_eq!((counts.forged, counts.hands), (0, 1));
    if report.is_failed || report.silences > 0 || counts.lost > 0 {
        println!("SKIPPED the rest of {test}: the machine is late, {report}, {counts:?}");
        return;
    }
    assert!(counts.recovered > 500, "{counts:?}");
    assert!(report.largest_force_n > 0.05, "{report}");
    println!("{report}");
}

// REQ-COS-15
#[test]
fn a_killed_hand_and_a_cut_lead_to_force_zero() {
    let _turn = turn();
    let test = "a_killed_hand_and_a_cut_lead_to_force_zero";
    let place = Place::stiff("lan-killed");
    let key = key(&place, "lan.key");
    let serve = place.serve(&["--budget-us", "off", "--json"]);
    let agent = Lenient::start(&place, &key);
    let relay = Relay::start(&agent.address, 0);
    // A cut: the hand's own force falls, and rises when the link is whole again.
    let Some(mut hand) = begin(test, &relay.address, &key) else { return };
    let held = |hand: &mut Hand, periods: u32| {
        (0..periods).for_each(|at| {
            let number = hand.send(&press(200)[at.min(199) as usize..][..1]).unwrap();
            let _ = hand.receive(number, MILLISECOND_NS);
        });
        (size_n(hand.shown().tools[0].force_n), hand.state())
    };
    let (mut pressed_n, mut state) = held(&mut hand, 500);
    for _ in 0..20 {
        if pressed_n > 0.0 || state != State::Open {
            break;
        }
        (pressed_n, state) = held(&mut hand, 500);
    }
    relay.weather.is_cut.store(true, Relaxed);
    let (fallen_n, _) = held(&mut hand, 100);
    assert_eq!(fallen_n, 0.0);
    relay.weather.is_cut.store(false, Relaxed);
    let (mut again_n, mut after) = held(&mut hand, 500);
    // A late machine may take longer to press again.
    for _ in 0..20 {
        if again_n > 0.0 || after != State::Open {
            break;
        }
        (again_n, after) = held(&mut hand, 500);
    }
    if (state, after) == (State::Open, State::Open) && hand.silences() == 1 {
        assert!(pressed_n > 0.0 && again_n > 0.0, "{pressed_n} {again_n}");
    } else {
        println!(
            "SKIPPED the size of the force in {test}: the machine is late, {state:?} {after:?}"
        );
    }
    drop(hand);
    agent.wait_for(|news| *news == News::Silent);
    // A program that is killed in the middle of a press.
    let path = place.file("path.csv");
    let rows = press(60_000)
        .into_iter()
        .enumerate()
        .map(|(tick, pose)| format!("{tick},0,0,{},{}\n", pose.position_m[2], pose.engaged));
    let text = "tick,x_m,y_m,z_m,engaged\n".to_owned() + &rows.collect::<String>();
    std::fs::write(&path, text).unwrap();
    let (path, key) = (path.to_str().unwrap(), key.to_str().unwrap());
    let mut program = Running::start(&mut lan(&["hand", &agent.address, path, "--key", key]));
    agent.wait_for(|news| matches!(news, News::Opened(_)));
    std::thread::sleep(Duration::from_millis(500));
    program.kill();
    // The server says by its watchdog that all forces are 0; then the agent is free.
    agent.wait_for(|news| *news == News::Fallen);
    agent.wait_for(|news| *news == News::Silent);
    let counts = agent.end().counts;
    let served = serve.interrupt().with(130).json();
    assert!(served["watchdog_fired"].as_u64().unwrap() >= 2, "{served}");
    assert_eq!((counts.hands, counts.refused), (2, 0), "{counts:?}");
}

// REQ-COS-15
#[test]
fn a_delay_above_six_ticks_is_refused_before_and_in_a_session() {
    let _turn = turn();
    let test = "a_delay_above_six_ticks_is_refused";
    let place = Place::stiff("lan-slow");
    let key = key(&place, "lan.key");
    let serve = place.serve(&["--budget-us", "off", "--json"]);
    let mut agent = Program::start(&place, &key);
    let relay = Relay::start(&agent.address, 4000);
    let options = || Options::new(relay.address.clone(), Key::read(&key).unwrap());
    let refused = Hand::open(options(), || false).unwrap_err();
    assert_eq!(refused.kind(), Kind::Refused);
    assert!(refused.to_string().contains("six ticks"), "{refused}");
    // A way that gets slow: the session ends, and the force is 0.
    relay.weather.delay_us.store(0, Relaxed);
    if let Some(mut hand) = begin(test, &relay.address, &key) {
        let mut begin_ns = now_ns();
        let slow = |hand: &Hand| hand.state() != State::Open;
        for (at, pose) in press(20_000).iter().enumerate() {
            if at == 300 {
                relay.weather.delay_us.store(4000, Relaxed);
            }
            let number = hand.send(&[*pose]).unwrap();
            begin_ns = now_ns().max(begin_ns + MILLISECOND_NS);
            let _ = hand.receive(number, begin_ns.saturating_sub(now_ns()));
            if slow(&hand) {
                break;
            }
        }
        assert!(matches!(hand.state(), State::Refused(_)), "{:?}", hand.state());
        while hand.next(now_ns() + 100 * MILLISECOND_NS).is_some() {}
        assert_eq!(size_n(hand.shown().tools[0].force_n), 0.0);
        agent.running.notes_until("chaincell-lan: no poses: the tissue's force has fallen to 0");
        let counts = agent.end();
        assert_eq!(counts["refused"], 2, "{counts}");
    } else {
        assert!(agent.end()["poses"] == 0);
    }
    serve.interrupt().with(130);
}

// REQ-COS-14
#[test]
fn who_has_no_key_gets_nothing_and_a_second_hand_is_told() {
    let _turn = turn();
    let test = "who_has_no_key_gets_nothing";
    let place = Place::stiff("lan-key");
    let (right, wrong) = (key(&place, "lan.key"), key(&place, "other.key"));
    let serve = place.serve(&["--budget-us", "off", "--json"]);
    let agent = Lenient::start(&place, &right);
    let options = |key: &Path| Options {
        wait_ns: 300 * MILLISECOND_NS,
        ..Options::new(agent.address.clone(), Key::read(key).unwrap())
    };
    let nobody = Hand::open(options(&wrong), || false).unwrap_err();
    assert_eq!(nobody.kind(), Kind::NoServer);
    assert!(nobody.to_string().contains("with the same key"), "{nobody}");
    // Noise, damage, and a datagram of the agent's kind get no answer either; the same one whole gets one.
    let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
    socket.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let head = Head { hand: [1; 16], sequence: 1, stamp_ns: 1, ..Head::default() };
    let [hello, foreign] =
        [Message::Hello, Message::Open].map(|of| seal(&Key::read(&right).unwrap(), &head, &of));
    let mut damaged = hello.clone();
    damaged[50] ^= 1;
    for bytes in [&b"noise"[..], &[], &[7; 1500], &damaged, &foreign, &hello] {
        socket.send_to(bytes, &agent.address).unwrap();
    }
    let mut buffer = [0; 2048];
    assert!(socket.recv(&mut buffer).is_ok());
    socket.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
    assert!(socket.recv(&mut buffer).is_err(), "one answer to six datagrams");
    // One at a time.
    if let Some(mut hand) = begin(test, &agent.address, &right) {
        let second = std::thread::scope(|scope| {
            let options = options(&right);
            let second = scope.spawn(move || Hand::open(options, || false).map(|_| ()));
            while !second.is_finished() {
                hand.hello();
                while hand.next(now_ns() + MILLISECOND_NS).is_some() {}
            }
            second.join().unwrap()
        });
        let second = second.unwrap_err();
        assert!(
            second.kind() == Kind::Taken && second.to_string().contains("another hand"),
            "{second}"
        );
    }
    let counts = agent.end().counts;
    assert!(counts.forged > 1 && counts.foreign >= 3 && counts.poses == 0, "{counts:?}");
    serve.interrupt().with(130);
}

#[test]
fn a_refusal_names_the_place_and_the_remedy() {
    let place = Place::new("lan-refusals");
    let key = key(&place, "lan.key");
    let path = place.file("path.csv");
    std::fs::write(&path, "tick,x_m,y_m,z_m,engaged\n0,0,0,nan,0\n").unwrap();
    let open = place.file("open.key");
    std::fs::copy(&key, &open).unwrap();
    std::fs::set_permissions(&open, std::fs::Permissions::from_mode(0o644)).unwrap();
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().to_string();
    let [key, open, path] = [&key, &open, &path].map(|file| file.to_str().unwrap());
    let agent =
        |listen, key| ["agent", "--listen", listen, "--key", key, "--wait-for-server-s", "0"];
    for (arguments, texts) in [
        (&["key", key][..], &["lan.key", "remove it first"][..]),
        (&agent("127.0.0.1:0", "no.key"), &["--key no.key", "chaincell-lan key no.key"]),
        (&agent("127.0.0.1:0", open), &["--key ", "chmod 600"]),
        (&agent(&port, key), &["--listen 127.0.0.1:", "take another port"]),
        (&agent("192.0.2.1:7200", key), &["--listen 192.0.2.1:7200", "ip address"]),
        (&agent("nowhere", key), &["--listen nowhere", "0.0.0.0:7200"]),
        (
            &[&agent("127.0.0.1:0", key)[..], &["--scene", "lan-nobody"]].concat(),
            &["chaincell serve"],
        ),
        (&["hand", "127.0.0.1:1", path, "--key", key], &["path.csv: line 2", "is no pose"]),
        (&["hand", "127.0.0.1:1", "no.csv", "--key", key], &["no.csv: "]),
        (&["hand", "127.0.0.1", path, "--key", key, "--wait-s", "-1"], &["--wait-s -1"]),
    ] {
        let said = Running::start(&mut lan(arguments)).end(SHORT).with(2).err;
        assert!(texts.iter().all(|text| said.contains(text)), "{arguments:?}: {said}");
    }
    // Nobody listens there.
    std::fs::write(path, "tick,x_m,y_m,z_m,engaged\n0,0,0,0,0\n").unwrap();
    let nobody = ["hand", "127.0.0.1:1", path, "--key", key, "--wait-s", "0.1"];
    let said = Running::start(&mut lan(&nobody)).end(SHORT).with(2).err;
    assert!(said.contains("no agent answers") && said.contains("127.0.0.1:1"), "{said}");
}
