//! The serving loop allocates nothing of its own; what iceoryx2 allocates is counted.

use std::time::{Duration, Instant};

use chaincell_host::bake::ImageBytes;
use chaincell_host::engine::motion::Pose;
use chaincell_host::engine::tissue::{Node, TissueEngine};
use chaincell_host::files::recording::{Recording, TraceFile};
use chaincell_host::session::ipc::contacts::ContactReader;
use chaincell_host::session::ipc::names::unique_scene;
use chaincell_host::session::ipc::services::{Domain, SceneServices};
use chaincell_host::session::ipc::state::StateReader;
use chaincell_host::session::ipc::stress::{NodeStress, StressReader};
use chaincell_host::session::ipc::surface::{SurfaceHeader, SurfaceReader, SurfaceRow};
use chaincell_host::session::loops::control::{ControlOptions, control};
use chaincell_host::session::loops::record::Recorder;
use chaincell_host::session::loops::serve::{ServeOptions, Server};
use chaincell_kernel::trace::Header;
use chaincell_kernel::{Budget, ContactForce, TickOutput, ToolPose};
use chaincell_kernel::{Model, Network, Settings, Track};
use chaincell_tests::allocations::so_far;
use chaincell_tests::turn;

use super::{BYTES_PER_SEND, COUNTED_TICKS, WARM_UP_TICKS};

/// What iceoryx2 allocates to list the readers of a service.
const BYTES_PER_LIST: u64 = 544;

/// Sessions that are tried until the ticks of one take [`VIEWED_SPAN`]: on a loaded machine all poses may
/// wait before the first tick, and all ticks then end within a viewer's period.
const ATTEMPTS: usize = 5;
/// Of the body that viewers are sent.
const NODES: usize = 1000;
/// Many periods of the viewers.
const VIEWED_SPAN: Duration = Duration::from_millis(100);

/// Reads the counters of the thread that ticks it.
#[derive(Default)]
struct Counter {
    ticks: u64,
    /// Messages to viewers: states and contacts.
    sent: u64,
    counted_sent: (u64, u64),
    start: (u64, u64),
    end: (u64, u64),
    /// Of the counted ticks.
    begin: Option<Instant>,
    span: Duration,
}

impl Counter {
    /// Messages to viewers while it was counted.
    fn sent(&self) -> u64 {
        self.counted_sent.1 - self.counted_sent.0
    }
}

impl TissueEngine for Counter {
    fn tick_by(&mut self, _poses: &[ToolPose], _budget: Budget<'_>) -> TickOutput {
        self.ticks += 1;
        let now = so_far();
        if self.ticks == WARM_UP_TICKS {
            self.start = now;
            self.counted_sent.0 = self.sent;
            self.begin = Some(Instant::now());
        }
        self.span = self.begin.map_or(Duration::ZERO, |begin| begin.elapsed());
        self.end = now;
        self.counted_sent.1 = self.sent;
        TickOutput::NONE
    }

    fn state_hash(&mut self) -> u64 {
        self.ticks
    }

    /// A message is sent behind the last nodes of a pass; the pass may have begun before the counted ticks.
    fn read_stresses(&mut self, first: usize, to: &mut [NodeStress], _means: &mut [f32]) -> bool {
        self.sent += u64::from(first + to.len() == NODES);
        true
    }

    fn read_nodes(&mut self, _to: &mut [Node]) {
        self.sent += 1;
    }

    fn read_surface(&mut self, _to: &mut [SurfaceRow]) -> SurfaceHeader {
        self.sent += 1;
        let copies = self.ticks as u32 % 100;
        SurfaceHeader { nodes: NODES as u32, copies, ..SurfaceHeader::default() }
    }

    fn read_contacts(&mut self, each: &mut dyn FnMut(u32, &ContactForce)) {
        self.sent += 1;
        (0..self.ticks as u32 % 100).for_each(|node| each(node, &CONTACT));
    }
}

const CONTACT: ContactForce = ContactForce {
    position_m: [0.0; 3],
    normal_n: [0.0; 3],
    tangential_n: [0.0; 3],
    area_m2: 0.0,
    cell: 0,
    origin: 0,
    tool: 0,
    part: 0,
    triangle: 0,
};

