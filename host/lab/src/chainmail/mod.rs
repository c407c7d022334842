//! Traditional `ChainMail`, in double precision: the method that the paper improves on.
//!
//! An element that is moved drags a neighbour along only as far as the link's bounds demand, and
//! the neighbour drags its own in turn: a move spreads as one front, each element is looked at
//! once, and there is neither a force nor an energy. Bounds follow the axes, link by link.
//!
//! The form is the generalised one, for any graph with a first-in-first-out front (Y. Li, K. Brodlie,
//! Soft object modelling with generalised `ChainMail`, 2003). On a lattice of equal bounds it moves the
//! elements as the six lists of S. F. F. Gibson do (3D `ChainMail`: a fast algorithm for deforming
//! volumetric objects, 1997). [`ChainMail::relax`] is the elastic relaxation of both.

mod limits;

use std::collections::VecDeque;

use chaincell_kernel::Model;

use crate::reference::vectors::{minus, plus};
use chaincell_host::engine::rest_m;
use chaincell_host::error::{Error, Result};
pub use limits::Limits;

/// A chain of elements that can be moved.
#[derive(Debug, Clone)]
pub struct ChainMail {
    limits: Limits,
    /// Neighbours of each element, ascending.
    neighbours: Vec<Vec<u32>>,
    rest_m: Vec<[f64; 3]>,
    position_m: Vec<[f64; 3]>,
    fixed: Vec<bool>,
    /// Put in place by the last move.
    held: Vec<usize>,
    /// Number of the last move that looked at an element; moves count from 1.
    looked_at: Vec<u64>,
    moves: u64,
}

impl ChainMail {
    /// Elements at rest at `rest_m` \[m\], linked along `links`, `fixed` never to move.
    pub fn new(
        rest_m: &[[f64; 3]],
        links: &[[u32; 2]],
        fixed: &[u32],
        limits: Limits,
    ) -> Result<Self> {
        let count = rest_m.len();
        let named = links.as_flattened().iter().chain(fixed);
        if let Some(element) = named.copied().find(|&element| element as usize >= count) {
            return Err(Error::input(format!("element {element}: the chain has {count} elements")));
        }
        // Both sides of each link, once.
        let mut neighbours = vec![Vec::new(); count];
        for &[i, j] in links {
            neighbours[i as usize].push(j);
            neighbours[j as usize].push(i);
        }
        for of_element in &mut neighbours {
            of_element.sort_unstable();
            of_element.dedup();
        }
        // At rest, before the first move.
        let mut is_fixed = vec![false; count];
        fixed.iter().for_each(|&element| is_fixed[element as usize] = true);
        Ok(Self {
            limits,
            neighbours,
            rest_m: rest_m.to_vec(),
            position_m: rest_m.to_vec(),
            fixed: is_fixed,
            held: Vec::new(),
            looked_at: vec![0; count],
            moves: 0,
        })
    }

    /// The cells and links of a model, its fixed cells fixed; elements in the model's order.
    pub fn of_model(model: &Model<'_>, limits: Limits) -> Result<Self> {
        let rest = (0..model.cells()).map(|cell| rest_m(model, cell));
        let links = (0..model.cells()).flat_map(|cell| {
            model.neighbours(cell).map(move |(_, other)| [cell as u32, other as u32])
        });
        let fixed: Vec<u32> = model.fixed().iter().map(|&cell| cell.into()).collect();
        Self::new(&rest.collect::<Vec<_>>(), &links.collect::<Vec<_>>(), &fixed, limits)
    }

    /// Positions \[m\].
    pub fn positions_m(&self) -> &[[f64; 3]] {
        &self.position_m
    }

    /// Positions at rest \[m\].
    pub fn rest_m(&self) -> &[[f64; 3]] {
        &self.rest_m
    }

    /// Puts elements at positions \[m\], lets the chain follow and holds them there until the next
    /// move. Each element is looked at once at most; a link's bounds are kept towards the element
    /// that led there. Cost: linear in the elements looked at.
    pub fn move_to(&mut self, held: &[(usize, [f64; 3])]) -> Result<()> {
        self.put(held)?;
        let mut front = VecDeque::new();
        for &(element, _) in held {
            self.pass_on(element, &mut front);
        }
        while let Some((element, sponsor)) = front.pop_front() {
            if self.follow(element, sponsor) {
                self.pass_on(element, &mut front);
            }
        }
        Ok(())
    }

    /// One relaxation sweep: every element that is neither fixed nor held moves by the mean of its
    /// links' excess over their limits at equilibrium, all from the positions before the sweep.
    ///
    /// With [`Limits::RIGID`] every link strives for its offset at rest. On a bipartite chain without
    /// anything held the sweep may swing between two states.
    pub fn relax(&mut self, equilibrium: &Limits) {
        let mut pinned = self.fixed.clone();
        self.held.iter().for_each(|&element| pinned[element] = true);
        let relaxed = |element: usize| {
            let (here, neighbours) = (self.position_m[element], &self.neighbours[element]);
            if pinned[element] || neighbours.is_empty() {
                return here;
            }
            let sum = neighbours.iter().fold([0.0; 3], |sum, &neighbour| {
                let nearest = self.nearest(element, neighbour as usize, equilibrium);
                plus(sum, 1.0, minus(nearest, here))
            });
            plus(here, 1.0, sum.map(|x| x / neighbours.len() as f64))
        };
        self.position_m = (0..self.position_m.len()).map(relaxed).collect();
    }

    /// Begins a move: the elements `held` stand where they are put.
    fn put(&mut self, held: &[(usize, [f64; 3])]) -> Result<()> {
        for &(element, position) in held {
            let why = match self.fixed.get(element) {
                None => format!("the chain has {} elements", self.fixed.len()),
                Some(true) => "it is fixed and cannot be moved".to_owned(),
                Some(false) if !position.iter().all(|x| x.is_finite()) => {
                    "its position must be finite".to_owned()
                }
                Some(false) => continue,
            };
            return Err(Error::input(format!("element {element} of a chain: {why}")));
        }
        self.moves += 1;
        self.held.clear();
        for &(element, position) in held {
            self.held.push(element);
            self.position_m[element] = position;
            self.looked_at[element] = self.moves;
        }
        Ok(())
    }

    /// Queues the neighbours of an element.
    fn pass_on(&self, element: usize, front: &mut VecDeque<(usize, usize)>) {
        front.extend(self.neighbours[element].iter().map(|&next| (next as usize, element)));
    }

    /// Moves an element by the least that satisfies its link to `sponsor`; returns whether it moved.
    /// An element that this move has looked at before stays where it is.
    fn follow(&mut self, element: usize, sponsor: usize) -> bool {
        if self.looked_at[element] == self.moves {
            return false;
        }
        self.looked_at[element] = self.moves;
        if self.fixed[element] {
            return false;
        }
        let before = self.position_m[element];
        self.position_m[element] = self.nearest(element, sponsor, &self.limits);
        self.position_m[element] != before
    }

    /// The nearest place of an element that satisfies its link to a neighbour.
    fn nearest(&self, element: usize, neighbour: usize, limits: &Limits) -> [f64; 3] {
        let (here, from) = (self.position_m[element], self.position_m[neighbour]);
        let region = limits.region(minus(self.rest_m[element], self.rest_m[neighbour]));
        std::array::from_fn(|axis| {
            let [low, high] = region[axis];
            let offset = here[axis] - from[axis];
            if offset < low {
                from[axis] + low
            } else if offset > high {
                from[axis] + high
            } else {
                here[axis]
            }
        })
    }
}

#[cfg(test)]
mod tests;
