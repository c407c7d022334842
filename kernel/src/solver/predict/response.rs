//! Response of a body to a motion of the held cells: K phi = 0 at the free cells, phi = 1 at the held ones,
//! by conjugate gradients for each axis.
//!
//! K is the second derivative of the energy at rest: with all links taut, for a link of weight w and
//! direction n the matrix w n n' / 2 between its ends, or that of nodal shapes. The preconditioner is that
//! of `track`: 1 / W or the cell's local part, and the coarse level if the model has one.
//!
//! Source: M. R. Hestenes and E. Stiefel, Methods of conjugate gradients, 1952.

use super::{ARRAYS, TRACK};
use crate::backend::slices::copy;
use crate::backend::team::Team;
use crate::backend::{VectorUnit, run};
use crate::energy::held::Contact;
use crate::energy::residual::Terms;
use crate::energy::state::States;
use crate::energy::term::Term;
use crate::model::Model;
use crate::number::cell::{Cell, add, dot, scale, sub};
use crate::number::two_float::Eight;
use crate::solver::coarse::elastic::ElasticSolve;
use crate::solver::coarse::{Coarse, Solve, scalar};
use crate::solver::loops::scalar::track::factor;
use crate::solver::scheme::Memory;

/// Largest number of link passes for a field.
pub const ITERATIONS_MAX: usize = 2000;
/// Share of the first residual, in the norm of the preconditioner, at which a field is accurate enough: the
/// remainder is far below the body's deviation from its field at rest.
const ENOUGH: f64 = 1.0e-3;
/// This multiple of the field's energy replaces that norm if it is smaller: a slender body yields to the tool
/// with a small part of the energy of the first residual.
const SOFT: f64 = 100.0;
/// Share of that norm below which the energy of a field is lost in rounding.
const ROUNDING: f64 = 1.0e-6;
/// Largest displacement of a cell in a field, for a unit motion of the tool.
const FIELD_MAX: f32 = 1.0e3;

/// The system of one field, in the arrays of the scheme.
struct System<'a, 'm> {
    model: &'a Model<'m>,
    held: &'a [Contact],
    /// -K phi of the free cells.
    residual: &'a mut [Cell],
    /// The search direction.
    way: &'a mut [Cell],
    /// Its product with K, then the preconditioned residual.
    product: &'a mut [Cell],
    /// Memory for a coarse level.
    room: &'a mut [Eight],
    /// Corrections of an elastic level in that memory.
    corrections: usize,
    vectors: Option<VectorUnit>,
}

/// Computes the three fields in the last arrays of the scheme. Returns true if they can be used: not on a
/// body with slack, and not without held cells. The other arrays are set to the state afterwards.
pub(super) fn solve(
    model: &Model<'_>,
    mut memory: Memory<'_>,
    held: &[Contact],
    corrections: usize,
) -> bool {
    let cells = memory.state.len();
    if memory.own.len() != ARRAYS * cells || memory.residual.len() != cells {
        return false;
    }
    let mut is_good = !held.is_empty() && !model.has_slack();
    for axis in 0..ARRAYS - TRACK {
        is_good = is_good && field(model, &mut memory, (held, corrections), axis);
    }
    memory.residual.fill(Cell::ZERO);
    for array in memory.own.chunks_mut(cells.max(1)).take(TRACK) {
        copy(array, memory.state);
    }
    is_good
}

/// Computes the field of an axis. Returns true if it can be used.
fn field(
    model: &Model<'_>,
    memory: &mut Memory<'_>,
    (held, corrections): (&[Contact], usize),
    axis: usize,
) -> bool {
    let cells = memory.state.len();
    let Some((points, fields)) = memory.own.split_at_mut_checked(TRACK * cells) else {
        return false;
    };
    let Some((way, product)) = points.split_at_mut_checked(cells) else { return false };
    let Some(field) = fields.get_mut(axis * cells..(axis + 1) * cells) else { return false };
    // Start from a unit displacement of the held cells.
    field.fill(Cell::ZERO);
    let unit = [0, 1, 2].map(|at| if at == axis { 1.0 } else { 0.0 });
    put(field, held, Cell::at(unit));
    let (residual, room) = (&mut *memory.residual, &mut *memory.room);
    let vectors = memory.vectors;
    let mut system = System { model, held, residual, way, product, room, corrections, vectors };
    let mut energy = system.begin(field);
    let first = system.precondition();
    let mut left = first;
    // Iterate until the residual is small.
    copy(system.way, system.product);
    for _ in 0..ITERATIONS_MAX {
        if left <= ENOUGH * ENOUGH * measure(first, energy) {
            break;
        }
        let curvature = system.curvature();
        if curvature.is_nan() || curvature <= 0.0 {
            break;
        }
        energy -= left / curvature * left;
        system.step(field, (left / curvature) as f32);
        let next = system.precondition();
        system.turn((next / left) as f32);
        left = next;
    }
    // Held and fixed cells are not predicted: they follow the tool, or stay.
    put(field, held, Cell::ZERO);
    // This is false for values that are not finite.
    field.iter().all(|field| field.xyz().iter().all(|x| x.abs() <= FIELD_MAX))
}

