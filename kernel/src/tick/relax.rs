//! The start of a tick of a body that relaxes: its memory follows its strain.

use super::settings::Network;
use super::tissue::TissueMut;
use crate::backend::run;
use crate::energy::current::rounded_up;
use crate::energy::following::{Course, Parts, Sums};
use crate::energy::links::follow::FollowLinks;
use crate::energy::nodal::follow::Follow;
use crate::energy::residual::{Terms, places};
use crate::energy::sliced::displace_outputs;
use crate::model::relaxing_links::RelaxingLinks;
use crate::model::{Model, others};
use crate::relax::body::RelaxingBody;
use crate::solver::Dynamics;

impl<D: Dynamics> TissueMut<'_, D> {
    /// Lets the memory follow the published positions. A late tick only counts.
    pub(super) fn relax(&mut self, network: &Network<'_>, is_late: bool) {
        let model = network.model();
        let mut memory = core::mem::take(&mut self.cut);
        let change = RelaxingBody::of(memory.words_mut(), model).and_then(|mut body| {
            body.count();
            if is_late { None } else { self.follow(model, &mut body) }
        });
        self.cut = memory;
        // Book the change of the energy; all else is as after a correction.
        if let Some(rise) = change {
            self.head.touched = None;
            self.head.level.shift(rounded_up(rise));
            self.head.awake.wake_all(model);
        }
    }

    /// Returns the change of the energy, rounded up, in internal units; `None` if nothing changes.
    fn follow(&mut self, model: &Model<'_>, body: &mut RelaxingBody<'_, '_>) -> Option<f64> {
        let courses = body.due();
        if courses.iter().all(|course| course.faded <= 0.0) {
            return None;
        }
        let of_body = courses.get(..body.branches())?;
        let sums = if model.is_nodal() {
            self.follow_shapes(model, of_body, body)?
        } else {
            self.follow_links(model, of_body, body)?
        };
        let change = body.book(&courses, &sums);
        change.any.then_some(change.rise)
    }

    /// The memory of shapes follows their strain.
    fn follow_shapes(
        &mut self,
        model: &Model<'_>,
        courses: &[Course],
        body: &mut RelaxingBody<'_, '_>,
    ) -> Option<Sums> {
        // Displacements of the awake slices; others lie in their rest shape and remember nothing.
        let (cells, slices) = (model.cells(), model.slice_count());
        let state = self.state.get(..cells)?;
        let terms = Terms::<D::Number>::of(model, self.states.shared(model.kept_states()));
        let terms = Terms { vectors: self.head.vectors, ..terms };
        let awake = &self.head.awake.set;
        displace_outputs(terms, awake.iter(slices), state);
        // Follow them.
        let mut sums = Sums::NONE;
        let work = Follow {
            shapes: others::shapes(&model.others),
            states: terms.states,
            slices: awake.iter(slices),
            courses,
            parts: Parts::of(courses),
            rows: body.arrays.rows,
            numbers: body.arrays.numbers,
            sums: &mut sums,
        };
        run(self.head.vectors, work);
        Some(sums)
    }

    /// The memory of links follows their tension.
    fn follow_links(
        &self,
        model: &Model<'_>,
        courses: &[Course],
        body: &mut RelaxingBody<'_, '_>,
    ) -> Option<Sums> {
        let mut sums = Sums::NONE;
        let work = FollowLinks {
            links: RelaxingLinks(model),
            at: places(model, self.state.get(..model.cells())?),
            courses,
            parts: Parts::of(courses),
            rows: body.arrays.link_rows,
            numbers: body.arrays.link_numbers,
            sums: &mut sums,
        };
        run(self.head.vectors, work);
        Some(sums)
    }

    /// Forgets all strain.
    pub(super) fn forget_strain(&mut self, model: &Model<'_>) {
        if let Some(mut body) = RelaxingBody::of(self.cut.words_mut(), model) {
            body.reset();
        }
    }
}
