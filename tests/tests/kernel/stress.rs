//! Strain and stress of the tissue at a cell, beside formulas and beside the force that makes them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_client::stress::NodeStress;
use chaincell_host::bake::tissue::{Band, Branch, DEVICE_HZ, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme, rest_m};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::{
    Drive, Model, Network, Predict, Settings, Stress, ToolPart, ToolPose, Unloading,
};
use chaincell_tests::bodies::{baked, model, nodal, under};
use chaincell_tests::graph::sample;
use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::bench::Bench;
use crate::cutting;

const YOUNG_PA: f64 = 5000.0;

fn matrix(rows: [[f32; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|row, column| rows[row][column].into())
}

/// The stretches of the shape of unit volume nearest to one with these: q = f + p / q, their product 1.
fn of_unit_volume(stretches: Vector3<f64>) -> Vector3<f64> {
    let (mut low, mut high) = (-0.2, 1.0);
    let at = |p: f64| stretches.map(|f| 0.5 * (f + (f * f + 4.0 * p).sqrt()));
    for _ in 0..60 {
        let p = 0.5 * (low + high);
        if at(p).product() > 1.0 { high = p } else { low = p }
    }
    at(low)
}

/// The Cauchy stress of a body with these principal stretches \[Pa\]: of E = mu |F - R|^2 + 3 lambda / 2 |F - Q|^2.
fn cauchy_pa(stretches: Vector3<f64>) -> Vector3<f64> {
    let poisson = 0.45;
    let mu = YOUNG_PA / (2.0 * (1.0 + poisson));
    let lambda = 2.0 * mu * poisson / (1.0 - 2.0 * poisson);
    let unit = of_unit_volume(stretches);
    let first = (stretches.add_scalar(-1.0) * 2.0 * mu) + (stretches - unit) * 3.0 * lambda;
    first.component_mul(&stretches) / stretches.product()
}

/// Every cell of a body that is stretched and turned as a whole, at its faces too.
#[test]
fn a_uniform_stretch_has_its_stress_in_every_cell() {
    let image = nodal("box:4x3x4x0.01", YOUNG_PA);
    let model = model(&image);
    let mut engine = under(&image, Contact::Cells(vec![]), (Scheme::Predict, 1), 1.0).unwrap();
    for (stretches, angle) in [([0.97, 1.02, 1.1], 0.7), ([0.8, 0.9, 0.85], -1.2)] {
        let (stretches, turn) =
            (Vector3::from(stretches), Rotation3::from_euler_angles(0.3, angle, 0.2));
        let f = turn.matrix() * Matrix3::from_diagonal(&stretches);
        let place = |cell: usize| {
            let rest = Vector3::from(model.rest_position(cell).map(f64::from));
            <[f64; 3]>::from(f * rest).map(|x| x as f32)
        };
        let places: Vec<[f32; 3]> = (0..model.cells()).map(place).collect();
        engine.set_positions(&places).unwrap();
        let principal_pa = cauchy_pa(stretches);
        let wanted_pa =
            turn.matrix() * Matrix3::from_diagonal(&principal_pa) * turn.matrix().transpose();
        for cell in 0..model.cells() {
            let found = engine.stress(cell).unwrap();
            assert!((matrix(found.gradient) - f).norm() < 1e-4, "{cell}: {found:?}");
            let off_pa = (matrix(found.cauchy_pa) - wanted_pa).norm();
            assert!(off_pa < 2e-3 * wanted_pa.norm(), "{cell}: {found:?}, not {wanted_pa}");
            let mut sorted = <[f64; 3]>::from(stretches);
            sorted.sort_by(|a, b| b.total_cmp(a));
            let near = found.stretches.iter().zip(sorted);
            assert!(near.clone().all(|(a, b)| (f64::from(*a) - b).abs() < 1e-4), "{found:?}");
            let mean_pa = principal_pa.mean();
            assert!((f64::from(found.mean_pa()) - mean_pa).abs() < 2e-3 * wanted_pa.norm());
        }
    }
    assert_eq!(engine.stress(model.cells()), None, "beyond the last cell");
}

/// Tissue of this Poisson's ratio.
fn tissue(poisson: f64) -> Tissue {
    Tissue::new(PerCell::Uniform(YOUNG_PA), PerCell::Uniform(poisson))
}

fn image(spec: &str, tissue: Tissue) -> ImageBytes {
    baked(spec, &BakeOptions { tissue: Some(tissue), ..BakeOptions::default() })
}

/// Small strain: Hooke's law, whose stress after von Mises and whose mean stress are known.
#[test]
fn small_strain_has_the_stress_of_hookes_law() {
    let strain = 4e-3_f64;
    for poisson in [0.3, 0.45] {
        let image = image("box:4x3x4x0.01", tissue(poisson));
        let model = model(&image);
        let mut engine = under(&image, Contact::Cells(vec![]), (Scheme::Predict, 1), 1.0).unwrap();
        let shear_pa = YOUNG_PA / (2.0 * (1.0 + poisson));
        let bulk_pa = YOUNG_PA / (3.0 * (1.0 - 2.0 * poisson));
        let (mut sheared, across) = (Matrix3::zeros(), -poisson * strain);
        sheared[(0, 2)] = strain;
        let pulled = Matrix3::from_diagonal(&Vector3::new(across, across, strain));
        for (name, slope, mises_pa, mean_pa) in [
            ("pulled", pulled, YOUNG_PA * strain, YOUNG_PA * strain / 3.0),
            ("sheared", sheared, 3.0_f64.sqrt() * shear_pa * strain, 0.0),
            ("swollen", strain * Matrix3::identity(), 0.0, 3.0 * bulk_pa * strain),
        ] {
            let f = Matrix3::identity() + slope;
            let place = |cell: usize| {
                let rest = Vector3::from(model.rest_position(cell).map(f64::from));
                <[f64; 3]>::from(f * rest).map(|x| x as f32)
            };
            let places: Vec<[f32; 3]> = (0..model.cells()).map(place).collect();
            engine.set_positions(&places).unwrap();
            for cell in 0..model.cells() {
                let found = engine.stress(cell).unwrap();
                let off_pa = [
                    f64::from(found.von_mises_pa()) - mises_pa,
                    f64::from(found.mean_pa()) - mean_pa,
                ];
                let of_pa = 0.01 * (mises_pa + mean_pa);
                assert!(
                    off_pa.iter().all(|x| x.abs() < of_pa),
                    "{poisson} {name}: {found:?}, off by {off_pa:?} Pa"
                );
            }
        }
    }
}

/// The cells of a layer of a box with 5 x 5 of them, each with its share of the cross-section.
fn layer(model: &Model<'_>, layer: usize) -> Vec<(usize, f64)> {
    let at_side = |index: usize| if index == 0 || index == 4 { 0.5 } else { 1.0 };
    let of = |node: usize| {
        let cell = model.cell_of_input(node as u32).unwrap();
        (usize::from(cell), at_side(node / 13 / 5) * at_side(node / 13 % 5) / 16.0)
    };
    (0..25).map(|column| of(column * 13 + layer)).collect()
}

/// The force over the middle of a bar by its stress over that at its end, and the mean stress after von Mises over that
/// along it, after a step of so many ticks up or down by `step_m` each.
fn carried(image: &ImageBytes, step_m: f32) -> (f64, f64) {
    let model = model(image);
    let mut end: Vec<u16> = layer(&model, 12).into_iter().map(|(cell, _)| cell as u16).collect();
    end.sort_unstable();
    let contact = Contact::Cells(end);
    let settings = Settings {
        sweeps: 8,
        max_force_n: 1.0e3,
        max_tool_step_m: 1.0e-4,
        unloading: Unloading::Off,
        ..Settings::for_model(&model)
    };
    let network = Network::new(model, settings).unwrap();
    let mut engine =
        Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact).unwrap();
    let mut force_n = Vector3::zeros();
    for tick in 0..600_u16 {
        let output = engine.tick(&sample([0.0, 0.0, step_m * f32::from(tick.min(150))], 1));
        force_n = Vector3::from(<[f32; 3]>::from(output.force_n).map(f64::from));
    }
    let mean = |engine: &mut Engine<'_>, of: fn(&Stress) -> f32| -> f64 {
        let cells = layer(&model, 6).into_iter();
        cells.map(|(cell, share)| share * f64::from(of(&engine.stress(cell).unwrap()))).sum()
    };
    let across = mean(&mut engine, |stress| stress.gradient[0][0] * stress.gradient[1][1]);
    let along_pa = mean(&mut engine, |stress| stress.cauchy_pa[2][2]);
    let mises_pa = mean(&mut engine, Stress::von_mises_pa);
    // The hand feels the force of the tissue, which pulls back.
    (along_pa * 0.02 * 0.02 * across / -force_n.z, mises_pa / along_pa.abs())
}

