//! The list of the terms, and one pass over it cell by cell: the residual of every cell and the energy of the
//! whole body.
//!
//! The residual r of cell i is the negative gradient of E, for links the sum of w mu (`P_j` - `P_i`) (Eq. 12)
//! with E = sum of w d^2 / 4. The fourth lane of a residual is the cell's sum of w d^2; the sum over all
//! cells counts each link at both ends, so E is an eighth of that sum.

use super::current::{Load, rounded_up};
use super::held::Contact;
use super::links::bands::Links;
use super::links::number::LinkNumber;
use super::state::States;
use super::stress::Stress;
use super::surface::Touch;
use super::term::{Pass, Term};
use crate::backend::VectorUnit;
use crate::backend::f32x8::chunk;
use crate::backend::slice_set::SliceSet;
use crate::backend::slices::{cells_of, clear};
use crate::backend::team::Team;
use crate::model::Model;
#[cfg(feature = "relax")]
use crate::model::relaxing_links::RelaxingLinks;
use crate::number::Sum;
use crate::number::cell::{Cell, output, single};
use crate::number::two_float::{LANES, TwoFloat};

/// The terms in a tick: the body, whether its bands are closed (unloading), and the tool's effect on it.
#[derive(Clone, Copy)]
pub(crate) struct Terms<'a, 'm, N = f32> {
    pub model: &'a Model<'m>,
    pub closed: bool,
    /// The vector unit to use.
    pub vectors: Option<VectorUnit>,
    /// The team that runs the parts of a large body.
    pub team: Team<'a>,
    /// The terms' states of the cells.
    pub states: States<'a>,
    /// Cells that the tool acts on.
    pub contacts: &'a [Contact<N>],
    /// The current into each of them; `None` if the tool holds them.
    pub current: Option<[f32; 3]>,
    /// The tools in contact on the surface.
    pub touch: Touch<'a>,
}

impl<'a, 'm, N: LinkNumber> Terms<'a, 'm, N> {
    /// The terms of a body that no tool acts on.
    pub fn of(model: &'a Model<'m>, states: States<'a>) -> Self {
        let (closed, vectors, team) = (false, None, Team::ALONE);
        let (contacts, current, touch) = (&[][..], None, Touch::NONE);
        Self { model, closed, vectors, team, states, contacts, current, touch }
    }

    /// The list of all terms, in the order of their sums.
    #[inline(always)]
    pub fn list(&self) -> impl Term<N> + use<'a, 'm, N> {
        self.list_with(self.touch)
    }

    /// The list with another form of the tools' term.
    #[inline(always)]
    pub fn list_with<T: Term<N>>(&self, tools: T) -> impl Term<N> + use<'a, 'm, N, T> {
        let load = Load { current: self.current, cells: self.contacts };
        let links = Links::of(self.model, self.closed);
        #[cfg(feature = "relax")]
        let links = (links, RelaxingLinks(self.model));
        (links, (self.model.others, (tools, load)))
    }

