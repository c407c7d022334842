//! The half-links of a cell of a body of links, from its tetrahedra.
//!
//! A link of the image lies in the tetrahedra at its edge. Where these have fallen apart, each piece has a link with
//! its share of the weight, see `shares`. Rest length and band are those of the link. Copies lie where their cell lies,
//! so the shares store what the link stores, and a split leaves the energy as it is. **The bound.** The shares of a
//! link add up to at most its weight, and a copy has at most the weights of its cell: twice the diagonal of L, the sum
//! of the weights, never grows at a cell, and a copy may keep the mobility of the cell from which it was copied.
//! Half-links are in ascending order of their other ends, as in the image: the sums of a pass follow this order.
//!
//! Young's modulus, for the sides of opened faces, is that of the tissue to which the image's links are equivalent:
//! E = sum of k l^2 / (12 V_i) over the links at cell i, V_i a quarter of the volume of its tetrahedra.
//!
//! Cost: a look at the tetrahedra of a cell for each of its links, volumes only for one that is shared.

use super::body::CutBody;
use super::hats::gradients;
use super::memory::{ImageGroups, image_groups, inherit};
use super::shares::{lane_of, put_lane};
use crate::energy::links::law::{Band, link_force};
use crate::model::{range, slots_of};
use crate::number::cell::sub;
use crate::number::two_float::LANES;

/// Numbers of a half-link.
#[derive(Clone, Copy)]
pub(super) struct LinkNumbers {
    length: f32,
    weight: f32,
    alpha: f32,
}

impl LinkNumbers {
    /// Those of a place without a half-link.
    pub const PADDING: Self = Self { length: 0.0, weight: 1.0, alpha: 0.0 };
}

/// Sum of w l^2.
fn wl2(links: impl Iterator<Item = LinkNumbers>) -> f32 {
    links.fold(0.0, |sum, link| sum + link.weight * link.length * link.length)
}

impl CutBody<'_, '_> {
    /// Sets the half-links of a cell; one without a place in the cell's groups is left out.
    pub(super) fn relink(&mut self, cell: usize) {
        let (lane, groups) = (cell % LANES, range(self.arrays.rows, cell / LANES));
        for group in groups.clone() {
            self.put_link(group, lane, cell as u16, LinkNumbers::PADDING);
        }
        // Name the other ends, each once, ascending; the cell itself is behind the last one.
        let mut count = 0;
        for index in 0..self.star(cell).len() {
            let Some(tetrahedron) = self.tetrahedron_at(cell, index) else { continue };
            let corners = self.arrays.corners.get(tetrahedron).copied().unwrap_or_default();
            for id in corners.into_iter().filter(|&id| usize::from(id) != cell) {
                let known = groups.clone().take(count);
                let before =
                    known.filter(|&group| self.end_of(group, lane).is_some_and(|end| end < id));
                let place = groups.start + before.count();
                if self.end_of(place, lane) == Some(id) || count == groups.len() {
                    continue;
                }
                for group in (place..groups.start + count).rev() {
                    self.name_end(group + 1, lane, self.end_of(group, lane).unwrap_or(id));
                }
                self.name_end(place, lane, id);
                count += 1;
            }
        }
        // Then their numbers.
        for group in groups.take(count) {
            if let Some(end) = self.end_of(group, lane) {
                self.put_link(group, lane, end, self.link_numbers(cell, end.into()));
            }
        }
    }

    /// Names the other end of a cell's half-link anew; `to` is the last copy that the cell sees.
    pub(super) fn relink_end(&mut self, cell: usize, from: u16, to: u16) {
        let (lane, groups) = (cell % LANES, range(self.arrays.rows, cell / LANES));
        let Some(place) = groups.clone().find(|&group| self.end_of(group, lane) == Some(from))
        else {
            return;
        };
        // Those after it move one place down, and the renamed one takes the last place.
        let renamed = self.link_in(place, lane);
        let mut last = place;
        for group in place + 1..groups.end {
            match self.end_of(group, lane) {
                Some(end) if usize::from(end) != cell => {
                    self.put_link(last, lane, end, self.link_in(group, lane));
                    last = group;
                }
                _ => break,
            }
        }
        self.put_link(last, lane, to, renamed);
    }

    /// Numbers of the half-link of a cell to another one, from their tetrahedra.
    fn link_numbers(&self, cell: usize, other: usize) -> LinkNumbers {
        let (here, there) = (self.origin(cell), self.origin(other));
        let whole = self.image_link(here, there).unwrap_or(LinkNumbers::PADDING);
        LinkNumbers { weight: self.weight_share(cell, other, whole.weight), ..whole }
    }

    /// Numbers of a link of the image, if these cells are linked.
    fn image_link(&self, cell: usize, other: usize) -> Option<LinkNumbers> {
        self.image_link_in(self.image_group(cell, other)?, cell % LANES)
    }

