//! The mutable state: statically sized arrays, and the size-erased view that implements the work.

use nalgebra::Vector3;

use super::budget::Budget;
use super::error::{ResetError, StateError};
use super::hash::{and_pins, and_words, state_hash};
use super::sample::{TickOutput, ToolSample};
use super::settings::Network;
use crate::backend::VectorUnit;
use crate::backend::team::Team;
use crate::contact::error::ContactError;
use crate::contact::held;
use crate::contact::memory::TouchRoom;
use crate::contact::pose::ToolPose;
use crate::cut::memory::CutRoom;
use crate::energy::held::{Contact, Touched};
use crate::energy::links::number::LinkNumber;
use crate::energy::state::{TermState, TermStates};
use crate::model::image::CELLS_MAX;
use crate::model::terms::TermData;
use crate::model::{COORDINATE_MAX, Model};
use crate::number::cell::{Cell, add, from_single, output, scale};
use crate::number::kept::kept;
use crate::number::two_float::Eight;
use crate::number::{Number, float_env};
use crate::solver::awake::Awake;
use crate::solver::level::Level;
use crate::solver::scheme::{Memory, UNKNOWN};
use crate::solver::{Blocks, CellArrays, Dynamics};

kept! {
    /// Scalar state of a tissue: all of it but the arrays.
    #[derive(Debug, Clone, Copy)]
    pub struct Head<D> {
        pub(crate) dynamics: D,
        pub(crate) level: Level,
        /// Checksum of the model the arrays belong to, `None` before the first reset.
        pub(crate) model: Option<u32>,
        /// Number of chosen contact cells.
        pub(crate) chosen: usize,
        /// True if tools are chosen in place of cells.
        pub(crate) has_tools: bool,
        /// Number of basis functions under the tools, whose resistance the coarse level takes into account;
        /// `None` if that is not possible.
        pub(crate) resisted: Option<u16>,
        /// True if the tool is engaged.
        pub(crate) engaged: bool,
        /// Tool position when it engaged \[m\].
        pub(crate) tool_origin_m: [f32; 3],
        /// Displacement of the held cells, or the current into the contact cells [mean link lengths].
        pub(crate) applied: [f32; 3],
        /// Largest displacement since the tool engaged [mean link lengths].
        pub(crate) deepest: f32,
        /// Weight of the links between held and other cells.
        pub(crate) outer_weight: f32,
        /// True if the tool was released and has not engaged since.
        pub(crate) released: bool,
        /// True if the bands are closed.
        pub(crate) closed: bool,
        /// The slices that a sweep updates.
        pub(crate) awake: Awake,
        pub(crate) last_good: ToolSample,
        pub(crate) bad_ticks: u32,
        /// Force of the last tick with a sweep, which a late tick repeats \[N\].
        pub(crate) force_n: [f32; 3],
    } not stored {
        /// Energy of nodal shapes at the held cells, and the force on them, since the last tick's sweeps.
        pub(crate) touched: Option<Touched> = None,
        /// Energy that the tools gave the body in the last tick, in internal units.
        pub(crate) given: f32 = 0.0,
        /// r . z of the last accepted pass, in internal units; below 0 if it is not known.
        pub(crate) off_balance: f32 = UNKNOWN,
        /// Sweeps of the last tick with sweeps, as long as the force is that of it and the tool's motion since is
        /// known: 0 in the safe state, after a release, and if a limit shortened the motion.
        pub(crate) settled: u16 = 0,
        /// The vector unit found at the reset.
        pub(crate) vectors: Option<VectorUnit> = None,
    }
}

