//! Cubes of graded sizes: an octree over a grid of equal cubes, in which neighbours differ by a factor of 2
//! at most, at edges and corners too.

use std::collections::BTreeMap;

/// Coordinates in halves of the finest cube, so that corners and centres of all cubes are whole.
pub(super) type Place = [i32; 3];

/// The cubes that are not divided.
pub(super) struct Octree {
    /// Edge by lower corner.
    leaves: BTreeMap<Place, i32>,
    /// Edge of the coarsest cubes.
    coarsest: i32,
    limit: usize,
}

/// The octree has more cubes than allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::mesh) struct TooMany;

impl Octree {
    /// Starts with a grid of `counts` cubes that can be halved `levels` times; it may have `limit` cubes more.
    pub(super) fn new(counts: [i32; 3], levels: u32, limit: usize) -> Self {
        let coarsest = 2 << levels;
        let mut leaves = BTreeMap::new();
        for (x, y) in (0..counts[0]).flat_map(|x| (0..counts[1]).map(move |y| (x, y))) {
            for z in 0..counts[2] {
                leaves.insert([x, y, z].map(|at| at * coarsest), coarsest);
            }
        }
        let limit = leaves.len() + limit;
        Self { leaves, coarsest, limit }
    }

    /// Divides cubes for which `is_coarse` returns true, and those next to much smaller ones. The cubes are
    /// given by lower corner and edge.
    pub(super) fn refine(&mut self, is_coarse: impl Fn(Place, i32) -> bool) -> Result<(), TooMany> {
        let mut open: Vec<(Place, i32)> = self.leaves().collect();
        while let Some((low, edge)) = open.pop() {
            if self.is_leaf(low, edge) && edge > 2 && is_coarse(low, edge) {
                self.divide(low, edge, &mut open)?;
            }
        }
        open.extend(self.leaves());
        while let Some((low, edge)) = open.pop() {
            if !self.is_leaf(low, edge) {
                continue;
            }
            for step in around() {
                let beside = [0, 1, 2].map(|axis| low[axis] + step[axis] * edge);
                while let Some((large, size)) =
                    self.holder(beside, edge).filter(|of| of.1 > 2 * edge)
                {
                    self.divide(large, size, &mut open)?;
                }
            }
        }
        Ok(())
    }

    /// The cubes, sorted: lower corner and edge.
    pub(super) fn leaves(&self) -> impl Iterator<Item = (Place, i32)> + '_ {
        self.leaves.iter().map(|(low, edge)| (*low, *edge))
    }

    /// Returns true if this cube exists and is not divided.
    pub(super) fn is_leaf(&self, low: Place, edge: i32) -> bool {
        self.leaves.get(&low) == Some(&edge)
    }

    /// Replaces a cube by its eight parts, and lists them.
    fn divide(
        &mut self,
        low: Place,
        edge: i32,
        open: &mut Vec<(Place, i32)>,
    ) -> Result<(), TooMany> {
        if self.leaves.len() >= self.limit {
            return Err(TooMany);
        }
        self.leaves.remove(&low);
        let half = edge / 2;
        for part in 0..8 {
            let low = [0, 1, 2].map(|axis| low[axis] + half * (part >> axis & 1));
            self.leaves.insert(low, half);
            open.push((low, half));
        }
        Ok(())
    }

    /// Returns the cube of at least this edge in which a cube of it lies.
    fn holder(&self, low: Place, edge: i32) -> Option<(Place, i32)> {
        let sizes = std::iter::successors(Some(edge), |edge| Some(2 * edge));
        let mut holders = sizes
            .take_while(|edge| *edge <= self.coarsest)
            .map(|edge| (low.map(|x| x.div_euclid(edge) * edge), edge));
        holders.find(|(low, edge)| self.is_leaf(*low, *edge))
    }
}

/// Steps to the 26 cubes around one.
fn around() -> impl Iterator<Item = Place> {
    let steps = (0..27).map(|at| [at / 9 - 1, at / 3 % 3 - 1, at % 3 - 1]);
    steps.filter(|step| *step != [0; 3])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fine around one corner of a cube in the middle.
    #[test]
    fn neighbours_differ_by_two_and_the_volume_is_kept() {
        let mut tree = Octree::new([4, 4, 4], 4, 100_000);
        let is_inside = |low: Place, edge: i32| low.iter().all(|x| (*x..x + edge).contains(&33));
        tree.refine(is_inside).unwrap();
        let cubes: Vec<(Place, i32)> = tree.leaves().collect();
        assert_eq!(cubes.iter().map(|cube| i64::from(cube.1).pow(3)).sum::<i64>(), 128i64.pow(3));
        assert!(cubes.iter().any(|cube| cube.1 == 2));
        for (low, edge) in &cubes {
            for (other, size) in &cubes {
                let touch = (0..3).all(|x| low[x] <= other[x] + size && other[x] <= low[x] + edge);
                assert!(!touch || edge.max(size) <= &(2 * edge.min(size)), "{low:?} {other:?}");
            }
        }
        let mut small = Octree::new([4, 4, 4], 4, 10);
        assert_eq!(small.refine(is_inside), Err(TooMany));
    }
}
