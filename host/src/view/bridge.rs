//! Follows a running scene for pages: joins it once as one more reader, and keeps the newest frame.
//!
//! The scene's server sends a state between its ticks where somebody reads. It knows nothing of pages.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use chaincell_client::Command;
use iceoryx2::prelude::{CallbackProgression, PortFactory};
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::interrupt;
use crate::session::ipc;
use crate::session::ipc::command::{CommandClient, refusal_text};
use crate::session::ipc::contacts::{Contact, ContactReader};
use crate::session::ipc::payload::{CommandMessage, NodePosition};
use crate::session::ipc::services::{Domain, SceneServices};
use crate::session::ipc::state::StateReader;
use crate::session::ipc::stress::{NodeStress, StressReader};
use crate::session::ipc::surface::SurfaceReader;
use crate::session::ipc::viewed::{Reader, Viewed};
use crate::session::ipc::watching::WatchPorts;
use crate::session::timing::clock::{MILLISECOND_NS, SECOND_NS, now_ns};
use crate::view::live::{Body, Sent, Subject};
use crate::view::server::{Feed, Live};

/// Period at which messages are looked for.
const LOOK: Duration = Duration::from_millis(4);
/// Period at which the server is looked for, while it sends nothing \[ns\].
const SERVER_NS: u64 = 250 * MILLISECOND_NS;
/// Time without a state after which the tools are shown without one: in a pause there are answers alone \[ns\].
const TOOLS_NS: u64 = 100 * MILLISECOND_NS;
/// Longest wait for the first state of a server that runs already \[ns\].
const FIRST_NS: u64 = 2 * SECOND_NS;
/// Longest wait for the reply to a command \[ns\].
const REPLY_NS: u64 = SECOND_NS;

/// A scene that is followed; dropping it ends that.
#[derive(Debug)]
pub struct Bridge {
    scene: Arc<SceneServices>,
    feed: Arc<Feed>,
    stop: Arc<AtomicBool>,
    following: Option<JoinHandle<()>>,
    takes_commands: bool,
}

/// State of the scene in a notice, by which the page knows what to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum Status {
    Waiting,
    Live,
    Gone,
    OtherModel,
    Ended,
}

/// A notice: its state and what it says.
#[derive(Debug, Serialize)]
struct Notice<'a> {
    status: Status,
    text: &'a str,
}

/// What a page may ask for.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case", deny_unknown_fields)]
enum Ask {
    Reset,
    Pause,
    Resume,
    Set { name: String, value: f32 },
}

/// The answer to a page.
#[derive(Debug, Serialize)]
struct Answer {
    done: bool,
    text: String,
}

impl Bridge {
    /// Follows a scene, whose server may come later, and takes commands of pages if it should.
    ///
    /// # Errors
    /// A scene that cannot be opened, or whose running server has another model.
    pub fn start(
        scene: Option<&str>,
        domain: &Domain,
        subject: Subject,
        takes_commands: bool,
    ) -> Result<Self> {
        let scene = Arc::new(ipc::open(scene, domain)?);
        let follower = Follower {
            ports: WatchPorts::open(&scene)?,
            bodies: Bodies::open(&scene, &subject)?,
            contacts: Contacts { reader: ContactReader::open(&scene)?, newest: Vec::new() },
            stresses: Stresses::default(),
            feed: Arc::default(),
            status: None,
            looked_ns: 0,
            last: None,
            subject,
            scene: Arc::clone(&scene),
        };
        let (feed, stop) = (Arc::clone(&follower.feed), Arc::<AtomicBool>::default());
        let mut bridge = Self { scene, feed, stop, following: None, takes_commands };
        bridge.follow(follower)?;
        Ok(bridge)
    }

