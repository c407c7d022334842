//! Material parameters from measurements: stiffness and slack of each group of nodes and the
//! body's time constant, or Young's modulus and stiffening of nodal shapes, fitted to
//! force-displacement curves, relaxation curves and displacement fields.
//!
//! A target is a CSV file; its header says what it is:
//!
//! | header | what was measured |
//! |---|---|
//! | `displacement_m,force_n` | equilibrium forces of a growing press |
//! | `displacement_m,force_n,q25_n,q75_n` | the same with the quartiles of what was measured again and again: they are the error of each row |
//! | `time_s,force_n` | the force after a step of `--displacement-m`: the only one that shows the time constant |
//! | `time_s,displacement_m,force_n` | the force along a path of the tool in time, such as a ramp and a hold |
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
//! comes from the singular values of the Jacobian at the end ([`uncertainty`]). Links have no volume
//! term, and Poisson's ratio of nodal shapes is held ([`unknown`]). The tool holds cells, or is a
//! sphere or the edge of a blade ([`tool`]); a body may be a slab whose thickness is unknown ([`slab`]).

pub mod fit;
pub mod forward;
pub mod noisy;
mod problem;
pub mod slab;
mod start;
pub mod target;
pub mod tool;
pub mod uncertainty;
pub mod unknown;
pub mod write;

use std::borrow::Cow;

use chaincell_host::bake::tissue::Band;
use chaincell_host::bake::{BakeOptions, Cuttable, PerCell};
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{self, Mesh};
use slab::Slab;
use target::{Kind, Target};
use tool::Tool;

pub use fit::{Identified, check, identify};
pub use unknown::{Bounds, Wanted};

/// Nodes of one material.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Group {
    /// Name for tables.
    pub name: String,
    /// Input ids, ascending.
    pub nodes: Vec<u32>,
}

/// What is looked for; what a body does not have stays empty.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Parameters {
    /// Stiffness of a link of each group [N/m].
    pub stiffness_n_per_m: Vec<f64>,
    /// Half-width of the band of each group's links \[rest lengths\].
    pub alpha: Vec<f64>,
    /// Time constant of the whole body \[s\]: its cells share one capacitance.
    pub time_constant_s: f64,
    /// Young's modulus of each group \[Pa\].
    pub young_pa: Vec<f64>,
    /// Stiffening bands of the whole body.
    pub stiffening: Vec<Band>,
    /// Thickness of the slab \[m\].
    pub thickness_m: f64,
    /// Displacement of the tool from where it meets the surface to its 0 \[m\].
    pub offset_m: f64,
    /// Energy that a cut takes for each area \[J/m^2\].
    pub toughness_j_per_m2: f64,
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
    /// What touches the body.
    pub tool: Tool<'a>,
    /// Direction of the push, a unit vector; a target may have its own.
    pub direction: [f64; 3],
    /// What was measured.
    pub targets: &'a [Target],
    /// The slab that `mesh` is, where it is one.
    pub slab: Option<Slab>,
    /// What else is looked for on nodal shapes.
    pub wanted: Wanted,
}

