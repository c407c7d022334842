//! Nodal shapes in an image: the numbers of every cell and every half-link.

#[cfg(feature = "relax")]
use super::branches::{self, BranchNumbers};
use super::image::{LAW_DET1, ModelError, Sections, kind, nodal, params};
use super::layout::Layout;
use super::range;
use super::terms::{Keeps, TermData};
use crate::number::cell::dot;
use crate::number::two_float::LANES;
#[cfg(feature = "relax")]
use crate::number::two_float::TwoFloat;

/// Ranges far beyond those of a mesh, within which energies and forces stay finite up to [`SATURATION_MAX`]:
/// volumes, moduli, and spreads [mean link lengths, 2 `k_ref` / l].
const VOLUMES: core::ops::RangeInclusive<f32> = 1.0e-12..=1.0e6;
const MODULI: core::ops::RangeInclusive<f32> = nodal::MU_MIN..=1.0e6;
const LAMBDA_3_MAX: f32 = 1.0e9;
const BAND_MAX: f32 = 1.0e9;
/// Largest stretch at which a band begins.
const STRETCH_MAX: f32 = 0.95;
const SPREAD_MAX: f32 = 1.0e12;
/// Largest slope of a hat function [1 / mean link length].
const SLOPE_MAX: f32 = 1.0e4;
/// Largest K of a body of nodal shapes [mean link lengths].
const SATURATION_MAX: f32 = 1.0e5;
/// Share of a row's diagonal element that rounding may have taken from the row's bound.
const ROUNDING: f32 = 1.0e-3;

/// Numbers of eight cells, by number and lane.
pub(crate) type CellNumbers = [[f32; LANES]; nodal::CELL_ROWS];
/// Numbers of eight half-links, by number and lane.
pub(crate) type SlotNumbers = [[f32; LANES]; nodal::SLOT_ROWS];

/// Offsets of eight cells, by element and lane.
pub(crate) type OffsetNumbers = [[f32; LANES]; 9];

/// A half-link: the numbers of a group of eight, and the lane of this one.
#[derive(Clone, Copy)]
pub(crate) struct Slot<'a> {
    numbers: &'a SlotNumbers,
    lane: usize,
}

impl Slot<'_> {
    /// Returns a number of the half-link.
    #[inline(always)]
    pub fn number(self, row: usize) -> f32 {
        self.numbers.get(row).and_then(|lanes| lanes.get(self.lane)).copied().unwrap_or(0.0)
    }

    /// Returns three consecutive numbers.
    #[inline(always)]
    pub fn three(self, row: usize) -> [f32; 3] {
        [self.number(row), self.number(row + 1), self.number(row + 2)]
    }
}

/// The nodal shapes of a body; none in a body of links.
#[derive(Clone, Copy)]
pub(crate) struct Nodal<'a> {
    /// Numbers of the cells, by slice.
    pub cells: &'a [CellNumbers],
    /// Numbers of the half-links, by group of the slices.
    pub slots: &'a [SlotNumbers],
    /// Groups of each slice, slices + 1.
    pub rows: &'a [u32],
    /// Other ends, by group and lane.
    pub ids: &'a [[u16; LANES]],
    /// Rest positions of the cells.
    pub rest: &'a [[f32; 3]],
    /// Number of cells.
    pub count: usize,
    /// Stretch at which the band begins; 0 for no band.
    pub stretch_min: f32,
    /// Offsets of the cells' shapes, by slice; none in a body without cuts.
    #[cfg(feature = "cut")]
    pub offsets: &'a [OffsetNumbers],
    /// 1 for each slice in which a cell has an offset.
    #[cfg(feature = "cut")]
    pub is_offset: &'a [u8],
    /// Branches of relaxation, of a body of links too; none in an elastic body.
    #[cfg(feature = "relax")]
    pub branches: &'a [BranchNumbers],
    /// How the body remembers its strain in this tick; none outside a tick.
    #[cfg(feature = "relax")]
    pub memory: Remembered<'a>,
}

/// Proof that this kernel is built with relaxation: without, there is no such value.
#[cfg(feature = "relax")]
pub(crate) type Relaxing = ();
#[cfg(not(feature = "relax"))]
pub(crate) type Relaxing = core::convert::Infallible;

/// The memory of a slice, and the part of the shear modulus that acts.
pub(crate) type SliceMemoryOf<'a> = Option<(&'a MemoryNumbers, f32, Relaxing)>;

