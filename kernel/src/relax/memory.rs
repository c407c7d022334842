//! The words of a body that relaxes.

use crate::energy::links::follow::HalfLinkRow;
use crate::energy::nodal::follow::BranchRows;
use crate::model::Model;
use crate::model::image::BRANCHES_MAX;
use crate::model::nodal::{HalfLinkMemory, MemoryNumbers};
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
    /// By slice, a branch after the other; none in a body of links.
    pub rows: &'a mut [BranchRows],
    /// By group of half-links, a branch after the other; none in a body of shapes.
    pub link_rows: &'a mut [HalfLinkRow],
    /// The numbers for a tick, by slice and by group: they follow from the rows and the clock.
    pub numbers: &'a mut [MemoryNumbers],
    pub link_numbers: &'a mut [HalfLinkMemory],
}

/// Slices of shapes and groups of half-links that remember.
fn remembering(model: &Model<'_>) -> [usize; 2] {
    if model.is_nodal() {
        [model.slice_count(), 0]
    } else {
        [0, model.slices.map_or(0, |slices| slices.neighbours.len())]
    }
}

/// Words of the state and of the numbers that follow from it; `None` for an elastic body.
pub(crate) fn sizes(model: &Model<'_>) -> Option<[usize; 2]> {
    let (branches, [slices, groups]) = (model.others.branches().len(), remembering(model));
    let words = |of_slice: usize, of_group: usize| (slices * of_slice + groups * of_group) / 4;
    let rows = words(branches * size_of::<BranchRows>(), branches * size_of::<HalfLinkRow>());
    let numbers = words(size_of::<MemoryNumbers>(), size_of::<HalfLinkMemory>());
    (branches > 0).then_some([CLOCK + rows, numbers])
}

/// The words of the state; `None` for an elastic body, and if there are too few.
pub(crate) fn state<'w>(words: &'w [u32], model: &Model<'_>) -> Option<&'w [u32]> {
    let [state, numbers] = sizes(model)?;
    words.get(..state + numbers)?.get(..state)
}

/// Divides the words; `None` for an elastic body, and if there are too few.
pub(crate) fn arrays<'w>(words: &'w mut [u32], model: &Model<'_>) -> Option<Arrays<'w>> {
    let ([slices, groups], branches) = (remembering(model), model.others.branches().len());
    sizes(model)?;
    let rest = &mut { words };
    Some(Arrays {
        since: take::<u32>(rest, BRANCHES_MAX)?.first_chunk_mut()?,
        taken: take::<u32>(rest, BRANCHES_MAX)?.first_chunk_mut()?,
        remembered: take::<Double>(rest, 2 * BRANCHES_MAX)?.first_chunk_mut()?,
        relaxed: take::<Double>(rest, 2)?.first_mut()?,
        rows: take(rest, slices * branches * size_of::<BranchRows>() / 4)?,
        link_rows: take(rest, groups * branches * size_of::<HalfLinkRow>() / 4)?,
        numbers: take(rest, slices * size_of::<MemoryNumbers>() / 4)?,
        link_numbers: take(rest, groups * size_of::<HalfLinkMemory>() / 4)?,
    })
}
