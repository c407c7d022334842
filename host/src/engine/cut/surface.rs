//! The surface of a body as it is cut now, for viewers.

use chaincell_client::surface::{SurfaceHeader, SurfaceRow};
use chaincell_kernel::triangles_max;

use crate::engine::{Engine, shown, to_m};

impl Engine<'_> {
    /// Most rows of [`Self::read_surface`]; `None` for a body that cannot be cut.
    #[must_use]
    pub fn surface_rows(&self) -> Option<usize> {
        let model = self.network.model();
        self.can_be_cut().then(|| model.cells().max(triangles_max(model)))
    }

    /// Writes the surface of a body that can be cut as it is now, as much as fits: the nodes in the order of
    /// [`Self::read_nodes`], the copies of split ones after them, and the triangles. Returns the lengths of the lists
    /// in a header whose other fields are 0. Allocates nothing after its first call.
    pub fn read_surface(&mut self, to: &mut [SurfaceRow]) -> SurfaceHeader {
        let Self { network, tissue, shown: order, rows, .. } = self;
        let model = network.model();
        let order = order.get_or_init(|| shown(model));
        let rows = rows.get_or_init(|| rows_of(order));
        let copies = tissue.cut_output(network).copies as usize;
        // The nodes, and the copies after them, whose cells have the numbers of their rows.
        to.fill(SurfaceRow::default());
        for (row, slot) in to.iter_mut().take(order.len() + copies).enumerate() {
            let (cell, origin) = match order.get(row) {
                Some(&cell) => (cell as usize, Some(cell as usize)),
                None => {
                    let origin = tissue.origin_of_copy(network, row - order.len());
                    (row, origin.map(usize::from))
                }
            };
            let node = origin.and_then(|origin| model.input_id().get(origin));
            slot.node = node.copied().unwrap_or_default();
            slot.position_m = to_m(model, tissue.position(model, cell)).map(|x| x as f32);
        }
        // The triangles.
        let mut triangles = 0;
        tissue.each_triangle(network, &mut |cells| {
            if let Some(slot) = to.get_mut(triangles) {
                let row = |cell: u16| rows.get(usize::from(cell)).copied();
                slot.corners = cells.map(|cell| row(cell).unwrap_or_else(|| cell.into()));
                triangles += 1;
            }
        });
        SurfaceHeader {
            nodes: order.len() as u32,
            copies: copies as u32,
            triangles: triangles as u32,
            ..SurfaceHeader::default()
        }
    }
}

/// The place of each cell in an order of cells.
fn rows_of(order: &[u32]) -> Vec<u32> {
    let mut rows = vec![0; order.len()];
    for (row, &cell) in (0..).zip(order) {
        if let Some(place) = rows.get_mut(cell as usize) {
            *place = row;
        }
    }
    rows
}
