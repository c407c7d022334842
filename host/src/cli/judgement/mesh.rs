//! Edges of the surface compared with the radius of the tool, and the error of the force that comes from them.
//!
//! The errors are the largest ones measured, beside axisymmetric finite elements down to half a radius and on a
//! refined organ down to one radius; `tests/MEASURED.md` has both tables, "A sphere beside finite elements".

use std::fmt;

use chaincell_kernel::Model;
use serde::Serialize;

use crate::engine::course::ToolCourse;
use crate::engine::reach::Reach;
use crate::engine::{Engine, rest_m};
use crate::mesh::{CELLS_MAX, GROWTH, HALVINGS_MAX, halvings};
use crate::words::length;

/// Radius over edge from which on a row of the table holds, and its errors: less than a quarter of a radius
/// deep, up to half a radius, deeper.
const ERRORS: [(f64, [f64; 3]); 3] =
    [(2.0, [0.10, 0.14, 0.14]), (1.0, [0.25, 0.17, 0.26]), (0.0, [0.77, 0.32, 0.32])];
/// Depths [radii] at which the columns of the table begin, after the first.
const DEPTHS: [f64; 2] = [0.25, 0.5];
/// Radius over edge of the finest row.
const FINE: f64 = ERRORS[0].0;
/// Radius of the part of the body that is to be finer, in radii of the tool.
const REACH: f64 = 1.5;
/// Cells of a filled body in a cube of their mean edge.
const DENSITY: f64 = 1.575;

/// The mesh under a tool, or under any sphere where the tool is not known yet.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeshFit {
    /// Mean edge of the surface near the contact, or of all of it \[m\].
    pub edge_m: f64,
    /// Smallest radius of the tool's parts \[m\].
    pub radius_m: Option<f64>,
    /// Depth to which the tool came \[m\].
    #[serde(skip)]
    depth_m: f64,
    /// Largest measured error of the force for such a mesh, as a share; `None` for links, for tools that are
    /// no sphere, and where the tool is not known.
    pub force_error: Option<f64>,
    /// A mesh with edges of half the radius.
    #[serde(skip)]
    finer: Option<Finer>,
    #[serde(skip)]
    is_nodal: bool,
}

/// A mesh that is fine enough under the tool, as `--fill` makes it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Finer {
    /// Largest measured error of the force, as a share.
    error: f64,
    /// Mean edges away from the contact and at it \[m\].
    sizes_m: [f64; 2],
    /// The place of the contact, and how far the finer part reaches \[m\].
    place_m: [f64; 3],
    reach_m: f64,
    /// Some number of cells.
    cells: f64,
}

impl Finer {
    /// Of a body of this number of cells and mean link, which is pressed at a place by a radius.
    fn new(
        cells: usize,
        link_m: f64,
        fine_m: f64,
        (place_m, radius_m): ([f64; 3], f64),
        error: f64,
    ) -> Self {
        // Away from the contact `--fill` makes the size nearest to today's.
        let coarse_m = fine_m * halvings(link_m, fine_m).clamp(1.0, HALVINGS_MAX).exp2();
        let (sizes_m, reach_m) = ([coarse_m, fine_m], REACH * radius_m);
        let away = cells as f64 * (link_m / coarse_m).powi(3);
        let cells = away + more_cells(sizes_m, reach_m);
        Self { error, sizes_m, place_m, reach_m, cells }
    }

    /// The text that `--fill` takes.
    fn option(&self) -> String {
        let [coarse, fine, reach] =
            [self.sizes_m[0], self.sizes_m[1], self.reach_m].map(two_digits);
        let [x, y, z] = self.place_m.map(|x| (1e4 * x).round() / 1e4 + 0.0);
        format!("--fill {coarse},{fine}@{x},{y},{z},{reach}")
    }
}