    fn follow(&mut self, mut follower: Follower) -> Result<()> {
        // A server that runs has a state for a new reader; one of another model is refused at once.
        let end_ns = now_ns() + FIRST_NS;
        follower.look_for_server();
        while follower.status == Some(Status::Live) && !follower.look()? && now_ns() < end_ns {
            interrupt::check()?;
            thread::sleep(LOOK);
        }
        if follower.status == Some(Status::OtherModel) {
            return Err(Error::input(follower.other_model()));
        }
        let stop = Arc::clone(&self.stop);
        let thread = thread::Builder::new().name("bridge".into()).spawn(move || {
            while !stop.load(Ordering::Acquire) {
                if let Err(why) = follower.look() {
                    follower.say(Status::Gone, &format!("{why}; open the page again"));
                    return;
                }
                thread::sleep(LOOK);
            }
        });
        let thread = thread.map_err(|why| Error::check(format!("cannot begin a thread: {why}")))?;
        self.following = Some(thread);
        Ok(())
    }

    /// The frames and the commands of the scene, for a server.
    #[must_use]
    pub fn live(&self) -> Live {
        let commands = self.takes_commands.then(|| Arc::clone(&self.scene));
        let client = Mutex::new(None);
        let reply = Box::new(move |message: &str| {
            let done = match &commands {
                None => Err("this page may only look: start chaincell view with --commands".into()),
                Some(scene) => {
                    obey(scene, &mut client.lock().unwrap_or_else(PoisonError::into_inner), message)
                }
            };
            let answer = match done {
                Ok(text) => Answer { done: true, text },
                Err(text) => Answer { done: false, text },
            };
            serde_json::to_string(&answer).ok()
        });
        Live { feed: Arc::clone(&self.feed), reply }
    }

    /// Number of open pages.
    #[must_use]
    pub fn pages(&self) -> usize {
        self.feed.pages()
    }

    /// Ends following; pages keep the last frame and show why.
    pub fn end(&mut self, text: &str) {
        self.stop_following();
        say(&self.feed, Status::Ended, text);
    }

    fn stop_following(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(following) = self.following.take() {
            let _ = following.join();
        }
    }
}

impl Drop for Bridge {
    fn drop(&mut self) {
        self.stop_following();
    }
}

/// The last body, the tick whose tools were shown with it, and when \[ns\].
#[derive(Debug)]
struct Last {
    body: Body,
    tick: u64,
    shown_ns: u64,
}

/// The reader of the body: of its states, or of one that can be cut of its surfaces, which are states with copies and
/// triangles.
#[derive(Debug)]
enum Bodies {
    States(StateReader),
    Surfaces(SurfaceReader),
}

impl Bodies {
    fn open(scene: &SceneServices, subject: &Subject) -> Result<Self> {
        Ok(match subject.can_be_cut() {
            true => Self::Surfaces(SurfaceReader::open(scene)?),
            false => Self::States(StateReader::open(scene)?),
        })
    }

    /// Takes the newest body, if one has come.
    fn take(&self) -> Result<Option<Body>> {
        match self {
            Self::States(reader) => {
                Ok(reader.take()?.map(|(header, nodes)| Body { header, nodes, ..Body::default() }))
            }
            Self::Surfaces(reader) => {
                let Some(view) = reader.borrow()? else { return Ok(None) };
                let (header, rows) = (view.header(), view.rows());
                let [nodes, copies, triangles] =
                    [header.nodes, header.copies, header.triangles].map(|count| count as usize);
                let mut places =
                    rows.iter().map(|of| NodePosition { node: of.node, position_m: of.position_m });
                Ok(Some(Body {
                    header: header.into(),
                    nodes: places.by_ref().take(nodes).collect(),
                    copies: places.take(copies).collect(),
                    triangles: rows.iter().take(triangles).map(|of| of.corners).collect(),
                }))
            }
        }
    }

    /// Returns true if a program that is alive sends bodies. A killed one may still be registered.
    fn is_served(&self, scene: &SceneServices) -> bool {
        match self {
            Self::States(reader) => has_sender(reader, scene),
            Self::Surfaces(reader) => has_sender(reader, scene),
        }
    }
}

fn has_sender<T: Viewed>(reader: &Reader<T>, scene: &SceneServices) -> bool {
    let mut is_alive = false;
    if reader.is_served() {
        reader.topic().dynamic_config().list_publishers(|publisher| {
            is_alive |= scene.is_alive(publisher.node_id);
            CallbackProgression::Continue
        });
    }
    is_alive
}

/// The newest contacts of the scene; none where its tool holds cells.
#[derive(Debug)]
struct Contacts {
    reader: ContactReader,
    newest: Vec<Contact>,
}

