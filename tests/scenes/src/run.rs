//! Plays a scene tick by tick, and two runs against each other.

use chaincell_kernel::Cell;
use chaincell_kernel::ContactError;
use chaincell_kernel::snapshot::SnapshotError;
use chaincell_kernel::trace::{Header, Record, Writer};
use chaincell_kernel::{
    Budget, CutOutput, Dynamics, Model, ModelError, Network, Number, ResetError, SettingsError,
    TickOutput, TissueMut, ToolPose,
};

use crate::{Digest, Scene, TOOLS_MAX, Tools};

/// Most cells that a scene's tool holds.
const HELD_MAX: usize = 16;
/// Of a stroke's ticks those in which two tools grip what they touch, and let go.
const GRIP: [u32; 2] = [20, 30];
const STROKE: u32 = 50;
/// Ticks in which a grip fades.
const FADE: u16 = 3;
/// Stands for the input id of a cell that has none.
pub const NO_ID: u32 = u32::MAX;
/// How far a fault moves a cell [mean link lengths].
pub const FAULT: f32 = 1.0 / 1024.0;

/// Why a scene cannot be played.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RunError {
    /// The image is refused.
    Model(ModelError),
    /// The settings are refused.
    Settings(SettingsError),
    /// The tissue does not fit the body: take the scene's `Body`.
    Reset(ResetError),
    /// The held cells or the tools are refused.
    Contacts(ContactError),
    /// This input id is no cell of the body, or the scene holds too many.
    Held(u32),
}

impl core::fmt::Display for RunError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Model(why) => write!(f, "the scene's image: {why}"),
            Self::Settings(why) => write!(f, "the scene's settings: {why}"),
            Self::Reset(why) => write!(f, "{why}; take the scene's own Body"),
            Self::Contacts(why) => write!(f, "the scene's held cells or tools: {why}"),
            Self::Held(id) => write!(f, "node {id} is no cell, or beyond {HELD_MAX} held cells"),
        }
    }
}

impl core::error::Error for RunError {}

/// A scene under way in a tissue that somebody else owns.
pub struct Run<'t, D: Dynamics> {
    scene: &'static Scene,
    pub(crate) network: Network<'static>,
    pub(crate) tissue: TissueMut<'t, D>,
    digest: Digest,
    next: u32,
    fault: Option<(u32, usize)>,
}

impl<'t, D: Dynamics> Run<'t, D> {
    /// The scene's body at rest in `tissue`, its cells chosen.
    ///
    /// # Errors
    /// A tissue that does not fit the scene; anything else means a damaged program.
    pub fn new(scene: &'static Scene, mut tissue: TissueMut<'t, D>) -> Result<Self, RunError> {
        let model = Model::from_bytes(scene.image).map_err(RunError::Model)?;
        let network = Network::new(model, (scene.settings)(&model)).map_err(RunError::Settings)?;
        tissue.reset(&network).map_err(RunError::Reset)?;
        if let Some(Tools { parts, friction, .. }) = scene.tools() {
            tissue.choose_tools(&network, parts, *friction).map_err(RunError::Contacts)?;
            return Ok(Self {
                scene,
                network,
                tissue,
                digest: Digest::new(),
                next: 0,
                fault: None,
            });
        }
        let mut cells = [0; HELD_MAX];
        let held = cells.get_mut(..scene.held.len()).ok_or(RunError::Held(u32::MAX))?;
        for (cell, &id) in held.iter_mut().zip(scene.held) {
            *cell = model.cell_of_input(id).ok_or(RunError::Held(id))?;
        }
        held.sort_unstable();
        tissue.choose_contacts(&network, held).map_err(RunError::Contacts)?;
        Ok(Self { scene, network, tissue, digest: Digest::new(), next: 0, fault: None })
    }

    /// Leaves the vector unit alone: the bits stay the same.
    pub fn go_scalar(&mut self) {
        self.tissue.go_scalar();
    }

    /// No cell sleeps from here on: the bits stay the same.
    pub fn forbid_sleep(&mut self) {
        self.tissue.forbid_sleep(self.network.model());
    }