/// Cells that half a ball of the finer size adds at a surface, with the layers around it in which the size
/// is doubled.
fn more_cells([coarse_m, fine_m]: [f64; 2], reach_m: f64) -> f64 {
    const STEPS: usize = 400;
    let end_m = reach_m + coarse_m / GROWTH;
    let step_m = end_m / STEPS as f64;
    let shells = (0..STEPS).map(|at| {
        let out_m = (at as f64 + 0.5) * step_m;
        let largest = 1.0 + GROWTH * (out_m - reach_m).max(0.0) / fine_m;
        let size_m = (fine_m * largest.log2().floor().exp2()).min(coarse_m);
        let volume_m3 = 2.0 * std::f64::consts::PI * out_m * out_m * step_m;
        DENSITY * volume_m3 * (size_m.powi(-3) - coarse_m.powi(-3))
    });
    shells.sum()
}

/// A length as an option takes it.
fn two_digits(length_m: f64) -> f64 {
    format!("{length_m:.1e}").parse().unwrap_or(length_m)
}

/// Errors at a radius over edge and a depth [radii].
fn error(radius: f64, depth: f64) -> f64 {
    let (_, errors) = ERRORS.iter().find(|(least, _)| radius >= *least).unwrap_or(&ERRORS[2]);
    errors[DEPTHS.iter().filter(|begin| depth >= **begin).count()]
}

impl MeshFit {
    /// The mesh where a tool first touched the body of an engine; `None` where none did.
    pub fn under(engine: &Engine<'_>, tool: &ToolCourse) -> Option<Self> {
        let model = engine.network().model();
        let parts = engine.contact().first_tool()?;
        if parts.iter().any(chaincell_kernel::ToolPart::is_half_space) {
            return None;
        }
        // An edge has no radius.
        let radii = parts.iter().filter(|part| !part.is_edge()).map(|part| part.radius_m.into());
        let radius_m: f64 = radii.reduce(f64::min)?;
        let touch_m = tool.touch_m?.map(f64::from);
        let reach = Reach::of(model);
        let edge_m = reach.edge_near_m(touch_m, radius_m)?;
        let is_sphere = engine.contact().radius_m().is_some();
        let depth = tool.reached_m.unwrap_or_default() / radius_m;
        let place_m = reach.nearest_m(touch_m)?;
        Some(Self::with(model, edge_m, place_m, (radius_m, depth, is_sphere)))
    }

    /// The mesh of a model, for any sphere; `None` without a surface that tools touch.
    pub fn of_surface(model: &Model<'_>) -> Option<Self> {
        if !model.has_contact_surface() {
            return None;
        }
        let centre = rest_m(model, 0);
        let edge_m = Reach::of(model).edge_near_m(centre, f64::INFINITY)?;
        let is_nodal = model.is_nodal();
        let depth_m = 0.0;
        Some(Self { edge_m, radius_m: None, depth_m, force_error: None, finer: None, is_nodal })
    }

    fn with(
        model: &Model<'_>,
        edge_m: f64,
        place_m: [f64; 3],
        (radius_m, depth, is_sphere): (f64, f64, bool),
    ) -> Self {
        let is_nodal = model.is_nodal();
        let is_judged = is_nodal && is_sphere;
        let fine_m = radius_m / FINE;
        let link_m = model.unit_m().into();
        let finer = || {
            Finer::new(model.body_cells(), link_m, fine_m, (place_m, radius_m), error(FINE, depth))
        };
        Self {
            edge_m,
            radius_m: Some(radius_m),
            depth_m: depth * radius_m,
            force_error: is_judged.then(|| error(radius_m / edge_m, depth)),
            finer: (edge_m > fine_m).then(finer),
            is_nodal,
        }
    }
}