impl Bench<'_> {
    /// Whether a time constant can be seen in the data.
    pub fn has_time(&self) -> bool {
        self.targets.iter().any(|target| target.is_in_time())
    }

    /// All parameters as they are before the fit.
    pub fn start(&self) -> Parameters {
        let groups = self.groups.len();
        let thickness_m = self.slab.map_or(0.0, |slab| slab.thickness_m);
        let Some(tissue) = &self.options.tissue else {
            let stiffness_n_per_m = vec![mean(&self.options.stiffness_n_per_m); groups];
            let alpha = vec![0.0; groups];
            return Parameters {
                stiffness_n_per_m,
                alpha,
                time_constant_s: 1.0,
                ..Parameters::default()
            };
        };
        let young_pa = vec![mean(&tissue.young_pa); groups];
        let stiffening = tissue.stiffening.clone();
        let toughness_j_per_m2 =
            self.options.cuttable.as_ref().map_or(0.0, |cut| mean(&cut.toughness_j_per_m2));
        Parameters {
            young_pa,
            stiffening,
            thickness_m,
            toughness_j_per_m2,
            ..Parameters::default()
        }
    }

    /// The mesh at the thickness of the parameters.
    pub(crate) fn mesh_of(&self, parameters: &Parameters) -> Cow<'_, Mesh> {
        match self.slab {
            Some(slab) if self.wanted.thickness => {
                Cow::Owned(slab.at_thickness(self.mesh, parameters.thickness_m))
            }
            _ => Cow::Borrowed(self.mesh),
        }
    }

    /// Refuses what no parameter could explain.
    pub fn check(&self) -> Result<()> {
        if self.options.tissue.as_ref().is_some_and(|tissue| tissue.relaxation.is_some()) {
            return Err(Error::input(
                "--branch: presses are fitted in equilibrium, where branches have relaxed; leave them out (--branch \
                 none with --tissue), and find them with `chaincell relaxation`",
            ));
        }
        let size_m = size(self.mesh);
        for target in self.targets {
            let (name, depth_m) = (&target.name, target.depth_m());
            if depth_m > size_m {
                return Err(Error::input(format!(
                    "{name}: a displacement of {depth_m} m is beyond the body's size of \
                     {size_m:.4} m; displacements are in metres, and see --units"
                )));
            }
            if target.is_in_time() && self.options.tissue.is_some() {
                return Err(Error::input(format!(
                    "{name}: nodal shapes have no time constant; give equilibrium forces, find branches with \
                     `chaincell relaxation`, or leave --young-pa out"
                )));
            }
            if target.is_in_time() && !matches!(self.tool, Tool::Held(_)) {
                return Err(Error::input(format!(
                    "{name}: a probe has no relaxation in time; give equilibrium forces, or hold \
                     cells: --contact cells:SELECTOR"
                )));
            }
            let last = self.mesh.nodes_m.len() as u32;
            let is_none = |node: &&u32| **node >= last || self.mesh.unused.contains(node);
            if let Some(node) = target.nodes.iter().find(is_none) {
                return Err(Error::input(format!("{name}: node {node} is none of the body's")));
            }
        }
        self.check_wanted()?;
        if self.targets.is_empty() {
            return Err(Error::input("--target: give at least one measurement"));
        }
        match self.groups.iter().find(|group| group.nodes.is_empty()) {
            Some(group) => Err(Error::input(format!("--group {}: no node in it", group.name))),
            None if self.groups.is_empty() => Err(Error::input("--group: give at least one")),
            None => Ok(()),
        }
    }

    /// What is looked for must be there.
    fn check_wanted(&self) -> Result<()> {
        let Wanted { stiffening, half_width, thickness, offset, toughness } = self.wanted;
        let tissue = self.options.tissue.as_ref();
        let bands = tissue.map_or(0, |tissue| tissue.stiffening.len());
        let cuttable = self.options.cuttable.as_ref();
        let is_one =
            |cuttable: &Cuttable| matches!(cuttable.toughness_j_per_m2, PerCell::Uniform(_));
        let is_field = |target: &Target| target.kind == Kind::Field;
        let why = if self.wanted != Wanted::default() && tissue.is_none() {
            "all that it names is looked for on nodal shapes: add --young-pa"
        } else if offset && matches!(self.tool, Tool::Held(_)) {
            "offset is where a probe met the surface: give --contact probe:RADIUS"
        } else if toughness && !matches!(self.tool, Tool::Blade(..)) {
            "toughness is what a blade feels: give --contact blade:LENGTH"
        } else if toughness && !cuttable.is_none_or(is_one) {
            "toughness is looked for as one value of the whole body: give one --toughness-j-per-m2 and none to \
             --material, or fit the press into each part by itself"
        } else if (stiffening || half_width) && bands == 0 {
            "there is no band; say where to begin, as --stiffening 0.1=5000"
        } else if thickness && self.slab.is_none() {
            "thickness is that of a generated slab; give slab:WIDTHxTHICKNESSxD in place of the mesh"
        } else if thickness && self.targets.iter().any(is_field) {
            "thickness moves the nodes that a field names; leave one out"
        } else {
            return Ok(());
        };
        Err(Error::input(format!("--fit: {why}")))
    }

    /// Values of every node before the fit.
    pub(crate) fn base(&self, value: &PerCell) -> Vec<f64> {
        match value {
            PerCell::Uniform(value) => vec![*value; self.mesh.nodes_m.len()],
            PerCell::Each(values) => values.clone(),
        }
    }
}

/// Mean over the nodes.
fn mean(value: &PerCell) -> f64 {
    match value {
        PerCell::Uniform(value) => *value,
        PerCell::Each(values) => values.iter().sum::<f64>() / values.len().max(1) as f64,
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
mod probed;
#[cfg(test)]
mod tests;
