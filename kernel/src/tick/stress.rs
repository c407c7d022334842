//! Strain and stress of a tissue, for reports.

use super::tissue::TissueMut;
use crate::energy::residual::Terms;
use crate::energy::stress::Stress;
use crate::model::Model;
use crate::number::Number;
use crate::number::cell::{Cell, output};
use crate::solver::Dynamics;

impl<D: Dynamics> TissueMut<'_, D> {
    /// Strain and stress of the tissue around a cell at the published positions; `None` beyond the last cell and
    /// in a body of links, whose stress no law gives. It has the parts of the shape, of the least stretch, of
    /// stiffening, and of what a body that relaxes has not yet relaxed; a cut is in it from the tick in which it
    /// parts the cell. The mean stress is that of the cell and of those linked to it, by volume. Cost: some
    /// thousand operations and the half-links of each of these cells; a tick does none of it.
    ///
    /// ```
    /// # use chaincell_kernel::*;
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// # let network = Network::new(model, Settings::for_model(&model))?;
    /// # let mut tissue = Tissue::<128, Track>::new();
    /// # tissue.reset(&network)?;
    /// let stress = tissue.view().stress(&model, 47);
    /// assert_eq!(stress, None); // the plane is made of links
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn stress(&mut self, model: &Model<'_>, cell: usize) -> Option<Stress> {
        self.stress_with(model, cell, &mut [])
    }

    /// The same for many cells: `means_pa` has a number for each cell, NaN before the first call at these
    /// positions, and later calls take from it the mean stress of cells that earlier ones met.
    pub fn stress_with(
        &mut self,
        model: &Model<'_>,
        cell: usize,
        means_pa: &mut [f32],
    ) -> Option<Stress> {
        self.with_body_model(model, |tissue, model| {
            let (limit, state) = (D::Number::from_single(model.saturation()), &*tissue.state);
            let at = |cell: usize| output(state.get(cell).unwrap_or(&Cell::ZERO).xyz(), limit);
            Terms::of(model, tissue.states.shared(model.kept_states())).stress(cell, &at, means_pa)
        })
    }
}
