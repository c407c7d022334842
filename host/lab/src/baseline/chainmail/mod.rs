//! Traditional `ChainMail`, in double precision: the method that the paper improves on.
//!
//! An element that is moved drags a neighbour along only as far as the link's bounds demand, and
//! the neighbour drags its own in turn: a move spreads as one front, each element is looked at
//! once, and there is neither a force nor an energy. Bounds follow the axes, link by link.
//!
//! | part | source |
//! |---|---|
//! | [`Lattice`] | S. F. F. Gibson, 3D ChainMail: a fast algorithm for deforming volumetric objects, 1997 |
//! | [`Graph`] | Y. Li, K. Brodlie, Soft object modelling with generalised ChainMail, 2003 |
//! | [`Chain::relax`] | the elastic relaxation of both |

mod elements;
mod graph;
mod lattice;
mod limits;

pub use elements::{Cost, Elements};
pub use graph::Graph;
pub use lattice::Lattice;
pub use limits::Limits;

use crate::reference::vectors::{minus, plus};
use chaincell_host::error::Result;

/// A chain of elements that can be moved.
pub trait Chain {
    /// The elements.
    fn elements(&self) -> &Elements;

    /// The elements, to be moved.
    fn elements_mut(&mut self) -> &mut Elements;

    /// Elements that an element is linked to.
    fn neighbours(&self, element: usize) -> impl Iterator<Item = usize>;

    /// Puts elements at positions \[m\], lets the chain follow and holds them there until the next
    /// move. Each element is looked at once at most; a link's bounds are kept towards the element
    /// that led there. Cost: linear in the elements looked at.
    ///
    /// # Errors
    /// An element that is not there or is fixed; a position that is not finite.
    fn move_to(&mut self, held: &[(usize, [f64; 3])]) -> Result<Cost>;

    /// One relaxation sweep: every element that is neither fixed nor held moves by the mean of its
    /// links' excess over their limits at equilibrium, all from the positions before the sweep.
    ///
    /// With [`Limits::RIGID`] every link strives for its offset at rest.
    ///
    /// On a bipartite chain without anything held the sweep may swing between two states.
    fn relax(&mut self, equilibrium: &Limits) -> Cost {
        let elements = self.elements();
        let mut positions = elements.position_m.clone();
        let mut cost = Cost::default();
        for (element, pinned) in elements.pinned().into_iter().enumerate() {
            if pinned {
                continue;
            }
            cost.visited += 1;
            let here = elements.position_m[element];
            let (mut sum, mut links) = ([0.0; 3], 0_u32);
            for neighbour in self.neighbours(element) {
                sum =
                    plus(sum, 1.0, minus(elements.nearest(element, neighbour, equilibrium), here));
                links += 1;
            }
            if links == 0 {
                continue;
            }
            let to = plus(here, 1.0, sum.map(|x| x / f64::from(links)));
            cost.moved += usize::from(to != here);
            positions[element] = to;
        }
        self.elements_mut().position_m = positions;
        cost
    }
}

#[cfg(test)]
mod tests;
