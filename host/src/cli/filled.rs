//! The printed figures of a closed surface that was filled.

use serde::Serialize;

use crate::error::Result;
use crate::mesh::{Filled, Mesh};
use crate::terminal;
use crate::words::{length, volume};

/// Figures of the tetrahedra.
#[derive(Debug, Serialize)]
pub(super) struct FilledReport {
    surface_triangles: usize,
    turned_triangles: usize,
    bodies: usize,
    cavities: usize,
    tetrahedra: usize,
    nodes: usize,
    mean_edge_m: f64,
    /// Mean edges in the finer regions and away from them.
    #[serde(skip_serializing_if = "Option::is_none")]
    graded_edges_m: Option<[Option<f64>; 2]>,
    smallest_dihedral_deg: f64,
    largest_dihedral_deg: f64,
    roundness_min: f64,
    volume_m3: f64,
    volume_error: f64,
    surface_distance_m: f64,
    handles: [i64; 2],
}

impl FilledReport {
    /// Of a body that was made of a surface; none of others.
    pub(super) fn of(mesh: &Mesh) -> Option<Self> {
        let filled: &Filled = mesh.filled.as_ref()?;
        let [smallest_dihedral_deg, largest_dihedral_deg] = filled.dihedral_deg;
        Some(Self {
            surface_triangles: filled.triangles,
            turned_triangles: filled.turned,
            bodies: filled.bodies,
            cavities: filled.cavities,
            tetrahedra: mesh.tetrahedra.len(),
            nodes: mesh.nodes_m.len(),
            mean_edge_m: filled.edge_m,
            graded_edges_m: filled.graded_m,
            smallest_dihedral_deg,
            largest_dihedral_deg,
            roundness_min: filled.roundness,
            volume_m3: filled.volume_m3,
            volume_error: filled.volume_error,
            surface_distance_m: filled.distance_m,
            handles: filled.handles,
        })
    }

    /// Some lines on standard output.
    pub(super) fn print(&self) -> Result<()> {
        let row = |name: &str, value: String| terminal::say(format_args!("  {name:<14}{value}"));
        // Print the surface.
        let cavities = match self.cavities {
            0 => String::new(),
            count => format!(", cavities: {count}"),
        };
        let turned = match self.turned_triangles {
            0 => String::new(),
            count => format!(", {count} of them turned round"),
        };
        row(
            "surface",
            format!(
                "{} triangles{turned}; bodies: {}{cavities}",
                self.surface_triangles, self.bodies
            ),
        )?;
        // Print the tetrahedra, their quality and volume.
        row(
            "filled",
            format!(
                "{} tetrahedra, {} nodes, mean edge {}",
                self.tetrahedra,
                self.nodes,
                length(self.mean_edge_m)
            ),
        )?;
        if let Some(edges_m) = self.graded_edges_m {
            let [fine, coarse] = edges_m.map(|edge_m| edge_m.map_or_else(|| "none".into(), length));
            row("graded", format!("mean edge {fine} in the region, {coarse} away from it"))?;
        }
        row(
            "quality",
            format!(
                "angles between faces {:.1} to {:.1} degrees, roundness {:.2} or more (1: regular)",
                self.smallest_dihedral_deg, self.largest_dihedral_deg, self.roundness_min
            ),
        )?;
        row(
            "volume",
            format!(
                "{}, of the tetrahedra {:+.2} %",
                volume(self.volume_m3),
                100.0 * self.volume_error
            ),
        )?;
        // Name handles that were lost, and print the distance.
        if self.handles[0] != self.handles[1] {
            let [of_surface, of_filled] = self.handles;
            terminal::note(format_args!(
                "note: the surface has handles: {of_surface}, the tetrahedra: {of_filled}; holes or bridges \
                 thinner than they are are lost"
            ));
        }
        row("distance", format!("{} between the surfaces at most", length(self.surface_distance_m)))
    }
}
