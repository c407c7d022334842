//! Strain and stress of a tissue, for reports and for viewers.

use chaincell_client::stress::NodeStress;
use chaincell_kernel::Stress;

use super::{Engine, shown};

/// The row of a node.
fn row(node: u32, of: &Stress) -> NodeStress {
    let (von_mises_pa, mean_pa) = (of.von_mises_pa(), of.mean_pa());
    NodeStress { node, stretches: of.stretches, von_mises_pa, mean_pa }
}

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

    /// Number of cells whose stress [`Self::read_stresses`] meets; `None` where it has none to write.
    pub fn stressed_cells(&mut self) -> Option<usize> {
        let model = self.network.model();
        let has_stress = model.fine_nodes() == 0 && self.tissue.stress(model, 0, &mut []).is_some();
        has_stress.then(|| model.cells())
    }

    /// Writes strain and stress of the nodes from the `first` one on, in the order of [`Self::read_nodes`], as many as
    /// fit; false in a body of links and in one that stands for a finer mesh. `means_pa` has a number for each cell,
    /// NaN at first, in which later calls find mean stresses that earlier ones met. Allocates nothing once the nodes
    /// have been read.
    pub fn read_stresses(
        &mut self,
        first: usize,
        to: &mut [NodeStress],
        means_pa: &mut [f32],
    ) -> bool {
        let model = self.network.model();
        if model.fine_nodes() > 0 {
            return false;
        }
        let cells = self.shown.get_or_init(|| shown(model)).iter().skip(first);
        for (place, &cell) in to.iter_mut().zip(cells) {
            let Some(of) = self.tissue.stress(model, cell as usize, means_pa) else { return false };
            let node = model.input_id().get(cell as usize).copied().unwrap_or_default();
            *place = row(node, &of);
        }
        true
    }

    /// Looks at the copies of split cells from the `first` one on, at most `most`, without those of dropped pieces:
    /// where a copy has more stress after von Mises than the row of its node in `to`, all rows of
    /// [`Self::read_stresses`], the row becomes that of the copy. Returns the number of copies that it has looked at,
    /// less than `most` behind the last one. Allocates nothing.
    pub fn add_copies(
        &mut self,
        first: usize,
        most: usize,
        to: &mut [NodeStress],
        means_pa: &mut [f32],
    ) -> usize {
        let (network, tissue) = (&self.network, &mut self.tissue);
        let model = network.model();
        for looked in 0..most {
            let copy = first + looked;
            let Some(origin) = tissue.origin_of_copy(network, copy) else { return looked };
            let cell = model.body_cells() + copy;
            let is_dropped = u16::try_from(cell).is_ok_and(|cell| tissue.is_dropped(network, cell));
            let id = model.input_id().get(usize::from(origin)).copied();
            let Some(node) = id.filter(|_| !is_dropped) else { continue };
            let place = to.binary_search_by_key(&node, |row| row.node).ok();
            let place = place.and_then(|place| to.get_mut(place));
            let Some((place, of)) = place.zip(tissue.stress(model, cell, means_pa)) else {
                continue;
            };
            if of.von_mises_pa() > place.von_mises_pa {
                *place = row(node, &of);
            }
        }
        most
    }
}
