//! Sets of cells that are joined two by two: each cell names a lower one of its set, the lowest itself.

/// The lowest cell of a cell's set, which stands for it; those on the way then name the one after the next.
pub(super) fn standing(roots: &mut [u16], mut cell: u16) -> u16 {
    while let Some(&next) = roots.get(usize::from(cell)).filter(|&&next| next != cell) {
        let after = roots.get(usize::from(next)).copied().unwrap_or(next);
        if let Some(slot) = roots.get_mut(usize::from(cell)) {
            *slot = after;
        }
        cell = next;
    }
    cell
}

/// Joins the sets of two cells.
pub(super) fn join(roots: &mut [u16], one: u16, other: u16) {
    let (one, other) = (standing(roots, one), standing(roots, other));
    let (low, high) = if one < other { (one, other) } else { (other, one) };
    if let Some(root) = roots.get_mut(usize::from(high)) {
        *root = low;
    }
}
