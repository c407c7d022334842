//! A program of somebody else that sends poses of several tools.

use iceoryx2::node::Node;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use super::{eventually, node, service};

/// Places for tools in a message.
pub const PLACES: usize = 8;

/// A tool of [`Poses`]: 40 bytes, as declared by the contract.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct ToolPose {
    /// Which tool.
    pub number: u32,
    /// 1 while it holds the contact cells.
    pub engaged: u32,
    /// Its position \[m\].
    pub position_m: [f32; 3],
    /// Unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// Zero.
    pub reserved: u32,
}

/// 344 bytes, as declared by the contract.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolPoses.v2")]
#[repr(C)]
pub struct Poses {
    /// Number of the tick.
    pub tick: u64,
    /// When it was sent \[ns\].
    pub send_ns: u64,
    /// Places in use.
    pub tools: u32,
    /// Zero.
    pub reserved: u32,
    /// The places.
    pub each: [ToolPose; PLACES],
}

/// A tool of [`Forces`]: 40 bytes, as declared by the contract.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[repr(C)]
pub struct ToolForce {
    /// Which tool.
    pub number: u32,
    /// Number of held cells.
    pub contacts: u32,
    /// Force on the tool \[N\].
    pub force_n: [f32; 3],
    /// Torque on the tool \[N m\].
    pub torque_n_m: [f32; 3],
    /// What bit.
    pub flags: u32,
    /// Zero.
    pub reserved: u32,
}

/// 384 bytes, as declared by the contract.
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.ToolForces.v2")]
#[repr(C)]
pub struct Forces {
    /// Number of the tick.
    pub tick: u64,
    /// The server's session.
    pub session_id: u64,
    /// Tick of the pose that the force is of.
    pub force_tick: u64,
    /// When the message answered was sent \[ns\].
    pub send_ns: u64,
    /// Hash after the tick.
    pub state_hash: u64,
    /// Certified level \[J\].
    pub energy_j: f32,
    /// What bit.
    pub flags: u32,
    /// Time of the tick \[ns\].
    pub step_ns: u32,
    /// Sweeps of the tick.
    pub sweeps: u32,
    /// Places in use.
    pub tools: u32,
    /// Zero.
    pub reserved: u32,
    /// The places.
    pub each: [ToolForce; PLACES],
}

const _: () = assert!(size_of::<Poses>() == 344 && size_of::<Forces>() == 384);

impl Poses {
    /// One tool, number 0, that is not turned.
    #[must_use]
    pub fn of(tick: u64, position_m: [f32; 3], engaged: u32) -> Self {
        let mut poses =
            Self { tick, send_ns: tick.wrapping_mul(1000), tools: 1, ..Self::default() };
        poses.each[0] =
            ToolPose { engaged, position_m, orientation: [0.0, 0.0, 0.0, 1.0], ..poses.each[0] };
        poses
    }
}

/// The outside program, on one scene.
#[derive(Debug)]
pub struct ToolsOutsider {
    // Ports before their node: fields are dropped in this order.
    publisher: Option<Publisher<ipc::Service, Poses, ()>>,
    subscriber: Subscriber<ipc::Service, Forces, ()>,
    _node: Node<ipc::Service>,
}

impl ToolsOutsider {
    /// Joins a scene as a sender of poses and a reader of answers once its services exist.
    #[track_caller]
    #[must_use]
    pub fn join(scene: &str) -> Self {
        Self::join_as(scene, true)
    }

    /// Joins it as a reader, and as a sender too if it `sends`.
    #[track_caller]
    pub(super) fn join_as(scene: &str, sends: bool) -> Self {
        let node = node();
        let forces = eventually(|| {
            let service = node.service_builder(&service(scene, "forces"));
            service.publish_subscribe::<Forces>().open().ok()
        });
        let subscriber = forces.subscriber_builder().create().unwrap();
        let publisher = sends.then(|| {
            let tools = eventually(|| {
                let service = node.service_builder(&service(scene, "tools"));
                service.publish_subscribe::<Poses>().open().ok()
            });
            tools.publisher_builder().create().unwrap()
        });
        Self { publisher, subscriber, _node: node }
    }

    /// Sends one message.
    pub fn send(&self, poses: Poses) {
        self.publisher.as_ref().unwrap().send_copy(poses).unwrap();
    }

    /// The next answer.
    #[track_caller]
    #[must_use]
    pub fn receive(&self) -> Forces {
        eventually(|| self.try_receive())
    }

    /// An answer that has arrived.
    #[must_use]
    pub fn try_receive(&self) -> Option<Forces> {
        self.subscriber.receive().unwrap().map(|sample| *sample)
    }
}
