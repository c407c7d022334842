//! The elements of a chain and the one step that all forms share: follow the sponsor.

use super::Limits;
use crate::reference::vectors::minus;
use chaincell_host::error::{Error, Result};

/// What a move or a sweep cost.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Cost {
    /// Elements looked at, the held ones left out.
    pub visited: usize,
    /// Those of them that moved.
    pub moved: usize,
}

/// Positions of a chain, with what is held and which element moved which.
#[derive(Debug, Clone)]
pub struct Elements {
    pub(super) rest_m: Vec<[f64; 3]>,
    pub(super) position_m: Vec<[f64; 3]>,
    fixed: Vec<bool>,
    /// Put in place by the last move.
    held: Vec<usize>,
    /// Number of the last move that looked at an element; moves count from 1.
    looked_at: Vec<u64>,
    sponsor: Vec<usize>,
    moves: u64,
}

impl Elements {
    /// Elements at rest, `fixed` never to move.
    pub(super) fn new(rest_m: &[[f64; 3]], fixed: &[u32]) -> Result<Self> {
        let count = rest_m.len();
        let mut is_fixed = vec![false; count];
        for &element in fixed {
            let Some(fixed) = is_fixed.get_mut(element as usize) else {
                return Err(Error::input(format!(
                    "fixed element {element}: the chain has {count} elements"
                )));
            };
            *fixed = true;
        }
        Ok(Self {
            rest_m: rest_m.to_vec(),
            position_m: rest_m.to_vec(),
            fixed: is_fixed,
            held: Vec::new(),
            looked_at: vec![0; count],
            sponsor: (0..count).collect(),
            moves: 0,
        })
    }

    /// Positions \[m\].
    #[must_use]
    pub fn positions_m(&self) -> &[[f64; 3]] {
        &self.position_m
    }

    /// Positions at rest \[m\].
    #[must_use]
    pub fn rest_m(&self) -> &[[f64; 3]] {
        &self.rest_m
    }

    /// Which element led the last move to this one; none for held ones and those it did not reach.
    #[must_use]
    pub fn sponsor(&self, element: usize) -> Option<usize> {
        let reached = self.moves > 0 && self.looked_at.get(element) == Some(&self.moves);
        self.sponsor.get(element).copied().filter(|&sponsor| reached && sponsor != element)
    }

    /// Whether an element never moves.
    pub(super) fn is_fixed(&self, element: usize) -> bool {
        self.fixed[element]
    }

    /// Whether an element is fixed or held.
    pub(super) fn pinned(&self) -> Vec<bool> {
        let mut pinned = self.fixed.clone();
        for &element in &self.held {
            pinned[element] = true;
        }
        pinned
    }

    /// Begins a move: the elements `held` stand where they are put.
    pub(super) fn put(&mut self, held: &[(usize, [f64; 3])]) -> Result<()> {
        let count = self.position_m.len();
        for &(element, position) in held {
            let why = match self.fixed.get(element) {
                None => format!("the chain has {count} elements"),
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
            self.sponsor[element] = element;
        }
        Ok(())
    }

    /// Moves an element by the least that satisfies its link to `sponsor`; tells whether it moved.
    /// An element that this move has looked at before stays where it is.
    pub(super) fn follow(
        &mut self,
        element: usize,
        sponsor: usize,
        limits: &Limits,
        cost: &mut Cost,
    ) -> bool {
        if self.looked_at[element] == self.moves {
            return false;
        }
        self.looked_at[element] = self.moves;
        self.sponsor[element] = sponsor;
        cost.visited += 1;
        if self.fixed[element] {
            return false;
        }
        let before = self.position_m[element];
        let after = self.nearest(element, sponsor, limits);
        self.position_m[element] = after;
        let moved = after != before;
        cost.moved += usize::from(moved);
        moved
    }

    /// The nearest place of an element that satisfies its link to a neighbour.
    pub(super) fn nearest(&self, element: usize, neighbour: usize, limits: &Limits) -> [f64; 3] {
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