/// Reference for a field's remaining residual, from the first residual and the field's energy.
fn measure(first: f64, energy: f64) -> f64 {
    let soft = SOFT * energy;
    if soft > first {
        first
    } else if soft > ROUNDING * first {
        soft
    } else {
        ROUNDING * first
    }
}

/// Sets the held cells to a value.
fn put(cells: &mut [Cell], held: &[Contact], value: Cell) {
    for contact in held {
        if let Some(cell) = cells.get_mut(contact.cell()) {
            *cell = value;
        }
    }
}

/// Inner product, added up in the order of the cells.
fn inner(a: &[Cell], b: &[Cell]) -> f64 {
    a.iter().zip(b).fold(0.0, |sum, (a, b)| sum + f64::from(dot(a.xyz(), b.xyz())))
}

impl System<'_, '_> {
    /// Computes the residual of a field that is 0 except at the held cells. Returns twice its energy.
    fn begin(&mut self, field: &[Cell]) -> f64 {
        multiply(self.model, field, self.residual);
        let energy = inner(field, self.residual);
        put(self.residual, self.held, Cell::ZERO);
        for residual in &mut *self.residual {
            *residual = Cell::at(scale(-1.0, residual.xyz()));
        }
        energy
    }

    /// Computes K times the search direction in `product`. Returns its inner product with the direction.
    fn curvature(&mut self) -> f64 {
        multiply(self.model, self.way, self.product);
        put(self.product, self.held, Cell::ZERO);
        inner(self.way, self.product)
    }

    /// Moves by `length` along the search direction.
    fn step(&mut self, field: &mut [Cell], length: f32) {
        for (field, way) in field.iter_mut().zip(&*self.way) {
            *field = Cell::at(add(field.xyz(), scale(length, way.xyz())));
        }
        for (residual, product) in self.residual.iter_mut().zip(&*self.product) {
            *residual = Cell::at(sub(residual.xyz(), scale(length, product.xyz())));
        }
    }

    /// Computes the preconditioned residual in `product`. Returns its inner product with the residual.
    fn precondition(&mut self) -> f64 {
        let basis = self.model.coarse_basis;
        if let Some(basis) = basis {
            scalar::restrict(&basis, self.residual, self.room);
            if basis.elastic().is_some() {
                let (room, corrections) = (&mut *self.room, self.corrections);
                let solve = ElasticSolve { basis, room, corrections, touch: None };
                solve.solve(self.vectors, Team::ALONE, 1);
            } else {
                let coarse = Coarse::Corrected(self.held.len());
                run(self.vectors, Solve { basis, room: self.room, coarse });
            }
        }
        let elastic = basis.and_then(|basis| basis.elastic());
        let factors = elastic.map_or(&[][..], |level| level.factors);
        for (cell, (product, residual)) in self.product.iter_mut().zip(&*self.residual).enumerate()
        {
            let mobility = self.model.mobility.get(cell).copied().unwrap_or(0.0);
            let fine = scale(mobility * factor(factors, cell), residual.xyz());
            let coarse = basis.map_or([0.0; 3], |basis| scalar::at_cell(&basis, self.room, cell));
            *product = Cell::at(add(fine, coarse));
        }
        put(self.product, self.held, Cell::ZERO);
        inner(self.residual, self.product)
    }

    /// The next search direction.
    fn turn(&mut self, share: f32) {
        for (way, product) in self.way.iter_mut().zip(&*self.product) {
            *way = Cell::at(add(product.xyz(), scale(share, way.xyz())));
        }
    }
}

/// K times a field, at the cells that can move.
fn multiply(model: &Model<'_>, field: &[Cell], product: &mut [Cell]) {
    product.fill(Cell::ZERO);
    Terms::<f32>::of(model, States::NONE).list().resist(field, product);
    for (product, _) in
        product.iter_mut().zip(model.mobility).filter(|(_, mobility)| **mobility <= 0.0)
    {
        *product = Cell::ZERO;
    }
}
