//! How a mesh file is read: options that `bake` and `convert` share; and the units of files.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

use crate::mesh::{Filling, MeshOptions};

/// Unit and filling.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct MeshFileArgs {
    /// Unit of the coordinates of a mesh file; all else is in metres
    #[arg(id = "unit_m", long = "units", value_name = "UNITS", value_enum, default_value_t = Units::M)]
    units: Units,
    /// Fill a closed surface (.stl, .obj, .ply) with tetrahedra of this mean edge [m]; of a smaller one
    /// within R of a place: SIZE,FINE@X,Y,Z,R [m], more places behind further @; or around the nodes of a
    /// selector of --fix, chosen in the evenly filled body: SIZE,FINE@near:SELECTOR
    #[arg(id = "fill_m", long = "fill", value_name = "SIZE", allow_negative_numbers = true)]
    fill: Option<Filling>,
}

/// Unit of a file's coordinates.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ValueEnum)]
pub enum Units {
    #[default]
    M,
    Mm,
}

impl Units {
    /// The unit in metres.
    pub(super) fn unit_m(self) -> f64 {
        match self {
            Self::M => 1.0,
            Self::Mm => 0.001,
        }
    }
}

impl MeshFileArgs {
    /// The unit in metres.
    pub(super) fn unit_m(&self) -> f64 {
        self.units.unit_m()
    }

    /// Options of reading the file: its unit, and how it is filled.
    pub(super) fn options(&self) -> MeshOptions {
        let filling = self.fill.clone();
        MeshOptions { unit_m: self.unit_m(), filling, ..MeshOptions::default() }
    }
}
