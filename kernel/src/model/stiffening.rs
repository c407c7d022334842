//! Stiffening in an image: sets of bands on the links of a body of nodal shapes.

use super::image::{ModelError, STIFFENING_MAX, Sections, kind};
use super::layout::Layout;
use super::terms::{Keeps, TermData};
use super::{range, slots_of};
use crate::number::two_float::LANES;

/// Ranges far beyond those of tissue.
const HALF_WIDTHS: core::ops::Range<f32> = 0.01..1.0;
const MODULI: core::ops::RangeInclusive<f32> = 1.0e-6..=1.0e6;
const VOLUME_MAX: f32 = 1.0e6;

/// A set of bands: every link outside its band is a spring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Set {
    /// Half the width of the band in rest lengths.
    pub half_width: f32,
    /// Young's modulus of only this set, of links shorter than their band and of longer ones [2 `k_ref` / l].
    pub moduli: [f32; 2],
}

impl Set {
    /// Of the numbers in the image, whose signs leave a side out.
    #[inline(always)]
    fn of(numbers: [u32; 2]) -> Self {
        let [half_width, modulus] = numbers.map(f32::from_bits);
        let size = modulus.abs();
        let short = if modulus < 0.0 { 0.0 } else { size };
        let long = if half_width < 0.0 { 0.0 } else { size };
        Self { half_width: half_width.abs(), moduli: [short, long] }
    }

    /// True if a set of the same band resists links on the same side.
    fn repeats(self, other: Self) -> bool {
        let mut sides = self.moduli.iter().zip(&other.moduli);
        self.half_width == other.half_width && sides.any(|(one, two)| *one > 0.0 && *two > 0.0)
    }
}

/// The sets of a body, the narrowest band first. Most bodies have none.
#[derive(Clone, Copy)]
pub(crate) struct Stiffening<'a> {
    /// Bits of the half-width and the modulus of each set as the image has them.
    pub sets: &'a [[u32; 2]],
    /// 2 V / l0^2 of each slot, with V the volume of the tetrahedra around its link. Times the modulus of a
    /// set it is the link's weight in that set.
    pub volumes: &'a [[f32; LANES]],
    /// Rest lengths of the slots.
    pub lengths: &'a [[f32; LANES]],
    /// Groups of each slice, slices + 1.
    pub rows: &'a [u32],
    /// Other ends, by group and lane.
    pub ids: &'a [[u16; LANES]],
    /// Rest positions.
    pub rest: &'a [[f32; 3]],
}

impl<'a> Stiffening<'a> {
    pub const NONE: Self =
        Self { sets: &[], volumes: &[], lengths: &[], rows: &[], ids: &[], rest: &[] };

    /// Returns true if the body has a set.
    #[inline(always)]
    pub fn is_any(&self) -> bool {
        !self.sets.is_empty()
    }