/// A bar pulled and pressed by its end: the stress over its middle carries the force, with stiffening and while it
/// relaxes too. A slender bar is free to grow and shrink across: its stress is along it alone.
#[test]
fn the_stress_over_a_bar_carries_the_force_at_its_end() {
    let stiffening = vec![Band::new(0.02, 2.0e4)];
    let relaxation = Some(Relaxation {
        branches: vec![Branch { ratio: 2.0, time_s: 0.5 }],
        is_instant: false,
        device_hz: DEVICE_HZ,
    });
    for (name, tissue) in [
        ("nu 0.3", tissue(0.3)),
        ("nu 0.45", tissue(0.45)),
        ("stiffening", Tissue { stiffening, ..tissue(0.3) }),
        ("relaxing", Tissue { relaxation, ..tissue(0.3) }),
    ] {
        let image = image("box:5x5x13x0.005", tissue);
        for step_m in [2e-5, -2e-5] {
            let (force, mises) = carried(&image, step_m);
            println!("{name}, {step_m}: force {force:.4}, von Mises {mises:.4}");
            assert!((force - 1.0).abs() < 0.01, "{name}, {step_m}: {force} of the force");
            assert!((mises - 1.0).abs() < 0.01, "{name}, {step_m}: {mises} of the stress along it");
        }
    }
}

