//! Strain and stress of a tissue, for reports.

use chaincell_kernel::Stress;

use super::{Engine, shown};

impl Engine<'_> {
    /// Strain and stress at a cell, at the published positions; `None` beyond the last cell and in a body of
    /// links.
    pub fn stress(&mut self, cell: usize) -> Option<Stress> {
        self.tissue.stress(self.network.model(), cell, &mut [])
    }

    /// Strain and stress of these cells; `None` in a body of links, and for a cell beyond the last.
    pub fn stresses(&mut self, cells: impl Iterator<Item = usize>) -> Option<Vec<Stress>> {
        let model = self.network.model();
        let mut means_pa = vec![f32::NAN; model.cells()];
        cells.map(|cell| self.tissue.stress(model, cell, &mut means_pa)).collect()
    }

    /// Strain and stress at each node, in the order of [`Self::read_nodes`]; `None` in a body of links.
    pub fn node_stresses(&mut self) -> Option<Vec<Stress>> {
        let shown = self.shown.get_or_init(|| shown(self.network.model())).clone();
        self.stresses(shown.into_iter().map(|cell| cell as usize))
    }
}