/// Numbers by which eight cells remember their strain, by number and lane: A - I in the order xx, yy, zz, xy, xz, yz,
/// twice the energy density that R does not change, and the force of the spread.
pub(crate) type MemoryNumbers = [[f32; LANES]; 10];

/// Numbers by which eight half-links of a body of links remember their tension, by number and lane, see
/// [`memory`](crate::energy::links).
#[cfg(feature = "relax")]
pub(crate) type HalfLinkMemory = [[f32; LANES]; 2];

/// The memory of a body that relaxes, constant in a tick, see [`memory`](crate::energy::nodal).
#[cfg(feature = "relax")]
#[derive(Clone, Copy)]
pub(crate) struct Remembered<'a> {
    /// Numbers by slice.
    pub numbers: &'a [MemoryNumbers],
    /// Those of a body of links, by group of half-links.
    pub links: &'a [HalfLinkMemory],
    /// The part of the instantaneous modulus that acts in this tick.
    pub part: f32,
    /// Energy of the spread that no cell's number has, in internal units.
    pub energy: TwoFloat,
}

#[cfg(feature = "relax")]
impl Remembered<'_> {
    pub const NONE: Self = Self { numbers: &[], links: &[], part: 1.0, energy: TwoFloat::ZERO };
}

impl<'a> Nodal<'a> {
    pub const NONE: Self = Self {
        cells: &[],
        slots: &[],
        rows: &[],
        ids: &[],
        rest: &[],
        count: 0,
        stretch_min: 0.0,
        #[cfg(feature = "cut")]
        offsets: &[],
        #[cfg(feature = "cut")]
        is_offset: &[],
        #[cfg(feature = "relax")]
        branches: &[],
        #[cfg(feature = "relax")]
        memory: Remembered::NONE,
    };

    /// Returns true if the body is made of shapes.
    #[inline(always)]
    pub fn is_any(&self) -> bool {
        self.count > 0
    }

