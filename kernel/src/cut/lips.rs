//! The lips of a cut: cells that were one, with the opened faces between them.
//!
//! At each corner of an opened face lie two cells, one of either side, once the cell there is split. Those of all
//! opened faces that share both cells are one lip, see [`lips`](crate::energy). The list follows from the opened
//! faces and the cells of the tetrahedra, as that of the touched faces does; it is made anew after the splits of a
//! tick. A spare cell has two places, for lips with two other cells; a further one is left out.
//!
//! At the start of a tick the normals turn with the cells' rotations, in a body of links with the faces themselves,
//! see `facing`. Where the cells of a lip are far from each other
//! its sides meet other parts of the cut, or nothing: a lip counts in full up to a mean edge, and not at all from two
//! on. No turn raises the energy: a lip that would press harder gets a shorter normal, so one whose sides have slid
//! away and come back overlapping presses only after they have parted. What the energy falls by is booked. The bounds
//! of the cells have the lips that count: else a piece that is drawn away would lag behind its tool.

use core::cmp::Ordering;
use core::ops::Range;

use super::body::CutBody;
use super::memory::{Arrays, LIPS};
use super::offset::of_shapes;
use crate::energy::lips::depth;
use crate::energy::state::States;
use crate::energy::term::Term;
use crate::model::image::contact;
use crate::model::lips::Lip;
use crate::number::cell::{add, dot, scale, sub};
use crate::number::sqrt::sqrt;
use crate::number::turn::{Turn, cross, turned};
use crate::number::two_float::LANES;

/// Twice the stiffness of a lip over a third of the contact stiffness of its faces, E times area over edge.
const WEIGHT: f32 = 12.0;
/// Distance of its cells, in mean edges, from which on a lip counts less, and from which on it does not count.
const APART: [f32; 2] = [1.0, 2.0];
/// Share of a normal that stays where a lip would press harder: a little less than all, for the rounding.
const FALL: f32 = 1.0 - 32.0 * f32::EPSILON;
/// Change of a normal below which it stays: without a motion of the body no lip changes.
const STILL: f32 = 1.0e-5;
/// Margin for the rounding of the cells' bounds.
const ROUNDED_UP: f32 = 1.001;

/// Outcome of a turn of the normals.
#[derive(Clone, Copy, Default)]
pub(crate) struct Turned {
    /// Energy of the lips after it, in internal units.
    pub energy: f64,
    /// A normal has changed.
    pub any: bool,
    /// Other lips count than before.
    pub others_count: bool,
}

/// Share with which a lip counts whose cells are this far from each other, in mean edges.
fn share(apart: f32) -> f32 {
    let [full, none] = APART;
    let share = (none - apart) / (none - full);
    if share > 0.0 { if share < 1.0 { share } else { 1.0 } } else { 0.0 }
}

impl CutBody<'_, '_> {
    /// Lists touched faces, lips and links anew, after splits.
    pub(crate) fn list(&mut self) {
        self.list_opened();
        self.list_lips(false);
        self.drop_sides();
        self.sort_ends();
        self.list_links();
    }

    /// The same for a body whose normals have been read.
    pub(super) fn list_read(&mut self) {
        self.list_opened();
        self.list_lips(true);
        self.drop_sides();
        self.sort_ends();
        self.list_links();
        self.bound_lips();
    }

    /// Makes the list anew. The normal of a place whose cells are others than before becomes 0, unless the normals
    /// have been read.
    fn list_lips(&mut self, is_read: bool) {
        self.arrays.lip_numbers.fill([0.0; 5]);
        for tetrahedron in 0..self.arrays.faces.len() {
            for corner in self.open_corners(tetrahedron) {
                if let Some([here, there]) = self.sides_once(tetrahedron, corner) {
                    self.add_lips(here, there, is_read);
                }
            }
        }
    }

    /// Both sides of an opened face, at one of its tetrahedra.
    pub(super) fn sides_once(&self, tetrahedron: usize, corner: usize) -> Option<[[u16; 3]; 2]> {
        let (other, opposite) = self.across(tetrahedron, corner)?;
        let sides = || [self.side(tetrahedron, corner), self.side(other, opposite)];
        (tetrahedron < other).then(sides)
    }

    /// The cells of the lip at a corner of one side of an opened face, and the sign of that side's area for it; `None`
    /// where both sides have the same cell.
    pub(super) fn lip_at(&self, cell: u16, there: [u16; 3]) -> Option<([u16; 2], f32)> {
        let origin = self.origin(cell.into());
        let across = there.into_iter().find(|&id| self.origin(id.into()) == origin)?;
        match cell.cmp(&across) {
            Ordering::Less => Some(([cell, across], 1.0)),
            Ordering::Equal => None,
            Ordering::Greater => Some(([across, cell], -1.0)),
        }
    }

