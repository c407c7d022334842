//! The surface in an image that tools touch: the contact stiffness of the triangles of `TRIANGLES`.

use super::image::{ModelError, Sections, contact, kind};
use super::opened::Opened;
use crate::number::sqrt::sqrt;

/// A range far beyond the numbers of meshes and tissue.
const NUMBERS: core::ops::RangeInclusive<f32> = 1.0e-12..=1.0e12;
/// Smallest and largest contact stiffness, relative to tissue as deep as an edge is long.
const STIFFNESS: [f32; 2] = [6.0, 20.0];
/// Relative contact stiffness per ratio of radius to edge length.
const OF_RADIUS: f32 = 8.0;
/// Stiffness of a rigid pin on shapes, relative to tissue as deep as an edge is long; and on links, whose guard would
/// discard most passes of a body with a stiffer one.
const RIGID: f32 = 200.0;
const RIGID_ON_LINKS: f32 = 10.0;
/// Largest distance between samples, in radii.
const SPACING: f32 = 0.45;
/// Most triangles per cell, far above the two of a closed surface: a tick visits each.
const TRIANGLES_MAX: usize = 16;
/// Most subdivisions of an edge.
pub(crate) const SUBDIVISIONS_MAX: u16 = 32;
/// Most samples along an edge.
const PARTS_MAX: f32 = SUBDIVISIONS_MAX as f32;

/// The triangles that tools touch, with their contact numbers.
#[derive(Clone, Copy)]
pub(crate) struct ContactSurface<'a> {
    /// Corners, outward: of the image's triangles, then of opened faces.
    pub triangles: &'a [[u16; 3]],
    /// Numbers of the image's triangles.
    numbers: &'a [[f32; 3]],
    opened: Opened<'a>,
}

/// A triangle at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Triangle {
    /// E a / h [2 `k_ref`], a its area and h the mean length of its edges.
    pub stiffness: f32,
    /// h [mean link lengths].
    pub edge: f32,
    /// a [mean link lengths squared].
    pub area: f32,
}

impl Triangle {
    /// Returns the total stiffness of all samples under a sphere [2 `k_ref`].
    pub fn weight(&self, radius: f32) -> f32 {
        let [least, most] = STIFFNESS;
        let times = OF_RADIUS * radius / self.edge;
        // Not by `clamp`, which may panic.
        let times = if times < least { least } else { times };
        self.stiffness * if times > most { most } else { times }
    }

    /// Returns the total stiffness of all samples under a rigid pin [2 `k_ref`].
    pub fn rigid(&self, is_nodal: bool) -> f32 {
        self.stiffness * if is_nodal { RIGID } else { RIGID_ON_LINKS }
    }

    /// Returns the number of subdivisions of an edge. There is a sample at the centre of each part.
    pub fn parts(&self, radius: f32) -> u16 {
        let parts = sqrt(self.area) / (SPACING * radius);
        let parts = if parts < PARTS_MAX { parts } else { PARTS_MAX };
        let whole = parts as u16;
        (whole + u16::from(f32::from(whole) < parts)).max(2)
    }
}

impl<'a> ContactSurface<'a> {
    /// The triangles with their numbers, without opened faces.
    pub fn of(triangles: &'a [[u16; 3]], numbers: &'a [[f32; 3]]) -> Self {
        Self { triangles, numbers, opened: Opened::NONE }
    }

    /// The same, of which the last triangles are those of opened faces.
    pub fn with(self, opened: Opened<'a>) -> Self {
        Self { opened, ..self }
    }

    /// Reads the contact numbers of an image, `None` if it has none.
    pub fn read(sections: &Sections<'a>) -> Result<Option<&'a [[f32; 3]]>, ModelError> {
        let Some(numbers) = sections.optional::<[f32; 3]>(kind::CONTACT)? else {
            return Ok(None);
        };
        let _: &[[u16; 3]] = sections.sized(kind::TRIANGLES, numbers.len())?;
        Ok(Some(numbers))
    }

    /// Checks the numbers and their count; the corners are checked with `TRIANGLES`.
    pub fn check(&self, cells: usize) -> Result<(), ModelError> {
        if self.numbers.len() > TRIANGLES_MAX * cells {
            return Err(ModelError::SectionSize(kind::CONTACT));
        }
        for (position, numbers) in self.numbers.iter().enumerate() {
            if !numbers.iter().all(|number| NUMBERS.contains(number)) {
                return Err(ModelError::Value(kind::CONTACT, position as u32));
            }
        }
        Ok(())
    }

    /// Smallest radius of a tool's part, at which the samples are just dense enough [mean link lengths].
    pub fn radius_min(&self) -> f32 {
        let areas = (0..self.triangles.len()).filter_map(|index| self.triangle(index));
        let largest = areas.fold(0.0, |most, (_, of)| if of.area > most { of.area } else { most });
        sqrt(largest) / (SPACING * PARTS_MAX)
    }

    /// Place of a triangle among those of opened faces; `None` for one of the image.
    #[inline(always)]
    fn opened_place(&self, index: usize) -> Option<usize> {
        index.checked_sub(self.numbers.len())
    }

    /// Name of a triangle: its index for those of the image. Names ascend.
    #[inline(always)]
    pub fn name(&self, index: usize) -> u32 {
        let opened = self.opened_place(index).and_then(|place| self.opened.name(place));
        opened.unwrap_or(index as u32)
    }

    /// Returns the corners and the numbers of the triangle with this name; `None` if there is none.
    pub fn named(&self, name: u32) -> Option<([u16; 3], Triangle)> {
        let index = match self.opened_place(name as usize) {
            None => name as usize,
            Some(_) => self.opened.place(name)? + self.numbers.len(),
        };
        self.triangle(index)
    }

    /// Share of its stiffness with which tools touch a triangle; 0 for one of a dropped piece, whose corners are one
    /// cell.
    #[inline(always)]
    pub fn share(&self, index: usize, edge: f32, at: &impl Fn(usize) -> [f32; 3]) -> f32 {
        let Some(place) = self.opened_place(index) else {
            let is_gone = self.triangles.get(index).is_some_and(|[a, b, _]| a == b);
            return if is_gone { 0.0 } else { 1.0 };
        };
        let opened = self.triangles.get(self.numbers.len()..).unwrap_or(&[]);
        self.opened.share(opened, place, edge, at)
    }

    /// Returns the corners and the numbers of a triangle.
    pub fn triangle(&self, index: usize) -> Option<([u16; 3], Triangle)> {
        let numbers = match self.opened_place(index) {
            None => self.numbers.get(index)?,
            Some(place) => self.opened.numbers(place)?,
        };
        let at = |row: usize| numbers.get(row).copied().unwrap_or(1.0);
        let [stiffness, edge, area] = [contact::STIFFNESS, contact::EDGE, contact::AREA].map(at);
        Some((*self.triangles.get(index)?, Triangle { stiffness, edge, area }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_parts_meet_more_samples_and_softer_ones() {
        let of = Triangle { stiffness: 2.0, edge: 1.0, area: 0.5 };
        assert_eq!(
            [0.1, 0.75, 1.0, 2.5, 10.0].map(|r| of.weight(r)),
            [12.0, 12.0, 16.0, 40.0, 40.0]
        );
        assert_eq!([10.0, 0.79, 0.78, 0.5, 0.1, 1e-9].map(|r| of.parts(r)), [2, 2, 3, 4, 16, 32]);
    }
}
