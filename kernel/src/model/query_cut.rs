//! The properties of a body that can be cut.

use super::Model;
use super::cuttable::Cuttable;
use super::loose::Loose;
use super::tearing::TearLimit;

impl<'a> Model<'a> {
    /// Number of cells without the spare ones: those that have an input id, and that a result shows.
    ///
    /// ```
    /// # use chaincell_kernel::{Model, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// let model = Model::from_bytes(image)?;
    /// assert_eq!((model.body_cells(), model.cells()), (81, 81)); // it cannot be cut
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    #[must_use]
    pub fn body_cells(&self) -> usize {
        self.cells() - self.spare_cells()
    }

    /// Number of spare cells, which take the further sides of a cut: the last ones. Until then each lies still at
    /// the body's centre, without links and input id. 0 for a body that cannot be cut.
    ///
    /// ```
    /// # use chaincell_kernel::{Model, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// let model = Model::from_bytes(image)?; // baked without `--cuttable`
    /// assert_eq!((model.spare_cells(), model.tetrahedra_to_cut()), (0, 0));
    /// assert_eq!(model.toughness_j_per_m2(), None);
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    #[must_use]
    pub fn spare_cells(&self) -> usize {
        self.cuttable.spare_cells()
    }

    /// Number of tetrahedra that a blade may part; 0 for a body that cannot be cut. See [`Self::spare_cells`].
    #[must_use]
    pub fn tetrahedra_to_cut(&self) -> usize {
        self.cuttable.corners().len()
    }

    /// Returns the energy that a cut takes for each area \[J/m^2\], the largest of all cells' where they differ; `None`
    /// for a body that cannot be cut. See [`Self::spare_cells`].
    #[must_use]
    pub fn toughness_j_per_m2(&self) -> Option<f32> {
        self.cuttable.is_any().then_some(self.cuttable.toughness_j_per_m2())
    }

    /// Returns the energy that a cut takes for each area at a cell \[J/m^2\]; `None` for a spare cell and for a body
    /// that cannot be cut. See [`Self::spare_cells`].
    #[must_use]
    pub fn cell_toughness_j_per_m2(&self, cell: usize) -> Option<f32> {
        let is_there = self.cuttable.is_any() && cell < self.body_cells();
        is_there.then(|| self.cuttable.cell_toughness_j_per_m2(cell))
    }

    /// Returns the limit at which the body tears by itself, `None` for one that does not tear. See
    /// [`Self::spare_cells`].
    ///
    /// ```
    /// # use chaincell_kernel::{Model, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// let model = Model::from_bytes(image)?; // baked without `--tears` and `--tear-stretch`
    /// assert_eq!(model.tear_limit(), None);
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    #[must_use]
    pub fn tear_limit(&self) -> Option<TearLimit> {
        self.cuttable.tear_limit()
    }

    /// Returns what becomes of pieces that come loose.
    ///
    /// ```
    /// # use chaincell_kernel::{Model, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// use chaincell_kernel::Loose;
    ///
    /// let model = Model::from_bytes(image)?; // baked without `--loose`
    /// assert_eq!(model.loose(), Loose::Leave);
    /// # Ok::<(), chaincell_kernel::ModelError>(())
    /// ```
    #[must_use]
    pub fn loose(&self) -> Loose {
        self.cuttable.loose()
    }

    /// Cells of a triangle of this name in the whole body, see [`Opened`](super::opened::Opened).
    pub(crate) fn whole_triangle(&self, name: u32) -> Option<[u16; 3]> {
        let name = name as usize;
        let Some(side) = name.checked_sub(self.triangles.len()) else {
            return self.triangles.get(name).copied();
        };
        self.cuttable.face(side / 4, side % 4)
    }

    /// Returns the tetrahedra that a blade may part.
    pub(crate) fn cuttable(&self) -> Cuttable<'a> {
        self.cuttable
    }
}
