//! Both sides as processes, and followers behind receivers.

use std::io::{BufRead, BufReader, Read};
use std::net::TcpListener;
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{JoinHandle, sleep, spawn};
use std::time::{Duration, Instant};

use chaincell_host::error::{self, Error};
use chaincell_host::files::recording;
use chaincell_host::files::recording::Step;
use chaincell_host::remote::follow::{FollowReport, Follower as Tissue, Told, join};
use chaincell_host::remote::frame::{Frame, read_head};
use chaincell_host::remote::intake::Intake;
use chaincell_host::remote::way::Program;
use chaincell_host::session::timing::clock::{SECOND_NS, now_ns};
use chaincell_kernel::Model;
use chaincell_kernel::trace::Reader;
use zenoh::{Config, Session, Wait};

/// A wait that no machine needs.
pub const LONG: Duration = Duration::from_secs(180);
const PROGRAM: &str = env!("CARGO_BIN_EXE_chaincell-link");

/// What came of a follower.
pub type Followed = Result<FollowReport, String>;

/// Waits until something is so. Returns false if it never is.
pub fn until(what: &str, mut is_so: impl FnMut() -> bool) -> bool {
    let start = Instant::now();
    while !is_so() {
        if start.elapsed() > LONG {
            println!("not within {LONG:?}: {what}");
            return false;
        }
        sleep(Duration::from_millis(5));
    }
    true
}

/// How a command ended that does not get far, and what it said; it writes nothing else.
pub fn ended(args: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(PROGRAM);
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut process = Process { child: command.spawn().unwrap() };
    assert!(until("the command ends", || process.child.try_wait().unwrap().is_some()), "{args:?}");
    let (mut out, mut err) = (Vec::new(), String::new());
    process.child.stdout.take().unwrap().read_to_end(&mut out).unwrap();
    process.child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert!(out.is_empty(), "{args:?}");
    (process.child.wait().unwrap().code(), err)
}

/// An endpoint of this machine that nobody else has: of the sender, or of a router.
pub struct Network {
    endpoint: String,
    router: Option<Session>,
}

impl Network {
    /// `None`, with a line that says so, where there is no loopback.
    pub fn new(test: &str) -> Option<Self> {
        Self::of("tcp", test)
    }

    /// The same by another protocol.
    pub fn of(protocol: &str, test: &str) -> Option<Self> {
        match TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()) {
            Ok(address) => Some(Self { endpoint: format!("{protocol}/{address}"), router: None }),
            Err(why) => {
                println!("SKIPPED {test}: no loopback: {why}");
                None
            }
        }
    }

    /// Starts a router at the endpoint, to which both sides connect from then on.
    pub fn start_router(&mut self) {
        let config = serde_json::json!({
            "mode": "router",
            "listen": { "endpoints": [self.endpoint], "timeout_ms": LONG.as_millis() as u64 },
            "scouting": { "multicast": { "enabled": false } },
        });
        let config = Config::from_json5(&config.to_string()).unwrap();
        self.router = Some(zenoh::open(config).wait().unwrap());
    }

    /// Ends the router.
    pub fn end_router(&mut self) {
        self.router.take().expect("a router").close().wait().unwrap();
    }

    /// A sender that is ready.
    pub fn send(&self, session: &Path, name: &str, options: &[&str]) -> Process {
        let mut command = Command::new(PROGRAM);
        let way = if self.router.is_some() { "--connect" } else { "--listen" };
        command.arg("send").arg(session).args(["--name", name, way, &self.endpoint]);
        let mut child =
            command.args(options).stdin(Stdio::null()).stdout(Stdio::piped()).spawn().unwrap();
        let out = BufReader::new(child.stdout.take().unwrap());
        let sender = Process { child };
        let said: Vec<String> = out.lines().map_while(Result::ok).take(1).collect();
        assert_eq!(said, ["ready"]);
        sender
    }

    #[cfg(feature = "tls")]
    pub fn endpoint(&self) -> &str {
        &self.endpoint
    }

    /// A receiver without a follower.
    pub fn receive(&self, name: &str, options: &[&str]) -> Stream {
        let mut child = Command::new(PROGRAM)
            .args(["receive", name, "--connect", &self.endpoint])
            .args(options)
            .env("CHAINCELL_LOG", "chaincell_link=debug")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let out = child.stdout.take().unwrap();
        let err = BufReader::new(child.stderr.take().unwrap());
        let said = Arc::new(Mutex::new(Vec::new()));
        let lines = Arc::clone(&said);
        spawn(move || {
            err.lines().map_while(Result::ok).for_each(|line| lines.lock().unwrap().push(line));
        });
        Stream { frames: spawn(move || frames(out)), said, process: Process { child } }
    }

    fn words(&self, name: &str, options: &[&str]) -> Vec<String> {
        let words = [PROGRAM, "receive", name, "--connect", &self.endpoint];
        words.iter().chain(options).copied().map(str::to_owned).collect()
    }
}