/// Stress \[Pa\] at a place below and beside a force of 1 N down on the face z = 0 of half of space (J. Boussinesq
/// 1885).
fn of_a_point_load(poisson: f64, place: Vector3<f64>) -> Matrix3<f64> {
    let (depth, away) = (-place.z, place.xy().norm());
    let far = place.norm();
    let (even, lateral) = (1.0 / (2.0 * std::f64::consts::PI * far * far), 1.0 - 2.0 * poisson);
    let down = -3.0 * depth.powi(3) / far.powi(3);
    let out = -3.0 * away * away * depth / far.powi(3) + lateral * far / (far + depth);
    let around = lateral * (depth / far - far / (far + depth));
    let shear = 3.0 * away * depth * depth / far.powi(3);
    // Axes out, around and up.
    let outward =
        if away > 0.0 { Vector3::new(place.x / away, place.y / away, 0.0) } else { Vector3::x() };
    let turn = Matrix3::from_columns(&[outward, Vector3::z().cross(&outward), Vector3::z()]);
    let local = Matrix3::new(out, 0.0, shear, 0.0, around, 0.0, shear, 0.0, down);
    even * turn * local * turn.transpose()
}

fn von_mises(stress: Matrix3<f64>) -> f64 {
    let deviator = stress - Matrix3::identity() * (stress.trace() / 3.0);
    (1.5 * deviator.norm_squared()).sqrt()
}

/// Edge of the box's cubes \[m\], and the pressure on a square of 5 x 5 nodes of its upper face \[Pa\].
const EDGE_M: f64 = 0.002;
const PRESSURE_PA: f64 = 0.01 * YOUNG_PA;

/// Places from the middle of the upper face \[edges\].
fn from_top(model: &Model<'_>) -> Vec<Vector3<f64>> {
    let places: Vec<Vector3<f64>> =
        (0..model.cells()).map(|cell| rest_m(model, cell).into()).collect();
    let middle = places.iter().sum::<Vector3<f64>>() / places.len() as f64;
    let top_m = places.iter().map(|place| place.z).fold(f64::MIN, f64::max);
    let origin = Vector3::new(middle.x, middle.y, top_m);
    places.iter().map(|place| (place - origin) / EDGE_M).collect()
}