impl<D: Dynamics> Head<D> {
    /// At rest, without a model.
    pub const NEW: Self = Self {
        dynamics: D::REST,
        level: Level::REST,
        model: None,
        chosen: 0,
        has_tools: false,
        resisted: None,
        engaged: false,
        tool_origin_m: [0.0; 3],
        applied: [0.0; 3],
        deepest: 0.0,
        outer_weight: 0.0,
        touched: None,
        given: 0.0,
        // All bits of a new body are zero, so that a static one takes no room in flash; a reset sets it.
        off_balance: 0.0,
        settled: 0,
        released: false,
        closed: false,
        awake: Awake::NONE,
        vectors: None,
        last_good: ToolSample { position_m: Vector3::new(0.0, 0.0, 0.0), engaged: 0 },
        bad_ticks: 0,
        force_n: [0.0; 3],
    };
}

/// A body's state in statically sized memory: room for `CELLS` cells under the scheme `D`, of
/// which a tool may hold `CONTACTS`; with memory for the states that terms of the energy keep of its
/// cells, `STATES` = [`term_states`](crate::term_states)`(CELLS)` for a body of nodal shapes.
///
/// `const` constructible, so it can be a `static`. All work is done by [`TissueMut`].
///
/// ```
/// # use chaincell_kernel::*;
/// # let plane = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(plane)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// let mut tissue = Tissue::<128, Track>::new(); // up to 128 cells, 64 of them held
/// tissue.reset(&network)?;
/// tissue.choose_contacts(&network, &[47])?;
/// tissue.tick(&network, &[ToolPose::at([0.0, 0.0, 0.0].into(), 1)], Budget::All);
/// tissue.tick(&network, &[ToolPose::at([0.0, 0.0, -0.002].into(), 1)], Budget::All);
/// let place_m = tissue.view().position_m(&model, 47).ok_or("no cell")?;
/// assert!((place_m.z + 0.002).abs() < 1e-6); // [m], where the tool holds it
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Tissue<
    const CELLS: usize,
    D: Dynamics,
    const CONTACTS: usize = 64,
    const STATES: usize = 0,
> {
    head: Head<D>,
    state: [Cell<D::Number>; CELLS],
    residual: [Cell<D::Number>; CELLS],
    own: D::Arrays<CELLS>,
    room: D::Room,
    contacts: [Contact<D::Number>; CONTACTS],
    states: [TermState; STATES],
}

impl<const CELLS: usize, D: Dynamics, const CONTACTS: usize, const STATES: usize>
    Tissue<CELLS, D, CONTACTS, STATES>
{
    /// RAM of the tissue \[bytes\].
    pub const RAM_BYTES: usize = size_of::<Self>();

    /// An empty tissue; [`Self::reset`] gives it a body.
    #[must_use]
    pub const fn new() -> Self {
        const { assert!(CELLS > 0 && CELLS <= CELLS_MAX, "between 1 and 65,535 cells") };
        const { assert!(CONTACTS <= CELLS, "no more contact cells than cells") };
        Self {
            head: Head::NEW,
            state: [Cell::ZERO; CELLS],
            residual: [Cell::ZERO; CELLS],
            own: <D::Arrays<CELLS> as CellArrays<D::Number>>::ZERO,
            room: <D::Room as Blocks>::ZERO,
            contacts: [Contact::NONE; CONTACTS],
            states: [TermState::ZERO; STATES],
        }
    }

    /// The size-erased view.
    pub fn view(&mut self) -> TissueMut<'_, D> {
        TissueMut {
            head: &mut self.head,
            state: &mut self.state,
            residual: &mut self.residual,
            own: self.own.flat(),
            room: self.room.flat(),
            contacts: &mut self.contacts,
            states: TermStates::new(&mut self.states),
            touch: TouchRoom::none(),
            cut: CutRoom::none(),
            team: Team::ALONE,
        }
    }

    /// The view with memory for contact on surfaces. Every call on such a tissue must use this view, since
    /// the tools are in that memory.
    pub fn touching<'a>(&'a mut self, touch: TouchRoom<'a>) -> TissueMut<'a, D> {
        TissueMut { touch, ..self.view() }
    }

    /// See [`TissueMut::reset`].
    ///
    /// # Errors
    /// As there.
    pub fn reset(&mut self, network: &Network<'_>) -> Result<(), ResetError> {
        self.view().reset(network)
    }

    /// See [`TissueMut::choose_contacts`].
    ///
    /// # Errors
    /// As there.
    pub fn choose_contacts(
        &mut self,
        network: &Network<'_>,
        cells: &[u16],
    ) -> Result<(), ContactError> {
        self.view().choose_contacts(network, cells)
    }

    /// See [`TissueMut::tick`].
    pub fn tick(
        &mut self,
        network: &Network<'_>,
        poses: &[ToolPose],
        budget: Budget<'_>,
    ) -> TickOutput {
        self.view().tick(network, poses, budget)
    }
}

