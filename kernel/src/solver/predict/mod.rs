//! `predict`: [`track`](super::Track) with a precomputed response of the body to a motion of the held cells.
//!
//! If a tool moves the cells that it holds by dp, the equilibrium of a linear body moves by
//!
//! ```text
//! sum over a of dp_a phi_a,   K phi_a = 0 at the free cells, phi_a = e_a at the held ones
//! ```
//!
//! K is the second derivative of the energy. The fields phi_x, phi_y and phi_z are solved for when the cells
//! are chosen, for the rest shape with all links taut ([`response`]). When the tool moves, the points of the
//! next pass and of the last one move along; the published point does not. After a discarded pass both start
//! at the published point, or the body would lag at every move. The guard judges the pass like any other, so
//! a wrong prediction, in a body that has rotated or folded, costs at most a discarded pass, and the
//! certificate is that of `track`.
//!
//! One sweep per tick then has to correct only the body's deviation from the fields.
//!
//! **Under tools on a surface** there are no fields, since the contact changes as the tool moves. If tools
//! continue by a share of their last motion, the points continue by that share of their motion in the last
//! ticks ([`momentum`]): a body that follows a steady tool is extrapolated to its next position. Then the
//! cells under the tools are brought into balance with their neighbours ([`near`]), which covers what no
//! extrapolation foresees: new contacts, and a tool that turns back.
//!
//! There are no fields, and the scheme is `track` bit for bit, under a current, and on a body with slack (alpha above
//! 0): there the response is local and changes with every link that becomes taut. A prediction moves every free cell,
//! so it wakes the whole body.
//!
//! Cost: three more arrays of cells than `track`; nine multiplications per cell in a tick in which the tool
//! moves. No sweep, no inner product. Under tools that move, at most two thirds of a pass more. Choosing
//! cells costs up to [`response::ITERATIONS_MAX`] linear link passes for each field, outside the tick (80 ms
//! for 5,773 cells on a workstation), and nothing if they are the cells chosen last; it drops the momentum of
//! a body that still moves.

mod fields;
mod momentum;
mod near;
mod response;

use super::Dynamics;
use super::scheme::{Body, Memory, Scheme};
use super::track::Track;
use crate::energy::held::Contact;
use crate::energy::surface::IS_BUILT;
use crate::model::Model;
use crate::number::cell::{Cell, add};
use crate::number::kept::kept;
use crate::number::two_float::Eight;
use momentum::Going;

/// Arrays of `track`, then one for each field.
const TRACK: usize = <Track as Dynamics>::ARRAYS;
const ARRAYS: usize = TRACK + 3;

kept! {
    /// State of the scheme; `ROOM` as for [`Track`].
    ///
    /// ```
    /// # use chaincell_kernel::{Budget, Dynamics, Model, Network, Settings, Tissue, ToolPose, include_model};
    /// use chaincell_kernel::{Predict, Track};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    ///
    /// /// Force of one sweep after the tool went 1 mm in a tick [N].
    /// fn force_n<D: Dynamics>(model: Model) -> Result<f32, Box<dyn std::error::Error>> {
    ///     let network = Network::new(model, Settings { sweeps: 1, ..Settings::for_model(&model) })?;
    ///     let mut tissue = Tissue::<128, D>::new();
    ///     tissue.reset(&network)?;
    ///     tissue.choose_contacts(&network, &[47])?; // `predict` solves for the answer here
    ///     tissue.tick(&network, &[ToolPose::at([0.0; 3].into(), 1)], Budget::All);
    ///     let pose = ToolPose::at([0.001, 0.0, 0.0].into(), 1);
    ///     Ok(tissue.tick(&network, &[pose], Budget::All).force_n.x)
    /// }
    /// let (predict_n, track_n) = (force_n::<Predict>(model)?, force_n::<Track>(model)?);
    /// assert!((predict_n + 0.0439).abs() < 2e-4); // [N], the force after any number of sweeps
    /// assert!(track_n < -0.07); // a body that has not settled resists more
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Predict<const ROOM: usize = 0> {
        track: Track<ROOM>,
        /// Number of cells chosen last; `None` with tools, and before any choice.
        prepared: Option<usize>,
        /// True if the fields are those of the chosen cells.
        pub(crate) is_known: bool,
        /// Displacement of the held cells since the last pass. The fields are applied before the next pass, so a
        /// tick without a pass does not pay for them.
        ahead: [f32; 3],
        /// Share of the body's last motion by which it continues if tools moved; `None` if none did.
        goes_on: Option<f32>,
        /// True if the first field holds the points of the last tick, and the second one their extrapolation.
        is_marked: bool,
        /// Sweeps since the last tick started.
        sweeps: u16,
    }
}

