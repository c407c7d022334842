//! Commands, on the server's side: carried out between ticks, at most one every 10 ms; those of a flood
//! overflow and stay without a reply.

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

/// Shortest span between two commands \[ns\].
const PERIOD_NS: u64 = 10 * MILLISECOND_NS;
/// Span between looks for a command \[ns\].
const LOOK_NS: u64 = MILLISECOND_NS;

/// The server's side.
#[derive(Debug)]
pub(crate) struct CommandServer {
    _service: Service,
    server: Server<Ipc, CommandMessage, (), ReplyMessage, ()>,
    look_ns: u64,
    failed: u64,
    /// A command whose reply waits for a file.
    waiting: Option<(Request, ReplyMessage)>,
}

/// A command with its way back.
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

    /// Whether to look for a command now; where a pose may be waiting (`idle` is false) only after
    /// a longer time without a look.
    pub(crate) fn is_due(&self, now_ns: u64, idle: bool) -> bool {
        now_ns >= self.look_ns + if idle { 0 } else { PERIOD_NS }
    }

    /// The next command, if any.
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

    /// Replies to a command, at once or with [`Self::finish`].
    pub(crate) fn reply(&mut self, request: Request, reply: ReplyMessage, is_later: bool) {
        if is_later {
            self.waiting = Some((request, reply));
        } else if let Err(why) = request.send_copy(reply) {
            complain(&mut self.failed, "cannot reply to a command", why);
        }
    }

    /// Whether a command waits for its reply.
    pub(crate) fn waits(&self) -> bool {
        self.waiting.is_some()
    }

    /// Sends the reply that waits: done, or refused after all.
    pub(crate) fn finish(&mut self, refusal: Option<Refusal>) {
        let Some((request, mut reply)) = self.waiting.take() else { return };
        if let Some(why) = refusal {
            (reply.result, reply.reason) = (1, why as u32);
        }
        self.reply(request, reply, false);
    }
}