    /// Numbers of the half-link of the image in a place.
    fn image_link_in(&self, group: usize, lane: usize) -> Option<LinkNumbers> {
        let slices = self.model.slices?;
        let number = |of: Option<&[[f32; LANES]]>, otherwise: f32| {
            of.and_then(|groups| lane_of(groups, group, lane)).unwrap_or(otherwise)
        };
        Some(LinkNumbers {
            length: number(Some(slices.lengths), 0.0),
            weight: number(slices.weights, 1.0),
            alpha: number(slices.alphas, self.model.alpha()),
        })
    }

    /// Sets the half-links of the whole body, and Young's moduli of its cells.
    pub(super) fn derive_links(&mut self) {
        let Some(slices) = self.model.slices else { return };
        // The half-links as the image has them; its weights are 1 where links do not differ.
        let links = &mut self.arrays.links;
        links.weights.fill([1.0; LANES]);
        let arrays = [
            (&mut *links.lengths, Some(slices.lengths)),
            (links.weights, slices.weights),
            (links.alphas, slices.alphas),
        ];
        for (array, of_image) in arrays {
            let slots = array.iter_mut().zip(of_image.unwrap_or_default());
            slots.for_each(|(slot, numbers)| *slot = *numbers);
        }
        // The moduli: sums over the links and over the tetrahedra of each cell.
        for cell in 0..self.bodily {
            let (sum, mut volume) = (self.wl2_of_image(cell), 0.0);
            for &tetrahedron in self.cut.star(cell) {
                let corners = self.cut.corners.get(tetrahedron as usize).copied();
                let corners = corners.unwrap_or_default().map(|id| self.rest_position(id));
                volume += 0.25 * gradients(corners).0;
            }
            if let Some(slot) = self.arrays.links.young.get_mut(cell) {
                *slot = sum / (24.0 * volume as f32);
            }
        }
    }

    /// Sum of w d^2 over the half-links of a cell: four times the energy of its links, with their own bands or with
    /// bands of one half-width.
    pub(super) fn wd2_of_links(
        &self,
        cell: usize,
        half_width: Option<f32>,
        at: &impl Fn(usize) -> [f32; 3],
    ) -> f32 {
        let stored = self.links_at(cell).map(|(other, link)| {
            let LinkNumbers { length, weight, alpha } = link;
            let rest = |cell: usize| self.model.rest_position(self.origin(cell));
            let apart = || sub(rest(other), rest(cell));
            let band = Band::new(half_width.unwrap_or(alpha));
            link_force(at(cell), at(other), length, weight, band, apart)
                .map_or(0.0, |force| force.wd2)
        });
        stored.sum()
    }

    /// Sum of w l^2 over the half-links of a cell of the image, l their rest lengths.
    pub(super) fn wl2_of_image(&self, cell: usize) -> f32 {
        let ImageGroups { rows, ids } = image_groups(self.model);
        let slots = slots_of(rows, ids, cell);
        wl2(slots.filter_map(|(group, _)| self.image_link_in(group, cell % LANES)))
    }

    /// The same of a cell as it is now.
    pub(super) fn wl2_of_links(&self, cell: usize) -> f32 {
        wl2(self.links_at(cell).map(|(_, link)| link))
    }

    /// The half-links of a cell: their other ends and numbers.
    fn links_at(&self, cell: usize) -> impl Iterator<Item = (usize, LinkNumbers)> {
        let slots = slots_of(self.arrays.rows, self.arrays.ids, cell);
        slots.map(move |(group, other)| (other, self.link_in(group, cell % LANES)))
    }

    /// Young's modulus of a cell.
    pub(super) fn young_of_links(&self, cell: usize) -> f32 {
        self.arrays.links.young.get(self.origin(cell)).copied().unwrap_or(0.0)
    }

    fn end_of(&self, group: usize, lane: usize) -> Option<u16> {
        lane_of(self.arrays.ids, group, lane)
    }

    fn name_end(&mut self, group: usize, lane: usize, end: u16) {
        put_lane(self.arrays.ids, group, lane, end);
    }

    /// Numbers of the half-link in a place.
    fn link_in(&self, group: usize, lane: usize) -> LinkNumbers {
        let links = &self.arrays.links;
        let of = |groups: &[[f32; LANES]], otherwise: f32| {
            lane_of(groups, group, lane).unwrap_or(otherwise)
        };
        LinkNumbers {
            length: of(links.lengths, 0.0),
            weight: of(links.weights, 1.0),
            alpha: of(links.alphas, self.model.alpha()),
        }
    }

    /// Sets a place of a cell's half-links.
    pub(super) fn put_link(&mut self, group: usize, lane: usize, end: u16, numbers: LinkNumbers) {
        self.name_end(group, lane, end);
        let LinkNumbers { length, weight, alpha } = numbers;
        let links = &mut self.arrays.links;
        put_lane(links.lengths, group, lane, length);
        put_lane(links.weights, group, lane, weight);
        put_lane(links.alphas, group, lane, alpha);
    }
}

impl super::memory::LinkArrays<'_> {
    /// Moves the numbers of a group.
    pub fn move_group(&mut self, from: usize, to: usize) {
        for array in [&mut *self.lengths, &mut *self.weights, &mut *self.alphas] {
            inherit(array, from, to);
        }
    }
}
