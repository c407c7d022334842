//! Memory for the cuts of a body, and how far it is cut.

mod loose;
pub mod report;
mod surface;

use chaincell_kernel::{CutOutput, CutRoom, Dynamics, Model, Network, cut_words};

use super::{Engine, Memory, Nodes};
use loose::Loose;
use report::CutReport;

/// Words for the cuts of a body; none for one that cannot be cut.
pub(super) struct CutMemory(Vec<u32>);

impl CutMemory {
    pub fn for_model(model: &Model<'_>) -> Self {
        Self(vec![0; cut_words(model)])
    }

    pub fn room(&mut self) -> CutRoom<'_> {
        CutRoom::new(&mut self.0)
    }

    pub fn ram_bytes(&self) -> usize {
        size_of_val(&*self.0)
    }
}

/// Interface to the cuts of a tissue of any scheme.
pub(super) trait AnyCut {
    fn cut_output(&mut self, network: &Network<'_>) -> CutOutput;
    fn cell_of_corner(
        &mut self,
        network: &Network<'_>,
        tetrahedron: usize,
        corner: usize,
    ) -> Option<u16>;
    fn origin_of_copy(&mut self, network: &Network<'_>, copy: usize) -> Option<u16>;
    fn each_triangle(&mut self, network: &Network<'_>, each: &mut dyn FnMut([u16; 3]));
    fn is_dropped(&mut self, network: &Network<'_>, cell: u16) -> bool;
    fn relaxed_j(&mut self, network: &Network<'_>) -> f32;
}

impl<D: Dynamics> AnyCut for Memory<D> {
    fn cut_output(&mut self, network: &Network<'_>) -> CutOutput {
        self.view().cut_output(network)
    }

    fn cell_of_corner(
        &mut self,
        network: &Network<'_>,
        tetrahedron: usize,
        corner: usize,
    ) -> Option<u16> {
        self.view().cell_of_corner(network, tetrahedron, corner)
    }

    fn origin_of_copy(&mut self, network: &Network<'_>, copy: usize) -> Option<u16> {
        self.view().origin_of_copy(network, copy)
    }

    fn each_triangle(&mut self, network: &Network<'_>, each: &mut dyn FnMut([u16; 3])) {
        self.view().triangles(network).for_each(each);
    }

    fn is_dropped(&mut self, network: &Network<'_>, cell: u16) -> bool {
        self.view().is_dropped(network, cell)
    }

    fn relaxed_j(&mut self, network: &Network<'_>) -> f32 {
        self.view().relaxed_j(network)
    }
}

impl Engine<'_> {
    /// Returns true for a body that can be cut.
    #[must_use]
    pub fn can_be_cut(&self) -> bool {
        self.network.model().tetrahedra_to_cut() > 0
    }

    /// Energy that the branches of a body have relaxed since the last reset \[J\]; `None` for an elastic body.
    pub fn relaxed_j(&mut self) -> Option<f32> {
        self.network.model().relaxes().then(|| self.tissue.relaxed_j(&self.network))
    }

    /// State of the cuts since the last reset; all 0 for a body that is whole.
    pub fn cut_output(&mut self) -> CutOutput {
        self.tissue.cut_output(&self.network)
    }

    /// The cut since the last reset, for reports; `None` for a body that cannot be cut. Allocates memory.
    pub fn cut(&mut self) -> Option<CutReport> {
        let output = self.can_be_cut().then(|| self.cut_output())?;
        let loose = match output.opened_faces {
            0 => Some(Loose::default()),
            _ => self.all_cut_cells().map(|cut| self.loose(&cut)),
        };
        Some(CutReport::of(self.network.model(), &output, loose))
    }

    /// The pieces that have come loose.
    fn loose(&self, cut: &CutCells) -> Loose {
        let model = self.network.model();
        let is_fixed = |cell| model.is_fixed(cell);
        Loose::of(&cut.tetrahedra, &cut.origins, model.body_cells(), is_fixed)
    }

    /// Area that the edges of blades have swept since the last reset \[m2\]; `None` for a body that cannot be cut.
    pub fn cut_area_m2(&mut self) -> Option<f32> {
        self.can_be_cut().then(|| self.cut_output().area_m2)
    }

    /// The body as it is cut now, without dropped pieces; `None` for one that is whole, and for one whose image has no
    /// tetrahedra to show (`lean`).
    pub fn cut_cells(&mut self) -> Option<CutCells> {
        let mut cut = self.all_cut_cells()?;
        let (network, tissue) = (&self.network, &mut self.tissue);
        cut.tetrahedra.retain(|&[first, ..]| !tissue.is_dropped(network, first));
        Some(cut)
    }

    /// The same with dropped pieces.
    fn all_cut_cells(&mut self) -> Option<CutCells> {
        let output = self.cut_output();
        let (network, tissue) = (&self.network, &mut self.tissue);
        let model = network.model();
        let whole = model.tetrahedra();
        if output.opened_faces == 0 || whole.len() != model.tetrahedra_to_cut() {
            return None;
        }
        let body = model.body_cells();
        let mut cells =
            CutCells { tetrahedra: whole.to_vec(), origins: vec![0; output.copies as usize] };
        for (at, (now, before)) in cells.tetrahedra.iter_mut().zip(whole).enumerate() {
            for (corner, (cell, &origin)) in now.iter_mut().zip(before).enumerate() {
                *cell = tissue.cell_of_corner(network, at, corner)?;
                let copy = usize::from(*cell).checked_sub(body);
                if let Some(place) = copy.and_then(|copy| cells.origins.get_mut(copy)) {
                    *place = origin;
                }
            }
        }
        Some(cells)
    }

    /// The nodes of [`Engine::nodes`], and behind them the copies of split cells with the ids of those.
    #[must_use]
    pub fn with_copies(&mut self, nodes: &Nodes, cut: &CutCells) -> Nodes {
        let ids = self.network.model().input_id();
        let mut nodes = nodes.clone();
        let of_copies = self.positions_m().into_iter().skip(ids.len());
        nodes.positions_m.extend(of_copies.take(cut.origins.len()));
        nodes.ids.extend(cut.origins.iter().filter_map(|&cell| ids.get(usize::from(cell))));
        nodes
    }
}

/// The cells of a body that is cut.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CutCells {
    /// The cells of each tetrahedron, copies of split cells among them.
    pub tetrahedra: Vec<[u16; 4]>,
    /// The cell of the whole body of which each copy is one. Copies are numbered behind the cells of the body.
    pub origins: Vec<u16>,
}
