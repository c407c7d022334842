//! Cutting a body: faces are opened between ticks, and cells split at the start of a tick.

#[cfg(feature = "cut")]
use super::choices::Cutting;
use super::settings::Network;
use super::tissue::TissueMut;
#[cfg(feature = "cut")]
use crate::contact::held::outer_weight;
#[cfg(feature = "cut")]
use crate::cut::body::CutBody;
#[cfg(feature = "cut")]
use crate::cut::memory::{OPENED, REFUSED, TORN, WAITING, inherit};
#[cfg(feature = "cut")]
use crate::cut::split::Look;
#[cfg(feature = "cut")]
use crate::cut::{LOOKS_MAX, SPLITS_MAX};
#[cfg(feature = "cut")]
use crate::energy::current::rounded_up;
#[cfg(feature = "cut")]
use crate::energy::held::is_among;
#[cfg(feature = "cut")]
use crate::energy::residual::places;
use crate::model::Model;
#[cfg(feature = "cut")]
use crate::number::cell::{Cell, dot};
#[cfg(feature = "cut")]
use crate::number::sqrt::sqrt;
#[cfg(feature = "cut")]
use crate::number::two_float::TwoFloat;
use crate::solver::Dynamics;

/// Rounding of the energy of an edge's samples and of pressed lips, relative to it.
#[cfg(feature = "cut")]
const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// The reason for which a face is not opened; nothing has changed.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, Tissue, Track, include_model};
/// use chaincell_kernel::CutError;
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// let mut tissue = Tissue::<128, Track>::new();
/// tissue.reset(&network)?;
/// let refused = tissue.view().open_face(&network, 0, 0); // of a body of links
/// assert_eq!(refused, Err(CutError::NotCuttable));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum CutError {
    /// The tissue was not reset to this network.
    #[error("the tissue belongs to another network: reset it first")]
    Model,
    /// The body cannot be cut.
    #[error("the body cannot be cut: bake it with `cuttable`")]
    NotCuttable,
    /// The tissue has too little memory for cutting.
    #[error("the tissue has too little memory for cutting: size it with cut_words")]
    Room,
    /// There is no such face (tetrahedron, corner).
    #[error(
        "tetrahedron {0} has no face opposite to a corner {1}, or the body has no such tetrahedron"
    )]
    Unknown(usize, usize),
}

/// State of the cuts of a body.
///
/// ```
/// use chaincell_kernel::CutOutput;
///
/// let whole = CutOutput::default();
/// assert_eq!((whole.opened_faces, whole.copies, whole.refused), (0, 0, 0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CutOutput {
    /// Number of faces between tetrahedra that are open.
    pub opened_faces: u32,
    /// Number of spare cells that are in use: copies of split cells.
    pub copies: u32,
    /// Number of cells that wait for a look at their tetrahedra.
    pub waiting: u32,
    /// Number of splits that were refused, for want of spare cells or half-links: the body is not as far open
    /// there as its faces are.
    pub refused: u32,
    /// Area that the edges of blades have swept since the reset \[m2\].
    pub area_m2: f32,
    /// Work that it took to part it: toughness times area, each area by the toughness there \[J\].
    pub work_j: f32,
    /// Number of faces that tools do not touch, for want of places: they are open all the same.
    pub untouched: u32,
    /// Number of cells at which a body that tears has torn by itself.
    pub torn: u32,
}