    /// Returns the offsets of a slice, if one of its cells has one.
    #[inline(always)]
    #[cfg(feature = "cut")]
    pub fn offset_of(&self, slice: usize) -> Option<&'a OffsetNumbers> {
        if *self.is_offset.get(slice)? == 0 { None } else { self.offsets.get(slice) }
    }

    /// Returns no offsets: this kernel is built without cuts.
    #[inline(always)]
    #[cfg(not(feature = "cut"))]
    pub fn offset_of(&self, _: usize) -> Option<&'a OffsetNumbers> {
        None
    }

    /// Returns what a slice remembers, with the part of the shear modulus that acts; `None` in an elastic body.
    #[inline(always)]
    #[cfg(feature = "relax")]
    pub fn memory_of(&self, slice: usize) -> SliceMemoryOf<'a> {
        Some((self.memory.numbers.get(slice)?, self.memory.part, ()))
    }

    /// Returns nothing: this kernel is built without relaxation.
    #[inline(always)]
    #[cfg(not(feature = "relax"))]
    pub fn memory_of(&self, _: usize) -> SliceMemoryOf<'a> {
        None
    }

    /// Returns a number of a cell.
    #[inline(always)]
    pub fn number(&self, cell: usize, row: usize) -> f32 {
        let lanes = self.cells.get(cell / LANES).and_then(|slice| slice.get(row));
        lanes.and_then(|lanes| lanes.get(cell % LANES)).copied().unwrap_or(0.0)
    }

    /// Returns the slots of a cell, their other ends and their numbers, including padding.
    #[inline(always)]
    pub fn slots_of(self, cell: usize) -> impl Iterator<Item = (usize, Slot<'a>)> {
        let (groups, lane) = (range(self.rows, cell / LANES), cell % LANES);
        let rows = self.slots.get(groups.clone()).zip(self.ids.get(groups));
        let (slots, ids) = rows.unwrap_or_default();
        slots.iter().zip(ids).map(move |(numbers, ids)| {
            let other = ids.get(lane).copied().unwrap_or_default();
            (usize::from(other), Slot { numbers, lane })
        })
    }

    /// Returns the half-links of a cell: their other ends, ascending, and their numbers.
    #[inline(always)]
    pub fn half_links_of(self, cell: usize) -> impl Iterator<Item = (usize, Slot<'a>)> {
        self.slots_of(cell).filter(move |&(other, _)| other != cell)
    }

    /// Returns `a_ii`.
    pub fn own_area(&self, cell: usize) -> [f32; 3] {
        [0, 1, 2].map(|axis| self.number(cell, nodal::OWN + axis))
    }

    /// Returns the rest position of a cell, zeros beyond the last one.
    #[inline(always)]
    pub fn rest_position(&self, cell: usize) -> [f32; 3] {
        self.rest.get(cell).copied().unwrap_or_default()
    }

    /// Returns `a_ji`: the numbers of the half-link from `other` back to `cell`, zeros without one.
    pub fn back_area(&self, cell: usize, other: usize) -> [f32; 3] {
        let mut slots = self.slots_of(other);
        slots.find(|&(end, _)| end == cell).map_or([0.0; 3], |(_, slot)| slot.three(nodal::AREA))
    }

    /// Visits the part of a row of L that comes from cell k's shape, in whose gradient the row's cell has
    /// the coefficient `area`.
    fn through(&self, k: usize, area: [f32; 3], visit: &mut impl FnMut(usize, f32)) {
        let even = 2.0 * (1.0 - nodal::BETA) * self.number(k, nodal::MU);
        let (band, volume) = (self.number(k, nodal::BAND), self.number(k, nodal::LAMBDA_3));
        let share = 1.0 / self.number(k, nodal::VOLUME);
        let weight = share * (even + band + volume);
        visit(k, weight * dot(area, self.own_area(k)));
        for (other, slot) in self.slots_of(k) {
            visit(other, weight * dot(area, slot.three(nodal::AREA)));
        }
    }

    /// Returns true if a cell may have this stiffness of the band.
    fn is_band(&self, band: f32) -> bool {
        let most = if self.stretch_min > 0.0 { BAND_MAX } else { 0.0 };
        (0.0..=most).contains(&band)
    }

    fn check_cell(&self, cell: usize) -> Result<(), ModelError> {
        let at = |row| self.number(cell, row);
        let volume = at(nodal::VOLUME);
        let is_small = |area: f32| area.abs() <= SLOPE_MAX * volume;
        let holds = VOLUMES.contains(&volume)
            && MODULI.contains(&at(nodal::MU))
            && (0.0..=LAMBDA_3_MAX).contains(&at(nodal::LAMBDA_3))
            && self.is_band(at(nodal::BAND))
            && (0..3).all(|axis| is_small(at(nodal::OWN + axis)));
        if !holds {
            return Err(ModelError::Value(kind::NODAL_CELLS, cell as u32));
        }
        let areas = self.slots_of(cell).flat_map(|(_, slot)| slot.three(nodal::AREA));
        if !areas.into_iter().all(is_small) {
            return Err(ModelError::Value(kind::NODAL_SLOTS, cell as u32));
        }
        Ok(())
    }

    /// Checks that the row bound of L is at least the row's diagonal element. The bake is responsible for the
    /// row sum, as it is for the inverse of the coarse level.
    fn check_bound(&self, layout: &Layout<'_>, cell: usize) -> Result<(), ModelError> {
        let (bound, mut diagonal) = (self.number(cell, nodal::BOUND), 0.0);
        self.each_of_row(cell, &mut |other, element| {
            diagonal += if other == cell { element } else { 0.0 };
        });
        if !(bound > 0.0 && bound >= (1.0 - ROUNDING) * diagonal) {
            return Err(ModelError::Value(kind::NODAL_CELLS, cell as u32));
        }
        if bound > layout.degree_bound {
            return Err(ModelError::Parameter(params::DEGREE_BOUND as u32));
        }
        Ok(())
    }

    fn check_group(
        &self,
        layout: &Layout<'_>,
        slice: usize,
        group: usize,
    ) -> Result<(), ModelError> {
        let wrong = || ModelError::Value(kind::NODAL_SLOTS, group as u32);
        let (slots, ids) = self.slots.get(group).zip(self.ids.get(group)).ok_or_else(wrong)?;
        let spreads = slots.get(nodal::SPREAD).ok_or_else(wrong)?;
        if !spreads.iter().all(|spread| spread.abs() <= SPREAD_MAX) {
            return Err(wrong());
        }
        for (lane, &id) in ids.iter().enumerate() {
            let (i, j) = (slice * LANES + lane, usize::from(id));
            // Padding exerts no force.
            let is_idle = slots.iter().all(|row| row.get(lane) == Some(&0.0));
            if (i >= layout.cells() || i == j) && !is_idle {
                return Err(wrong());
            }
        }
        Ok(())
    }
}

/// R as a unit quaternion, the real part first, then Q by rows.
impl Keeps for Nodal<'_> {
    const LASTING: usize = 13;

    fn at_rest(row: usize) -> f32 {
        if matches!(row, 0 | 4 | 8 | 12) { 1.0 } else { 0.0 }
    }
}

