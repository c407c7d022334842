//! Material parameters identified: a body of two materials, curves with noise, what comes back.

use chaincell_kernel::Model;
use serde_json::json;

use crate::charts::plot::Figure;
use crate::experiments::identify::noisy::noisy;
use crate::experiments::identify::target::Target;
use crate::experiments::identify::tool::Tool;
use crate::experiments::identify::uncertainty::Estimate;
use crate::experiments::identify::{
    Bench, Bounds, Group, Identified, Parameters, Wanted, forward, identify, write,
};
use crate::experiments::page::table::{Table, percent};
use crate::experiments::page::{Context, Numbers, Section};
use crate::reference::vectors::{minus, norm};
use chaincell_host::bake::{BakeOptions, bake};
use chaincell_host::engine::contact::contact_cells;
use chaincell_host::error::{Error, Result};
use chaincell_host::mesh::{self, Mesh, MeshOptions};

/// Noise of every measured number, in parts of the root mean square of its curve.
const NOISE: f64 = 0.03;
/// Seed of the noise.
const SEED: u64 = 2017;
/// Part of the rows that is held out.
const HOLD_OUT: f64 = 0.2;
/// Stiffness of the soft tissue and of the inclusion [N/m].
const STIFFNESS_N_PER_M: [f64; 2] = [20.0, 100.0];
/// Alpha of both.
const ALPHA: [f64; 2] = [0.05, 0.02];
/// Time constant of the body \[s\].
const TIME_CONSTANT_S: f64 = 0.05;
/// Middle of the stiff inclusion, below the contact, and its radius \[m\].
const INCLUSION_M: ([f64; 3], f64) = ([0.0, 0.0, 0.02], 0.0145);
/// Largest displacement of the curves \[m\].
const DEPTH_M: f64 = 0.012;
/// Cells under the tool, a suction cup on the middle of the top.
const CONTACT: &str = "box:-0.011,0.011,-0.011,0.011,0.039,0.041";

/// The organ: a block of soft tissue with a stiff inclusion.
struct Organ {
    mesh: Mesh,
    options: BakeOptions,
    groups: Vec<Group>,
    contacts: Vec<u16>,
}

impl Organ {
    fn new(quick: bool) -> Result<Self> {
        let spec = if quick { "box:5x5x5x0.01" } else { "box:7x7x5x0.01" };
        let mesh = mesh::load(spec, &MeshOptions::default())?;
        let (middle, radius_m) = INCLUSION_M;
        let inside = |p: &[f64; 3]| norm(minus(*p, middle)) < radius_m;
        let ids = 0..mesh.nodes_m.len() as u32;
        let (stiff, soft) = ids.partition(|&id| inside(&mesh.nodes_m[id as usize]));
        let group = |name: &str, nodes| Group { name: name.to_owned(), nodes };
        let groups = vec![group("soft", soft), group("inclusion", stiff)];
        let options = BakeOptions::default();
        let image = bake(&mesh, &mesh.default_fixed, &options)?;
        let model = Model::from_bytes(image.as_bytes()).map_err(Error::check)?;
        let contacts = contact_cells(CONTACT, &model)?;
        Ok(Self { mesh, options, groups, contacts })
    }

    fn bench<'a>(&'a self, targets: &'a [Target]) -> Bench<'a> {
        Bench {
            mesh: &self.mesh,
            fixed: &self.mesh.default_fixed,
            options: &self.options,
            groups: &self.groups,
            tool: Tool::Held(&self.contacts),
            direction: [0.0, 0.0, 1.0],
            targets,
            slab: None,
            wanted: Wanted::default(),
        }
    }

    /// What the engine gives for the truth, with noise.
    fn measured(&self, targets: Vec<Target>, truth: &Parameters) -> Result<Vec<Target>> {
        let exact = forward::predict(&self.bench(&targets), truth)?;
        noisy(targets, exact, NOISE, SEED)
    }

    /// A curve, a relaxation, and the displacements of all nodes, still without numbers.
    fn targets(&self) -> Vec<Target> {
        let displacement_m: Vec<f64> = (1..=25).map(|at| DEPTH_M * f64::from(at) / 25.0).collect();
        let time_s: Vec<f64> = (0..400).map(|at| 0.002 * f64::from(at)).collect();
        let nodes: Vec<u32> = (0..self.mesh.nodes_m.len() as u32).collect();
        let (few, many) = (vec![0.0; displacement_m.len()], vec![0.0; time_s.len()]);
        let field_m = vec![0.0; 3 * nodes.len()];
        vec![
            Target::press("pull", displacement_m, few),
            Target::relaxation("relaxation", DEPTH_M, time_s, many),
            Target::field("field", DEPTH_M, nodes, field_m),
        ]
    }
}

