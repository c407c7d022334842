//! One pass over the terms: the residual of every cell and the energy of the whole body.
//!
//! The residual r of cell i is the negative gradient of E, for links the sum of w mu (`P_j` - `P_i`) (Eq. 12)
//! with E = sum of w d^2 / 4. The fourth lane of a residual is the cell's sum of w d^2; the sum over all
//! cells counts each link at both ends, so E is an eighth of that sum.

use super::current::rounded_up;
use super::held::Contact;
use super::links::number::LinkNumber;
use super::links::term::Links;
use super::state::States;
use super::surface::Touch;
use super::term::Term;
use crate::backend::VectorUnit;
use crate::backend::f32x8::{Chunk, chunk};
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::cells_of;
use crate::backend::team::Team;
use crate::model::Model;
use crate::number::cell::{Cell, add, from_single, output, single};
use crate::number::two_float::{LANES, TwoFloat};
use crate::number::{Number, Sum};

/// The terms in a tick: the body, whether its bands are closed (unloading), and the tool's effect on its
/// contact cells.
#[derive(Clone, Copy)]
pub(crate) struct Terms<'a, 'm> {
    pub model: &'a Model<'m>,
    pub closed: bool,
    /// The vector unit to use.
    pub vectors: Option<VectorUnit>,
    /// The team that runs the parts of a large body.
    pub team: Team<'a>,
    /// The current into each contact cell; `None` if the tool holds them.
    pub current: Option<[f32; 3]>,
    /// The terms' states of the cells.
    pub states: States<'a>,
    /// The tools in contact on the surface.
    pub touch: Touch<'a>,
}

impl<'a, 'm> Terms<'a, 'm> {
    /// The links' bands.
    #[inline(always)]
    pub fn links(&self) -> Links<'a, 'm> {
        Links { model: self.model, closed: self.closed }
    }