impl Contacts {
    /// Takes what has come; those of a server that has begun anew since replace all others.
    fn take(&mut self, has_begun_anew: bool) -> Result<()> {
        if has_begun_anew {
            self.newest.clear();
        }
        while let Some(view) = self.reader.borrow()? {
            self.newest.clear();
            self.newest.extend(view.rows());
        }
        Ok(())
    }
}

/// The newest stresses of the scene, while a page asks for them: a reader makes the server compute.
#[derive(Debug, Default)]
struct Stresses {
    reader: Option<StressReader>,
    newest: Vec<NodeStress>,
    /// When a reader was asked for last \[ns\].
    refused_ns: u64,
}

impl Stresses {
    /// Takes what has come of this body; true if something has.
    fn take(&mut self, is_asked_for: bool, scene: &SceneServices, checksum: u32) -> Result<bool> {
        if !is_asked_for {
            *self = Self::default();
            return Ok(false);
        }
        // A scene that has no place for a reader is asked again later; the page shows all else.
        if self.reader.is_none() && now_ns() >= self.refused_ns + SERVER_NS {
            self.reader = StressReader::open(scene).ok();
            self.refused_ns = now_ns();
        }
        let Some(reader) = &self.reader else { return Ok(false) };
        let mut has_come = false;
        while let Some(view) = reader.borrow()? {
            self.newest.clear();
            if view.header().model_checksum == checksum {
                self.newest.extend(view.rows());
            }
            has_come = true;
        }
        Ok(has_come)
    }
}

/// Reads the scene's messages in a thread of its own.
#[derive(Debug)]
struct Follower {
    ports: WatchPorts,
    bodies: Bodies,
    contacts: Contacts,
    stresses: Stresses,
    feed: Arc<Feed>,
    status: Option<Status>,
    looked_ns: u64,
    last: Option<Last>,
    subject: Subject,
    // After its ports: fields are dropped in order.
    scene: Arc<SceneServices>,
}

impl Follower {
    /// Takes what has come; returns true if a state has.
    fn look(&mut self) -> Result<bool> {
        self.ports.take()?;
        let is_asked_for = self.feed.wants_stress();
        let has_stress = self.stresses.take(is_asked_for, &self.scene, self.subject.checksum)?;
        let Some(body) = self.bodies.take()? else {
            if now_ns() >= self.looked_ns + SERVER_NS {
                self.look_for_server();
            }
            self.show_again(has_stress);
            return Ok(false);
        };
        // The answer that belongs to the body was sent before it; the contacts follow it.
        self.ports.take()?;
        let last = self.last.as_ref().map_or(0, |last| last.body.header.ticks_answered);
        self.contacts.take(body.header.ticks_answered < last)?;
        if self.subject.is_of(&body) {
            let last = Last { tick: body.header.tick, body, shown_ns: now_ns() };
            self.publish(&last);
            self.last = Some(last);
            self.note(Status::Live);
        } else {
            self.note(Status::OtherModel);
        }
        self.looked_ns = now_ns();
        Ok(true)
    }

    /// Sends a body to the pages, with the newest contacts and stresses.
    fn publish(&self, Last { body, tick, .. }: &Last) {
        let (contacts, stresses) = (&self.contacts.newest[..], &self.stresses.newest[..]);
        self.feed.publish(self.subject.frame(
            Sent { body, contacts, stresses },
            *tick,
            &self.ports,
        ));
    }

    /// Shows the tools of the newest answer and new stresses on the last state, if no state comes.
    fn show_again(&mut self, has_stress: bool) {
        let newest = self.ports.answers().back().map(|answer| answer.tick);
        let Some(mut last) = self.last.take() else { return };
        let tick = newest.unwrap_or(last.tick);
        if has_stress || (tick != last.tick && now_ns() >= last.shown_ns + TOOLS_NS) {
            (last.tick, last.shown_ns) = (tick, now_ns());
            self.publish(&last);
        }
        self.last = Some(last);
    }

