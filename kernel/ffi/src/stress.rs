//! Strain and stress at a cell.

use chaincell_kernel::Stress;

use crate::code::Code;
use crate::layout::{self, Parts, Tissue, by_scheme};
use crate::memory;

/// Strain and stress of the tissue around a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct CellStress {
    /// Principal stretches, the largest first.
    pub stretches: [f32; 3],
    /// Cauchy stress xx, yy, zz, xy, yz, xz, above 0 where the tissue is pulled \[Pa\].
    pub cauchy_pa: [f32; 6],
    /// Stress after von Mises: that of a bar under tension is its tension \[Pa\].
    pub von_mises_pa: f32,
    /// Mean stress, a third of the trace: below 0 where the tissue is pressed from all sides \[Pa\].
    pub mean_pa: f32,
}

impl From<Stress> for CellStress {
    fn from(of: Stress) -> Self {
        Self {
            stretches: of.stretches,
            cauchy_pa: of.elements_pa(),
            von_mises_pa: of.von_mises_pa(),
            mean_pa: of.mean_pa(),
        }
    }
}

/// Strain and stress at the cell of a node of the input mesh, by its id, at the published positions. The mean stress is
/// that of the cell and of those linked to it. A body of links has none: `CHAINCELL_CODE_NO_STRESS`. A tick computes
/// nothing of it. Cost: some thousand operations for each of these cells, and a look through all cells for the id.
///
/// # Safety
/// `tissue` was made by `chaincell_tissue_init` and no other thread uses it; `stress` is storage for the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_stress(
    tissue: *mut Tissue,
    input_id: u32,
    stress: *mut CellStress,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    Code::of(unsafe { layout::front(tissue) }.and_then(|(scheme, sizes)| {
        memory::check(stress)?;
        // SAFETY: a tissue of this scheme stands there, and the caller says that it is ours.
        let found = unsafe {
            by_scheme!(scheme, D => {
                let Parts { network, tissue: mut body, .. } = layout::parts::<D>(tissue, sizes);
                let model = network.model();
                let cell = model.cell_of_input(input_id).ok_or(Code::UnknownId)?;
                body.stress(model, cell.into())
            })
        };
        // SAFETY: the caller's promises are handed on.
        unsafe { memory::write(stress, found.ok_or(Code::NoStress)?.into()) }
    }))
}