    /// 1 / W of every cell, including the tools' part.
    #[inline(always)]
    pub fn mobility(&self) -> &'a [f32] {
        self.touch.get().map_or(self.model.mobility, |touching| touching.mobility)
    }

    /// The local part of every cell's direction over r / W; empty without an elastic level.
    #[inline(always)]
    pub fn factors(&self) -> &'a [f32] {
        if let Some(touching) = self.touch.get() {
            return touching.factors;
        }
        let elastic = self.model.coarse_basis.and_then(|basis| basis.elastic());
        elastic.map_or(&[], |level| level.factors)
    }

    /// Adds the tools' contribution to the residuals of awake slices at the outputs of v.
    #[inline(always)]
    fn push<N: Number>(self, awake: &SliceSet, v: &[Cell<N>], residual: &mut [Cell<N>]) {
        let Some(touching) = self.touch.get() else { return };
        touching.pull(&self.outputs(v));
        for slice in awake.iter(self.model.slice_count()) {
            let Some(pulls) = touching.of_slice(slice) else { continue };
            let cells = residual.get_mut(cells_of(slice, v.len())).unwrap_or_default();
            for (r, pull) in cells.iter_mut().zip(pulls) {
                *r = r.plus(Cell(pull.0.map(N::from_single)));
            }
        }
    }

    /// Computes the tools' contribution to the residuals at states v within K, and returns it slice by slice.
    #[inline(always)]
    pub fn pulls(self, v: &[Cell]) -> impl Fn(usize, &Chunk) -> Option<Chunk> + Copy + use<'a> {
        if let Some(touching) = self.touch.get() {
            touching.pull(&self.outputs(v));
        }
        let touch = self.touch;
        move |slice, _| touch.get().and_then(|touching| touching.of_slice(slice))
    }

    /// Computes the tools' contribution to the residuals at states v within K, and writes it into the
    /// residuals of awake slices.
    #[inline(always)]
    pub fn pull_into(self, awake: &SliceSet, v: &[Cell], residual: &mut [Cell]) {
        let Some(touching) = self.touch.get() else { return };
        touching.pull(&self.outputs(v));
        for slice in touching.slices.iter(self.model.slice_count()) {
            let Some(pulls) = touching.of_slice(slice).filter(|_| awake.contains(slice)) else {
                continue;
            };
            let cells = residual.get_mut(cells_of(slice, v.len())).unwrap_or_default();
            for (slot, pull) in cells.iter_mut().zip(pulls) {
                *slot = pull;
            }
        }
    }

    /// Stores the displacements of the cells of these slices at the states v.
    #[inline(always)]
    pub fn displace<N: Number>(self, slices: impl Iterator<Item = usize>, v: &[Cell<N>]) {
        if self.states.any() {
            let (at, quads) = (self.outputs(v), self.states.all().quads());
            for slice in slices {
                let here = chunk(|lane| {
                    let [x, y, z] = at(slice * LANES + lane);
                    [x, y, z, 0.0]
                });
                self.model.others.displace(slice, &here, quads);
            }
        }
    }

    /// Updates the terms' states of the cells in awake slices to the states v.
    #[inline(always)]
    pub fn update<N: Number>(self, awake: &SliceSet, v: &[Cell<N>]) {
        if !self.states.any() {
            return;
        }
        self.displace(awake.iter(self.model.slice_count()), v);
        let at = self.outputs(v);
        for slice in awake.iter(self.model.slice_count()) {
            if let Some([from, to]) = self.states.step(slice) {
                self.model.others.update(cells_of(slice, v.len()), &at, from, to);
            }
        }
    }

    /// Starts a tick: applies the terms' corrections and calls `changed` for each cell whose state changed.
    /// Returns the change of the energy, in internal units.
    #[inline(always)]
    pub fn begin_tick<N: Number>(self, v: &[Cell<N>], mut changed: impl FnMut(usize)) -> TwoFloat {
        let (at, mut rise) = (self.outputs(v), 0.0);
        for cell in 0..v.len() {
            let before = self.states.at(cell);
            let (state, more) = self.model.others.begin_tick(cell, before, &at);
            if state != before {
                self.states.put(cell, state);
                rise += more;
                changed(cell);
            }
        }
        rounded_up(rise)
    }

    /// Outputs of the states v, in single precision.
    fn outputs<N: Number>(self, v: &[Cell<N>]) -> impl Fn(usize) -> [f32; 3] {
        let k = N::from_single(self.model.saturation());
        move |cell| v.get(cell).map_or([0.0; 3], |v| single(output(v.xyz(), k)))
    }

    /// One pass cell by cell at states within K: residuals of awake slices, with contact cells driven.
    /// Returns the energy in internal units.
    pub fn energy<N: LinkNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        contacts: &[Contact<N>],
    ) -> TwoFloat {
        let tally = self.residuals(awake, v, residual, contacts);
        let mut lanes = N::WideSum::default();
        for slice in awake.iter(self.model.slice_count()) {
            let cells = residual.get(cells_of(slice, self.model.cells())).unwrap_or(&[]);
            for (lane, r) in cells.iter().enumerate() {
                lanes.add(lane, N::energy_term(r.w()));
            }
        }
        N::energy(&lanes, tally).times_power_of_two(0.125)
    }

    /// Residuals and energies of awake slices at states within K, with contact cells driven.
    #[inline(always)]
    pub fn residuals<N: LinkNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        contacts: &[Contact<N>],
    ) -> N::Tally {
        self.update(awake, v);
        let mut tally = if self.model.is_nodal() {
            clear(awake, residual)
        } else {
            N::accumulate(self.links(), awake, v, residual)
        };
        let states = self.states.all();
        self.model.others.accumulate(awake, v, residual, &mut tally, &|v| v, states);
        self.push(awake, v, residual);
        self.drive(residual, contacts);
        tally
    }

    /// The same at the outputs of all states; every slice must be awake. Returns the sum of w d^2 over the
    /// cells.
    pub fn saturated_residual<N: LinkNumber>(
        self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
        contacts: &[Contact<N>],
    ) -> TwoFloat {
        let k = N::from_single(self.model.saturation());
        self.update(awake, v);
        let mut tally = if self.model.is_nodal() {
            clear(awake, residual)
        } else {
            self.links().accumulate(awake, v, residual, |v| output(v, k))
        };
        let states = self.states.all();
        self.model.others.accumulate(awake, v, residual, &mut tally, &|v| output(v, k), states);
        self.push(awake, v, residual);
        self.drive(residual, contacts);
        let mut lanes = N::WideSum::default();
        for (cell, r) in residual.iter().enumerate() {
            lanes.add(cell % LANES, N::energy_term(r.w()));
        }
        N::energy(&lanes, tally)
    }

    /// Clears the residuals of held cells, or adds the current to those of the contact cells; the fourth
    /// lanes stay.
    fn drive<N: Number>(self, residual: &mut [Cell<N>], contacts: &[Contact<N>]) {
        for contact in contacts {
            if let Some(r) = residual.get_mut(contact.cell()) {
                let [x, y, z] = match self.current {
                    Some(current) => add(r.xyz(), from_single(current)),
                    None => [N::ZERO; 3],
                };
                *r = Cell([x, y, z, r.w()]);
            }
        }
    }
}

/// Clears the residuals of awake slices.
fn clear<N: LinkNumber>(awake: &SliceSet, residual: &mut [Cell<N>]) -> N::Tally {
    let cells = residual.len();
    for slice in awake.iter(cells.div_ceil(LANES)) {
        residual.get_mut(cells_of(slice, cells)).unwrap_or_default().fill(Cell::ZERO);
    }
    N::Tally::default()
}