    /// Cells that the tool holds: they do not move in a sweep.
    #[inline(always)]
    pub fn held(&self) -> &'a [Contact<N>] {
        if self.current.is_none() { self.contacts } else { &[] }
    }

    /// Returns true if a non-zero current flows into the contact cells.
    pub fn is_loaded(&self) -> bool {
        self.current.is_some_and(|current| current != [0.0; 3])
    }

    /// The guarded quantity at the states `v` with the energy `energy`: E - W, or E without a current.
    pub fn potential(&self, energy: TwoFloat, v: &[Cell<N>]) -> TwoFloat {
        self.list().potential(energy, &self.published(v))
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

    /// The rotation of a cell as a unit quaternion, real part first; `None` if no term has one.
    #[inline(always)]
    pub fn turn(&self, cell: usize) -> Option<[f32; 4]> {
        self.list().turn(cell, self.states.all())
    }

    /// Strain and stress of a cell with the cells at these positions \[mean link lengths\]; `None` where no term
    /// has them. `means_pa` is as of [`TissueMut::stress_with`](crate::TissueMut::stress_with).
    pub fn stress(
        &self,
        cell: usize,
        at: &impl Fn(usize) -> [N; 3],
        means_pa: &mut [f32],
    ) -> Option<Stress> {
        let (states, unit_pa) = (self.states.all(), self.model.stress_unit_pa());
        self.list().stress(cell, at, states, unit_pa, means_pa, None)
    }

    /// Starts a tick: applies the terms' corrections and calls `changed` for each cell whose state changed.
    /// Returns the change of the energy, in internal units.
    #[inline(always)]
    pub fn begin_tick(&self, v: &[Cell<N>], mut changed: impl FnMut(usize)) -> TwoFloat {
        let (at, states) = (places(self.model, v), self.states.all());
        rounded_up(self.list().begin_tick(&at, states, &mut changed))
    }

    /// Stores the displacements of the cells of these slices at the states v.
    #[inline(always)]
    pub fn displace(&self, slices: impl Iterator<Item = usize>, v: &[Cell<N>]) {
        let (list, at, states) = (self.list(), places(self.model, v), self.states.all());
        for slice in slices.filter(|_| self.states.any()) {
            let here = chunk(|lane| {
                let [x, y, z] = at(slice * LANES + lane);
                [x, y, z, 0.0]
            });
            list.displace(slice, &here, states);
        }
    }

    /// Outputs of the states v; zeros beyond the last cell.
    pub fn published(&self, v: &[Cell<N>]) -> impl Fn(usize) -> [N; 3] {
        let k = N::from_single(self.model.saturation());
        move |cell| v.get(cell).map_or([N::ZERO; 3], |v| output(v.xyz(), k))
    }

    /// Prepares the terms for a pass, and updates their states of the cells in these slices.
    #[inline(always)]
    pub fn update(&self, changed: &SliceSet, v: &[Cell<N>]) {
        let (list, at) = (self.list(), places(self.model, v));
        list.prepare(&at);
        if self.states.any() {
            self.displace(changed.iter(self.model.slice_count()), v);
            for slice in changed.iter(self.model.slice_count()) {
                if let Some([from, to]) = self.states.step(slice) {
                    list.update(cells_of(slice, v.len()), &at, from, to);
                }
            }
        }
    }

    /// One pass cell by cell at states within K after [`Self::update`]: residuals of awake slices, those of
    /// held cells 0. Returns the energy in internal units.
    pub fn energy(&self, awake: &SliceSet, v: &[Cell<N>], residual: &mut [Cell<N>]) -> TwoFloat {
        let tally = self.residuals::<false>(awake, v, residual);
        self.sum(awake, residual, tally)
    }

    /// The same at the outputs of all states, with the update; every slice must be awake.
    pub fn saturated_energy(
        &self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
    ) -> TwoFloat {
        self.update(awake, v);
        let tally = self.residuals::<true>(awake, v, residual);
        self.sum(awake, residual, tally)
    }

    /// The energy of a pass.
    fn sum(&self, awake: &SliceSet, residual: &[Cell<N>], tally: N::Tally) -> TwoFloat {
        let mut lanes = N::WideSum::default();
        for slice in awake.iter(self.model.slice_count()) {
            let cells = residual.get(cells_of(slice, self.model.cells())).unwrap_or(&[]);
            for (lane, r) in cells.iter().enumerate() {
                lanes.add(lane, N::energy_term(r.w()));
            }
        }
        N::energy(&lanes, tally).times_power_of_two(0.125)
    }

    /// Residuals and energies of awake slices after [`Self::update`], at states within K or, `CLAMPED`, at the
    /// outputs of all states.
    #[inline(always)]
    pub fn residuals<const CLAMPED: bool>(
        &self,
        awake: &SliceSet,
        v: &[Cell<N>],
        residual: &mut [Cell<N>],
    ) -> N::Tally {
        let (list, slices) = (self.list(), self.model.slice_count());
        // Add the terms; held cells do not move.
        clear(residual, awake.iter(slices));
        let saturation = N::from_single(self.model.saturation());
        let (pass, mut tally) = (Pass::<N, CLAMPED> { awake, v, saturation }, N::Tally::default());
        list.accumulate(&pass, residual, &mut tally, self.states.all());
        for contact in self.held() {
            if let Some(r) = residual.get_mut(contact.cell()) {
                *r = Cell([N::ZERO, N::ZERO, N::ZERO, r.w()]);
            }
        }
        tally
    }
}

/// Published positions at the states v in single precision; zeros beyond the last cell.
pub(crate) fn places<'a, N: LinkNumber>(
    model: &Model<'_>,
    v: &'a [Cell<N>],
) -> impl Fn(usize) -> [f32; 3] + use<'a, N> {
    let k = N::from_single(model.saturation());
    move |cell| v.get(cell).map_or([0.0; 3], |v| single(output(v.xyz(), k)))
}