impl<'a> TermData<'a> for Nodal<'a> {
    fn read(sections: &Sections<'a>) -> Result<Self, ModelError> {
        let none = Self {
            #[cfg(feature = "relax")]
            branches: branches::read(sections)?,
            ..Self::NONE
        };
        let Some(words) = sections.optional::<u32>(kind::NODAL)? else {
            // Links that relax do so by their slices.
            #[cfg(feature = "relax")]
            if !none.branches.is_empty() {
                sections.required::<[u16; LANES]>(kind::SLICE_NEIGHBOURS)?;
            }
            return Ok(none);
        };
        let stretch_min = match *words {
            [LAW_DET1, stretch] => f32::from_bits(stretch),
            [_, _] => return Err(ModelError::SectionVersion(kind::NODAL)),
            _ => return Err(ModelError::SectionSize(kind::NODAL)),
        };
        if stretch_min.to_bits() != 0 && !(0.01..=STRETCH_MAX).contains(&stretch_min) {
            return Err(ModelError::Value(kind::NODAL, 1));
        }
        let ids: &[[u16; LANES]] = sections.required(kind::SLICE_NEIGHBOURS)?;
        let rows: &[u32] = sections.required(kind::SLICE_ROWS)?;
        let rest: &[[f32; 3]] = sections.required(kind::REST)?;
        let count = rest.len();
        let cells = sections.sized(kind::NODAL_CELLS, count.div_ceil(LANES))?;
        let slots = sections.sized(kind::NODAL_SLOTS, ids.len())?;
        Ok(Self { cells, slots, rows, ids, rest, count, stretch_min, ..none })
    }

    fn check(&self, layout: &Layout<'_>) -> Result<(), ModelError> {
        if !self.is_any() {
            return Ok(());
        }
        if self.count != layout.cells() || layout.has_weights || layout.has_slack {
            return Err(ModelError::Layout);
        }
        for cell in 0..layout.cells() {
            self.check_cell(cell)?;
        }
        for slice in 0..layout.slices() {
            if range(self.rows, slice).len() > nodal::LINKS_MAX {
                return Err(ModelError::Index(kind::SLICE_ROWS, slice as u32));
            }
            for group in range(self.rows, slice) {
                self.check_group(layout, slice, group)?;
            }
        }
        for cell in 0..layout.cells() {
            self.check_bound(layout, cell)?;
        }
        if layout.saturation <= SATURATION_MAX {
            Ok(())
        } else {
            Err(ModelError::Parameter(params::SATURATION as u32))
        }
    }

    fn add_bound(&self, cell: usize, sum: f32) -> f32 {
        sum + self.number(cell, nodal::BOUND)
    }

    fn rests(&self, _: &Layout<'_>) -> bool {
        true
    }

    fn keeps(&self) -> bool {
        self.is_any()
    }

    fn each_of_row(&self, cell: usize, visit: &mut impl FnMut(usize, f32)) {
        if !self.is_any() {
            return;
        }
        self.through(cell, self.own_area(cell), visit);
        for (other, slot) in self.half_links_of(cell) {
            self.through(other, self.back_area(cell, other), visit);
            visit(cell, slot.number(nodal::SPREAD));
            visit(other, -slot.number(nodal::SPREAD));
        }
    }

    fn is_dormant(&self, cell: usize) -> bool {
        if !self.is_any() {
            return true;
        }
        let numbers = [nodal::VOLUME, nodal::MU, nodal::LAMBDA_3, nodal::BAND, nodal::BOUND];
        let [volume, mu, lambda_3, band, bound] = numbers.map(|row| self.number(cell, row));
        let least = *MODULI.start();
        let area = self.own_area(cell);
        (volume, mu, bound) == (1.0, least, least)
            && [lambda_3, band] == [0.0; 2]
            && area == [0.0; 3]
    }

    fn elasticity(&self, cell: usize, unit_pa: f32) -> Option<[f32; 2]> {
        if cell >= self.count {
            return None;
        }
        let (mu, lambda) = (self.number(cell, nodal::MU), self.number(cell, nodal::LAMBDA_3) / 3.0);
        let poisson = 0.5 * lambda / (lambda + mu);
        Some([2.0 * mu * (1.0 + poisson) * unit_pa, poisson])
    }

    fn stretch_min(&self) -> Option<f32> {
        self.is_any().then_some(self.stretch_min)
    }

    #[cfg(feature = "relax")]
    fn branches(&self) -> &'a [BranchNumbers] {
        self.branches
    }

    fn replaces_links(&self) -> bool {
        self.is_any()
    }
}
