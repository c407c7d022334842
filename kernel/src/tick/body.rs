//! The body as it is now: cut, or with the memory of its strain.

use super::settings::Network;
use super::tissue::TissueMut;
#[cfg(feature = "cut")]
use crate::cut::body::CutBody;
#[cfg(any(feature = "cut", feature = "relax"))]
use crate::cut::memory::CutRoom;
use crate::cut::memory::cut_state;
use crate::model::Model;
#[cfg(feature = "relax")]
use crate::number::clamp::finite;
#[cfg(feature = "relax")]
use crate::relax::body::RelaxingBody;
use crate::solver::Dynamics;

impl<D: Dynamics> TissueMut<'_, D> {
    /// Calls `run` with the body as it is now.
    #[cfg(any(feature = "cut", feature = "relax"))]
    pub(super) fn with_body_model<R>(
        &mut self,
        model: &Model<'_>,
        run: impl FnOnce(&mut Self, &Model<'_>) -> R,
    ) -> R {
        let mut memory = core::mem::take(&mut self.cut);
        let now = of_room(&mut memory, model);
        let result = run(self, now.as_ref().unwrap_or(model));
        self.cut = memory;
        result
    }

    /// In a kernel that neither cuts nor relaxes a body is as its image has it.
    #[cfg(not(any(feature = "cut", feature = "relax")))]
    pub(super) fn with_body_model<R>(
        &mut self,
        model: &Model<'_>,
        run: impl FnOnce(&mut Self, &Model<'_>) -> R,
    ) -> R {
        run(self, model)
    }

    /// Calls `run` with the network of the body as it is now.
    pub(super) fn with_body<R>(
        &mut self,
        network: &Network<'_>,
        run: impl FnOnce(&mut Self, &Network<'_>) -> R,
    ) -> R {
        #[cfg(any(feature = "cut", feature = "relax"))]
        return self.with_body_model(network.model(), |tissue, model| {
            run(tissue, &network.of_model(*model))
        });
        #[cfg(not(any(feature = "cut", feature = "relax")))]
        run(self, network)
    }

    /// Words of the state of a body that is cut, or that relaxes; `None` for another one.
    pub(super) fn body_state(&self, model: &Model<'_>) -> Option<&[u32]> {
        #[cfg(any(feature = "cut", feature = "relax"))]
        return cut_state(self.cut.words(), model);
        #[cfg(not(any(feature = "cut", feature = "relax")))]
        cut_state(&[], model)
    }

    /// Energy that the branches of a body have relaxed since the reset \[J\]: work that the hand did and that neither
    /// the body holds nor a sweep took. 0 for an elastic body, and in a kernel without the feature `relax`.
    #[must_use]
    pub fn relaxed_j(&mut self, network: &Network<'_>) -> f32 {
        #[cfg(feature = "relax")]
        if let Some(body) = RelaxingBody::of(self.cut.words_mut(), network.model()) {
            return finite((body.relaxed() * f64::from(network.model().energy_unit_j())) as f32);
        }
        #[cfg(not(feature = "relax"))]
        let _ = network;
        0.0
    }
}

/// The body as these words have it; `None` for one that is as in its image.
#[cfg(any(feature = "cut", feature = "relax"))]
fn of_room<'a, 'm: 'a>(memory: &'a mut CutRoom<'_>, model: &'a Model<'m>) -> Option<Model<'a>> {
    #[cfg(feature = "relax")]
    if model.relaxes() {
        return RelaxingBody::of(memory.words_mut(), model).map(RelaxingBody::into_model);
    }
    #[cfg(feature = "cut")]
    return CutBody::of(memory, model).map(CutBody::into_model);
    #[cfg(not(feature = "cut"))]
    None
}