#[cfg(feature = "cut")]
impl<D: Dynamics> TissueMut<'_, D> {
    /// Opens the face of a tetrahedron that lies opposite to a corner, on both sides: the tissue there parts in
    /// the next ticks that are not late. Tetrahedra are numbered as in the mesh, corners from 0 to 3 as in the
    /// image. Call it between two ticks. Returns false for an outer face and for one that is open already.
    ///
    /// Cost: a look at the tetrahedra of one cell.
    ///
    /// # Errors
    /// A tissue that was not reset to this network, a body that cannot be cut, too little memory, a face beyond
    /// the body.
    pub fn open_face(
        &mut self,
        network: &Network<'_>,
        tetrahedron: usize,
        corner: usize,
    ) -> Result<bool, CutError> {
        let model = network.model();
        if self.head.model != Some(model.checksum()) {
            return Err(CutError::Model);
        }
        if !model.cuttable().is_any() {
            return Err(CutError::NotCuttable);
        }
        let mut body = CutBody::of(&mut self.cut, model).ok_or(CutError::Room)?;
        body.open_face(tetrahedron, corner).ok_or(CutError::Unknown(tetrahedron, corner))
    }

    /// State of the cuts; all 0 for a body that is whole, and without memory for cuts.
    #[must_use]
    pub fn cut_output(&mut self, network: &Network<'_>) -> CutOutput {
        let Some(body) = CutBody::of(&mut self.cut, network.model()) else {
            return CutOutput::default();
        };
        let unit_m = f64::from(body.model.unit_m());
        let area_m2 = (body.area() * unit_m * unit_m) as f32;
        let count = |index: usize| body.arrays.counts.get(index).copied().unwrap_or(0);
        CutOutput {
            opened_faces: count(OPENED),
            copies: body.used() as u32,
            waiting: count(WAITING),
            refused: count(REFUSED),
            area_m2,
            work_j: body.work_j(area_m2),
            untouched: body.arrays.listed[1],
            torn: body.arrays.tear.get(TORN).copied().unwrap_or(0),
        }
    }

    /// The cell that a corner of a tetrahedron has now, a copy after a split; `None` beyond the body and for one
    /// that cannot be cut.
    #[must_use]
    pub fn cell_of_corner(
        &mut self,
        network: &Network<'_>,
        tetrahedron: usize,
        corner: usize,
    ) -> Option<u16> {
        let body = CutBody::of(&mut self.cut, network.model())?;
        body.arrays.corners.get(tetrahedron)?.get(corner).copied()
    }

    /// The cell that copy number `copy`, from 0, was made from; `None` beyond the last copy. A copy is the cell
    /// behind the [`body_cells`](crate::Model::body_cells) with its number.
    #[must_use]
    pub fn origin_of_copy(&mut self, network: &Network<'_>, copy: usize) -> Option<u16> {
        let body = CutBody::of(&mut self.cut, network.model()).filter(|body| copy < body.used())?;
        body.arrays.origins.get(copy).copied()
    }

    /// The triangles of the surface as it is now, three cells of each: those of the model in its order, at a split
    /// cell with the copies that they hang on now, and behind them the sides of open faces that can part. A triangle
    /// of a piece that is gone ([`Loose::Drop`](crate::Loose)) has three times the same cell. Of a body without memory
    /// for cuts they are those of the [model](crate::Model::triangles).
    pub fn triangles<'a>(
        &'a mut self,
        network: &'a Network<'_>,
    ) -> impl ExactSizeIterator<Item = [u16; 3]> + use<'a, D> {
        let model = network.model();
        let body = CutBody::of(&mut self.cut, model);
        let triangles = body.and_then(CutBody::into_triangles).unwrap_or(model.triangles);
        triangles.iter().copied()
    }

    /// Returns true for a cell of a piece that has come loose and is gone, see [`Loose::Drop`](crate::Loose).
    #[must_use]
    pub fn is_dropped(&mut self, network: &Network<'_>, cell: u16) -> bool {
        let body = CutBody::of(&mut self.cut, network.model());
        body.is_some_and(|body| body.is_dropped(cell.into()))
    }

    /// Finds the loose pieces where the tool holds these cells, or as it has chosen.
    pub(super) fn find_pieces(&mut self, model: &Model<'_>, cells: Option<&[u16]>) {
        let mut memory = core::mem::take(&mut self.cut);
        let body = CutBody::of(&mut memory, model).filter(CutBody::seeks_pieces);
        if let Some(mut body) = body.filter(|body| body.used() > 0) {
            let chosen = self.contacts.get(..self.head.chosen).unwrap_or(&[]);
            body.find_loose(&|cell| match cells {
                Some(cells) => cells.contains(&(cell as u16)),
                None => is_among(chosen, cell),
            });
            body.list();
            self.stop_loose(&body);
            body.bound_lips();
        }
        self.cut = memory;
    }

    /// Returns true if there is memory to cut this body.
    pub(super) fn has_cut_memory(&mut self, model: &Model<'_>) -> bool {
        CutBody::of(&mut self.cut, model).is_some()
    }

    /// Closes all cuts.
    pub(super) fn close_cuts(&mut self, model: &Model<'_>) {
        if let Some(mut body) = CutBody::of(&mut self.cut, model) {
            body.reset();
        }
    }

    /// Moves the fronts of blades on, lets the body tear, splits the cells that wait, at most [`SPLITS_MAX`], and
    /// lowers the offsets of copies.
    pub(super) fn part(&mut self, network: &Network<'_>) {
        let model = network.model();
        let mut memory = core::mem::take(&mut self.cut);
        let parted = CutBody::of(&mut memory, model).map(|mut body| {
            let is_off = network.settings().cut == Cutting::Off;
            self.draw(&mut body, is_off);
            let pressed = self.energy_of_lips(&body);
            if !is_off {
                self.tear(&mut body);
            }
            let split = self.split(&mut body);
            body.pay(split.unwrap_or(0.0));
            if split.is_some() {
                let held = self.contacts.get(..self.head.chosen).unwrap_or(&[]);
                body.find_loose(&|cell| is_among(held, cell));
                body.list();
                self.stop_loose(&body);
            }
            self.rename_fronts(&body);
            let lowered = self.lower(&mut body);
            let (turned, others_count) = self.turn_lips(&mut body, pressed);
            let is_bound = others_count || split.is_some();
            if is_bound {
                body.bound_lips();
            }
            body.renew_sides(self.head.vectors);
            ([split, lowered, turned], is_bound)
        });
        self.cut = memory;
        let Some((changes, is_bound)) = parted else { return };
        if is_bound {
            self.touch.forget_bounds();
            self.with_body(network, |tissue, network| {
                let held = tissue.contacts.get(..tissue.head.chosen).unwrap_or(&[]);
                tissue.head.outer_weight = outer_weight(network.model(), held);
            });
        }
        if changes == [None; 3] {
            return;
        }
        // Book the change of the energy; all else is as after a correction.
        self.head.touched = None;
        let change = changes.iter().fold(0.0, |sum, change| sum + change.unwrap_or(0.0));
        self.head.level.shift(rounded_up(change));
        self.head.awake.wake_all(model);
        self.head.dynamics.pushed();
    }

    /// Moves the fronts of blades on, and opens the faces that they pass; if cutting is off, blades leave the tissue.
    fn draw(&mut self, body: &mut CutBody<'_, '_>, is_off: bool) {
        let Some(state) = self.state.get(..body.model.cells()) else { return };
        let at = places(body.model, state);
        let Some(arrays) = self.touch.whole() else { return };
        for tool in arrays.tools.iter_mut().filter(|tool| tool.is_in) {
            let (pivot, edge) = (tool.proxy.pivot, &mut tool.proxy.edge);
            if edge.samples().is_empty() {
                continue;
            }
            let (before, size) = (edge.energy(&at), edge.reach(pivot));
            let slid = edge.crossing().slid;
            let turned = size * sqrt(dot(tool.spin, tool.spin));
            let moved = sqrt(dot(tool.way, tool.way)) + turned + slid.abs();
            // An edge that is drawn back takes hold where it is.
            let is_back = dot(edge.forward(), tool.way) + slid < 0.0;
            let ahead = if is_back { turned } else { moved };
            // A blade that moves too far leaves its fronts and cuts nothing.
            let moved = if is_off { f32::INFINITY } else { moved };
            let Some(begun) = body.draw(edge, moved, ahead, &at) else { continue };
            self.head.given += begun;
            let after = edge.energy(&at);
            let rounding = ROUNDING * (before + after);
            self.head.level.shift(TwoFloat::from(after).minus(before.into()).plus(rounding.into()));
            self.head.awake.wake_all(body.model);
        }
    }

    /// Stops the motion of the cells of loose pieces.
    fn stop_loose(&mut self, body: &CutBody<'_, '_>) {
        let cells = body.model.cells();
        for cell in (0..cells).filter(|&cell| body.is_loose(cell)) {
            // The scheme goes on from the published points.
            self.head.dynamics.interrupt();
            let here = self.state.get(cell).copied().unwrap_or(Cell::ZERO);
            for (at, array) in self.own.chunks_mut(cells).take(D::ARRAYS).enumerate() {
                if let Some(slot) = array.get_mut(cell) {
                    *slot = if at < D::POINTS { here } else { Cell::ZERO };
                }
            }
        }
    }

    /// Opens the faces of a cell that tears, while a tool is engaged.
    fn tear(&mut self, body: &mut CutBody<'_, '_>) {
        let Some(state) = self.state.get(..body.model.cells()) else { return };
        if !self.head.engaged {
            return;
        }
        let held = self.contacts.get(..self.head.chosen).unwrap_or(&[]);
        let states = self.states.shared(body.model.kept_states());
        body.tear(&|cell| is_among(held, cell), &places(body.model, state), states);
    }

    /// Adds the energy by which the sweeps have lowered the level to the credit of a body that tears.
    pub(super) fn earn(&mut self, model: &Model<'_>, fallen: f32) {
        if model.tear_limit().is_some()
            && let Some(mut body) = CutBody::of(&mut self.cut, model)
        {
            body.earn(fallen);
        }
    }

    /// Names the cells of the blades' fronts anew.
    fn rename_fronts(&mut self, body: &CutBody<'_, '_>) {
        let tools = self.touch.whole().into_iter().flat_map(|arrays| &mut *arrays.tools);
        tools.for_each(|tool| body.rename_fronts(&mut tool.proxy.edge));
    }

    /// Splits cells by ascending number. Returns the rise of the energy, rounded up; `None` without a split.
    fn split(&mut self, body: &mut CutBody<'_, '_>) -> Option<f64> {
        let (cells, mut rise) = (body.model.cells(), None);
        let states = self.states.shared(body.model.kept_states());
        let (mut looks, mut splits) = (LOOKS_MAX, SPLITS_MAX);
        let is_any = body.arrays.counts.get(WAITING).is_some_and(|&waiting| waiting > 0);
        for cell in 0..if is_any { cells } else { 0 } {
            if looks == 0 || splits == 0 {
                break;
            }
            // A cell that the tool holds waits.
            let held = self.contacts.get(..self.head.chosen).unwrap_or(&[]);
            let is_waiting = body.arrays.marks.get(cell) == Some(&1);
            if !is_waiting || (self.head.engaged && is_among(held, cell)) {
                continue;
            }
            looks -= 1;
            body.mark(cell, 0);
            let first = body.bodily + body.used();
            let state = self.state.get(..cells)?;
            let look = body.look(cell, &places(body.model, state), states);
            if let Look::Split(change) = look {
                splits -= 1;
                *rise.get_or_insert(0.0) += if change > 0.0 { change } else { 0.0 };
                // The copies lie where the cell lies, in all arrays.
                for copy in first..body.bodily + body.used() {
                    inherit(self.state, cell, copy);
                    inherit(self.residual, cell, copy);
                    let arrays = self.own.chunks_mut(cells).take(D::ARRAYS);
                    arrays.for_each(|array| inherit(array, cell, copy));
                }
            }
        }
        rise
    }

    /// Energy of the sides that press on each other, in internal units.
    fn energy_of_lips(&self, body: &CutBody<'_, '_>) -> f64 {
        if body.used() == 0 {
            return 0.0;
        }
        let state = self.state.get(..body.model.cells()).unwrap_or(&[]);
        body.lips_energy(&places(body.model, state))
    }

    /// Turns the normals between the sides of cuts, whose energy was `before`. Returns the change of the energy,
    /// rounded up, `None` if there is none; and true if other lips count than before.
    fn turn_lips(&mut self, body: &mut CutBody<'_, '_>, before: f64) -> (Option<f64>, bool) {
        if body.used() == 0 {
            return (None, false);
        }
        let state = self.state.get(..body.model.cells()).unwrap_or(&[]);
        let states = self.states.shared(body.model.kept_states());
        let turned = body.turn_lips(before, &places(body.model, state), states);
        let after = turned.energy;
        let change = (turned.any && before > 0.0)
            .then(|| after - before + f64::from(ROUNDING) * (before + after));
        (change, turned.others_count)
    }

    /// Lowers the offsets. Returns the change of the energy, rounded up; `None` without one.
    fn lower(&mut self, body: &mut CutBody<'_, '_>) -> Option<f64> {
        let state = self.state.get(..body.model.cells())?;
        let states = self.states.shared(body.model.kept_states());
        let change = body.decay(body.credit(), &places(body.model, state), states);
        body.pay(change.unwrap_or(0.0));
        change
    }
}