impl<const CELLS: usize, D: Dynamics, const CONTACTS: usize, const STATES: usize> Default
    for Tissue<CELLS, D, CONTACTS, STATES>
{
    fn default() -> Self {
        Self::new()
    }
}

/// A tissue of any size, over memory of the caller.
///
/// `state` and `residual` hold at least as many cells as the model, `own` [`Dynamics::ARRAYS`] times
/// as many; a reset refuses a model that does not fit. Example: [`array_bytes`](crate::array_bytes).
pub struct TissueMut<'a, D: Dynamics> {
    /// Scalar state.
    pub head: &'a mut Head<D>,
    /// State v of every cell [mean link lengths from the body's centre].
    pub state: &'a mut [Cell<D::Number>],
    /// Memory for the residual.
    pub residual: &'a mut [Cell<D::Number>],
    /// The scheme's arrays.
    pub own: &'a mut [Cell<D::Number>],
    /// Memory for the coarse level of a model that has one, see [`coarse_room`](crate::coarse_room).
    pub room: &'a mut [Eight],
    /// Memory for contact cells.
    pub contacts: &'a mut [Contact<D::Number>],
    /// States that the energy terms keep of [`Model::kept_states`] cells, [`term_states`] for that number.
    ///
    /// [`term_states`]: crate::term_states
    pub states: TermStates<'a>,
    /// Memory for tools on a model with a contact surface.
    pub touch: TouchRoom<'a>,
    /// Memory for cutting a body baked with `--cuttable`; without it such a body stays whole.
    pub cut: CutRoom<'a>,
    /// The team that runs the parts of a large body; it changes no bit.
    pub team: Team<'a>,
}

