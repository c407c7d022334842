//! Strain and stress of a whole body, computed some nodes at a time.

use chaincell_client::stress::NodeStress;

use super::tissue::TissueEngine;

/// The rows of all nodes, and how far they are computed.
#[derive(Debug)]
pub struct StressRows {
    rows: Vec<NodeStress>,
    means_pa: Vec<f32>,
    /// The node that comes next; behind the nodes, the copy of a split one.
    next: usize,
}

impl StressRows {
    /// Rows of a body with these numbers of nodes and cells.
    #[must_use]
    pub fn new(nodes: usize, cells: usize) -> Self {
        Self { rows: vec![NodeStress::default(); nodes], means_pa: vec![f32::NAN; cells], next: 0 }
    }

    /// The rows by ascending node.
    #[must_use]
    pub fn rows(&self) -> &[NodeStress] {
        &self.rows
    }

    /// Returns true between the first and the last step of a pass.
    #[must_use]
    pub fn is_in_pass(&self) -> bool {
        self.next > 0
    }

    /// Computes at most `most` nodes and, behind the last of them, copies of split ones, see
    /// [`TissueEngine::add_copies`]. Returns true for the last step of a pass, the next one begins anew; `None` if the
    /// tissue has no stress. Allocates nothing.
    pub fn step(&mut self, most: usize, engine: &mut dyn TissueEngine) -> Option<bool> {
        let (first, nodes) = (self.next, self.rows.len());
        if first == 0 {
            self.means_pa.fill(f32::NAN);
        }
        // The nodes.
        if first < nodes {
            let next = first.saturating_add(most).min(nodes);
            let some = self.rows.get_mut(first..next)?;
            if !engine.read_stresses(first, some, &mut self.means_pa) {
                self.next = 0;
                return None;
            }
            self.next = next;
        }
        // The copies.
        let Some(copy) = self.next.checked_sub(nodes) else { return Some(false) };
        let most = most - (self.next - first);
        let looked = engine.add_copies(copy, most, &mut self.rows, &mut self.means_pa);
        let is_last = looked < most;
        self.next = if is_last { 0 } else { self.next + looked };
        Some(is_last)
    }

    /// Computes all of them at once.
    pub fn read_all(&mut self, engine: &mut dyn TissueEngine) {
        self.next = 0;
        self.step(usize::MAX, engine);
    }
}