    /// The places for lips of these cells.
    pub(super) fn lip_places(&self, cells: [u16; 2]) -> Range<usize> {
        let spare = usize::from(cells[1]).saturating_sub(self.bodily);
        LIPS * spare..LIPS * (spare + 1)
    }

    /// Adds an opened face with these sides to the lips at its corners.
    fn add_lips(&mut self, cells: [u16; 3], there: [u16; 3], is_read: bool) {
        let [a, b, c] = cells.map(|cell| self.rest_position(self.origin(cell.into()) as u16));
        let third = scale(1.0 / 6.0, cross(sub(b, a), sub(c, a)));
        let numbers = self.contact_numbers(cells);
        let number = |row: usize| numbers.get(row).copied().unwrap_or(0.0);
        let weight = WEIGHT / 3.0 * number(contact::STIFFNESS);
        for cell in cells {
            let Some((cells, sign)) = self.lip_at(cell, there) else { continue };
            let area = scale(sign, third);
            self.add_lip(Lip { cells, weight, area, edge: number(contact::EDGE) }, is_read);
        }
    }

    /// Adds a lip, or its numbers to the one of these cells.
    fn add_lip(&mut self, more: Lip, is_read: bool) {
        for place in self.lip_places(more.cells) {
            let known = self.lip(place);
            if known.is_some_and(|lip| lip.cells != more.cells) {
                continue;
            }
            let mut lip = more;
            if let Some(known) = known {
                lip.weight += known.weight;
                lip.area = add(known.area, more.area);
                lip.edge = if known.edge > more.edge { known.edge } else { more.edge };
            }
            if let (Some(cells), Some(numbers), Some(normal)) = (
                self.arrays.lip_cells.get_mut(place),
                self.arrays.lip_numbers.get_mut(place),
                self.arrays.normals.get_mut(place),
            ) {
                if !is_read && *cells != lip.cells {
                    *normal = [0.0; 3];
                }
                (*cells, *numbers) = (lip.cells, lip.numbers());
            }
            return;
        }
    }

    /// The lip in a place.
    pub(super) fn lip(&self, place: usize) -> Option<Lip> {
        Lip::of(self.arrays.lip_cells.get(place)?, self.arrays.lip_numbers.get(place)?)
    }

    /// The lips, each with its place.
    pub(super) fn lips(&self) -> impl Iterator<Item = (usize, Lip)> {
        (0..LIPS * self.used()).filter_map(|place| Some((place, self.lip(place)?)))
    }

    /// Lists the lips at each of their cells, by slices.
    fn sort_ends(&mut self) {
        let Arrays { lip_cells, lip_numbers, lip_rows, ends, .. } = &mut self.arrays;
        lip_rows.fill(0);
        let each = || {
            let all = lip_cells.iter().zip(&**lip_numbers).enumerate();
            all.filter_map(|(place, (cells, numbers))| Some((place, Lip::of(cells, numbers)?)))
        };
        // Count those of each slice, and sum the counts.
        for (_, lip) in each() {
            for cell in lip.cells {
                if let Some(row) = lip_rows.get_mut(usize::from(cell) / LANES + 1) {
                    *row += 1;
                }
            }
        }
        let mut sum = 0;
        for row in lip_rows.iter_mut() {
            sum += *row;
            *row = sum;
        }
        // Put each end in the last free place of its slice; the rows are then the starts.
        for (place, lip) in each() {
            for (end, cell) in lip.cells.into_iter().enumerate() {
                if let Some(row) = lip_rows.get_mut(usize::from(cell) / LANES + 1) {
                    *row -= 1;
                    if let Some(slot) = ends.get_mut(*row as usize) {
                        *slot = (2 * place + end) as u32;
                    }
                }
            }
        }
        // The starts move one place down.
        for slice in 1..lip_rows.len() {
            let start = lip_rows.get(slice).copied().unwrap_or(0);
            if let Some(slot) = lip_rows.get_mut(slice - 1) {
                *slot = start;
            }
        }
        if let Some(last) = lip_rows.last_mut() {
            *last = sum;
        }
    }

