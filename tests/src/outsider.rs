//! A program of somebody else on the scene's services: it knows the names and the bytes of the
//! messages, and nothing of chaincell's code.

use std::time::{Duration, Instant};

use iceoryx2::node::Node;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

/// Longest wait for a service or a message.
const LIMIT: Duration = Duration::from_secs(60);

/// 24 bytes, as declared by the contract.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolPose.v1")]
#[repr(C)]
pub struct Pose {
    /// Number of the tick.
    pub tick: u64,
    /// Tool position \[m\].
    pub position_m: [f32; 3],
    /// 1 while the tool holds the contact cells.
    pub engaged: u32,
}

/// 48 bytes, as declared by the contract.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolForce.v1")]
#[repr(C)]
pub struct Force {
    /// Number of the tick.
    pub tick: u64,
    /// Force on the tool \[N\].
    pub force_n: [f32; 3],
    /// Certified level \[J\].
    pub energy_j: f32,
    /// Number of held cells.
    pub contacts: u32,
    /// What bit.
    pub flags: u32,
    /// Time of the tick \[ns\].
    pub step_ns: u32,
    /// Zero.
    pub reserved: u32,
    /// Hash after the tick.
    pub state_hash: u64,
}

/// The outside program, on one scene.
#[derive(Debug)]
pub struct Outsider {
    // Ports before their node: fields are dropped in this order.
    publisher: Option<Publisher<ipc::Service, Pose, ()>>,
    subscriber: Subscriber<ipc::Service, Force, ()>,
    _node: Node<ipc::Service>,
}

impl Outsider {
    /// Joins a scene as a reader of answers once its services exist; as a sender of poses too if
    /// it `sends`.
    #[track_caller]
    #[must_use]
    pub fn join(scene: &str, sends: bool) -> Self {
        set_log_level(LogLevel::Fatal);
        let node = NodeBuilder::new()
            .config(&Config::default())
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .unwrap();
        let name = |topic: &str| -> ServiceName {
            format!("chaincell/{scene}/{topic}").as_str().try_into().unwrap()
        };
        let force = eventually(|| {
            node.service_builder(&name("force")).publish_subscribe::<Force>().open().ok()
        });
        let subscriber = force.subscriber_builder().create().unwrap();
        let publisher = sends.then(|| {
            let pose = eventually(|| {
                node.service_builder(&name("pose")).publish_subscribe::<Pose>().open().ok()
            });
            pose.publisher_builder().create().unwrap()
        });
        Self { publisher, subscriber, _node: node }
    }

    /// Sends one pose.
    pub fn send(&self, pose: Pose) {
        self.publisher.as_ref().unwrap().send_copy(pose).unwrap();
    }

    /// The next answer.
    #[track_caller]
    #[must_use]
    pub fn receive(&self) -> Force {
        eventually(|| self.try_receive())
    }

    /// Waits for an answer to a tick of at least this number.
    #[track_caller]
    pub fn after(&self, tick: u64) -> u64 {
        loop {
            let seen = self.receive().tick;
            if seen >= tick {
                return seen;
            }
        }
    }

    /// An answer that has arrived.
    #[must_use]
    pub fn try_receive(&self) -> Option<Force> {
        self.subscriber.receive().unwrap().map(|sample| *sample)
    }
}

#[track_caller]
fn eventually<T>(mut look: impl FnMut() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < LIMIT, "nothing within {LIMIT:?}");
        std::thread::sleep(Duration::from_micros(200));
    }
}
