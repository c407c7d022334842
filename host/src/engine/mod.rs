//! A tissue of any size on the heap: its memory is allocated once, then it ticks like the firmware's.

pub mod contact;
pub mod convergence;
pub mod course;
pub mod cut;
pub mod estimates;
pub mod far;
#[cfg(test)]
pub(crate) mod fixture;
pub mod flag_ticks;
pub mod mesh_error;
pub mod motion;
pub mod order;
mod pins;
pub mod place;
pub mod reach;
pub mod resting;
pub mod slow_press;
pub mod snapshot;
pub mod staged;
mod stress;
pub mod stress_limit;
pub mod stress_rows;
pub mod threads;
pub mod tissue;
pub mod tools;
mod touch;
pub mod untouched;

use std::cell::OnceCell;

use chaincell_kernel::trace::Command;
use chaincell_kernel::{
    Budget, Cell, Contact as Slot, ContactError, Dynamics, Euler, Head, I8F24, Model, Network,
    Number, Predict, ResetError, Rkl2, Settings, Stress, Team, TermState, TermStates, TickOutput,
    TissueMut, ToolPart, ToolPose, Track, Workers, term_states,
};

pub use chaincell_kernel::{Arithmetic, Scheme};
pub use cut::CutCells;

use crate::error::{Error, Result};
use cut::{AnyCut, CutMemory};
use pins::AnyPins;
use snapshot::AnySaved;
use tissue::{Node, Refusal};
use tools::AnyTools;
use touch::TouchMemory;
pub use touch::{Contact, only_sphere};

/// Fewest sweeps of a tick for links under a moving tool, if a press folds them: on a generated organ of
/// 1,000 cells 9 of 10 forces are within 53 % of those of 64 sweeps at one sweep, within 13 % at four.
const LINKS_LEAST_SWEEPS: u16 = 4;

/// Arrays of a tissue under the scheme `D`.
struct Memory<D: Dynamics> {
    head: Head<D>,
    state: Vec<Cell<D::Number>>,
    residual: Vec<Cell<D::Number>>,
    own: Vec<Cell<D::Number>>,
    room: Vec<[f32; 8]>,
    contacts: Vec<Slot<D::Number>>,
    states: Vec<TermState>,
    touch: TouchMemory,
    cut: CutMemory,
    workers: Option<Box<dyn Workers + Send>>,
}

impl<D: Dynamics> Memory<D> {
    fn new(model: &Model<'_>, contact: &Contact) -> Self {
        let (cells, slots) = (model.cells(), contact.slots());
        let room = match contact {
            Contact::Cells(_) => D::room_blocks(model, slots),
            Contact::Tools { .. } => D::tool_blocks(model),
        };
        Self {
            head: Head::NEW,
            state: vec![Cell::ZERO; cells],
            residual: vec![Cell::ZERO; cells],
            own: vec![Cell::ZERO; D::ARRAYS * cells],
            room: vec![[0.0; 8]; room],
            contacts: vec![Slot::NONE; slots],
            states: vec![TermState::ZERO; term_states(model.kept_states())],
            touch: TouchMemory::for_contact(model, contact),
            cut: CutMemory::for_model(model),
            workers: None,
        }
    }

    fn view(&mut self) -> TissueMut<'_, D> {
        TissueMut {
            head: &mut self.head,
            state: &mut self.state,
            residual: &mut self.residual,
            own: &mut self.own,
            room: &mut self.room,
            contacts: &mut self.contacts,
            states: TermStates::new(&mut self.states),
            touch: self.touch.room(),
            cut: self.cut.room(),
            team: self.workers.as_deref().map_or(Team::ALONE, |workers| Team::of(workers)),
        }
    }
}