/// A process that is killed where the test lets it go.
pub struct Process {
    child: Child,
}

impl Drop for Process {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a receiver writes.
pub struct Stream {
    frames: JoinHandle<Vec<Frame>>,
    said: Arc<Mutex<Vec<String>>>,
    process: Process,
}

impl Stream {
    pub fn times_asked(&self) -> usize {
        self.times_said(&["asks for"])
    }

    /// Lines on standard error with all these parts.
    pub fn times_said(&self, parts: &[&str]) -> usize {
        let has_all = |line: &&String| parts.iter().all(|part| line.contains(part));
        self.said.lock().unwrap().iter().filter(has_all).count()
    }

    /// All frames until the receiver ends, which it has to do well.
    pub fn frames(mut self) -> Vec<Frame> {
        assert!(until("the receiver ends", || self.process.child.try_wait().unwrap().is_some()));
        assert!(self.process.child.wait().unwrap().success());
        self.frames.join().unwrap()
    }

    /// All frames until now.
    #[cfg(feature = "tls")]
    pub fn stop(self) -> Vec<Frame> {
        drop(self.process);
        self.frames.join().unwrap()
    }
}

fn frames(mut out: ChildStdout) -> Vec<Frame> {
    read_head(&mut out).unwrap();
    let mut frames = Vec::new();
    while let Ok(frame) = Frame::read(&mut out) {
        frames.push(frame);
    }
    // Nothing stands after the last whole frame.
    assert_eq!(out.read(&mut [0]).unwrap(), 0);
    frames
}

/// A follower behind a receiver, in a thread.
pub struct Follower {
    ticks: Arc<AtomicU64>,
    thread: JoinHandle<error::Result<FollowReport>>,
}

impl Follower {
    pub fn of(network: &Network, name: &str) -> Self {
        Self::with(network, name, &[], LONG)
    }

    /// The same with options of the receiver; it waits at most this long for a stream that begins.
    pub fn with(network: &Network, name: &str, options: &[&str], wait: Duration) -> Self {
        let (words, ticks) = (network.words(name, options), Arc::new(AtomicU64::new(0)));
        let count = Arc::clone(&ticks);
        Self { ticks, thread: spawn(move || follow(words, wait, &count)) }
    }

    /// Waits until it has run this many ticks.
    #[track_caller]
    pub fn wait_for_ticks(&self, ticks: u64) {
        let ran = || self.ticks.load(Ordering::SeqCst);
        let is_there = until("ticks", || ran() >= ticks || self.thread.is_finished());
        assert!(is_there && ran() >= ticks, "{} of {ticks} ticks", ran());
    }

    /// Waits for its end.
    pub fn end(self) -> Followed {
        assert!(until("the follower ends", || self.thread.is_finished()));
        self.thread.join().unwrap().map_err(|why| why.to_string())
    }
}

/// `chaincell follow -- WORDS`, in this process, which without a wait ends with the receiver, or after 30 s.
fn follow(words: Vec<String>, wait: Duration, ticks: &AtomicU64) -> error::Result<FollowReport> {
    let label = Path::new("link");
    let mut intake = Intake::new(Box::new(Program::new(words)));
    let mut joined = join(&mut intake, None, now_ns() + wait.as_secs() * SECOND_NS)?;
    let image = joined.image.take().ok_or_else(|| Error::input("no model"))?;
    let trace = Reader::open(&joined.begun).map_err(Error::input)?;
    let model = Model::from_bytes(image.as_bytes()).map_err(Error::input)?;
    let (mut tissue, _, _) = recording::tissue(&trace, label, model)?;
    if let Some(begin) = &joined.start {
        tissue.restore(&begin.snapshot.saved)?;
    }
    let mut follower = Tissue::new(intake, &joined, &mut tissue, None)?;
    follower.run(joined, |_, told| {
        if let Told::Step(Step::Tick { .. }) = told {
            ticks.fetch_add(1, Ordering::SeqCst);
        }
        Ok(())
    })?;
    Ok(follower.report())
}
