//! Snapshots of a tissue.

use super::{SNAPSHOT_HEADER_BYTES, SnapshotError, open, seal};
use crate::backend::VectorUnit;
use crate::contact::memory::TouchState;
use crate::energy::held::Contact;
use crate::energy::links::number::LinkNumber;
use crate::energy::state::{TermState, term_states};
use crate::energy::surface::{Anchor, NearTriangle, ToolState};
use crate::model::Model;
use crate::number::cell::Cell;
use crate::number::float_env;
use crate::number::kept::{Kept, Pass, joined, named};
#[cfg(feature = "relax")]
use crate::relax::kept;
use crate::solver::scheme::UNKNOWN;
use crate::solver::{Dynamics, NumberOf};
use crate::tick::error::ResetError;
use crate::tick::settings::Network;
use crate::tick::tissue::{Head, TissueMut};

/// Returns the layout of a tissue under a scheme. Parts that the model does not use are left out, so that
/// kernels built with and without a feature read each other's snapshots.
fn layout<D: Dynamics>(model: &Model<'_>) -> u32 {
    let of_all = [
        // Number of arrays of the residual.
        1,
        D::ARRAYS as u32,
        named(0, D::NAME),
        <Head<D> as Kept>::LAYOUT,
        <Cell<NumberOf<D>> as Kept>::LAYOUT,
        <Contact<NumberOf<D>> as Kept>::LAYOUT,
    ];
    let of_shapes = (model.kept_states() > 0).then_some(TermState::LAYOUT);
    let of_surfaces = [TouchState::LAYOUT, ToolState::LAYOUT, NearTriangle::LAYOUT, Anchor::LAYOUT];
    let of_surfaces = of_surfaces.into_iter().filter(|_| model.has_contact_surface());
    of_all.into_iter().chain(of_shapes).chain(of_surfaces).fold(0, joined)
}

impl<D: Dynamics> TissueMut<'_, D> {
    /// Returns the bytes of a [snapshot](crate::snapshot) of the tissue in its present state: they depend on
    /// the model, on the cells or tools that were chosen, and on the triangles in reach.
    ///
    /// # Errors
    /// A tissue that was not reset to this network.
    pub fn snapshot_bytes(&mut self, network: &Network<'_>) -> Result<usize, SnapshotError> {
        let mut pass = Pass::count();
        self.keep(self.saved(network)?, &mut pass);
        Ok(SNAPSHOT_HEADER_BYTES + pass.end()?)
    }

    /// Saves the whole tissue between two ticks; returns the number of bytes written. The tissue does not
    /// change. Cost: about that of copying its memory; no memory besides a few kB of stack.
    ///
    /// ```
    /// # use chaincell_kernel::{Budget, Model, Network, Settings, Tissue, ToolPose, Track, include_model};
    /// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
    /// # let model = Model::from_bytes(image)?;
    /// # let network = Network::new(model, Settings::for_model(&model))?;
    /// # let mut tissue = Tissue::<128, Track>::new();
    /// # tissue.reset(&network)?;
    /// # tissue.choose_contacts(&network, &[47])?;
    /// # tissue.tick(&network, &[ToolPose::at([0.0; 3].into(), 1)], Budget::All);
    /// let pose = [ToolPose::at([0.0, 0.0, -0.004].into(), 1)];
    /// let mut bytes = [0; 8 * 1024];
    /// let length = tissue.view().save(&network, &mut bytes)?;
    /// let first = tissue.tick(&network, &pose, Budget::All);
    ///
    /// let mut other = Tissue::<128, Track>::new(); // of a later run, on any processor
    /// other.view().restore(&network, &bytes[..length])?;
    /// assert_eq!(other.tick(&network, &pose, Budget::All), first); // to the last bit
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A tissue that was not reset to this network, a buffer that is too short.
    pub fn save(
        &mut self,
        network: &Network<'_>,
        bytes: &mut [u8],
    ) -> Result<usize, SnapshotError> {
        let (needed, given) = (self.snapshot_bytes(network)?, bytes.len());
        let bytes = bytes.get_mut(..needed).ok_or(SnapshotError::Buffer { needed, given })?;
        let mut pass = Pass::write(bytes.get_mut(SNAPSHOT_HEADER_BYTES..).unwrap_or(&mut []));
        self.keep(self.saved(network)?, &mut pass);
        pass.end()?;
        let model = network.model();
        seal(bytes, layout::<D>(model), model.checksum());
        Ok(needed)
    }

    /// Continues from a snapshot: the same model, settings and samples give the same state hashes and forces.
    /// The tissue needs no reset before, but capacity for the contact cells, tools and triangles of the
    /// snapshot. As after a reset, the vector unit is used if there is one.
    ///
    /// # Errors
    /// The first fault of the bytes, of the tissue's capacity or of the thread's arithmetic; the
    /// tissue stays as it is.
    pub fn restore(&mut self, network: &Network<'_>, bytes: &[u8]) -> Result<(), SnapshotError> {
        let model = network.model();
        float_env::check().map_err(|why| SnapshotError::Reset(ResetError::Float(why)))?;
        D::Number::admits(model).map_err(|why| SnapshotError::Reset(ResetError::Range(why)))?;
        self.check_fit(model).map_err(SnapshotError::Reset)?;
        let words = open(bytes, layout::<D>(model), model.checksum())?;
        let mut head = Head::NEW;
        for mut pass in [Pass::check(words), Pass::read(words)] {
            head = self.keep((Head::NEW, model), &mut pass);
            if pass.end()? != words.len() {
                return Err(SnapshotError::Length);
            }
            if head.model != Some(model.checksum()) {
                return Err(SnapshotError::Model(head.model.unwrap_or(0)));
            }
        }
        *self.head = Head { vectors: VectorUnit::find(), off_balance: UNKNOWN, ..head };
        Ok(())
    }

    /// Returns the scalars to save, and the model; fails if the tissue was not reset to this network.
    fn saved<'n, 'm>(
        &self,
        network: &'n Network<'m>,
    ) -> Result<(Head<D>, &'n Model<'m>), SnapshotError> {
        let model = network.model();
        match self.head.model {
            Some(of) if of == model.checksum() => Ok((*self.head, model)),
            _ => Err(SnapshotError::NotReset),
        }
    }

    /// Passes over the scalars and the arrays, and returns the scalars.
    fn keep(&mut self, (mut head, model): (Head<D>, &Model<'_>), pass: &mut Pass<'_>) -> Head<D> {
        head.keep(pass);
        let cells = model.cells();
        pass.slice(self.state, cells);
        pass.slice(self.residual, cells);
        pass.slice(self.own, D::ARRAYS * cells);
        let room = if head.has_tools { D::tool_room(model) } else { D::room(model, head.chosen) };
        pass.slice(self.room, room);
        pass.slice(self.contacts, head.chosen);
        pass.slice(self.states.memory(), term_states(model.kept_states()));
        if model.has_contact_surface() {
            self.touch.keep(cells, pass);
        }
        #[cfg(feature = "cut")]
        if model.cuttable().is_any() {
            self.touch.keep_edges(pass);
            crate::cut::kept::keep(&mut self.cut, model, pass);
        }
        #[cfg(feature = "relax")]
        if model.relaxes() {
            kept::keep(self.cut.words_mut(), model, pass);
        }
        if model.has_contact_surface() {
            self.touch.keep_pins(pass);
        }
        head
    }
}
