//! The cut of a body by a session, in words and numbers.

use std::fmt;

use chaincell_kernel::{CutOutput, Model};
use serde::{Deserialize, Serialize};

use super::loose::Loose;
use crate::words::counted;

/// The cut of a body that can be cut, since the last reset.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CutReport {
    /// Area that the edges of blades have swept \[m2\].
    pub cut_area_m2: f32,
    /// Work that it took to part the tissue there \[J\].
    pub cut_work_j: f32,
    /// Number of faces between tetrahedra that are open.
    pub opened_faces: u32,
    /// Number of copies of split cells.
    pub copied_cells: u32,
    /// Number of splits for which there was no spare cell.
    pub refused_splits: u32,
    /// Number of pieces that hang on no fixed cell; not of a body whose image has no tetrahedra to show (`lean`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loose_pieces: Option<u32>,
    /// Number of their cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loose_cells: Option<u32>,
    /// Number of cells at which the body has torn by itself; not of one that does not tear.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torn_cells: Option<u32>,
}

impl CutReport {
    /// The cut of a body that can be cut.
    #[must_use]
    pub fn of(model: &Model<'_>, cut: &CutOutput, loose: Option<Loose>) -> Self {
        Self {
            cut_area_m2: cut.area_m2,
            cut_work_j: cut.work_j,
            opened_faces: cut.opened_faces,
            copied_cells: cut.copies,
            refused_splits: cut.refused,
            loose_pieces: loose.map(|loose| loose.pieces),
            loose_cells: loose.map(|loose| loose.cells),
            torn_cells: model.tear_limit().is_some().then_some(cut.torn),
        }
    }

    /// The remedy where cells could not split.
    #[must_use]
    pub fn remedy(&self) -> Option<String> {
        let splits = counted(self.refused_splits, "split");
        (self.refused_splits > 0).then(|| {
            format!(
                "{splits} refused for want of spare cells: the body holds together there; bake it with more \
                 --cut-spare"
            )
        })
    }
}

impl fmt::Display for CutReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{:.2} mm^2 with {:.3} mJ, {} open, {}",
            1e6 * self.cut_area_m2,
            1e3 * self.cut_work_j,
            counted(self.opened_faces, "face"),
            counted(self.copied_cells, "copied cell")
        )?;
        if let Some(torn) = self.torn_cells {
            write!(f, ", {} torn", counted(torn, "cell"))?;
        }
        match (self.loose_pieces, self.loose_cells) {
            (Some(pieces @ 1..), Some(cells)) => {
                write!(f, ", {} of {} loose", counted(pieces, "piece"), counted(cells, "cell"))
            }
            _ => Ok(()),
        }
    }
}
