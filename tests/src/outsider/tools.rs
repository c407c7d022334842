//! A program of somebody else that sends poses of several tools.

pub use chaincell_client::tools::{
    OneToolForce as ToolForce, OneToolPose as ToolPose, TOOLS_MAX as PLACES, ToolForces as Forces,
    ToolPoses as Poses, UNKNOWN_N,
};
use iceoryx2::node::Node;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;

use super::{eventually, node, service};

/// The message of one tool, number 0, that is not turned.
#[must_use]
pub fn one_tool(tick: u64, position_m: [f32; 3], engaged: u32) -> Poses {
    let mut poses = Poses { tick, send_ns: tick.wrapping_mul(1000), tools: 1, ..Poses::default() };
    let orientation = [0.0, 0.0, 0.0, 1.0];
    let engaged = u16::try_from(engaged).unwrap_or(u16::MAX);
    poses.each[0] = ToolPose { engaged, position_m, orientation, ..ToolPose::default() };
    poses
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