    /// Bytes of a snapshot of the tissue as it is now.
    ///
    /// # Errors
    /// None of a run under way.
    pub fn snapshot_bytes(&mut self) -> Result<usize, SnapshotError> {
        self.tissue.snapshot_bytes(&self.network)
    }

    /// Saves the tissue; gives the number of bytes.
    ///
    /// # Errors
    /// A buffer that is too short.
    pub fn save(&mut self, bytes: &mut [u8]) -> Result<usize, SnapshotError> {
        self.tissue.save(&self.network, bytes)
    }

    /// Forgets the tissue's state and goes on from a snapshot.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), SnapshotError> {
        self.tissue.reset(&self.network).map_err(SnapshotError::Reset)?;
        self.tissue.restore(&self.network, bytes)
    }

    /// Samples that a tool grips.
    pub fn gripped(&mut self, tool: usize) -> usize {
        self.tissue.gripped(&self.network, tool)
    }

    /// State of the cuts.
    pub fn cuts(&mut self) -> CutOutput {
        self.tissue.cut_output(&self.network)
    }

    /// Plays `ticks` ticks, each told to `after` with its state hash.
    pub fn play(&mut self, ticks: u32, mut after: impl FnMut(u32, u64)) {
        for _ in 0..ticks {
            let tick = self.next;
            let (_, state_hash) = self.tick();
            after(tick, state_hash);
        }
    }

    /// Plays one tick: its answer and the hash of the state after it.
    pub fn tick(&mut self) -> (TickOutput, u64) {
        self.tick_with(&self.scene.sample(self.next))
    }

    /// Plays one tick with a sample that came from elsewhere: from an interrupt, say.
    pub fn tick_with(&mut self, sample: &ToolPose) -> (TickOutput, u64) {
        let output = match self.scene.tools() {
            Some(tools) if tools.count() > 1 => self.tick_tools(tools, sample),
            _ => self.tissue.tick(&self.network, &[*sample], Budget::All),
        };
        if let Some((_, cell)) = self.fault.take_if(|(tick, _)| *tick == self.next)
            && let Some(v) = self.tissue.state.get_mut(cell)
        {
            let [x, y, z] = v.xyz();
            *v = Cell::at([x.plus(Number::from_single(FAULT)), y, z]);
        }
        let state_hash = self.tissue.state_hash(self.network.model());
        self.digest.absorb(&output, state_hash);
        self.next += 1;
        (output, state_hash)
    }

    /// Plays one tick of several tools.
    fn tick_tools(&mut self, tools: &Tools, sample: &ToolPose) -> TickOutput {
        let [grip, let_go] = GRIP.map(|at| self.next % STROKE == at);
        for tool in (0..tools.count()).filter(|_| grip) {
            self.tissue.grip(&self.network, tool);
        }
        for tool in (0..tools.count()).filter(|_| let_go) {
            self.tissue.let_go(tool, FADE);
        }
        let poses: [ToolPose; TOOLS_MAX] = tools.poses(sample);
        self.tissue.tick(&self.network, &poses, Budget::All)
    }

    /// Begins the trace of this run: writes its header to the front of `to` and gives its length.
    /// The records are those of [`Self::record`]. `None` where `to` is too short, and for a scene
    /// of tools, whose poses take records of their own.
    #[must_use]
    pub fn begin_trace(&self, to: &mut [u8]) -> Option<(Writer, usize)> {
        if self.scene.tools().is_some() {
            return None;
        }
        let model = self.network.model();
        let mut ids = [0; HELD_MAX];
        let ids = ids.get_mut(..self.scene.held.len())?;
        ids.copy_from_slice(self.scene.held);
        ids.sort_unstable_by_key(|&id| model.cell_of_input(id));
        let header = Header::of::<D>(&self.network)?;
        Writer::begin(&header, ids, to)
    }

    /// Plays one tick and gives its record.
    pub fn record(&mut self) -> Record {
        let tick = self.next;
        let (_, state_hash) = self.tick();
        let sample = self.scene.sample(tick);
        Record { state_hash: Some(state_hash), ..Record::of(tick.into(), sample) }
    }

    /// Digest of the ticks so far.
    #[must_use]
    pub fn digest(&self) -> u64 {
        self.digest.value()
    }

    /// Bytes in the digest.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.digest.bytes()
    }
}

