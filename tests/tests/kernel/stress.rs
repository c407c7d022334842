//! Strain and stress of the tissue at a cell, beside formulas and beside the force that makes them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_host::engine::{Contact, Engine, Scheme};
use chaincell_kernel::{Model, Stress};
use chaincell_tests::bodies::{model, nodal, under};
use nalgebra::{Matrix3, Rotation3, Vector3};

use chaincell_tests::graph::sample;

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

/// The cells of a layer of a box with 5 x 5 of them, each with its share of the cross-section.
fn layer(model: &Model<'_>, layer: usize) -> Vec<(usize, f64)> {
    let at_side = |index: usize| if index == 0 || index == 4 { 0.5 } else { 1.0 };
    let of = |node: usize| {
        let cell = model.cell_of_input(node as u32).unwrap();
        (usize::from(cell), at_side(node / 13 / 5) * at_side(node / 13 % 5) / 16.0)
    };
    (0..25).map(|column| of(column * 13 + layer)).collect()
}

/// A bar pulled and pressed by its end: the stress over its middle carries the force.
#[test]
fn the_stress_over_a_bar_carries_the_force_at_its_end() {
    let image = nodal("box:5x5x13x0.005", YOUNG_PA);
    let model = model(&image);
    let mut end: Vec<u16> = layer(&model, 12).into_iter().map(|(cell, _)| cell as u16).collect();
    end.sort_unstable();
    let step_m = 2e-5_f32;
    for way in [1.0, -1.0] {
        let contact = Contact::Cells(end.clone());
        let mut engine = under(&image, contact, (Scheme::Predict, 8), step_m * 1.01).unwrap();
        let mut force_n = Vector3::zeros();
        for tick in 0..600_u16 {
            let z_m = way * step_m * f32::from(tick.min(150));
            let output = engine.tick(&sample([0.0, 0.0, z_m], 1));
            force_n = Vector3::from(<[f32; 3]>::from(output.force_n).map(f64::from));
        }
        let mean = |engine: &mut Engine<'_>, of: fn(&Stress) -> f32| -> f64 {
            let cells = layer(&model, 6).into_iter();
            cells.map(|(cell, share)| share * f64::from(of(&engine.stress(cell).unwrap()))).sum()
        };
        let across = mean(&mut engine, |stress| stress.gradient[0][0] * stress.gradient[1][1]);
        let carried_n = mean(&mut engine, |stress| stress.cauchy_pa[2][2]) * 0.02 * 0.02 * across;
        // The hand feels the force of the tissue, which pulls back.
        let ratio = carried_n / -force_n.z;
        assert!((ratio - 1.0).abs() < 0.03, "{carried_n} N, felt {} N", force_n.z);
        // A slender bar is free to grow and shrink across: its stress is along it alone.
        let mises_pa = mean(&mut engine, Stress::von_mises_pa);
        let along_pa = carried_n.abs() / (0.02 * 0.02 * across);
        assert!((mises_pa / along_pa - 1.0).abs() < 0.03, "{mises_pa} Pa, {along_pa} Pa");
    }
}