    /// Sets the bounds of all cells, with those of the lips that count; the cells of loose pieces stay where they are.
    pub(crate) fn bound_lips(&mut self) {
        let basis = self.model.coarse_basis.and_then(|basis| basis.elastic());
        let factors = basis.map_or(&[][..], |level| level.factors);
        for cell in 0..self.bodily + self.used() {
            let origin = self.origin(cell);
            for (array, image) in [
                (&mut *self.arrays.mobility, self.model.mobility),
                (&mut *self.arrays.factors, factors),
            ] {
                if let (Some(slot), Some(&number)) = (array.get_mut(cell), image.get(origin)) {
                    *slot = number;
                }
            }
        }
        // Each lip adds its weight to the bounds W of its cells, one after the other.
        for place in 0..LIPS * self.used() {
            let Some(lip) = self.lip(place).filter(|_| self.counts(place)) else { continue };
            for cell in lip.cells.map(usize::from) {
                let Some(mobility) = self.arrays.mobility.get_mut(cell) else { continue };
                let more = ROUNDED_UP * lip.weight * *mobility;
                *mobility /= 1.0 + more;
                if let Some(factor) = self.arrays.factors.get_mut(cell) {
                    *factor *= (1.0 + more) / (1.0 + *factor * more);
                }
            }
        }
        self.freeze();
    }

    /// Returns true if the lip in a place has a normal.
    fn counts(&self, place: usize) -> bool {
        self.arrays.normals.get(place).is_some_and(|normal| *normal != [0.0; 3])
    }

    /// Turns the normals for a tick, after which the energy of the lips is at most `most`, in internal units.
    pub(crate) fn turn_lips(
        &mut self,
        most: f64,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) -> Turned {
        let mut turned = Turned::default();
        self.face_lips(at);
        for place in 0..LIPS * self.used() {
            let normal = self.lip(place).map(|lip| {
                let before = self.arrays.normals.get(place).copied().unwrap_or_default();
                let normal = self.normal(place, &lip, at, states).unwrap_or_default();
                let places = lip.cells.map(|cell| at(cell.into()));
                // A lip presses no harder than before.
                let [was, is] = [before, normal].map(|normal| depth(normal, places));
                let normal = if is > was { scale(FALL * was / is, normal) } else { normal };
                let way = sub(normal, before);
                if dot(way, way) > STILL * STILL { normal } else { before }
            });
            self.set_normal(place, normal.unwrap_or_default(), &mut turned);
        }
        // Neither do lips to which a split has added faces.
        turned.energy = self.lips_energy(at);
        if turned.energy > most {
            let share = FALL * sqrt((most / turned.energy) as f32);
            for place in 0..LIPS * self.used() {
                let normal = self.arrays.normals.get(place).copied().unwrap_or_default();
                self.set_normal(place, scale(share, normal), &mut turned);
            }
            turned.energy = self.lips_energy(at);
        }
        turned
    }

    /// Sets the normal in a place.
    fn set_normal(&mut self, place: usize, normal: [f32; 3], turned: &mut Turned) {
        let counted = self.counts(place);
        if let Some(slot) = self.arrays.normals.get_mut(place) {
            let before = core::mem::replace(slot, normal.map(|x| x + 0.0));
            turned.any |= before != *slot;
        }
        turned.others_count |= counted != self.counts(place);
    }

    /// Normal of a lip, times the root of its share.
    fn normal(
        &self,
        place: usize,
        lip: &Lip,
        at: &impl Fn(usize) -> [f32; 3],
        states: States<'_>,
    ) -> Option<[f32; 3]> {
        let turn = |cell: u16| Term::<f32>::turn(self.shapes(), cell.into(), of_shapes(states));
        let normal = if self.is_of_links() {
            *self.arrays.links.lip_areas.get(place)?
        } else {
            let turned = |cell: u16| Some(turned(Turn::new(turn(cell)?)?, lip.area));
            let [first, second] = lip.cells.map(turned);
            add(first?, second?)
        };
        let size = sqrt(dot(normal, normal));
        let unit = (size > 0.0).then(|| scale(1.0 / size, normal))?;
        let [one, other] = lip.cells.map(|cell| at(cell.into()));
        let way = sub(other, one);
        let share = share(sqrt(dot(way, way)) / lip.edge);
        Some(scale(sqrt(share), unit))
    }

    /// Energy of the lips, in internal units.
    pub(crate) fn lips_energy(&self, at: &impl Fn(usize) -> [f32; 3]) -> f64 {
        let energies = self.lips().map(|(place, lip)| {
            let normal = self.arrays.normals.get(place).copied().unwrap_or_default();
            let depth = f64::from(depth(normal, lip.cells.map(|cell| at(cell.into()))));
            0.25 * f64::from(lip.weight) * depth * depth
        });
        energies.sum()
    }
}