/// A scene under way, whatever its scheme.
pub trait Stepper {
    /// The scene.
    fn scene(&self) -> &'static Scene;
    /// Ticks played so far.
    fn ticks(&self) -> u32;
    /// Plays one tick and gives the hash of the state after it.
    fn step(&mut self) -> u64;
    /// Digest of the ticks so far.
    fn digest(&self) -> u64;
    /// Bytes in the digest.
    fn bytes(&self) -> u64;
    /// Bits of a cell's published position; `None` beyond the last.
    fn cell_bits(&self, cell: usize) -> Option<[u64; 3]>;
    /// Input id of a cell; `None` beyond the last.
    fn input_id(&self, cell: usize) -> Option<u32>;
    /// Leaves the vector unit alone: the bits stay the same.
    fn go_scalar(&mut self);
    /// Moves a cell's x by [`FAULT`] behind the sweeps of `tick`, to see that comparisons find it.
    fn fault(&mut self, tick: u32, cell: usize);
}

impl<D: Dynamics> Stepper for Run<'_, D> {
    fn scene(&self) -> &'static Scene {
        self.scene
    }

    fn ticks(&self) -> u32 {
        self.next
    }

    fn step(&mut self) -> u64 {
        self.tick().1
    }

    fn digest(&self) -> u64 {
        Run::digest(self)
    }

    fn bytes(&self) -> u64 {
        Run::bytes(self)
    }

    fn cell_bits(&self, cell: usize) -> Option<[u64; 3]> {
        let position = self.tissue.position(self.network.model(), cell)?;
        Some(position.map(|x| u64::from(x.word())))
    }

    fn input_id(&self, cell: usize) -> Option<u32> {
        self.network.model().input_id().get(cell).copied()
    }

    fn go_scalar(&mut self) {
        Run::go_scalar(self);
    }

    fn fault(&mut self, tick: u32, cell: usize) {
        self.fault = Some((tick, cell));
    }
}

/// What [`stage`](crate::stage) calls with a scene and a tissue for it.
pub trait Act {
    /// What comes out.
    type Output;
    /// Does it.
    fn act<D: Dynamics>(self, scene: &'static Scene, tissue: TissueMut<'_, D>) -> Self::Output;
}

/// Where two runs part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Difference {
    /// First tick that differs.
    pub tick: u32,
    /// First cell that differs after it, with its input id ([`NO_ID`] for a copy of a split cell) and its bits
    /// in both runs; `None` where the states are the same, and force, energy, contacts or flags differ.
    pub cell: Option<(usize, u32, [[u64; 3]; 2])>,
}

impl core::fmt::Display for Difference {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "first difference at tick {}: ", self.tick)?;
        match self.cell {
            Some((cell, id, [one, other])) => {
                write!(f, "cell {cell} (node {id}) is {one:08x?} and {other:08x?}")
            }
            None => f.write_str("the states agree; force, energy, contacts or flags differ"),
        }
    }
}

/// Plays both runs for `ticks` ticks, or to the first that differs. They must stand at the same
/// tick of the same scene.
pub fn first_difference(
    one: &mut dyn Stepper,
    other: &mut dyn Stepper,
    ticks: u32,
) -> Option<Difference> {
    for _ in 0..ticks {
        let tick = one.ticks();
        if one.step() != other.step() || one.digest() != other.digest() {
            let cell = (0..one.scene().cells).find_map(|cell| {
                let bits = [one.cell_bits(cell)?, other.cell_bits(cell)?];
                let id = one.input_id(cell).unwrap_or(NO_ID);
                (bits[0] != bits[1]).then_some((cell, id, bits))
            });
            return Some(Difference { tick, cell });
        }
    }
    None
}
