//! The session on this board: body and output stage, played record by record and compared.

use chaincell_kernel::snapshot::SnapshotError;
use chaincell_kernel::stage::Stage;
use chaincell_kernel::trace::{Command, Decoder, Entry, RECORD_BYTES, Reader, Record};
use chaincell_kernel::{Budget, Model, Network, TickOutput, TissueMut, ToolPose, Track};
use heapless::Vec;

use super::console;
use super::snapshot::Snapshot;
use super::stream::Stop;

/// Most cells of the body, and most of them that the tool holds.
pub const CELLS: usize = 256;
pub const HELD: usize = 64;
/// The scheme that this board computes.
pub type Scheme = Track;

/// A session of one tool that holds cells, with an output stage.
pub struct Session {
    pub network: Network<'static>,
    tissue: TissueMut<'static, Scheme>,
    pub stage: Stage,
    held: Vec<u16, HELD>,
    decoder: Decoder,
    is_paused: bool,
    /// The last tick, if there was one.
    last_tick: Option<u64>,
    /// The last pose of the device.
    pub pose: ToolPose,
    /// Hashes that were compared, all equal.
    compared: u32,
}

impl Session {
    /// The session at rest; `begun` is what its trace begins with.
    pub fn begin(
        begun: &[u8],
        model: Model<'static>,
        mut tissue: TissueMut<'static, Scheme>,
    ) -> Result<Self, Stop> {
        let trace = refused(Reader::open(begun), "it begins with no header of a trace")?;
        let header = trace.header();
        if !header.is_of::<Scheme>() || header.tools.is_some() {
            return Err(Stop::Refused("the session has another scheme, or tools by their parts"));
        }
        let network = refused(header.network(model), "the session is of another model or release")?;
        let stage = refused(header.output_stage(), "the stage's settings")?;
        let stage = stage.ok_or(Stop::Refused("the session has no output stage"))?;
        let mut cells = [0; HELD];
        let held = refused(trace.contact_cells(&model, &mut cells), "it holds too many cells")?;
        let held = refused(Vec::from_slice(held), "it holds too many cells")?;
        refused(tissue.reset(&network), "the body does not fit")?;
        refused(tissue.choose_contacts(&network, &held), "the cells that it holds")?;
        let (decoder, pose) = (trace.decoder(), ToolPose::AWAY);
        let (is_paused, last_tick, compared) = (false, None, 0);
        Ok(Self { network, tissue, stage, held, decoder, is_paused, last_tick, pose, compared })
    }

    /// Goes to the state of a snapshot, which comes before the record `records` and after the tick `last_tick`, 0 for
    /// none.
    pub fn restore(
        &mut self,
        snapshot: &Snapshot<'_>,
        records: u32,
        last_tick: u64,
    ) -> Result<(), Stop> {
        let other = "the snapshot does not fit this board: it is of another release, or damaged";
        self.network = refused(Network::new(*self.network.model(), snapshot.settings), other)?;
        let tissue: Result<(), SnapshotError> = self.tissue.restore(&self.network, snapshot.tissue);
        refused(tissue, other)?;
        refused(self.stage.restore(snapshot.stage), other)?;
        self.decoder.skip_to(records);
        (self.is_paused, self.last_tick) =
            (snapshot.is_paused, Some(last_tick).filter(|&tick| tick > 0));
        Ok(())
    }

    /// Index of the record that comes next.
    pub fn next_record(&self) -> u32 {
        self.decoder.index()
    }

    /// Plays a record, whose own checksum is checked, and compares the state.
    pub fn play(&mut self, record: &[u8; RECORD_BYTES]) -> Result<(), Stop> {
        let index = self.decoder.index();
        let entry = self.decoder.next(record);
        match refused(entry, "a record is damaged, or of another session")? {
            Some(entry @ Entry::Tick(of)) => {
                self.repeat(&of);
                self.compare(index, of.tick, &entry)
            }
            Some(entry @ Entry::Command(of)) => {
                self.obey(&of.command)?;
                self.compare(index, of.tick, &entry)
            }
            _ => Err(Stop::Refused("the session has tools by their parts")),
        }
    }

    /// Repeats a tick with all that a clock decided.
    fn repeat(&mut self, of: &Record) {
        if !self.is_paused {
            if of.ramp_restarted {
                self.stage.restart_ramp();
            }
            let between =
                self.last_tick.and_then(|last| of.tick.checked_sub(last.saturating_add(1)));
            self.stage.skipped(between.filter(|&ticks| ticks < HOUR_TICKS).map_or(0, whole));
            if let Some(ticks) = of.delay_ticks {
                self.stage.delayed(ticks);
            }
            self.tick(&of.sample, Budget::again(of.sweeps));
        }
        (self.last_tick, self.pose) = (Some(of.tick), of.sample);
    }

    /// Carries out a command between two ticks.
    fn obey(&mut self, command: &Command) -> Result<(), Stop> {
        let unknown = "a command that this board does not have";
        match command {
            Command::Pause => self.is_paused = true,
            Command::Resume => self.is_paused = false,
            Command::Snapshot { .. } => {}
            Command::Reset => {
                refused(self.tissue.reset(&self.network), unknown)?;
                refused(self.tissue.choose_contacts(&self.network, &self.held), unknown)?;
                self.stage = refused(Stage::new(*self.stage.settings()), unknown)?;
            }
            Command::Sweeps(_)
            | Command::MaxForceN(_)
            | Command::MaxToolStepM(_)
            | Command::Unloading(_) => {
                let settings = command.settings(*self.network.settings());
                self.network = refused(Network::new(*self.network.model(), settings), unknown)?;
            }
            _ => return Err(Stop::Refused(unknown)),
        }
        Ok(())
    }

    fn compare(&mut self, index: u32, tick: u64, entry: &Entry) -> Result<(), Stop> {
        match entry.compare(index, self.state_hash()) {
            Ok(is_compared) => {
                self.compared += u32::from(is_compared);
                Ok(())
            }
            Err(why) => {
                console::number("differs_at", tick as u32);
                console::bits("recorded_hash", why.recorded);
                Err(Stop::Refused("a tick gives other bits here"))
            }
        }
    }

    /// One tick of the device: through the stage to the body, and back.
    pub fn tick(&mut self, device: &ToolPose, budget: Budget<'_>) -> TickOutput {
        let device = match device.is_good() {
            true => ToolPose::at(device.position_m, device.engaged.into()),
            false => *device,
        };
        self.stage.limit_force(self.network.settings().max_force_n);
        let tool = self.stage.sample(&device);
        let output = self.tissue.tick(&self.network, &[tool], budget);
        self.stage.output(&output)
    }

    /// True while the session is paused: the device gets no force.
    pub fn is_paused(&self) -> bool {
        self.is_paused
    }

    pub fn state_hash(&self) -> u64 {
        self.tissue.state_hash(self.network.model())
    }

    /// Says how far the board has followed.
    pub fn say(&self) {
        console::number("tick", self.last_tick.unwrap_or(0) as u32);
        console::number("compared", self.compared);
        console::bits("hash", self.state_hash());
    }
}

/// Distance of two ticks from which on the count has begun anew: an hour at 1 kHz.
const HOUR_TICKS: u64 = 3_600_000;

fn whole(ticks: u64) -> u16 {
    u16::try_from(ticks).unwrap_or(u16::MAX)
}

fn refused<T, E>(result: Result<T, E>, why: &'static str) -> Result<T, Stop> {
    result.map_err(|_| Stop::Refused(why))
}