/// Identifies the two materials from the curves alone, and with the field.
pub fn section(context: &Context) -> Result<Section> {
    let organ = Organ::new(context.quick)?;
    let truth = Parameters {
        stiffness_n_per_m: STIFFNESS_N_PER_M.to_vec(),
        alpha: ALPHA.to_vec(),
        time_constant_s: TIME_CONSTANT_S,
        ..Parameters::default()
    };
    let targets = organ.measured(organ.targets(), &truth)?;
    let curves = identify(&organ.bench(&targets[..2]), &Bounds::default(), HOLD_OUT)?;
    let all = identify(&organ.bench(&targets), &Bounds::default(), HOLD_OUT)?;
    let mut figures = Vec::new();
    for drawn in write::charts(&targets, &all)? {
        let name = format!("paper_identified_{}", drawn.name);
        figures.push(Figure { name, ..drawn });
    }
    let numbers = vec![Numbers {
        name: "paper_identified_residuals".to_owned(),
        csv: write::residuals_csv(&targets, &all),
    }];
    let caption = |what: &str, found: &Identified| {
        format!("From {what}: {} evaluations in {:.1} s.", found.evaluations, found.seconds)
    };
    Ok(Section {
        key: "identified",
        title: "Material parameters identified".to_owned(),
        results: vec![(
            "Left open: the material parameters",
            format!(
                "Two materials, slack and time from curves and a field with {} % of noise, on a body of \
                 {} cells: within {:.1} % where they are determined. From curves alone {} of the \
                 parameters are not determined, and the fit says so.",
                100.0 * NOISE,
                organ.mesh.nodes_m.len(),
                100.0 * largest_error(&all, &truth),
                curves.estimates.iter().filter(|found| !found.determined).count()
            ),
        )],
        text: text(&organ, &curves, &all),
        figures,
        tables: vec![
            (caption("a force and a relaxation curve", &curves), table(&curves, &truth)),
            (caption("both curves and the field of displacements", &all), table(&all, &truth)),
        ],
        numbers,
        json: json!({
            "cells": organ.mesh.nodes_m.len(),
            "noise_percent": 100.0 * NOISE,
            "curves": rows(&curves, &truth),
            "curves_and_field": rows(&all, &truth),
        }),
    })
}

/// Every estimate with the true value beside it.
fn with_truth<'a>(found: &'a Identified, truth: &Parameters) -> Vec<(&'a Estimate, f64)> {
    let values = truth.stiffness_n_per_m.iter().chain(&truth.alpha).chain([&truth.time_constant_s]);
    found.estimates.iter().zip(values.copied()).collect()
}

fn largest_error(found: &Identified, truth: &Parameters) -> f64 {
    let determined = with_truth(found, truth).into_iter().filter(|(found, _)| found.determined);
    determined.map(|(found, truth)| (found.value / truth - 1.0).abs()).fold(0.0, f64::max)
}

fn rows(found: &Identified, truth: &Parameters) -> Vec<serde_json::Value> {
    let each = with_truth(found, truth).into_iter();
    each.map(|(found, truth)| {
        json!({
            "parameter": found.parameter,
            "group": found.group,
            "true": truth,
            "found": found.value,
            "error_percent": 100.0 * (found.value / truth - 1.0),
            "interval": found.interval,
            "determined": found.determined,
        })
    })
    .collect()
}

fn table(found: &Identified, truth: &Parameters) -> Table {
    Table::of(&with_truth(found, truth))
        .column("parameter", |(found, _)| found.name())
        .column("true", |(_, truth)| truth)
        .column("identified", |(found, _)| format!("{:.4}", found.value))
        .column("error [%]", |(found, truth)| percent(found.value / truth - 1.0))
        .column("95 % interval", |(found, _)| {
            let [low, high] = found.interval;
            format!("{low:.4} to {high:.4}")
        })
        .column("determined", |(found, _)| if found.determined { "yes" } else { "no" })
        .table()
}

fn text(organ: &Organ, curves: &Identified, all: &Identified) -> Vec<String> {
    let open = |found: &Identified| match found.undetermined.as_slice() {
        [] => "every parameter is determined".to_owned(),
        said => said.join("; "),
    };
    vec![
        format!(
            "The paper leaves the identification of material parameters to future work. Here a \
             body of {} cells, soft tissue around a stiff inclusion, is pulled at its top by {} mm; \
             force, relaxation and displacements carry {} % noise. `chaincell identify` finds the \
             stiffness and the slack of both materials and the time constant by least squares over \
             the engine itself. A fifth of the rows is held out.",
            organ.mesh.nodes_m.len(),
            1e3 * DEPTH_M,
            100.0 * NOISE
        ),
        format!("From the two curves alone: {}.", open(curves)),
        format!("With the field of displacements: {}.", open(all)),
        "The intervals are linearised: those of parameters that are not determined are only wide."
            .to_owned(),
        "Truth and fit come from the same forward problem, so this shows what noise does, not how \
         well the model describes tissue."
            .to_owned(),
    ]
}