/// A square of a deep box under an even pressure: from 2 edges below to its width below, 2 edges within its rim, beside
/// half of space under the same loads. Prints and returns the distances from it in shares of its stress: of the stress
/// after von Mises, of the mean stress and of the vertical one.
fn off_half_space(poisson: f64) -> [f64; 3] {
    let image = image("box:33x33x21x0.002", tissue(poisson));
    let model = model(&image);
    let places = from_top(&model);
    let side = |cell: usize| places[cell].x.abs().max(places[cell].y.abs());
    let cells = |least: f64, most: f64, within: f64| -> Vec<usize> {
        let is_in = |&cell: &usize| (least..most).contains(&-places[cell].z) && side(cell) < within;
        (0..places.len()).filter(is_in).collect()
    };
    // The load, settled.
    let loaded: Vec<u16> = cells(-0.1, 0.1, 2.1).into_iter().map(|cell| cell as u16).collect();
    assert_eq!(loaded.len(), 25);
    let load_n = PRESSURE_PA * EDGE_M * EDGE_M;
    let settings = Settings {
        drive: Drive::Current,
        unloading: Unloading::Off,
        sweeps: 8,
        max_tool_step_m: 1.0,
        ..Settings::for_model(&model)
    };
    let network = Network::new(model, settings).unwrap();
    let contact = Contact::Cells(loaded.clone());
    let mut engine =
        Engine::with_contact(network, Scheme::Predict, Arithmetic::F32, contact).unwrap();
    engine.tick(&sample([0.0; 3], 1));
    let current_m = (load_n / (2.0 * f64::from(model.stiffness_n_per_m()))) as f32;
    for _ in 0..100 {
        engine.tick(&sample([0.0, 0.0, -current_m], 1));
    }
    // Both stresses below it.
    let (mut off, mut size) = ([0.0; 3], [0.0; 3]);
    for cell in cells(1.9, 5.1, 1.1) {
        let from = loaded.iter().map(|&at| (places[cell] - places[usize::from(at)]) * EDGE_M);
        let wanted: Matrix3<f64> = from.map(|place| load_n * of_a_point_load(poisson, place)).sum();
        let stress = engine.stress(cell).unwrap();
        let found = [
            f64::from(stress.von_mises_pa()),
            f64::from(stress.mean_pa()),
            f64::from(stress.cauchy_pa[2][2]),
        ];
        let wanted = [von_mises(wanted), wanted.trace() / 3.0, wanted[(2, 2)]];
        for (at, (found, wanted)) in found.into_iter().zip(wanted).enumerate() {
            off[at] += (found - wanted).powi(2);
            size[at] += wanted.powi(2);
        }
    }
    let shares = [0, 1, 2].map(|at| (off[at] / size[at]).sqrt());
    println!("nu {poisson}: von Mises, mean, vertical stress off by {shares:.3?}");
    shares
}

#[test]
fn the_stress_under_a_pressed_square_is_that_of_half_of_space() {
    for poisson in [0.3, 0.45] {
        let [mises, mean, vertical] = off_half_space(poisson);
        assert!(
            mises < 0.08 && mean < 0.08 && vertical < 0.08,
            "{poisson}: {mises} {mean} {vertical}"
        );
    }
}