/// In a kernel without the feature `cut` nothing is cut.
#[cfg(not(feature = "cut"))]
impl<D: Dynamics> TissueMut<'_, D> {
    pub(super) fn find_pieces(&mut self, _: &Model<'_>, _: Option<&[u16]>) {}

    /// Opens no face: this kernel is built without the feature `cut`.
    ///
    /// # Errors
    /// The body cannot be cut.
    pub fn open_face(&mut self, _: &Network<'_>, _: usize, _: usize) -> Result<bool, CutError> {
        Err(CutError::NotCuttable)
    }

    /// State of the cuts: all 0.
    #[must_use]
    pub fn cut_output(&mut self, _: &Network<'_>) -> CutOutput {
        CutOutput::default()
    }

    /// The cell that a copy was made from: this kernel makes none.
    #[must_use]
    pub fn origin_of_copy(&mut self, _: &Network<'_>, _: usize) -> Option<u16> {
        None
    }

    /// The triangles of the surface: those of the [model](crate::Model::triangles).
    pub fn triangles<'a>(
        &'a mut self,
        network: &'a Network<'_>,
    ) -> impl ExactSizeIterator<Item = [u16; 3]> + use<'a, D> {
        network.model().triangles.iter().copied()
    }

    pub(super) fn has_cut_memory(&mut self, _: &Model<'_>) -> bool {
        false
    }

    pub(super) fn close_cuts(&mut self, _: &Model<'_>) {}
}
