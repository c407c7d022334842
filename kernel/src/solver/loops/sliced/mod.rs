//! Loops eight cells side by side: the same sums in the same order as cell by cell.

pub(crate) mod euler;
pub(crate) mod track;