impl<D: Dynamics> TissueMut<'_, D> {
    /// Sets the body to its rest shape, releases the tool and forgets its contact cells.
    ///
    /// # Errors
    /// A model that does not fit, or arithmetic that is not IEEE 754 to nearest.
    pub fn reset(&mut self, network: &Network<'_>) -> Result<(), ResetError> {
        float_env::check().map_err(ResetError::Float)?;
        D::Number::admits(network.model()).map_err(ResetError::Range)?;
        self.check_fit(network.model())?;
        // Reset the scalars; the scheme keeps its preparation for the same model.
        let cells = network.model().cells();
        let is_same = self.head.model == Some(network.model().checksum());
        let dynamics = if is_same { self.head.dynamics.stilled() } else { D::REST };
        *self.head = Head::NEW;
        self.head.dynamics = dynamics;
        self.head.off_balance = UNKNOWN;
        self.head.model = Some(network.model().checksum());
        self.head.vectors = VectorUnit::find();
        // Reset tools and arrays.
        self.touch.leave();
        self.close_cuts(network.model());
        #[cfg(feature = "relax")]
        self.forget_strain(network.model());
        self.residual.fill(Cell::ZERO);
        self.states.reset(network.model().kept_states());
        for (v, rest) in self.state.iter_mut().zip(network.model().rest) {
            *v = Cell::at(from_single(*rest));
        }
        for array in self.own.chunks_mut(cells.max(1)).take(D::POINTS) {
            for (own, v) in array.iter_mut().zip(&*self.state) {
                *own = *v;
            }
        }
        // Terms that may have energy in the rest shape make the level unknown.
        if !network.model().others.rests(&network.model().layout()) {
            self.head.level.forget();
            self.head.awake.wake_all(network.model());
        }
        log::debug!("tissue reset");
        Ok(())
    }

    /// Sets the position of every cell, also of fixed ones [mean link lengths from the body's centre],
    /// without motion and with the tool released; the contact cells stay chosen.
    ///
    /// The certified level starts anew from the energy of that state. The terms' states are those of the rest
    /// shape: a snapshot restores them too.
    ///
    /// # Errors
    /// The first fault of the positions; the state is unchanged then.
    pub fn set_positions(
        &mut self,
        network: &Network<'_>,
        positions: &[[f32; 3]],
    ) -> Result<(), StateError> {
        // Check model, count and range.
        let model = network.model();
        if self.head.model != Some(model.checksum()) {
            return Err(StateError::Model);
        }
        let (needed, given) = (model.cells(), positions.len());
        if needed != given {
            return Err(StateError::Count { needed, given });
        }
        let range = -COORDINATE_MAX..=COORDINATE_MAX;
        if let Some(cell) = positions.iter().position(|p| !p.iter().all(|x| range.contains(x))) {
            return Err(StateError::Position(cell));
        }
        // Reset the scalars except the chosen contacts.
        let kept = *self.head;
        *self.head = Head::NEW;
        self.head.off_balance = UNKNOWN;
        self.head.vectors = kept.vectors;
        self.head.dynamics = kept.dynamics.stilled();
        self.head.model = kept.model;
        self.head.has_tools = kept.has_tools;
        self.head.chosen = kept.chosen;
        self.head.level.forget();
        self.head.awake.wake_all(model);
        self.touch.leave();
        self.states.reset(model.kept_states());
        #[cfg(feature = "relax")]
        self.forget_strain(model);
        if kept.awake.is_sleepless() {
            self.head.awake.forbid_sleep(model);
        }
        for (cell, (v, position)) in self.state.iter_mut().zip(positions).enumerate() {
            // -0.0 becomes +0.0.
            *v = Cell::at(from_single(position.map(|x| x + 0.0)));
            let own = self.own.get_mut(..D::ARRAYS * needed).unwrap_or(&mut []);
            self.head.dynamics.place(own, cell, *v, model.saturation());
        }
        Ok(())
    }

    /// Chooses the cells that the tool holds while engaged: cells of the image, ascending, none of them
    /// fixed. [`Model::cell_of_input`] finds the cell of an input id.
    ///
    /// # Errors
    /// The first cell that cannot be chosen, or a list longer than the capacity; the old choice stays.
    pub fn choose_contacts(
        &mut self,
        network: &Network<'_>,
        cells: &[u16],
    ) -> Result<(), ContactError> {
        let model = self.may_choose(network)?;
        held::check(model, cells, self.contacts.len())?;
        self.find_pieces(model, Some(cells));
        let held = self.with_body(network, |tissue, network| tissue.hold(network.model(), cells));
        if held.is_err() {
            // It holds what it held before.
            self.find_pieces(model, None);
        }
        held
    }

    /// Lets the tool hold these cells of the body as it is.
    #[cfg_attr(feature = "cut", inline(never))]
    #[cfg_attr(not(feature = "cut"), inline(always))]
    fn hold(&mut self, model: &Model<'_>, cells: &[u16]) -> Result<(), ContactError> {
        // A spare cell that is not in use cannot move.
        let bodily = model.cells() - model.spare_cells();
        let is_idle = |&cell: &u16| {
            let cell = usize::from(cell);
            cell >= bodily && model.mobility.get(cell).is_none_or(|&mobility| mobility <= 0.0)
        };
        if model.spare_cells() > 0
            && let Some(at) = cells.iter().position(is_idle)
        {
            return Err(ContactError::Fixed(at));
        }
        let (needed, room) = (D::room(model, cells.len()), self.room.len());
        if needed > room {
            return Err(ContactError::CoarseRoom { needed, room });
        }
        let is_prepared = self.head.dynamics.is_prepared(cells.len())
            && self
                .contacts
                .iter()
                .zip(cells)
                .all(|(slot, &cell)| slot.cell() == usize::from(cell));
        for (slot, &cell) in self.contacts.iter_mut().zip(cells) {
            *slot = Contact::new(cell);
        }
        self.head.chosen = cells.len();
        self.head.has_tools = false;
        self.touch.drop_pins();
        if !is_prepared {
            self.prepare(model);
        }
        Ok(())
    }

    /// Lets the scheme prepare for the chosen cells.
    fn prepare(&mut self, model: &Model<'_>) {
        let cells = model.cells();
        if let (Some(state), Some(residual), Some(own), Some(held)) = (
            self.state.get(..cells),
            self.residual.get_mut(..cells),
            self.own.get_mut(..D::ARRAYS * cells),
            self.contacts.get(..self.head.chosen),
        ) {
            let (room, vectors) = (&mut *self.room, self.head.vectors);
            let memory = Memory { state, residual, own, room, vectors };
            self.head.dynamics.hold(model, memory, held);
        }
    }

    /// Returns the model if the contacts may be chosen now.
    pub(super) fn may_choose<'n, 'm>(
        &self,
        network: &'n Network<'m>,
    ) -> Result<&'n Model<'m>, ContactError> {
        let model = network.model();
        if self.head.engaged {
            Err(ContactError::Engaged)
        } else if self.head.model != Some(model.checksum()) {
            Err(ContactError::Model)
        } else {
            Ok(model)
        }
    }

    /// Stops using the vector unit until the next reset: the bits stay the same.
    pub fn go_scalar(&mut self) {
        self.head.vectors = None;
    }

    /// Sweeps over every cell until the next reset, also at rest: the bits stay the same.
    pub fn forbid_sleep(&mut self, model: &Model<'_>) {
        self.head.awake.forbid_sleep(model);
    }

    /// Published position of a cell in the frame of the input mesh \[m\]; `None` beyond the last.
    #[must_use]
    pub fn position_m(&self, model: &Model<'_>, cell: usize) -> Option<Vector3<f32>> {
        let position = self.position(model, cell)?.map(Number::single);
        Some(add(model.centre_m(), scale(model.unit_m(), position)).into())
    }

    /// Position of a node of the embedded mesh, by input id, in the frame of the input mesh \[m\], computed
    /// from the published positions of the cells around it. `None` for a node that is left out, for an id
    /// beyond the last, and in a model without an embedded mesh. Cost: the node's weights.
    #[must_use]
    pub fn fine_position_m(&self, model: &Model<'_>, node: usize) -> Option<Vector3<f32>> {
        let at = |cell| Some(self.position(model, cell)?.map(Number::single));
        let position = model.fine_position(node, at)?;
        Some(add(model.centre_m(), scale(model.unit_m(), position)).into())
    }

    /// Published position of a cell [mean link lengths from the body's centre].
    #[must_use]
    pub fn position(&self, model: &Model<'_>, cell: usize) -> Option<[D::Number; 3]> {
        let v = self.state.get(..model.cells())?.get(cell)?;
        Some(output(v.xyz(), D::Number::from_single(model.saturation())))
    }

    /// The state hash, see [`state_hash`]; of a body with opened faces it covers the state of the cuts too, and
    /// after that the pins.
    #[must_use]
    pub fn state_hash(&self, model: &Model<'_>) -> u64 {
        let state = self.state.get(..model.cells()).unwrap_or(self.state);
        let hash = state_hash(state, self.states.cells(model.kept_states()), model.saturation());
        let hash = self.body_state(model).map_or(hash, |words| and_words(hash, words));
        self.touch.state().map_or(hash, |(state, pins)| and_pins(hash, state, pins))
    }
}
