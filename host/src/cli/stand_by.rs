//! Standing by for a server on the same machine: its session is followed, and goes on here if it is killed.

use std::path::Path;

use super::recorded::trace_path;
use super::restore::OTHER;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::error::{Error, Result};
use crate::files::snapshot::SessionSnapshot;
use crate::remote::follow::{Follower, Joined, join};
use crate::remote::intake::Intake;
use crate::remote::mirror::Place;
use crate::remote::way::Local;
use crate::session::ipc::services::SceneServices;
use crate::terminal;

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
    /// A session that cannot be followed, or that was started otherwise.
    pub fn join(session: &'a Path, begun: &[u8], tissue: &Staged<'_>) -> Result<Self> {
        let place = Place::of(trace_path(session));
        let mut intake = Intake::new(Box::new(Local::new(place)));
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
    /// A damaged trace; a tick that differs; Ctrl-C.
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
        follower.run(joined, |_, _| Ok(()))?;
        let report = follower.report();
        if let Some(of) = report.first_difference {
            return Err(Error::check(format!(
                "tick {} (record {}) is the first that differs from the session of {}",
                of.tick,
                of.record,
                session.display()
            )));
        }
        if !report.was_killed {
            return Ok(None);
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
