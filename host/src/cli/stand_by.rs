//! Standing by for a server on the same machine: its session is followed, and goes on here if it is killed.

use std::path::Path;

use super::restore::OTHER;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::error::{Error, Result};
use crate::files::recording::Tail;
use crate::files::snapshot::SessionSnapshot;
use crate::remote::follow::{Follower, Joined, Told, join};
use crate::remote::intake::Intake;
use crate::remote::place::Place;
use crate::remote::way::Local;
use crate::session::ipc::services::SceneServices;
use crate::session::ipc::watching::WatchPorts;
use crate::terminal;

/// Ticks between the newest answer and the last record that a running session does not have.
const FAR_TICKS: u64 = 5000;

/// A session that another server records, joined by one that may take its place.
pub struct StandBy<'a> {
    session: &'a Path,
    intake: Intake,
    joined: Joined,
}

impl<'a> StandBy<'a> {
    /// Joins the session, which was begun like that of `tissue`, at rest; `begun` is what a trace of it begins
    /// with.
    ///
    /// # Errors
    /// A session that cannot be followed, that was started otherwise, or whose server is on another scene.
    pub fn join(
        session: &'a Path,
        begun: &[u8],
        scene: &SceneServices,
        tissue: &Staged<'_>,
    ) -> Result<Self> {
        let place = Place::find(session, None)?;
        if !Tail::open(&place.trace)?.is_written() {
            let why = "its server has ended or was killed already: go on with its newest snapshot by --restore";
            return Err(Error::file("stand by for", session, why));
        }
        if !scene.is_served() {
            let why = format_args!(
                "its server is not on {}: pass the --scene of that server",
                scene.label()
            );
            return Err(Error::file("stand by for", session, why));
        }
        let mut intake = Intake::new(Box::new(Local::Found(place)));
        let joined = join(&mut intake, Some(tissue.model_checksum()), 0)?;
        match joined.begun == begun {
            true => Ok(Self { session, intake, joined }),
            false => Err(Error::file("stand by for", session, OTHER)),
        }
    }

    /// Follows the session with the tissue until its server ends. Returns it at its last record if the server
    /// was killed, `None` if it ended by itself.
    ///
    /// # Errors
    /// A damaged trace; a tick that differs; a session that went on when its record was full; Ctrl-C.
    pub fn wait(
        self,
        scene: &SceneServices,
        tissue: &mut Staged<'_>,
    ) -> Result<Option<SessionSnapshot>> {
        // Follow from the newest snapshot to the end.
        let Self { session, intake, joined } = self;
        if let Some(begin) = &joined.start {
            tissue.restore(&begin.snapshot.saved)?;
        }
        terminal::say("standing by")?;
        let begun = joined.begun.clone();
        let mut follower = Follower::new(intake, &joined, tissue, None)?;
        let mut answers = Answers { ports: WatchPorts::open(scene)?, is_told: false };
        follower.run(joined, |_, told| match told {
            Told::Look { tick, .. } => answers.look(session, tick),
            _ => Ok(()),
        })?;
        let report = follower.report();
        follower.check_same(session)?;
        if !report.was_killed {
            return Ok(None);
        }
        if let Some(beyond) = answers.beyond(report.last_tick)? {
            return Err(Error::check(format!(
                "the server of {} was killed after tick {beyond}, and its record was full after tick {}: nothing is \
                 taken over; start both again, with a larger --record-ticks",
                session.display(),
                report.last_tick
            )));
        }
        // Its controller goes on if no other program could have been it.
        let publisher = scene.only_pose_publisher().unwrap_or(0);
        terminal::note(format_args!(
            "note: the server of {} was killed after tick {}: taking over",
            session.display(),
            report.last_tick
        ));
        follower.snapshot(&begun, publisher).map(Some)
    }
}

/// The answers of the server that is stood by for.
struct Answers {
    ports: WatchPorts,
    is_told: bool,
}

impl Answers {
    /// The tick of the newest answer, if it is after the last record.
    fn beyond(&mut self, recorded_tick: u64) -> Result<Option<u64>> {
        self.ports.take()?;
        let newest = self.ports.answers().back().map(|answer| answer.tick);
        Ok(newest.filter(|&tick| tick > recorded_tick))
    }

    /// Says once that a session goes on without being recorded.
    fn look(&mut self, session: &Path, recorded_tick: u64) -> Result<()> {
        let beyond = self.beyond(recorded_tick)?;
        if !self.is_told && beyond.is_some_and(|tick| tick > recorded_tick + FAR_TICKS) {
            self.is_told = true;
            terminal::note(format_args!(
                "note: the record of {} ends with tick {recorded_tick}, and its session goes on: it cannot be taken \
                 over; start both again, with a larger --record-ticks",
                session.display()
            ));
        }
        Ok(())
    }
}
