//! The agent's loop: datagrams in, poses to the tissue, its answers back.

use chaincell_client::clock::{MILLISECOND_NS, SECOND_NS, now_ns};
use chaincell_client::services::{Domain, SceneServices};
use chaincell_client::tools::{ToolForces, ToolPoses};
use chaincell_client::{Exchange, Options, Result};

use crate::agent::{Agent, News};
use crate::report::AgentReport;
use crate::socket::Socket;

/// Wait between looks at the tissue while an answer is due \[ns\].
const LOOK_NS: u64 = 30_000;
/// Longest wait for a datagram \[ns\].
const IDLE_NS: u64 = MILLISECOND_NS;
/// Time between looks for the server \[ns\].
const SERVED_NS: u64 = SECOND_NS;
/// Wait for an answer after which it is not waited for any more \[ns\].
const ANSWER_NS: u64 = 20 * MILLISECOND_NS;

/// A scene, as its controller.
#[derive(Debug)]
pub struct Scene {
    exchange: Exchange,
    // After its ports: fields are dropped in order.
    services: SceneServices,
}

impl Scene {
    /// Joins a scene, and waits for its server.
    ///
    /// # Errors
    /// No server in time, another controller, another user's files.
    pub fn open(name: Option<&str>, server_wait_ns: u64, stop: impl Fn() -> bool) -> Result<Self> {
        let services = SceneServices::open_unless(name, &Domain::default(), &mut || stop())?;
        let options = Options { server_wait_ns, ..Options::default() };
        let exchange = Exchange::open(&services, &options, stop)?;
        Ok(Self { exchange, services })
    }

    fn send(&mut self, poses: ToolPoses) -> Result<()> {
        self.exchange.send(poses)
    }

    fn receive(&mut self) -> Option<ToolForces> {
        self.exchange.receive()
    }
}

/// Runs the agent until `stop` returns true or the server has ended. `say` gets the news.
///
/// # Errors
/// Shared memory that takes no pose.
pub fn run(
    agent: &mut Agent,
    socket: &Socket,
    scene: &mut Scene,
    stop: impl Fn() -> bool,
    say: impl Fn(News),
) -> Result<AgentReport> {
    // The last pose in the tissue, and when it was sent.
    let mut asked: Option<(u64, u64)> = None;
    let mut looked_ns = now_ns();
    let ended = loop {
        if stop() {
            break "stopped";
        }
        // All that has come, then the newest poses.
        while let Some(arrived) = socket.take() {
            if let Some(reply) = agent.take(arrived.bytes(), arrived.from, now_ns()) {
                socket.send_to(&reply, arrived.from);
            }
        }
        for poses in agent.poses() {
            asked = Some((poses.tick, now_ns()));
            scene.send(poses)?;
        }
        // Answers go back as they come.
        while let Some(forces) = scene.receive() {
            if let Some((hand, datagram)) = agent.answer(&forces, now_ns()) {
                socket.send_to(&datagram, hand);
            }
            asked = asked.filter(|(tick, _)| *tick > forces.tick);
        }
        let now_ns = now_ns();
        agent.look(now_ns);
        agent.news().into_iter().for_each(&say);
        if now_ns - looked_ns >= SERVED_NS {
            looked_ns = now_ns;
            if !scene.services.is_served() {
                break "the tissue's session has ended";
            }
        }
        asked = asked.filter(|(_, asked_ns)| now_ns - asked_ns < ANSWER_NS);
        socket.wait(now_ns + if asked.is_some() { LOOK_NS } else { IDLE_NS });
    };
    Ok(AgentReport { ended: ended.to_owned(), counts: agent.counts() })
}