/// Whose readers a session has.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Viewed {
    Nothing,
    States,
    Stresses,
    Surfaces,
    Contacts,
}

impl Viewed {
    const ALL: [Self; 5] =
        [Self::Nothing, Self::States, Self::Stresses, Self::Surfaces, Self::Contacts];
}

#[test]
fn one_small_allocation_of_iceoryx2_a_message_and_none_of_ours() {
    let _turn = turn();
    for of in Viewed::ALL {
        let viewed = of != Viewed::Nothing;
        let is_long = |counter: &Counter| counter.span > VIEWED_SPAN || !viewed;
        let Some(counter) = (0..ATTEMPTS).map(|_| served(of)).find(is_long) else {
            println!("SKIPPED {of:?}: {ATTEMPTS} times all ticks came at once, no message was due");
            continue;
        };
        let count = counter.end.0 - counter.start.0;
        let bytes = counter.end.1 - counter.start.1;
        let sent = counter.sent();
        assert_eq!(counter.ticks, WARM_UP_TICKS + COUNTED_TICKS);
        assert!(sent > 0 || !viewed, "{of:?}: nothing was sent");
        assert!(sent == 0 || viewed, "something that nobody reads");
        let messages = COUNTED_TICKS + sent;
        // With readers, iceoryx2 lists them before each message; a pause of the controller adds one.
        let lists = count - messages;
        assert!(if viewed { lists >= sent } else { lists == 0 }, "{lists} for {sent} messages");
        assert_eq!(bytes, messages * BYTES_PER_SEND + lists * BYTES_PER_LIST, "{of:?}");
    }
}

/// The beginning of a trace.
fn begun() -> Recording {
    let image = ImageBytes::copy(include_bytes!("../../data/plane9.chaincell"));
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let network = Network::new(model, Settings::for_model(&model)).unwrap();
    Recording::of(&Header::of::<Track>(&network).unwrap(), &[40]).unwrap()
}

/// The counts of a session with a reader or without one.
fn served(viewed: Viewed) -> Counter {
    let root = tempfile::tempdir().unwrap();
    let options = ServeOptions {
        scene: Some(unique_scene("test")),
        domain: Domain { prefix: None, root: Some(root.path().to_owned()) },
        ticks: Some(WARM_UP_TICKS + COUNTED_TICKS),
        seconds: Some(20.0),
        watchdog_ms: 0,
        realtime: false,
        ..ServeOptions::default()
    };
    let control_options = ControlOptions {
        scene: options.scene.clone(),
        domain: options.domain.clone(),
        realtime: false,
        ..ControlOptions::default()
    };
    let trace = root.path().join("a.trace");
    let server = std::thread::spawn(move || {
        let mut counter = Counter::default();
        let records = Recorder::trace_records(1000, 0);
        let trace = TraceFile::create("--record", &trace, false, begun(), records).unwrap();
        let mut recorder = Recorder::with_capacity(1000).with_trace(trace);
        let server = Server::open(&options).unwrap();
        let server = server.with_state(NODES, 200).unwrap().with_contacts(1, 200).unwrap();
        let server = server.with_stress((NODES, NODES), 200).unwrap();
        let server = server.with_surface(2 * NODES, 200).unwrap().with_commands().unwrap();
        server.run(&mut counter, &mut recorder).unwrap();
        assert_eq!(recorder.ticks(), WARM_UP_TICKS + COUNTED_TICKS);
        counter
    });
    let scene =
        SceneServices::open(control_options.scene.as_deref(), &control_options.domain).unwrap();
    let states = (viewed == Viewed::States).then(|| StateReader::open(&scene).unwrap());
    let stresses = (viewed == Viewed::Stresses).then(|| StressReader::open(&scene).unwrap());
    let surfaces = (viewed == Viewed::Surfaces).then(|| SurfaceReader::open(&scene).unwrap());
    let contacts = (viewed == Viewed::Contacts).then(|| ContactReader::open(&scene).unwrap());
    let poses: Vec<Pose> =
        (0..WARM_UP_TICKS + COUNTED_TICKS).map(|tick| Pose { tick, ..Pose::default() }).collect();
    control(&poses, &control_options).unwrap();
    let counter = server.join().unwrap();
    drop((states, stresses, surfaces, contacts));
    counter
}
