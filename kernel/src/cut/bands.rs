//! The stiffening bands of a body that is cut.
//!
//! A link's bands have the weights `w_s` = 2 `E_s` V / l0^2, V the volume of the tetrahedra around it. Where these fall
//! apart, each piece has a link with its share of V, see `shares`. Rest length and bands stay and copies lie where
//! their cell lies, so the shares store what the link stored: no offset is needed. The shares of a link add up to at
//! most its weight, so no copy has more than the cell from which it was copied, whose bound it inherits.
//!
//! Cost: a look at the tetrahedra of a cell for each of its links, volumes only for one that is shared. RAM: 64 bytes
//! for each group of eight half-links.

use super::body::CutBody;
use super::memory::{BandArrays, inherit};
use super::shares::{lane_of, put_lane};
use crate::model::stiffening::Stiffening;
use crate::model::{others, range};
use crate::number::two_float::LANES;

impl CutBody<'_, '_> {
    /// The bands as the image has them.
    pub(super) fn derive_bands(&mut self) {
        let baked = others::bands(&self.model.others);
        let arrays = &mut self.arrays.bands;
        for (array, of_image) in
            [(&mut *arrays.volumes, baked.volumes), (&mut *arrays.lengths, baked.lengths)]
        {
            array.iter_mut().zip(of_image).for_each(|(slot, numbers)| *slot = *numbers);
        }
    }

    /// Sets the bands of a cell's half-links from their tetrahedra.
    pub(super) fn renumber_bands(&mut self, cell: usize) {
        let baked = others::bands(&self.model.others);
        if !baked.is_any() {
            return;
        }
        let lane = cell % LANES;
        for group in range(self.arrays.rows, cell / LANES) {
            let end = lane_of(self.arrays.ids, group, lane).map_or(cell, usize::from);
            let (here, there) = (self.origin(cell), self.origin(end));
            let numbers = self.image_group(here, there).filter(|_| end != cell).map(|whole| {
                let volume = Stiffening::at(baked.volumes, whole, here);
                [self.weight_share(cell, end, volume), Stiffening::at(baked.lengths, whole, here)]
            });
            let [volume, length] = numbers.unwrap_or_default();
            self.arrays.bands.put(group, lane, volume, length);
        }
    }

    /// The bands as they are now.
    pub(super) fn bands(&self) -> Stiffening<'_> {
        let arrays = &self.arrays;
        Stiffening {
            volumes: arrays.bands.volumes,
            lengths: arrays.bands.lengths,
            rows: arrays.rows,
            ids: arrays.ids,
            rest: arrays.rest,
            ..others::bands(&self.model.others)
        }
    }
}

impl BandArrays<'_> {
    /// Sets the numbers of a half-link: its volume by its squared rest length, and its rest length.
    pub(super) fn put(&mut self, group: usize, lane: usize, volume: f32, length: f32) {
        put_lane(self.volumes, group, lane, volume);
        put_lane(self.lengths, group, lane, length);
    }

    /// Moves the numbers of a group.
    pub(super) fn move_group(&mut self, from: usize, to: usize) {
        inherit(self.volumes, from, to);
        inherit(self.lengths, from, to);
    }
}
