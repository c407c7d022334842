//! Snapshots of a run: which ticks they are of, and their files.

use std::collections::BTreeSet;

use crate::engine::Engine;
use crate::engine::motion::Pose;
use crate::error::{Error, Result};
use crate::files::output::{Folder, SERIES, cells_csv, pvd, state_name, vtu};

/// Most snapshots of a run: each is two files of the size of the body.
const SNAPSHOTS_MAX: usize = 1000;

/// Which ticks.
#[derive(Debug, Clone, clap::Args)]
pub struct SnapshotArgs {
    /// Also write the positions after these ticks: cells_<tick>.csv, state_<tick>.vtu, and series.pvd
    /// of all for ParaView
    #[arg(
        long,
        value_name = "TICKS",
        value_delimiter = ',',
        allow_negative_numbers = true,
        requires = "out"
    )]
    snapshot_ticks: Vec<u64>,
    /// The same after every tick whose number N divides; at most 1,000 snapshots in all
    #[arg(long, value_name = "N", allow_negative_numbers = true, requires = "out",
        value_parser = clap::value_parser!(u64).range(1..))]
    snapshot_every: Option<u64>,
}

impl SnapshotArgs {
    /// The ticks of these poses that are written.
    ///
    /// # Errors
    /// A tick that no pose has, a count that no pose comes to, too many.
    pub fn of(&self, poses: &[Vec<Pose>]) -> Result<BTreeSet<u64>> {
        let of_path: BTreeSet<u64> = poses.iter().flatten().map(|pose| pose.tick).collect();
        let ends = (of_path.first().copied(), of_path.last().copied());
        let has = |option: &str, number: u64| {
            let (first, last) = (ends.0.unwrap_or_default(), ends.1.unwrap_or_default());
            Error::input(format!("{option} {number}: the path has the ticks {first} to {last}"))
        };
        if let Some(&tick) = self.snapshot_ticks.iter().find(|tick| !of_path.contains(tick)) {
            return Err(has("--snapshot-ticks", tick));
        }
        let mut ticks: BTreeSet<u64> = self.snapshot_ticks.iter().copied().collect();
        if let Some(every) = self.snapshot_every {
            let before = ticks.len();
            ticks.extend(of_path.iter().filter(|tick| tick.is_multiple_of(every)));
            if before == 0 && ticks.is_empty() {
                return Err(has("--snapshot-every", every));
            }
        }
        if ticks.len() <= SNAPSHOTS_MAX {
            return Ok(ticks);
        }
        let enough = of_path.len().div_ceil(SNAPSHOTS_MAX);
        Err(Error::input(format!(
            "{} snapshots: at most {SNAPSHOTS_MAX}; for all of the path pass --snapshot-every \
             {enough} or more",
            ticks.len()
        )))
    }
}

/// The snapshots of a run as they are written.
pub struct Snapshots<'a> {
    ticks: &'a BTreeSet<u64>,
    folder: &'a Folder,
    hz: u32,
    written: BTreeSet<u64>,
}

impl<'a> Snapshots<'a> {
    /// None written yet, of a run at a rate of ticks \[Hz\].
    pub fn new(ticks: &'a BTreeSet<u64>, folder: &'a Folder, hz: u32) -> Self {
        Self { ticks, folder, hz, written: BTreeSet::new() }
    }

    /// Writes that of a tick, behind it, where one is asked for.
    pub fn after(&mut self, tick: u64, engine: &mut Engine<'_>) -> Result<()> {
        if !self.ticks.contains(&tick) {
            return Ok(());
        }
        let nodes = engine.nodes();
        let body = vtu(engine, &nodes);
        self.folder.write(&format!("cells_{tick}.csv"), cells_csv(&nodes).as_bytes())?;
        self.folder.write(&state_name(tick), body.as_bytes())?;
        self.written.insert(tick);
        Ok(())
    }

    /// Writes the list of all.
    pub fn finish(&self) -> Result<()> {
        if self.written.is_empty() {
            return Ok(());
        }
        self.folder.write(SERIES, pvd(&self.written, self.hz).as_bytes())
    }
}