impl<const ROOM: usize> Dynamics for Predict<ROOM> {
    const NAME: &'static str = "predict";
    const REST: Self = Self {
        track: Track::REST,
        prepared: None,
        is_known: false,
        ahead: [0.0; 3],
        goes_on: None,
        is_marked: false,
        sweeps: 0,
    };
    const IS_ANYTIME: bool = true;
    const TAKES_SHAPES: bool = true;
    const TAKES_SURFACES: bool = true;
    const TELLS_ERROR: bool = true;
    const ARRAYS: usize = ARRAYS;
    const POINTS: usize = TRACK;
    type Arrays<const CELLS: usize> = [[Cell; CELLS]; ARRAYS];
    type Room = [Eight; ROOM];

    fn stilled(self) -> Self {
        let track = self.track.stilled();
        Self { track, ahead: [0.0; 3], goes_on: None, is_marked: false, sweeps: 0, ..self }
    }
}

impl<const ROOM: usize> Scheme for Predict<ROOM> {
    type Number = f32;

    /// Moves the points of the sweeps along the fields, and leaves the arrays of `track` in `body`.
    #[allow(private_interfaces)]
    fn begin(&mut self, body: &mut Body<'_, '_>) {
        let (cells, own) = (body.state.len(), core::mem::take(&mut body.own));
        let way = core::mem::take(&mut self.ahead);
        let follows = way != [0.0; 3] && self.is_known;
        // Held cells: apply the fields.
        if follows && !self.track.is_going() && !body.level.is_forgotten() {
            self.track.go_from(body.state, own);
        }
        let follows = follows && self.track.is_going();
        if follows && fields::follow(body.terms, own, body.awake, way) {
            // Beyond the range: the next pass starts at the published point.
            self.track.interrupt();
        }
        // Tools on a surface: extrapolate the body's motion.
        let goes_on = core::mem::take(&mut self.goes_on).filter(|_| IS_BUILT);
        if let Some(share) = goes_on {
            let going = Going {
                share,
                sweeps: self.sweeps,
                is_marked: self.is_marked,
                is_going: self.track.is_going(),
            };
            if momentum::go_on(body.terms, own, body.state, going)
                || going.is_going && near::balance(body, own)
            {
                self.track.interrupt();
            }
        }
        (self.is_marked, self.sweeps) = (goes_on.is_some(), 0);
        body.own = own.get_mut(..TRACK * cells).unwrap_or(&mut []);
    }

    #[allow(private_interfaces)]
    fn sweep(&mut self, body: &mut Body<'_, '_>) -> bool {
        self.sweeps = self.sweeps.saturating_add(1);
        self.track.sweep(body)
    }

    fn place(&mut self, own: &mut [Cell], cell: usize, position: Cell, k: f32) {
        let cells = own.len() / ARRAYS;
        self.track.place(own.get_mut(..TRACK * cells).unwrap_or(&mut []), cell, position, k);
    }

    fn pushed(&mut self) {
        self.track.pushed();
    }

    fn goes_on(&mut self, share: f32) {
        self.goes_on = Some(share);
    }

    fn follow(&mut self, way: [f32; 3]) {
        self.ahead = add(self.ahead, way);
    }

    fn ahead(&self) -> [f32; 3] {
        self.ahead
    }

    fn interrupt(&mut self) {
        self.track.interrupt();
    }

    fn next_points<'a>(&self, own: &'a [Cell], cells: usize) -> Option<&'a [Cell]> {
        self.track.next_points(own, cells)
    }

    fn has_moved(state: &[Cell], own: &[Cell], residual: &[Cell], cell: usize) -> bool {
        Track::<ROOM>::has_moved(state, own, residual, cell)
    }

    fn room(model: &Model<'_>, held: usize) -> usize {
        Track::<ROOM>::room(model, held)
    }

    fn tool_room(model: &Model<'_>) -> usize {
        Track::<ROOM>::tool_room(model)
    }

    fn resist(
        model: &Model<'_>,
        room: &mut [Eight],
        cells: impl Iterator<Item = (usize, f32)>,
    ) -> Option<u16> {
        Track::<ROOM>::resist(model, room, cells)
    }

    fn is_prepared(&self, held: usize) -> bool {
        self.prepared == Some(held)
    }

    fn release(&mut self) {
        (self.prepared, self.is_known, self.ahead) = (None, false, [0.0; 3]);
    }

    #[allow(private_interfaces)]
    fn hold(&mut self, model: &Model<'_>, memory: Memory<'_>, held: &[Contact]) {
        let Memory { state, residual, own, room, vectors } = memory;
        self.track.hold(model, Memory { state, residual, own, room, vectors }, held);
        let memory = Memory { state, residual, own, room, vectors };
        self.is_known = response::solve(model, memory, held, self.track.corrections());
        self.track.interrupt();
        self.ahead = [0.0; 3];
        self.prepared = Some(held.len());
    }
}