impl fmt::Display for MeshFit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let percent = |share: f64| format!("{:.0} %", 100.0 * share);
        let edges = length(self.edge_m);
        let Some(radius_m) = self.radius_m else {
            write!(f, "edges of {edges} on the surface: for a sphere of {} or more ", {
                length(FINE * self.edge_m)
            })?;
            if !self.is_nodal {
                return write!(f, "they are fine enough");
            }
            let [fine, coarse] = [error(FINE, 0.5), error(0.0, 0.5)].map(percent);
            return write!(f, "the force is within {fine}, below {edges} up to {coarse} off");
        };
        write!(f, "edges of {edges} for a radius of {}", length(radius_m))?;
        // The error depends on it.
        if self.depth_m > 0.0 {
            write!(f, ", {} deep", length(self.depth_m))?;
        }
        write!(f, ": ")?;
        match (self.force_error, &self.finer) {
            (Some(error), None) => return write!(f, "the force is within {}", percent(error)),
            (None, None) => return write!(f, "fine enough"),
            (Some(error), Some(_)) => write!(f, "the force is up to {} off", percent(error))?,
            (None, Some(_)) => write!(f, "coarse")?,
        }
        let Some(finer) = &self.finer else { return Ok(()) };
        let cells = finer.cells;
        if cells > CELLS_MAX as f64 {
            return write!(
                f,
                "; edges of half the radius at the contact need some {cells:.0} cells, more than {CELLS_MAX}: take \
                 a larger tool, or a smaller part of the body"
            );
        }
        write!(
            f,
            "; edges of half the radius at the contact ({} of a closed surface, some {cells:.0} cells)",
            finer.option()
        )?;
        match self.force_error {
            Some(_) => write!(f, " make that {}", percent(finer.error)),
            None => write!(f, " are fine enough"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fit(radius_m: f64, edge_m: f64, depth: f64) -> MeshFit {
        let (fine_m, place_m) = (radius_m / FINE, [0.012_34, -1e-9, 0.04]);
        let finer = Finer::new(1000, edge_m, fine_m, (place_m, radius_m), error(FINE, depth));
        MeshFit {
            edge_m,
            radius_m: Some(radius_m),
            depth_m: depth * radius_m,
            force_error: Some(error(radius_m / edge_m, depth)),
            finer: (edge_m > fine_m).then_some(finer),
            is_nodal: true,
        }
    }

    #[test]
    fn a_coarse_mesh_is_said_with_its_error_and_a_remedy() {
        assert_eq!(
            fit(0.005, 0.0058, 1.0).to_string(),
            "edges of 5.80 mm for a radius of 5.00 mm, 5.00 mm deep: the force is up to 32 % off; edges of half the \
             radius at the contact (--fill 0.005,0.0025@0.0123,0,0.04,0.0075 of a closed surface, some 1923 cells) make that 14 %"
        );
        let many = Finer { cells: 7e4, ..fit(0.005, 0.0058, 1.0).finer.unwrap() };
        let text = MeshFit { finer: Some(many), ..fit(0.005, 0.0058, 1.0) }.to_string();
        assert!(text.contains("more than 65535: take a larger tool"), "{text}");
        let text = fit(0.012, 0.0058, 0.3).to_string();
        assert!(text.ends_with("the force is within 14 %"), "{text}");
    }

    #[test]
    fn errors_are_those_of_the_table() {
        let found = [(2.0, 0.1), (1.5, 0.1), (1.5, 0.3), (0.5, 0.1), (0.5, 0.6)];
        assert_eq!(
            found.map(|(radius, depth)| error(radius, depth)),
            [0.10, 0.25, 0.17, 0.77, 0.32]
        );
    }

    #[test]
    fn without_a_tool_it_is_said_which_sphere_a_surface_suits() {
        let any =
            MeshFit { radius_m: None, force_error: None, finer: None, ..fit(1.0, 0.0058, 0.0) };
        let text = any.to_string();
        assert!(text.contains("sphere of 11.6 mm or more the force is within 14 %"), "{text}");
        let links = MeshFit { is_nodal: false, ..any }.to_string();
        assert!(links.ends_with("or more they are fine enough"), "{links}");
    }
}
