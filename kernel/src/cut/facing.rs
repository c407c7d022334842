//! The way that the lips of a body of links face: their areas as they are now.
//!
//! The normals of a body of shapes turn with its cells' rotations. Links have none, so the area of a lip is the mean
//! of its two sides', a third of each face for each corner.
//!
//! Cost: a look at each tetrahedron, and at those of a cell for each opened face, once a tick.

use super::body::CutBody;
use crate::number::cell::{add, scale, sub};
use crate::number::turn::cross;

/// Twice the area of a triangle with these corners.
fn twice_area([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    cross(sub(b, a), sub(c, a))
}

impl CutBody<'_, '_> {
    /// Sets the areas of the lips in a body of links.
    pub(super) fn face_lips(&mut self, at: &impl Fn(usize) -> [f32; 3]) {
        if !self.is_of_links() {
            return;
        }
        self.arrays.links.lip_areas.fill([0.0; 3]);
        for tetrahedron in 0..self.arrays.faces.len() {
            for corner in self.open_corners(tetrahedron) {
                if let Some([here, there]) = self.sides_once(tetrahedron, corner) {
                    self.face(here, there, at);
                }
            }
        }
    }

    /// Adds an opened face with these sides to the areas of the lips at its corners.
    fn face(&mut self, here: [u16; 3], there: [u16; 3], at: &impl Fn(usize) -> [f32; 3]) {
        let area = |side: [u16; 3]| twice_area(side.map(|cell| at(cell.into())));
        // The mean of both sides, a third of it: both are outward.
        let third = scale(1.0 / 12.0, sub(area(here), area(there)));
        for cell in here {
            let Some((cells, sign)) = self.lip_at(cell, there) else { continue };
            let mut places = self.lip_places(cells);
            let place = places.find(|&place| self.lip(place).is_some_and(|lip| lip.cells == cells));
            let area = place.and_then(|place| self.arrays.links.lip_areas.get_mut(place));
            if let Some(area) = area {
                *area = add(*area, scale(sign, third));
            }
        }
    }
}