/// The cells of a cut keep their stress in the tick that parts them, as they keep their forces.
#[test]
fn a_cut_leaves_the_stress_as_it_is_in_the_tick_that_parts() {
    let mesh = load("box:7x5x4x0.006", &MeshOptions::default()).unwrap();
    let options = BakeOptions {
        tissue: Some(tissue(0.3)),
        cuttable: Some(Cuttable::default()),
        ..BakeOptions::default()
    };
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    let network = cutting::network(&image, 1);
    let model = *network.model();
    let far = mesh.nodes_m.iter().map(|place| place[0]).fold(f64::MIN, f64::max);
    let is_end = |node: &u32| mesh.nodes_m[*node as usize][0] > far - 1e-6;
    let is_free = |node: &u32| !mesh.default_fixed.contains(node);
    let end: Vec<u32> = (0..mesh.nodes_m.len() as u32).filter(is_end).filter(is_free).collect();
    let mut body = Bench::<Predict>::holding(network, &end);
    for tick in 0..800_u16 {
        body.tick([0.0, 0.0, 3e-5 * f32::from(tick.min(200))]);
    }
    let mises_pa = |body: &mut Bench<'_, Predict>| -> Vec<f32> {
        let of = |cell| body.view().stress(&model, cell).unwrap().von_mises_pa();
        (0..model.body_cells()).map(of).collect()
    };
    let before = mises_pa(&mut body);
    for face in cutting::cut(&mesh, 0.005) {
        body.open(face).unwrap();
    }
    body.tick([0.0, 0.0, 6e-3]);
    let parted = body.cuts().copies;
    let after = mises_pa(&mut body);
    let largest = before.iter().fold(0.0_f32, |a, b| a.max(*b));
    let change = before.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    println!("{parted} copies, {change} of {largest} Pa");
    assert!(parted > 5 && change < 0.005 * largest, "{parted} copies: {change} of {largest} Pa");
}

/// A node that a blade has parted has the stress of the side with more of it.
#[test]
fn a_parted_node_has_the_stress_of_its_more_stressed_side() {
    let cuttable = Cuttable {
        toughness_j_per_m2: PerCell::Uniform(4.0),
        spare_share: 0.5,
        ..Cuttable::default()
    };
    let options = BakeOptions {
        tissue: Some(tissue(0.3)),
        cuttable: Some(cuttable),
        ..BakeOptions::default()
    };
    let image = baked("box:9x5x4x0.005", &options);
    let half = core::f32::consts::FRAC_1_SQRT_2;
    let edge = ToolPart { orientation: [0.0, 0.0, half, half], ..ToolPart::edge(0.03) };
    let contact = Contact::Tools { tools: vec![vec![edge]], friction: 0.0 };
    let mut engine = under(&image, contact, (Scheme::Predict, 4), 0.01).unwrap();
    let top_m = 0.01501;
    for tick in 0..500_u16 {
        let down_m = 2.0e-5 * f32::from(tick);
        engine.tick(&ToolPose::at([0.0, 0.0, top_m - down_m].into(), 1));
    }
    let copies = engine.cut_output().copies as usize;
    let cells = engine.network().model().body_cells();
    let origins = engine.cut_cells().unwrap().origins;
    // Rows without the copies, and with them.
    let mut means_pa = vec![f32::NAN; engine.network().model().cells()];
    let mut rows = vec![NodeStress::default(); engine.node_count()];
    assert!(engine.read_stresses(0, &mut rows, &mut means_pa));
    let alone = rows.clone();
    // In two steps, as between two ticks.
    assert_eq!(engine.add_copies(0, 3, &mut rows, &mut means_pa), 3);
    assert_eq!(engine.add_copies(3, usize::MAX, &mut rows, &mut means_pa), copies - 3);
    let ids = engine.network().model().input_id().to_vec();
    let (mut risen, mut is_all) = (0, true);
    for (row, alone) in rows.iter().zip(&alone) {
        let of_node = |(_, origin): &(usize, &u16)| ids[usize::from(**origin)] == row.node;
        let sides: Vec<f32> = (origins.iter().enumerate().filter(of_node))
            .map(|(copy, _)| engine.stress(cells + copy).unwrap().von_mises_pa())
            .collect();
        let most_pa = sides.iter().fold(alone.von_mises_pa, |most, side| most.max(*side));
        is_all &= (row.von_mises_pa - most_pa).abs() <= 1e-3 * most_pa;
        risen += u32::from(row.von_mises_pa > 1.01 * alone.von_mises_pa);
    }
    println!("{copies} copies, {risen} nodes with more stress on another side");
    assert!(copies > 4 && risen > 0 && is_all, "{copies} copies, {risen} risen");
}
