//! The cut of a body by a run, in words and numbers.

use std::fmt;

use serde::Serialize;

use crate::engine::Engine;
use crate::words::counted;

/// The cut of a body that can be cut, since the last reset.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CutReport {
    /// Area that the edges of blades have swept \[m2\].
    cut_area_m2: f32,
    /// Work that it took to part the tissue there \[J\].
    cut_work_j: f32,
    /// Number of faces between tetrahedra that are open.
    opened_faces: u32,
    /// Number of copies of split cells.
    copied_cells: u32,
    /// Number of splits for which there was no spare cell.
    refused_splits: u32,
    /// Number of cells at which the body has torn by itself; not of one that does not tear.
    #[serde(skip_serializing_if = "Option::is_none")]
    torn_cells: Option<u32>,
}

impl CutReport {
    /// The cut of an engine's body; `None` for one that cannot be cut.
    pub fn of(engine: &mut Engine<'_>) -> Option<Self> {
        if engine.network().model().tetrahedra_to_cut() == 0 {
            return None;
        }
        let cut = engine.cut_output();
        let tears = engine.network().model().tear_limit().is_some();
        Some(Self {
            cut_area_m2: cut.area_m2,
            cut_work_j: cut.work_j,
            opened_faces: cut.opened_faces,
            copied_cells: cut.copies,
            refused_splits: cut.refused,
            torn_cells: tears.then_some(cut.torn),
        })
    }

    /// Returns true for a body that tears: the page cannot play its sessions.
    pub fn tears(&self) -> bool {
        self.torn_cells.is_some()
    }

    /// The remedy where cells could not split.
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
        match self.torn_cells {
            Some(torn) => write!(f, ", {} torn", counted(torn, "cell")),
            None => Ok(()),
        }
    }
}