    /// Notes whether a server runs.
    fn look_for_server(&mut self) {
        self.looked_ns = now_ns();
        let status = match (self.bodies.is_served(&self.scene), self.status) {
            (true, Some(Status::OtherModel)) => Status::OtherModel,
            (true, _) => Status::Live,
            (false, None | Some(Status::Waiting)) => Status::Waiting,
            (false, _) => Status::Gone,
        };
        self.note(status);
    }

    fn note(&mut self, status: Status) {
        if self.status == Some(status) {
            return;
        }
        self.status = Some(status);
        let label = self.scene.label();
        let text = match status {
            Status::Waiting => {
                format!("no server on {label} yet: start chaincell serve with the same --scene")
            }
            Status::Live => format!("connected to {label}"),
            Status::Gone => format!(
                "the server of {label} has ended or was killed; this is its last state, until it is there again"
            ),
            Status::OtherModel => self.other_model(),
            Status::Ended => format!("{label} has ended"),
        };
        self.say(status, &text);
    }

    fn other_model(&self) -> String {
        format!(
            "{} serves another model, and this page shows the one with checksum {:08x}: start chaincell view \
             with the model file of chaincell serve",
            self.scene.label(),
            self.subject.checksum
        )
    }

    fn say(&self, status: Status, text: &str) {
        say(&self.feed, status, text);
    }
}

fn say(feed: &Feed, status: Status, text: &str) {
    // Two words always become JSON.
    if let Ok(notice) = serde_json::to_string(&Notice { status, text }) {
        feed.notify(notice);
    }
}

/// Carries out the message of a page; the client joins the scene with the first one.
fn obey(
    scene: &SceneServices,
    client: &mut Option<CommandClient>,
    message: &str,
) -> std::result::Result<String, String> {
    let ask = serde_json::from_str(message).map_err(|why| format!("no such command: {why}"))?;
    let command = command(&ask)?;
    let client = match client.take() {
        Some(opened) => client.insert(opened),
        None => client.insert(CommandClient::open(scene).map_err(|why| why.to_string())?),
    };
    let reply = client.send(CommandMessage::new(&command), REPLY_NS, || false);
    let reply = reply.map_err(|why| why.to_string())?;
    match reply.result {
        0 => Ok(format!("done after tick {}", reply.tick)),
        _ => Err(format!("refused: {}", refusal_text(reply.reason))),
    }
}

fn command(ask: &Ask) -> std::result::Result<Command, String> {
    Ok(match ask {
        Ask::Reset => Command::Reset,
        Ask::Pause => Command::Pause,
        Ask::Resume => Command::Resume,
        // The server checks the range.
        Ask::Set { name, value } => match name.as_str() {
            "sweeps" => Command::Sweeps(*value as u16),
            "max_force_n" => Command::MaxForceN(*value),
            "max_tool_step_m" => Command::MaxToolStepM(*value),
            _ => {
                return Err(format!(
                    "{name} cannot be set: sweeps, max_force_n or max_tool_step_m"
                ));
            }
        },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_asks_in_json_and_is_refused_in_words() {
        let parsed = |text: &str| {
            serde_json::from_str(text).map_err(|why| why.to_string()).and_then(|ask| command(&ask))
        };
        assert_eq!(parsed(r#"{"do":"pause"}"#), Ok(Command::Pause));
        assert_eq!(parsed(r#"{"do":"resume"}"#), Ok(Command::Resume));
        assert_eq!(parsed(r#"{"do":"reset"}"#), Ok(Command::Reset));
        let set = |name: &str, value: &str| {
            parsed(&format!(r#"{{"do":"set","name":"{name}","value":{value}}}"#))
        };
        assert_eq!(set("sweeps", "6"), Ok(Command::Sweeps(6)));
        assert_eq!(set("sweeps", "-1"), Ok(Command::Sweeps(0)), "the server refuses it");
        assert_eq!(set("max_force_n", "2.5"), Ok(Command::MaxForceN(2.5)));
        assert_eq!(set("max_tool_step_m", "0.002"), Ok(Command::MaxToolStepM(0.002)));
        assert!(set("model", "1").unwrap_err().contains("sweeps, max_force_n"));
        for bad in ["", "pause", "{}", r#"{"do":"snapshot"}"#, r#"{"do":"set","name":"sweeps"}"#] {
            assert!(parsed(bad).is_err(), "{bad}");
        }
    }
}
