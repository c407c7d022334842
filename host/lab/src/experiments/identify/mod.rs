//! Material parameters from measurements: stiffness and slack of each group of nodes and the
//! body's time constant, fitted to force-displacement curves, relaxation curves and displacement
//! fields.
//!
//! A target is a CSV file; its header says what it is:
//!
//! | header | what was measured |
//! |---|---|
//! | `displacement_m,force_n` | equilibrium forces of a growing press |
//! | `time_s,force_n` | the force after a step of `--displacement-m`: the only one that shows the time constant |
//! | `node,ux_m,uy_m,uz_m` | the displacement field at `--displacement-m`: alone it shows ratios of stiffness only, with `--force-n` their size |
//!
//! A fifth of the rows of each target is held out and only judges the result. `identified.json` has
//! each parameter with its 95 % interval, or says that the data leaves it open. `residuals.csv` has
//! a line a measured number (three a node of a field): measured, fit, fit less measured, held out
//! or not. The charts show the same, two a target: a good fit has residuals without a pattern, as
//! large in the rows held out as in the others. A fit bakes and presses the body some hundred
//! times: take a coarse mesh.
//!
//! The forward problem is the engine itself ([`forward`]); the fit is weighted least squares by
//! Levenberg and Marquardt from several starts ([`fit`]); what the data says of each parameter
//! comes from the singular values of the Jacobian at the end ([`uncertainty`]). A model of this
//! project has no volume term, so none is looked for.

pub mod fit;
pub mod forward;
pub mod noisy;
mod start;
pub mod target;
pub mod uncertainty;
pub mod write;

use chaincell_host::bake::{BakeOptions, PerCell};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{self, Mesh};
use target::{Data, Target};

pub use fit::{Identified, check, identify};

/// Nodes of one material.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// Name for tables.
    pub name: String,
    /// Input ids, ascending.
    pub nodes: Vec<u32>,
}

/// What is looked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// Stiffness of a link of each group [N/m].
    pub stiffness_n_per_m: Vec<f64>,
    /// Half-width of the band of each group's links \[rest lengths\].
    pub alpha: Vec<f64>,
    /// Time constant of the whole body \[s\]: its cells share one capacitance.
    pub time_constant_s: f64,
}

/// Where parameters are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Least and largest stiffness [N/m].
    pub stiffness_n_per_m: [f64; 2],
    /// Largest alpha; the least is 0.
    pub alpha_max: f64,
    /// Least and largest time constant \[s\].
    pub time_constant_s: [f64; 2],
}

impl Default for Bounds {
    fn default() -> Self {
        Self { stiffness_n_per_m: [0.01, 1e5], alpha_max: 0.5, time_constant_s: [1e-4, 1e4] }
    }
}

/// The body on the bench, and what was measured on it.
#[derive(Debug, Clone)]
pub struct Bench<'a> {
    /// The body.
    pub mesh: &'a Mesh,
    /// Nodes held for ever.
    pub fixed: &'a [u32],
    /// All that is known; its stiffness and alpha are those of nodes outside every group.
    pub options: &'a BakeOptions,
    /// Materials, no node in two.
    pub groups: &'a [Group],
    /// Cells that the tool holds, ascending.
    pub contacts: &'a [u16],
    /// Direction of the push, a unit vector.
    pub direction: [f64; 3],
    /// What was measured.
    pub targets: &'a [Target],
}

impl Bench<'_> {
    /// Whether a time constant can be seen in the data.
    #[must_use]
    pub fn has_time(&self) -> bool {
        self.targets.iter().any(|target| matches!(target.data, Data::Relaxation { .. }))
    }

    /// Refuses what no parameter could explain.
    ///
    /// # Errors
    /// A displacement beyond the body's own size, a node that is none, a group without nodes.
    pub fn check(&self) -> Result<()> {
        let size_m = size(self.mesh);
        for Target { name, data } in self.targets {
            let depth_m = match data {
                Data::Press { displacement_m, .. } => displacement_m.last().copied().unwrap_or(0.0),
                Data::Relaxation { displacement_m, .. } | Data::Field { displacement_m, .. } => {
                    *displacement_m
                }
            };
            if depth_m > size_m {
                return Err(Error::input(format!(
                    "{name}: a displacement of {depth_m} m is beyond the body's size of \
                     {size_m:.4} m; displacements are in metres, and see --units"
                )));
            }
            if let Data::Field { nodes, .. } = data {
                let last = self.mesh.nodes_m.len() as u32;
                let is_none = |node: &&u32| **node >= last || self.mesh.unused.contains(node);
                if let Some(node) = nodes.iter().find(is_none) {
                    return Err(Error::input(format!("{name}: node {node} is none of the body's")));
                }
            }
        }
        if self.targets.is_empty() {
            return Err(Error::input("--target: give at least one measurement"));
        }
        match self.groups.iter().find(|group| group.nodes.is_empty()) {
            Some(group) => Err(Error::input(format!("--group {}: no node in it", group.name))),
            None if self.groups.is_empty() => Err(Error::input("--group: give at least one")),
            None => Ok(()),
        }
    }

    /// Values of every node before the fit.
    pub(crate) fn base(&self, value: &PerCell) -> Vec<f64> {
        match value {
            PerCell::Uniform(value) => vec![*value; self.mesh.nodes_m.len()],
            PerCell::Each(values) => values.clone(),
        }
    }
}

/// Diagonal of the bounding box \[m\].
fn size(mesh: &Mesh) -> f64 {
    let extent = |axis: usize| {
        let along = mesh.nodes_m.iter().map(|p| p[axis]);
        along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
    };
    (0..3).map(|axis| extent(axis).powi(2)).sum::<f64>().sqrt()
}

/// Materials from NAME=SELECTOR each; all nodes as one where none is named.
///
/// # Errors
/// A text without name, a name given twice, a selector that fails, a node in two groups.
pub fn groups(texts: &[String], mesh: &Mesh) -> Result<Vec<Group>> {
    if texts.is_empty() {
        let nodes = (0..mesh.nodes_m.len() as u32).collect();
        return Ok(vec![Group { name: "all".to_owned(), nodes }]);
    }
    let mut owner: Vec<Option<usize>> = vec![None; mesh.nodes_m.len()];
    let mut groups: Vec<Group> = Vec::new();
    for text in texts {
        let (name, selector) = text.split_once('=').unwrap_or(("", text));
        let name = name.trim();
        if name.is_empty() || name.contains(',') {
            return Err(Error::input(format!(
                "--group {text}: give NAME=SELECTOR, such as tumour=group:tumour"
            )));
        }
        if groups.iter().any(|group| group.name == name) {
            return Err(Error::input(format!("--group {name}: given twice; give each once")));
        }
        let nodes = mesh::select(selector, &mesh.nodes_m, &mesh.groups, &mesh.border, "--group")?;
        for &node in &nodes {
            if let Some(other) = owner[node as usize].replace(groups.len()) {
                return Err(Error::input(format!(
                    "--group {name}: node {node} is in {} already; a node has one material",
                    groups[other].name
                )));
            }
        }
        groups.push(Group { name: name.to_owned(), nodes });
    }
    Ok(groups)
}

#[cfg(test)]
mod tests;
