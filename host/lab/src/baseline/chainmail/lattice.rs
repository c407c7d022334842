//! `ChainMail` on a lattice: six lists of candidates (Gibson 1997).
//!
//! Elements are numbered as the nodes of `box:NXxNYxNZxD`, (i NY + j) NZ + k; a plane has NZ = 1.
//! Left and right are along x, bottom and top along y, front and back along z.

use std::collections::VecDeque;

use super::{Chain, Cost, Elements, Limits};
use chaincell_host::error::{Error, Result};

/// The six directions in the order in which their lists are drained: front, back, left, right,
/// bottom, top. `[axis, 1 for upwards]`.
const DIRECTIONS: [[usize; 2]; 6] = [[2, 0], [2, 1], [0, 0], [0, 1], [1, 0], [1, 1]];

/// Where an element goes among its axes: z leads to all, x to its own and y, y to its own.
const RANK: [usize; 3] = [1, 2, 0];

/// An element to be looked at, and the one that moved beside it.
type Candidate = (usize, usize);

/// A box or plane of elements linked to their up to six neighbours.
#[derive(Debug, Clone)]
pub struct Lattice {
    elements: Elements,
    limits: Limits,
    nodes: [usize; 3],
    lists: [VecDeque<Candidate>; 6],
}

impl Lattice {
    /// A lattice of `nodes` elements along the axes at rest at `rest_m` \[m\], `fixed` never to
    /// move. Bounds follow the axes of space even where the lattice is turned in it.
    ///
    /// # Errors
    /// Another number of positions than of elements; a fixed element that is not there.
    pub fn new(
        nodes: [usize; 3],
        rest_m: &[[f64; 3]],
        fixed: &[u32],
        limits: Limits,
    ) -> Result<Self> {
        let [nx, ny, nz] = nodes;
        if rest_m.len() != nx * ny * nz {
            return Err(Error::input(format!(
                "{} positions for a lattice of {nx} x {ny} x {nz} elements",
                rest_m.len()
            )));
        }
        let elements = Elements::new(rest_m, fixed)?;
        Ok(Self { elements, limits, nodes, lists: Default::default() })
    }

    /// The neighbour in a direction.
    fn neighbour(&self, element: usize, [axis, up]: [usize; 2]) -> Option<usize> {
        let [nx, ny, nz] = self.nodes;
        let place = [element / (ny * nz), element / nz % ny, element % nz];
        let stride = [ny * nz, nz, 1][axis];
        match up {
            0 => (place[axis] > 0).then(|| element - stride),
            _ => (place[axis] + 1 < [nx, ny, nz][axis]).then(|| element + stride),
        }
    }

    /// Queues the neighbours of an element that `sponsor` has led from `direction`.
    fn pass_on(&mut self, element: usize, sponsor: usize, direction: [usize; 2]) {
        for (list, side) in DIRECTIONS.into_iter().enumerate() {
            let Some(next) = self.neighbour(element, side) else { continue };
            let onwards = side == direction || RANK[side[0]] > RANK[direction[0]];
            if onwards || self.round_a_corner(next, sponsor, direction, side) {
                self.lists[list].push_back((next, element));
            }
        }
    }

    /// Whether an element aside can only be reached from here: the way past the sponsor is barred
    /// by an element that does not pass moves on, as at a concave corner.
    fn round_a_corner(
        &self,
        next: usize,
        sponsor: usize,
        direction: [usize; 2],
        side: [usize; 2],
    ) -> bool {
        let aside = side[0] != direction[0] && !self.elements.is_fixed(next);
        aside && self.neighbour(sponsor, side).is_some_and(|bar| self.elements.is_fixed(bar))
    }
}

impl Chain for Lattice {
    fn elements(&self) -> &Elements {
        &self.elements
    }

    fn elements_mut(&mut self) -> &mut Elements {
        &mut self.elements
    }

    /// In the order of the lists.
    fn neighbours(&self, element: usize) -> impl Iterator<Item = usize> {
        DIRECTIONS.into_iter().filter_map(move |direction| self.neighbour(element, direction))
    }

    fn move_to(&mut self, held: &[(usize, [f64; 3])]) -> Result<Cost> {
        self.elements.put(held)?;
        let mut cost = Cost::default();
        for &(element, _) in held {
            for (list, side) in DIRECTIONS.into_iter().enumerate() {
                let next = self.neighbour(element, side);
                self.lists[list].extend(next.map(|next| (next, element)));
            }
        }
        while self.lists.iter().any(|list| !list.is_empty()) {
            for (list, direction) in DIRECTIONS.into_iter().enumerate() {
                while let Some((element, sponsor)) = self.lists[list].pop_front() {
                    if self.elements.follow(element, sponsor, &self.limits, &mut cost) {
                        self.pass_on(element, sponsor, direction);
                    }
                }
            }
        }
        Ok(cost)
    }
}
