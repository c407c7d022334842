//! Commands on the server's side: executed between ticks, at most one every 10 ms. Further ones overflow and
//! get no reply.

pub use chaincell_client::command::{CommandClient, Refusal, SWEEPS_MAX, refusal_text};
use chaincell_client::command::{Service, service};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;

use crate::error::Result;
use crate::session::ipc::complain::complain;
use crate::session::ipc::payload::{CommandMessage, ReplyMessage};
use crate::session::ipc::services::{Ipc, SceneServices, port_error};
use crate::session::timing::clock::MILLISECOND_NS;

/// Shortest time between two commands \[ns\].
const PERIOD_NS: u64 = 10 * MILLISECOND_NS;
/// Time between checks for a command \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;

/// The server's side.
#[derive(Debug)]
pub(crate) struct CommandServer {
    _service: Service,
    server: Server<Ipc, CommandMessage, (), ReplyMessage, ()>,
    look_ns: u64,
    failed: u64,
    /// A command that is answered once a file is written.
    waiting: Option<(Request, ReplyMessage)>,
}

/// A received command, to which a reply can be sent.
pub(crate) type Request = ActiveRequest<Ipc, CommandMessage, (), ReplyMessage, ()>;

impl CommandServer {
    pub(crate) fn open(scene: &SceneServices) -> Result<Self> {
        let service = service(scene)?;
        let server = service
            .server_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .max_loaned_responses_per_request(1)
            .create()
            .map_err(|why| port_error(&scene.command_name, why))?;
        Ok(Self { _service: service, server, look_ns: 0, failed: 0, waiting: None })
    }

    /// Returns true if it is time to check for a command; while a pose may be waiting (`idle` is false) only
    /// after a longer time without a check.
    pub(crate) fn is_due(&self, now_ns: u64, idle: bool) -> bool {
        now_ns >= self.look_ns + if idle { 0 } else { PERIOD_NS }
    }

    /// Returns the next command, if any.
    pub(crate) fn receive(&mut self, now_ns: u64) -> Option<Request> {
        self.look_ns = now_ns + LOOK_NS;
        match self.server.receive() {
            Ok(request) => {
                self.look_ns += if request.is_some() { PERIOD_NS - LOOK_NS } else { 0 };
                request
            }
            Err(why) => {
                complain(&mut self.failed, "cannot receive a command", why);
                None
            }
        }
    }

    /// Replies to a command at once, or later in [`Self::finish`].
    pub(crate) fn reply(&mut self, request: Request, reply: ReplyMessage, is_later: bool) {
        if is_later {
            self.waiting = Some((request, reply));
        } else if let Err(why) = request.send_copy(reply) {
            complain(&mut self.failed, "cannot reply to a command", why);
        }
    }

    /// Returns true if the reply to a command is pending.
    pub(crate) fn waits(&self) -> bool {
        self.waiting.is_some()
    }

    /// Sends the pending reply: success, or the refusal.
    pub(crate) fn finish(&mut self, refusal: Option<Refusal>) {
        let Some((request, mut reply)) = self.waiting.take() else { return };
        if let Some(why) = refusal {
            (reply.result, reply.reason) = (1, why as u32);
        }
        self.reply(request, reply, false);
    }
}