/// A tissue of any scheme.
trait AnyTissue: AnyTools + AnyPins + AnyCut + AnySaved {
    fn reset(&mut self, network: &Network<'_>) -> Result<()>;
    fn choose(
        &mut self,
        network: &Network<'_>,
        contact: &Contact,
    ) -> std::result::Result<(), ContactError>;
    fn tick(&mut self, network: &Network<'_>, poses: &[ToolPose], budget: Budget<'_>)
    -> TickOutput;
    fn is_anytime(&self) -> bool;
    fn state_hash(&mut self, model: &Model<'_>) -> u64;
    fn position(&mut self, model: &Model<'_>, cell: usize) -> [f64; 3];
    fn stress(&mut self, model: &Model<'_>, cell: usize, means_pa: &mut [f32]) -> Option<Stress>;
    fn nodes(&mut self, model: &Model<'_>, shown: &[u32], to: &mut [Node]);
    fn set_positions(&mut self, network: &Network<'_>, positions: &[[f32; 3]]) -> Result<()>;
    fn go_scalar(&mut self);
    fn share(&mut self, workers: Option<Box<dyn Workers + Send>>);
    fn forbid_sleep(&mut self, model: &Model<'_>);
    fn ram_bytes(&self) -> usize;
}

impl<D: Dynamics> AnyTissue for Memory<D> {
    fn reset(&mut self, network: &Network<'_>) -> Result<()> {
        self.view().reset(network).map_err(|why| match why {
            ResetError::Range(why) => Error::input(format!("`precision`: {why}")),
            ResetError::Shapes => Error::input(format!("`scheme`, `precision`: {why}")),
            other => Error::check(other),
        })
    }

    fn choose(
        &mut self,
        network: &Network<'_>,
        contact: &Contact,
    ) -> std::result::Result<(), ContactError> {
        match contact {
            Contact::Cells(cells) => self.view().choose_contacts(network, cells),
            Contact::Tools { tools, friction } => {
                let tools: Vec<&[ToolPart]> = tools.iter().map(Vec::as_slice).collect();
                self.view().choose_tools(network, &tools, *friction)
            }
        }
    }

    fn tick(
        &mut self,
        network: &Network<'_>,
        poses: &[ToolPose],
        budget: Budget<'_>,
    ) -> TickOutput {
        self.view().tick(network, poses, budget)
    }

    fn is_anytime(&self) -> bool {
        D::IS_ANYTIME
    }

    fn state_hash(&mut self, model: &Model<'_>) -> u64 {
        self.view().state_hash(model)
    }

    fn position(&mut self, model: &Model<'_>, cell: usize) -> [f64; 3] {
        self.view().position(model, cell).map_or([0.0; 3], |position| position.map(Number::double))
    }

    fn stress(&mut self, model: &Model<'_>, cell: usize, means_pa: &mut [f32]) -> Option<Stress> {
        self.view().stress_with(model, cell, means_pa)
    }

    fn nodes(&mut self, model: &Model<'_>, shown: &[u32], to: &mut [Node]) {
        let ids = model.input_id();
        let has_fine = model.fine_nodes() > 0;
        for (place, &at) in to.iter_mut().zip(shown) {
            let index = at as usize;
            *place = if has_fine {
                let position = self.view().fine_position_m(model, index).unwrap_or_default();
                Node { id: at, position_m: position.into() }
            } else {
                let position = to_m(model, self.position(model, index));
                let id = ids.get(index).copied().unwrap_or(u32::MAX);
                Node { id, position_m: position.map(|x| x as f32) }
            };
        }
    }

    fn set_positions(&mut self, network: &Network<'_>, positions: &[[f32; 3]]) -> Result<()> {
        self.view().set_positions(network, positions).map_err(Error::check)
    }

    fn go_scalar(&mut self) {
        self.view().go_scalar();
    }

    fn share(&mut self, workers: Option<Box<dyn Workers + Send>>) {
        self.workers = workers;
    }

    fn forbid_sleep(&mut self, model: &Model<'_>) {
        self.view().forbid_sleep(model);
    }

    fn ram_bytes(&self) -> usize {
        let (cells, contacts, room) = (self.state.len(), self.contacts.len(), self.room.len());
        let arrays = chaincell_kernel::array_bytes::<D>(cells, contacts, room);
        let states = self.states.len() * size_of::<TermState>();
        size_of::<Head<D>>() + arrays + states + self.touch.ram_bytes() + self.cut.ram_bytes()
    }
}

/// A network with its tissue.
pub struct Engine<'m> {
    network: Network<'m>,
    tissue: Box<dyn AnyTissue + Send>,
    contact: Contact,
    scheme: Scheme,
    /// See [`shown`]; computed at the first use.
    shown: OnceCell<Vec<u32>>,
    /// The place of each cell in `shown`; computed at the first use.
    rows: OnceCell<Vec<u32>>,
}

impl<'m> Engine<'m> {
    /// A body at rest with the contact cells `contacts` (ascending, none fixed), in `f32`.
    ///
    /// # Errors
    /// A scheme that the model does not support; contact cells that the kernel refuses, reported by their
    /// input ids.
    pub fn new(network: Network<'m>, scheme: Scheme, contacts: &[u16]) -> Result<Self> {
        Self::in_numbers(network, scheme, Arithmetic::F32, contacts)
    }

    /// Like [`Self::new`], with a number type for cells and links.
    ///
    /// # Errors
    /// As there; a scheme that does not support these numbers; a model beyond their range.
    pub fn in_numbers(
        network: Network<'m>,
        scheme: Scheme,
        numbers: Arithmetic,
        contacts: &[u16],
    ) -> Result<Self> {
        Self::with_contact(network, scheme, numbers, Contact::Cells(contacts.to_vec()))
    }

    /// Like [`Self::in_numbers`], with any contact.
    ///
    /// # Errors
    /// As there; tools that the kernel refuses.
    pub fn with_contact(
        network: Network<'m>,
        scheme: Scheme,
        numbers: Arithmetic,
        contact: Contact,
    ) -> Result<Self> {
        let (model, held) = (network.model(), &contact);
        let tissue: Box<dyn AnyTissue + Send> = match (scheme, numbers) {
            (Scheme::Euler, Arithmetic::F32) => Box::new(Memory::<Euler>::new(model, held)),
            (Scheme::Euler, Arithmetic::Fixed) => {
                Box::new(Memory::<Euler<I8F24>>::new(model, held))
            }
            (Scheme::Track, Arithmetic::F32) => Box::new(Memory::<Track>::new(model, held)),
            (Scheme::Track, Arithmetic::Fixed) => {
                Box::new(Memory::<Track<0, I8F24>>::new(model, held))
            }
            (Scheme::Predict, Arithmetic::F32) => Box::new(Memory::<Predict>::new(model, held)),
            (_, Arithmetic::Fixed) => {
                return Err(Error::input("`precision` fixed: for `scheme` euler and track only"));
            }
            (Scheme::Rkl2, Arithmetic::F32) => Box::new(Memory::<Rkl2>::new(model, held)),
        };
        let mut engine = Self {
            network,
            tissue,
            contact,
            scheme,
            shown: OnceCell::new(),
            rows: OnceCell::new(),
        };
        engine.reset()?;
        Ok(engine)
    }

    /// Resets the body to rest and releases the tool.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn reset(&mut self) -> Result<()> {
        self.tissue.reset(&self.network)?;
        self.tissue.choose(&self.network, &self.contact).map_err(|why| {
            let name = |at: usize| {
                let cell = self.contacts().get(at).copied().unwrap_or(u16::MAX);
                self.network.model().input_id().get(usize::from(cell)).copied()
            };
            match why {
                ContactError::Fixed(at) => Error::input(format!(
                    "`contact`: node {} is fixed and cannot be held by the tool",
                    name(at).unwrap_or_default()
                )),
                other => Error::input(format!("`{}`: {other}", self.contact.option())),
            }
        })
    }

    /// Changes the settings from the next tick on, and keeps the state.
    ///
    /// # Errors
    /// Settings that do not fit the model.
    pub fn choose(&mut self, settings: Settings) -> Result<()> {
        self.network = Network::new(*self.network.model(), settings).map_err(Error::check)?;
        Ok(())
    }

    /// One tick of one tool with all sweeps, see [`Self::tick_by`].
    pub fn tick(&mut self, pose: &ToolPose) -> TickOutput {
        self.tick_by(core::slice::from_ref(pose), Budget::All)
    }

    /// One tick with a pose for each tool and this budget, see [`TissueMut::tick`].
    pub fn tick_by(&mut self, poses: &[ToolPose], budget: Budget<'_>) -> TickOutput {
        self.tissue.tick(&self.network, poses, budget)
    }

    /// The scheme of the engine.
    #[must_use]
    pub fn scheme(&self) -> Scheme {
        self.scheme
    }

    /// Shares the sweeps of `track` and `predict` with these workers from now on, such as
    /// [`Threads`](threads::Threads), on a body of several [`parts`](chaincell_kernel::parts); `None` for the
    /// ticking thread only. The bits are the same.
    pub fn share(&mut self, workers: Option<Box<dyn Workers + Send>>) {
        self.tissue.share(workers);
    }

    /// Returns true if a tick may end after any sweep, see [`Dynamics::IS_ANYTIME`].
    #[must_use]
    pub fn is_anytime(&self) -> bool {
        self.tissue.is_anytime()
    }

    /// Fewest sweeps of a tick for a usable force of this contact: four for links under a moving tool, which
    /// with fewer sweeps tear into another equilibrium, or all if the settings have fewer; otherwise one.
    #[must_use]
    pub fn least_sweeps(&self) -> u16 {
        let is_moving = !matches!(self.contact, Contact::Cells(_));
        let is_of_links = self.network.model().kept_states() == 0;
        let most = self.network.settings().sweeps;
        if is_moving && is_of_links { most.min(LINKS_LEAST_SWEEPS) } else { 1 }
    }

    /// Executes a command other than pause and resume, which the loop handles. Allocates nothing. A reset
    /// costs as much as choosing the contact cells, several ticks for models with a coarse level.
    ///
    /// # Errors
    /// The reason for the refusal.
    pub fn obey(&mut self, command: &Command) -> std::result::Result<(), Refusal> {
        match command {
            Command::Pause | Command::Resume => Err(Refusal::Unsupported),
            Command::Reset => self.reset().map_err(|_| Refusal::Reset),
            Command::Grip { .. } | Command::LetGo { .. } => self.obey_hold(command),
            Command::Pin { .. } | Command::PinAt { .. } | Command::Unpin { .. } => {
                self.obey_pin(command)
            }
            // Under this scheme sweeps and the time per tick depend on each other.
            Command::Sweeps(_) if self.scheme.goes_by_tick() => Err(Refusal::Fixed),
            _ => {
                let settings = command.settings(*self.network.settings());
                let network = Network::new(*self.network.model(), settings);
                self.network = network.map_err(|_| Refusal::Value)?;
                Ok(())
            }
        }
    }

    /// Writes published positions by ascending input id, as many as fit. Allocates nothing after a call of
    /// [`Self::node_count`].
    pub fn read_nodes(&mut self, to: &mut [Node]) {
        let model = self.network.model();
        self.tissue.nodes(model, self.shown.get_or_init(|| shown(model)), to);
    }

    /// Number of nodes for which [`Self::read_nodes`] has positions.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.shown.get_or_init(|| shown(self.network.model())).len()
    }

    /// The state hash, see [`chaincell_kernel::tick::hash`].
    pub fn state_hash(&mut self) -> u64 {
        self.tissue.state_hash(self.network.model())
    }

    /// Sets every cell to a position [mean link lengths from the body's centre], in the model's order,
    /// without motion and with the tool released.
    ///
    /// # Errors
    /// Positions that are too few, not finite or too large.
    pub fn set_positions(&mut self, positions: &[[f32; 3]]) -> Result<()> {
        self.tissue.set_positions(&self.network, positions)
    }

    /// Stops using the vector unit until the next reset: the bits stay the same.
    pub fn go_scalar(&mut self) {
        self.tissue.go_scalar();
    }

    /// Sweeps over every cell until the next reset, also at rest: the bits stay the same.
    pub fn forbid_sleep(&mut self) {
        self.tissue.forbid_sleep(self.network.model());
    }

    /// Model and settings.
    #[must_use]
    pub fn network(&self) -> &Network<'m> {
        &self.network
    }

    /// The chosen contact cells; none with tools.
    #[must_use]
    pub fn contacts(&self) -> &[u16] {
        match &self.contact {
            Contact::Cells(cells) => cells,
            _ => &[],
        }
    }

    /// The tool's contact.
    #[must_use]
    pub fn contact(&self) -> &Contact {
        &self.contact
    }

    /// RAM of the tissue \[bytes\].
    #[must_use]
    pub fn ram_bytes(&self) -> usize {
        self.tissue.ram_bytes()
    }

    /// Every node of the input with its published position: the cells in the model's order, or the nodes of
    /// the embedded mesh in the input's order.
    pub fn nodes(&mut self) -> Nodes {
        let model = *self.network.model();
        if model.fine_nodes() == 0 {
            let ids = model.input_id().to_vec();
            let mut positions_m = self.positions_m();
            positions_m.truncate(ids.len());
            return Nodes { ids, positions_m };
        }
        let cells: Vec<[f32; 3]> =
            self.positions().into_iter().map(|position| position.map(|x| x as f32)).collect();
        let (ids, positions_m) = (0..model.fine_nodes())
            .filter_map(|node| {
                let place = model.fine_position(node, |cell| cells.get(cell).copied())?;
                Some((node as u32, to_m(&model, place.map(f64::from))))
            })
            .unzip();
        Nodes { ids, positions_m }
    }

    /// Published positions of all cells, the spare ones last [mean link lengths from the body's centre].
    pub fn positions(&mut self) -> Vec<[f64; 3]> {
        let model = self.network.model();
        (0..model.cells()).map(|cell| self.tissue.position(model, cell)).collect()
    }

    /// Published positions of all cells, the spare ones last \[m\].
    pub fn positions_m(&mut self) -> Vec<[f64; 3]> {
        let positions = self.positions();
        positions.into_iter().map(|position| to_m(self.network.model(), position)).collect()
    }
}

/// Indices by ascending input id: all cells, or the nodes of the embedded mesh.
fn shown(model: &Model<'_>) -> Vec<u32> {
    if model.fine_nodes() > 0 {
        let embedded = |&node: &u32| model.fine_rest(node as usize).is_some();
        return (0..model.fine_nodes() as u32).filter(embedded).collect();
    }
    let ids = model.input_id();
    let mut cells: Vec<u32> = (0..model.body_cells() as u32).collect();
    cells.sort_unstable_by_key(|&cell| ids.get(cell as usize));
    cells
}

/// Nodes of the input with their positions.
#[derive(Debug, Clone, PartialEq)]
pub struct Nodes {
    /// Input ids.
    pub ids: Vec<u32>,
    /// Positions \[m\], in the order of the ids.
    pub positions_m: Vec<[f64; 3]>,
}

/// Rest position of a cell in the frame of the input mesh \[m\].
#[must_use]
pub fn rest_m(model: &Model<'_>, cell: usize) -> [f64; 3] {
    to_m(model, model.rest_position(cell).map(f64::from))
}

/// Converts an internal position to the frame of the input mesh \[m\].
#[must_use]
pub fn to_m(model: &Model<'_>, position: [f64; 3]) -> [f64; 3] {
    let centre = model.centre_m();
    std::array::from_fn(|axis| f64::from(centre[axis]) + position[axis] * f64::from(model.unit_m()))
}
