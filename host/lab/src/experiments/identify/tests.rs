//! Recovery of known parameters from curves that the engine itself made, with noise.

use chaincell_kernel::Model;

use super::noisy::noisy;
use super::*;
use chaincell_host::mesh::MeshOptions;

/// A small block pulled at the middle of its top.
struct Block {
    mesh: Mesh,
    options: BakeOptions,
    groups: Vec<Group>,
    contacts: Vec<u16>,
}

impl Block {
    fn new(groups: &[&str]) -> Self {
        let mesh = mesh::load("box:6x6x4x0.01", &MeshOptions::default()).unwrap();
        let options = BakeOptions::default();
        let image = chaincell_host::bake::bake(&mesh, &mesh.default_fixed, &options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        let middle = "box:-0.011,0.011,-0.011,0.011,0.029,0.031";
        let contacts = chaincell_host::engine::contact::contact_cells(middle, &model).unwrap();
        let texts: Vec<String> = groups.iter().map(ToString::to_string).collect();
        let groups = super::groups(&texts, &mesh).unwrap();
        Self { mesh, options, groups, contacts }
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

    /// The targets with what the engine says of `truth`, and noise of `part` of their size.
    fn measured(&self, targets: Vec<Target>, truth: &Parameters, part: f64) -> Vec<Target> {
        let exact = forward::predict(&self.bench(&targets), truth).unwrap();
        noisy(targets, exact, part, 7).unwrap()
    }
}

fn curve() -> Target {
    let displacement_m: Vec<f64> = (1..=30).map(|at| 4e-4 * f64::from(at)).collect();
    let force_n = vec![0.0; displacement_m.len()];
    Target::press("curve", displacement_m, force_n)
}

fn relaxation() -> Target {
    let time_s: Vec<f64> = (0..400).map(|at| 0.002 * f64::from(at)).collect();
    let force_n = vec![0.0; time_s.len()];
    Target::relaxation("relaxation", 0.01, time_s, force_n)
}

fn field(block: &Block) -> Target {
    let nodes: Vec<u32> = (0..block.mesh.nodes_m.len() as u32).collect();
    let observed_m = vec![0.0; 3 * nodes.len()];
    Target::field("field", 0.01, nodes, observed_m)
}

fn truth(stiffness_n_per_m: &[f64], alpha: &[f64]) -> Parameters {
    Parameters {
        stiffness_n_per_m: stiffness_n_per_m.to_vec(),
        alpha: alpha.to_vec(),
        time_constant_s: 0.05,
        ..Parameters::default()
    }
}

#[track_caller]
fn near(found: f64, truth: f64, part: f64) {
    assert!((found / truth - 1.0).abs() < part, "{found} is not {truth}");
}

/// The upper half of the block and the lower one.
const HALVES: [&str; 2] = ["top=box:-1,1,-1,1,0.015,1", "bottom=box:-1,1,-1,1,-1,0.015"];

#[test]
fn stiffness_alpha_and_time_come_back_from_noisy_curves() {
    let block = Block::new(&[]);
    let truth = truth(&[35.0], &[0.06]);
    let targets = block.measured(vec![curve(), relaxation()], &truth, 0.03);
    let found = identify(&block.bench(&targets), &Bounds::default(), 0.2).unwrap();
    let [k, alpha, time] = found.estimates.as_slice() else { panic!("{found:#?}") };
    near(k.value, 35.0, 0.05);
    near(alpha.value, 0.06, 0.05);
    near(time.value, 0.05, 0.05);
    for estimate in &found.estimates {
        assert!(estimate.determined && estimate.half_width_percent.unwrap() < 5.0, "{estimate:?}");
        assert!(estimate.interval[0] < estimate.value && estimate.value < estimate.interval[1]);
    }
    assert!(found.undetermined.is_empty(), "{:?}", found.undetermined);
    for target in &found.targets {
        let part = |rms: f64| rms / target.rms_measured;
        assert!((0.01..0.05).contains(&part(target.rms_residual)), "{target:?}");
        assert!((0.01..0.06).contains(&part(target.rms_residual_held_out.unwrap())), "{target:?}");
        assert!(target.rows_held_out * 4 == target.rows);
    }
}

#[test]
fn a_field_alone_gives_only_ratios() {
    let block = Block::new(&HALVES);
    let targets = block.measured(vec![field(&block)], &truth(&[20.0, 60.0], &[0.0, 0.0]), 0.01);
    let bounds = Bounds::default().with("alpha", [0.0, 0.05]).unwrap();
    let found = identify(&block.bench(&targets), &bounds, 0.2).unwrap();
    assert!(!found.estimates[0].determined && !found.estimates[1].determined, "{found:#?}");
    assert!(found.undetermined.iter().any(|said| said.contains("only the ratios")), "{found:#?}");
    near(found.estimates[1].value / found.estimates[0].value, 3.0, 0.05);
}

/// A corner of the bottom layer, whose neighbours are fixed: the tool does not reach it.
#[test]
fn a_material_that_nothing_loads_is_said_to_be_open() {
    let block = Block::new(&["rest=box:-1,1,-1,1,0.005,1", "base=box:-1,1,-1,1,-1,0.005"]);
    let group = block.mesh.default_fixed.clone();
    assert_eq!(block.groups[1].nodes, group);
    let far = vec![
        Group { name: "rest".into(), nodes: (4..block.mesh.nodes_m.len() as u32).collect() },
        Group { name: "corner".into(), nodes: vec![0] },
    ];
    let block = Block { groups: far, ..block };
    let targets = block.measured(vec![curve()], &truth(&[30.0, 30.0], &[0.05, 0.05]), 0.01);
    let found = identify(&block.bench(&targets), &Bounds::default(), 0.2).unwrap();
    near(found.estimates[0].value, 30.0, 0.05);
    assert!(found.estimates[0].determined && found.estimates[2].determined, "{found:#?}");
    assert!(!found.estimates[1].determined && !found.estimates[3].determined, "{found:#?}");
    assert!(found.undetermined.iter().any(|said| said.contains("of corner")), "{found:#?}");
}

#[test]
fn what_cannot_be_met_is_refused() {
    let block = Block::new(&[]);
    let refused = |target: Target, part: &str| {
        let targets = [target];
        let error = identify(&block.bench(&targets), &Bounds::default(), 0.2).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    };
    let few = Target::press("few", vec![0.001, 0.002], vec![1.0, 2.0]);
    refused(few, "2 numbers to fit 2 parameters");
    let mut none = field(&block);
    none.nodes[0] = 9999;
    refused(none, "node 9999 is none of the body's");
}
