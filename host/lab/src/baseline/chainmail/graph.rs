//! Generalised `ChainMail`: the same on any graph, one first-in-first-out front (Li and Brodlie
//! 2003).

use std::collections::VecDeque;

use chaincell_kernel::Model;

use super::{Chain, Cost, Elements, Limits};
use chaincell_host::engine::rest_m;
use chaincell_host::error::{Error, Result};

/// Elements linked in any way.
#[derive(Debug, Clone)]
pub struct Graph {
    elements: Elements,
    limits: Limits,
    /// Start of each element's neighbours.
    rows: Vec<u32>,
    /// Neighbours of each element, ascending.
    neighbours: Vec<u32>,
    front: VecDeque<(usize, usize)>,
}

impl Graph {
    /// Elements at rest at `rest_m` \[m\], linked along `links`, `fixed` never to move.
    ///
    /// # Errors
    /// A link or a fixed element beyond the last position.
    pub fn new(
        rest_m: &[[f64; 3]],
        links: &[[u32; 2]],
        fixed: &[u32],
        limits: Limits,
    ) -> Result<Self> {
        let count = rest_m.len();
        let mut sides: Vec<[u32; 2]> = links.iter().flat_map(|&[i, j]| [[i, j], [j, i]]).collect();
        sides.sort_unstable();
        sides.dedup();
        if let Some([element, _]) = sides.iter().find(|side| side[0] as usize >= count) {
            return Err(Error::input(format!(
                "link of element {element}: the chain has {count} elements"
            )));
        }
        let mut rows = vec![0_u32; count + 1];
        for side in &sides {
            rows[side[0] as usize + 1] += 1;
        }
        for element in 0..count {
            rows[element + 1] += rows[element];
        }
        let neighbours = sides.iter().map(|side| side[1]).collect();
        let elements = Elements::new(rest_m, fixed)?;
        Ok(Self { elements, limits, rows, neighbours, front: VecDeque::new() })
    }

    /// The cells and links of a model, its fixed cells fixed; elements in the model's order.
    ///
    /// # Errors
    /// None for a model that the kernel accepts.
    pub fn of_model(model: &Model<'_>, limits: Limits) -> Result<Self> {
        let rest = (0..model.cells()).map(|cell| rest_m(model, cell));
        let links = (0..model.cells()).flat_map(|cell| {
            model.neighbours(cell).map(move |(_, other)| [cell as u32, other as u32])
        });
        let fixed: Vec<u32> = model.fixed().iter().map(|&cell| cell.into()).collect();
        Self::new(&rest.collect::<Vec<_>>(), &links.collect::<Vec<_>>(), &fixed, limits)
    }

    fn row(&self, element: usize) -> std::ops::Range<usize> {
        self.rows[element] as usize..self.rows[element + 1] as usize
    }

    fn pass_on(&mut self, element: usize) {
        for at in self.row(element) {
            self.front.push_back((self.neighbours[at] as usize, element));
        }
    }
}

impl Chain for Graph {
    fn elements(&self) -> &Elements {
        &self.elements
    }

    fn elements_mut(&mut self) -> &mut Elements {
        &mut self.elements
    }

    fn neighbours(&self, element: usize) -> impl Iterator<Item = usize> {
        self.neighbours[self.row(element)].iter().map(|&next| next as usize)
    }

    fn move_to(&mut self, held: &[(usize, [f64; 3])]) -> Result<Cost> {
        self.elements.put(held)?;
        let mut cost = Cost::default();
        for &(element, _) in held {
            self.pass_on(element);
        }
        while let Some((element, sponsor)) = self.front.pop_front() {
            if self.elements.follow(element, sponsor, &self.limits, &mut cost) {
                self.pass_on(element);
            }
        }
        Ok(cost)
    }
}
