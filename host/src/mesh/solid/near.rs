//! Points sorted into the cubes of a grid, to find those around a point without a search of all.

use std::collections::HashMap;

/// Numbered points.
pub(super) struct Near {
    /// Edge of a cube \[m\].
    edge_m: f64,
    places: HashMap<[i64; 3], Vec<(u32, [f64; 3])>>,
}

impl Near {
    /// Starts without points; [`Self::around`] finds those up to `edge_m` away.
    pub(super) fn new(edge_m: f64) -> Self {
        Self { edge_m, places: HashMap::new() }
    }

    /// Adds a point.
    pub(super) fn add(&mut self, number: u32, place_m: [f64; 3]) {
        self.places.entry(self.cube(place_m)).or_default().push((number, place_m));
    }

    /// Returns all points that are up to `edge_m` away, and some more. Cost: 27 cubes.
    pub(super) fn around(&self, place_m: [f64; 3]) -> impl Iterator<Item = (u32, [f64; 3])> + '_ {
        let [x, y, z] = self.cube(place_m);
        let steps = [-1, 0, 1];
        let cubes = steps.into_iter().flat_map(move |i| {
            steps.into_iter().flat_map(move |j| steps.map(|k| [x + i, y + j, z + k]))
        });
        cubes.filter_map(|cube| self.places.get(&cube)).flatten().copied()
    }

    fn cube(&self, place_m: [f64; 3]) -> [i64; 3] {
        place_m.map(|x| (x / self.edge_m).floor() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::geometry::distance;

    /// The result equals a search of all, for coordinates of both signs and on borders of cubes.
    #[test]
    fn all_places_near_are_found() {
        let places: Vec<[f64; 3]> = (0..343_u32)
            .map(|i| {
                [i % 7, i / 7 % 7, i / 49]
                    .map(|x| 0.5 * f64::from(x) - 1.75 + 0.25 * f64::from(i % 2))
            })
            .collect();
        let mut near = Near::new(1.0);
        (0..).zip(&places).for_each(|(number, place_m)| near.add(number, *place_m));
        for place_m in &places {
            let is_near = |of: &[f64; 3]| distance(*of, *place_m) <= 1.0;
            let mut found: Vec<u32> =
                near.around(*place_m).filter(|of| is_near(&of.1)).map(|of| of.0).collect();
            found.sort_unstable();
            let all = (0..).zip(&places).filter(|of: &(u32, _)| is_near(of.1)).map(|of| of.0);
            assert_eq!(found, all.collect::<Vec<u32>>());
        }
    }
}
