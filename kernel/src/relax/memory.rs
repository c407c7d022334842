//! The words of a body that relaxes.

use crate::energy::nodal::follow::BranchRows;
use crate::model::Model;
use crate::model::image::BRANCHES_MAX;
use crate::model::nodal::MemoryNumbers;
use crate::model::terms::TermData;
use crate::number::words::{Double, take};

/// Words of the clock.
const CLOCK: usize = 4 * BRANCHES_MAX + 2;

/// The words, by their use.
pub(crate) struct Arrays<'a> {
    /// Ticks since each branch last followed the strain.
    pub since: &'a mut [u32; BRANCHES_MAX],
    /// Ticks for which it then followed at once, 0 before the first time.
    pub taken: &'a mut [u32; BRANCHES_MAX],
    /// u . S u of the displacement that each branch remembers, in internal units.
    pub remembered: &'a mut [Double; BRANCHES_MAX],
    /// Energy that the branches have relaxed since the reset, in internal units.
    pub relaxed: &'a mut Double,
    /// By slice, a branch after the other.
    pub rows: &'a mut [BranchRows],
    /// The numbers for a tick, by slice: they follow from the rows and the clock.
    pub numbers: &'a mut [MemoryNumbers],
}

/// Words of the state and of the numbers that follow from it; `None` for an elastic body.
pub(crate) fn sizes(model: &Model<'_>) -> Option<[usize; 2]> {
    let branches = model.others.branches().len();
    let words = |rows: usize| model.slice_count() * rows / 4;
    (branches > 0).then(|| {
        [CLOCK + words(branches * size_of::<BranchRows>()), words(size_of::<MemoryNumbers>())]
    })
}

/// The words of the state; `None` for an elastic body, and if there are too few.
pub(crate) fn state<'w>(words: &'w [u32], model: &Model<'_>) -> Option<&'w [u32]> {
    let [state, numbers] = sizes(model)?;
    words.get(..state + numbers)?.get(..state)
}

/// Divides the words; `None` for an elastic body, and if there are too few.
pub(crate) fn arrays<'w>(words: &'w mut [u32], model: &Model<'_>) -> Option<Arrays<'w>> {
    let (slices, branches) = (model.slice_count(), model.others.branches().len());
    sizes(model)?;
    let rest = &mut { words };
    Some(Arrays {
        since: take::<u32>(rest, BRANCHES_MAX)?.first_chunk_mut()?,
        taken: take::<u32>(rest, BRANCHES_MAX)?.first_chunk_mut()?,
        remembered: take::<Double>(rest, 2 * BRANCHES_MAX)?.first_chunk_mut()?,
        relaxed: take::<Double>(rest, 2)?.first_mut()?,
        rows: take(rest, slices * branches * size_of::<BranchRows>() / 4)?,
        numbers: take(rest, slices * size_of::<MemoryNumbers>() / 4)?,
    })
}