    /// Returns the sets, the narrowest band first.
    #[inline(always)]
    pub fn sets(self) -> impl Iterator<Item = Set> + use<'a> {
        self.sets.iter().copied().map(Set::of)
    }

    /// Returns the sum of the moduli of all sets that resist a link on the same side, the larger one of both sides: no
    /// link is shorter and longer at once.
    #[inline(always)]
    pub fn modulus(&self) -> f32 {
        let [short, long] = self
            .sets()
            .fold([0.0_f32; 2], |[short, long], set| [short + set.moduli[0], long + set.moduli[1]]);
        if short > long { short } else { long }
    }

    /// Returns the slots of a cell without padding: group and other end.
    #[inline(always)]
    pub fn slots_of(self, cell: usize) -> impl Iterator<Item = (usize, usize)> + use<'a> {
        slots_of(self.rows, self.ids, cell)
    }

    /// Returns a cell's value in a group.
    #[inline(always)]
    pub fn at(values: &[[f32; LANES]], group: usize, cell: usize) -> f32 {
        values.get(group).and_then(|lanes| lanes.get(cell % LANES)).copied().unwrap_or(0.0)
    }

    /// Returns the sum of the weights of a cell's links over all sets.
    pub fn weight(&self, cell: usize) -> f32 {
        let volumes = self.slots_of(cell).map(|(group, _)| Self::at(self.volumes, group, cell));
        self.modulus() * volumes.fold(0.0, |sum, volume| sum + volume)
    }

    fn check_sets(self) -> Result<(), ModelError> {
        let mut last: Option<Set> = None;
        for (position, set) in self.sets().enumerate() {
            let Set { half_width, moduli: [short, long] } = set;
            let ascends =
                last.is_none_or(|last| half_width >= last.half_width && !set.repeats(last));
            last = Some(set);
            let modulus = if short > 0.0 { short } else { long };
            if !(ascends && HALF_WIDTHS.contains(&half_width) && MODULI.contains(&modulus)) {
                return Err(ModelError::Value(kind::STIFFENING, position as u32));
            }
        }
        Ok(())
    }

    /// Checks that both ends of a link have the same value, and padding has 0.
    fn check_slots(self, cells: usize) -> Result<(), ModelError> {
        for (group, volumes) in self.volumes.iter().enumerate() {
            let wrong = || ModelError::Value(kind::STIFFENING_SLOTS, group as u32);
            if !volumes.iter().all(|volume| (0.0..=VOLUME_MAX).contains(volume)) {
                return Err(wrong());
            }
        }
        for slice in 0..cells.div_ceil(LANES) {
            for group in range(self.rows, slice) {
                let wrong = || ModelError::Value(kind::STIFFENING_SLOTS, group as u32);
                for cell in slice * LANES..(slice + 1) * LANES {
                    let here = Self::at(self.volumes, group, cell);
                    let other = self.ids.get(group).and_then(|ids| ids.get(cell % LANES));
                    let other = usize::from(*other.ok_or_else(wrong)?);
                    let back = self.slots_of(other).find(|&(_, end)| end == cell);
                    let there = back.map_or(0.0, |(group, _)| Self::at(self.volumes, group, other));
                    if here != if cell < cells && cell != other { there } else { 0.0 } {
                        return Err(wrong());
                    }
                }
            }
        }
        Ok(())
    }
}

impl Keeps for Stiffening<'_> {}

impl<'a> TermData<'a> for Stiffening<'a> {
    fn read(sections: &Sections<'a>) -> Result<Self, ModelError> {
        let Some(sets) = sections.optional::<[u32; 2]>(kind::STIFFENING)? else {
            return Ok(Self::NONE);
        };
        if !(1..=STIFFENING_MAX).contains(&sets.len())
            || sections.optional::<u32>(kind::NODAL)?.is_none()
        {
            return Err(ModelError::Layout);
        }
        let ids: &[[u16; LANES]] = sections.required(kind::SLICE_NEIGHBOURS)?;
        Ok(Self {
            sets,
            volumes: sections.sized(kind::STIFFENING_SLOTS, ids.len())?,
            lengths: sections.sized(kind::SLICE_LENGTHS, ids.len())?,
            rows: sections.required(kind::SLICE_ROWS)?,
            ids,
            rest: sections.required(kind::REST)?,
        })
    }

    fn check(&self, layout: &Layout<'_>) -> Result<(), ModelError> {
        self.check_sets()?;
        self.check_slots(layout.cells())
    }

    fn add_bound(&self, cell: usize, sum: f32) -> f32 {
        if self.is_any() { sum + self.weight(cell) } else { sum }
    }

    fn rests(&self, _: &Layout<'_>) -> bool {
        true
    }

    fn each_of_row(&self, cell: usize, visit: &mut impl FnMut(usize, f32)) {
        let half = 0.5 * self.modulus();
        for (group, other) in self.slots_of(cell) {
            let weight = half * Self::at(self.volumes, group, cell);
            visit(cell, weight);
            visit(other, -weight);
        }
    }

    fn stiffening(&self, unit_pa: f32, visit: &mut impl FnMut(f32, f32)) {
        for [half_width, modulus] in self.sets.iter().map(|numbers| numbers.map(f32::from_bits)) {
            visit(half_width, modulus * unit_pa);
        }
    }
}
