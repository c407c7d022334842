//! The replay of a session that `chaincell cosim` has recorded.

use std::convert::Infallible;
use std::path::Path;

use chaincell_kernel::Budget;
use chaincell_kernel::trace::{Entry, Reader};

use crate::engine::convergence::{Convergence, ForceError};
use crate::engine::motion::Pose;
use crate::engine::staged::Staged;
use crate::engine::tissue::TissueEngine;
use crate::engine::untouched::Untouched;
use crate::error::{Error, Result};
use crate::files::recording::{self, Played, Start, Stop};

/// Results of the replay of a session; none for a session that was not recorded.
#[derive(Default)]
pub struct Replayed {
    pub state_hash: Option<String>,
    pub force_error: Option<ForceError>,
    pub never_touched: Option<Untouched>,
}

/// Plays the recorded session of at most that many ticks once more without shared memory. Only the trace has all of
/// a session: the sweeps and the delay of each tick, the commands, and the poses of all tools bit by bit.
pub fn replay(tissue: &mut Staged<'_>, place: &Path, ticks: u64) -> Result<Replayed> {
    let bytes = recording::read(place)?;
    let trace = Reader::open(&bytes).map_err(|why| Error::file("replay", place, why))?;
    let mut played = Played::default();
    let mut convergence = Convergence::new(ticks, tissue.engine().network().model().body_cells());
    let tick = |tissue: &mut Staged<'_>, poses: &[_], budget: Budget<'_>| {
        convergence.tick(tissue, poses, budget)
    };
    match recording::play_by(&trace, tissue, Start::default(), &mut played, tick) {
        Ok(_) => {}
        Err(Stop::Differs(why)) => {
            return Err(Error::check(format!("{}: {why}", place.display())));
        }
        Err(why @ (Stop::Command(_) | Stop::Enough)) => {
            return Err(Error::check(format!("{}: {why:?}", place.display())));
        }
    }
    // The poses of the first tool.
    let mut poses = Vec::new();
    let Ok(_) = trace.entries(|_, entry| {
        if let Entry::Tick(record) = entry {
            poses.push(Pose::of(record.tick, &record.sample));
        }
        Ok::<(), Infallible>(())
    });
    let never_touched = Untouched::of(tissue.engine(), &poses, played.has_touched);
    let state_hash = Some(format!("{:016x}", tissue.state_hash()));
    let force_error = convergence.error();
    Ok(Replayed { state_hash, force_error, never_touched })
}
