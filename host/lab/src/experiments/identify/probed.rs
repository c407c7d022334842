//! Recovery of Young's modulus, stiffening and thickness of a slab from what a probe feels on it.

use chaincell_host::bake::tissue::Tissue;

use super::*;

/// A slab under a sphere of 4 mm.
struct Probed {
    slab: Slab,
    mesh: Mesh,
    options: BakeOptions,
    groups: Vec<Group>,
}

/// One band, where the fit begins.
const BAND: Band = Band::new(0.05, 4000.0);

impl Probed {
    fn new() -> Self {
        let slab = Slab::parse("slab:0.024x0.008x0.002").unwrap().unwrap();
        let mesh = slab.mesh().unwrap();
        let tissue = Tissue::new(PerCell::Uniform(2000.0), PerCell::Uniform(0.45));
        let tissue = Some(Tissue { stiffening: vec![BAND], ..tissue });
        let options = BakeOptions { tissue, ..BakeOptions::default() };
        let groups = groups(&[], &mesh).unwrap();
        Self { slab, mesh, options, groups }
    }

    fn bench<'a>(&'a self, targets: &'a [Target], wanted: Wanted) -> Bench<'a> {
        Bench {
            mesh: &self.mesh,
            fixed: &self.mesh.default_fixed,
            options: &self.options,
            groups: &self.groups,
            tool: Tool::Probe { radius_m: 0.004, at_m: [0.0; 3] },
            direction: [0.0, 0.0, -1.0],
            targets,
            slab: Some(self.slab),
            wanted,
        }
    }

    /// What the probe feels down to 2 mm on a slab of these parameters, without noise.
    fn measured(&self, truth: &Parameters) -> Target {
        let displacement_m: Vec<f64> = (1..=5).map(|at| 4e-4 * f64::from(at)).collect();
        let force_n = vec![0.0; displacement_m.len()];
        let empty = [Target::press("probe", displacement_m, force_n)];
        let wanted = Wanted { thickness: true, ..Wanted::default() };
        let exact = forward::predict(&self.bench(&empty, wanted), truth).unwrap();
        noisy::noisy(empty.to_vec(), exact, 0.0, 1).unwrap().remove(0)
    }
}

/// A slab of 8 mm.
fn truth(young_pa: f64, modulus_pa: f64) -> Parameters {
    Parameters {
        young_pa: vec![young_pa],
        stiffening: vec![Band { modulus_pa, ..BAND }],
        thickness_m: 0.008,
        ..Parameters::default()
    }
}

#[track_caller]
fn near(found: f64, truth: f64, part: f64) {
    assert!((found / truth - 1.0).abs() < part, "{found} is not {truth}");
}

#[test]
fn a_probe_gives_back_youngs_modulus_and_stiffening() {
    let body = Probed::new();
    let target = body.measured(&truth(900.0, 12_000.0));
    let wanted = Wanted { stiffening: true, ..Wanted::default() };
    let targets = [target];
    let found = identify(&body.bench(&targets, wanted), &Bounds::default(), 0.0).unwrap();
    let [young, band] = found.estimates.as_slice() else { panic!("{found:#?}") };
    assert_eq!((young.name(), band.name()), ("young_pa of all".into(), "stiffening_pa".into()));
    near(young.value, 900.0, 0.02);
    near(band.value, 12_000.0, 0.02);
    assert!(young.determined && band.determined, "{found:#?}");
}

/// The force of a thin slab is larger, so a known modulus gives its thickness.
#[test]
fn a_thinner_slab_is_stiffer_under_the_probe() {
    let body = Probed::new();
    let force_n = |thickness_m: f64| {
        let slab = Parameters { thickness_m, ..truth(1000.0, 4000.0) };
        body.measured(&slab).observed[4]
    };
    assert!(force_n(0.004) > 1.2 * force_n(0.008));
}

/// A probe that touched before its displacement was 0 feels what it feels that much deeper.
#[test]
fn an_offset_shifts_the_curve() {
    let body = Probed::new();
    let force_n = |offset_m: f64| {
        let parameters = Parameters { offset_m, ..truth(1000.0, 4000.0) };
        body.measured(&parameters).observed
    };
    let (before, after) = (force_n(0.0), force_n(4e-4));
    for row in 0..4 {
        near(after[row], before[row + 1], 0.01);
    }
}

/// Rows that are known less well weigh less.
#[test]
fn quartiles_weigh_the_rows() {
    let body = Probed::new();
    let mut target = body.measured(&truth(900.0, 4000.0));
    target.observed[4] *= 2.0;
    let found = |wide: f64| {
        let quartiles = (0..5).map(|row| if row == 4 { [0.0, wide] } else { [0.0, 0.001] });
        let targets = [target.clone().with_quartiles(quartiles)];
        let bench = body.bench(&targets, Wanted::default());
        identify(&bench, &Bounds::default(), 0.0).unwrap().estimates[0].value
    };
    near(found(1.0), 900.0, 0.02);
    assert!(found(0.001) > 1000.0);
}

#[test]
fn nothing_of_time_is_looked_for_on_nodal_shapes_and_under_a_probe() {
    let body = Probed::new();
    let targets = [Target::relaxation("relax.csv", 0.001, vec![0.0, 1.0], vec![1.0, 0.5])];
    let bench = body.bench(&targets, Wanted::default());
    let refused = |bench: &Bench<'_>, part: &str| {
        let error = check(bench, &Bounds::default(), 0.0).unwrap_err();
        assert!(error.exit_code() == 2 && error.to_string().contains(part), "{error}");
    };
    refused(&bench, "relax.csv: nodal shapes have no time constant");
    let links = BakeOptions::default();
    refused(&Bench { options: &links, ..bench }, "relax.csv: a probe has no relaxation in time");
}
