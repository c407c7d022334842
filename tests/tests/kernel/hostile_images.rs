//! Images that no bake writes: what a tick walks is bounded by the cells, and every answer is finite.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::image::{NO_FUNCTION, kind, nodal, params};
use chaincell_kernel::{Model, ModelError, Network, TickOutput};
use chaincell_lab::bodies::Shape;
use chaincell_tests::forge::Forged;
use chaincell_tests::graph::sample;

/// Links with a coarse level.
fn links() -> Forged {
    let options = BakeOptions { coarse_basis: BasisSpacing::Links(2.0), ..BakeOptions::default() };
    Forged::of(Shape::generated("box:4x4x4x0.01").unwrap().bake(&options).unwrap().as_bytes())
}

/// Nodal shapes with a contact surface.
fn shapes() -> Forged {
    let options = BakeOptions {
        tissue: Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.4))),
        coarse_basis: BasisSpacing::Links(2.0),
        ..BakeOptions::default()
    };
    Forged::of(Shape::generated("box:4x4x4x0.01").unwrap().bake(&options).unwrap().as_bytes())
}

fn error(forged: &Forged) -> ModelError {
    Model::from_bytes(forged.sealed().as_bytes()).unwrap_err()
}

// REQ-MOD-06
#[test]
fn empty_boxes_are_refused() {
    for mut forged in [links(), shapes()] {
        let boxes = forged.get::<u32>(kind::COARSE_ROWS).len() - 1;
        forged.change(kind::COARSE_ROWS, |rows: &mut Vec<u32>| {
            rows.extend([*rows.last().unwrap(); 1000]);
        });
        forged.change(kind::COARSE_CORNERS, |of: &mut Vec<[u16; 8]>| {
            of.extend([[NO_FUNCTION; 8]; 1000])
        });
        assert_eq!(error(&forged), ModelError::Index(kind::COARSE_ROWS, boxes as u32));
    }
}

// REQ-MOD-06
#[test]
fn groups_of_padding_are_refused() {
    for (mut forged, is_nodal) in [(links(), false), (shapes(), true)] {
        let last = forged.get::<u32>(kind::SLICE_ROWS).len() as u32 - 2;
        let itself = *forged.get::<[u16; 8]>(kind::SLICE_NEIGHBOURS).last().unwrap();
        forged.change(kind::SLICE_ROWS, |rows: &mut Vec<u32>| *rows.last_mut().unwrap() += 1000);
        forged.change(kind::SLICE_NEIGHBOURS, |of: &mut Vec<[u16; 8]>| of.extend([itself; 1000]));
        forged.change(kind::SLICE_LENGTHS, |of: &mut Vec<[f32; 8]>| of.extend([[0.0; 8]; 1000]));
        if is_nodal {
            let idle = [[0.0_f32; 8]; nodal::SLOT_ROWS];
            forged.change(kind::NODAL_SLOTS, |of: &mut Vec<_>| of.extend([idle; 1000]));
        }
        assert_eq!(error(&forged), ModelError::Index(kind::SLICE_ROWS, last));
    }
}

// REQ-MOD-06
#[test]
fn more_triangles_than_a_surface_has_are_refused() {
    let mut forged = shapes();
    let most = 16 * Model::from_bytes(forged.sealed().as_bytes()).unwrap().cells();
    let numbers = forged.get::<[f32; 3]>(kind::CONTACT)[0];
    let mut grown = |count: usize| {
        forged.change(kind::TRIANGLES, |of: &mut Vec<[u16; 3]>| of.resize(count, of[0]));
        forged.change(kind::CONTACT, |of: &mut Vec<[f32; 3]>| of.resize(count, numbers));
        Model::from_bytes(forged.sealed().as_bytes()).map(|model| model.cells())
    };
    assert_eq!(grown(most), Ok(most / 16));
    assert_eq!(grown(most + 1), Err(ModelError::SectionSize(kind::CONTACT)));
}

/// All that a tick answers.
fn answers(output: &TickOutput) -> [f32; 6] {
    let [x, y, z] = output.force_n.into();
    [x, y, z, output.energy_j, output.work_j, output.stiffness_n_per_m]
}

/// Presses and throws a body; every answer is finite. Gives how many there were.
fn press(image: &ImageBytes, scheme: Scheme, probe: bool) -> usize {
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let mut settings = scheme.settings(&model, 2);
    settings.max_force_n = f32::INFINITY;
    settings.max_tool_step_m = model.unit_m();
    let network = Network::new(model, settings).unwrap();
    let free = (0..model.cells() as u16).rev().find(|&cell| !model.is_fixed(cell)).unwrap();
    let contact = match probe {
        true => Contact::sphere(model.unit_m(), 0.0),
        false => Contact::Cells(vec![free]),
    };
    let mut engine = Engine::with_contact(network, scheme, Arithmetic::F32, contact).unwrap();
    let (centre, unit_m) = (model.centre_m(), model.unit_m());
    let mut count = 0;
    for thrown in [0.0, 1.0, 1e3, 1e5] {
        for tick in 0..12_u16 {
            let place = [centre[0], centre[1], centre[2] - 0.3 * unit_m * f32::from(tick)];
            let output = engine.tick(&sample(place, u32::from(tick % 6 != 0)));
            for answer in answers(&output) {
                assert!(answer.is_finite(), "{scheme:?}, thrown by {thrown}: {output:?}");
                count += 1;
            }
        }
        let throw = |cell: usize| {
            let odd = if cell.is_multiple_of(2) { 1.0 } else { -1.0 };
            model.rest_position(cell).map(|x| x + odd * thrown)
        };
        let places: Vec<[f32; 3]> = (0..model.cells()).map(throw).collect();
        engine.set_positions(&places).unwrap();
    }
    count
}

fn reals(forged: &mut Forged, kind: u32, change: impl Fn(f32) -> f32) {
    forged
        .change(kind, |of: &mut Vec<f32>| of.iter_mut().for_each(|value| *value = change(*value)));
}

/// Other scalars of the body.
fn with_words(mut forged: Forged, words: &[(usize, f32)]) -> Forged {
    forged.change(kind::PARAMS, |of: &mut Vec<f32>| {
        words.iter().for_each(|&(word, value)| of[word] = value);
    });
    forged
}

/// Units at the ends of their range.
const UNITS: [(f32, f32); 6] =
    [(1e-18, 1e18), (1e18, 1e-18), (1e36, 1e-18), (1e-36, 1e18), (4e17, 1.0), (5e-19, 1.0)];

// REQ-MOD-07
#[test]
fn answers_are_finite_in_every_unit() {
    let mut taken = 0;
    for (stiffness, unit_m) in UNITS {
        for (forged, probes) in [(links(), [false, true]), (shapes(), [false, true])] {
            let words = [
                (params::STIFFNESS_N_PER_M, stiffness),
                (params::UNIT_M, unit_m),
                (params::ENERGY_MAX, 9.9e17),
            ];
            let image = with_words(forged, &words).sealed();
            if Model::from_bytes(image.as_bytes()).is_err() {
                continue;
            }
            for probe in probes {
                taken += press(&image, Scheme::Track, probe);
            }
        }
    }
    assert!(taken > 3000, "{taken}");
}

// REQ-MOD-07
#[test]
fn answers_are_finite_with_every_weight() {
    let mut taken = 0;
    // Powers of two leave the products as they are.
    for power in [-29, 29] {
        let factor = 2.0_f32.powi(power);
        let stiffness: Vec<f64> = (0..64).map(|i| 10.0 + f64::from(i)).collect();
        let options = BakeOptions {
            stiffness_n_per_m: PerCell::Each(stiffness),
            coarse_basis: BasisSpacing::Links(2.0),
            ..BakeOptions::default()
        };
        let baked = Shape::generated("box:4x4x4x0.01").unwrap().bake(&options).unwrap();
        let mut forged = Forged::of(baked.as_bytes());
        reals(&mut forged, kind::WEIGHT, |weight| factor * weight);
        reals(&mut forged, kind::SLICE_WEIGHTS, |w| if w == 1.0 { w } else { factor * w });
        reals(&mut forged, kind::MOBILITY, |mobility| mobility / factor);
        reals(&mut forged, kind::COARSE_INVERSE, |element| element / factor);
        let degree = forged.get::<f32>(kind::PARAMS)[params::DEGREE_BOUND];
        for (stiffness, unit_m) in UNITS {
            let words = [
                (params::DEGREE_BOUND, factor * degree),
                (params::STIFFNESS_N_PER_M, stiffness),
                (params::UNIT_M, unit_m),
                (params::ENERGY_MAX, 9.9e17),
            ];
            let image = with_words(forged.clone(), &words).sealed();
            if Model::from_bytes(image.as_bytes()).is_err() {
                continue;
            }
            for scheme in [Scheme::Track, Scheme::Euler] {
                taken += press(&image, scheme, false);
                if matches!(scheme, Scheme::Track | Scheme::Predict) {
                    taken += press(&image, scheme, true);
                }
            }
        }
    }
    assert!(taken > 3000, "{taken}");
}

// REQ-MOD-07
#[test]
fn answers_are_finite_with_every_modulus() {
    let mut taken = 0;
    for (row, value) in [(nodal::MU, 1e6), (nodal::MU, 1e-6), (nodal::LAMBDA_3, 1e9)] {
        for bound in [1.0, 1e12, 1e30] {
            let mut forged = shapes();
            forged.change(kind::NODAL_CELLS, |of: &mut Vec<[[f32; 8]; nodal::CELL_ROWS]>| {
                for slice in of {
                    slice[row] = [value; 8];
                    slice[nodal::BOUND].iter_mut().for_each(|at| *at *= bound);
                }
            });
            let bounds = forged.get::<[[f32; 8]; nodal::CELL_ROWS]>(kind::NODAL_CELLS);
            let fixed = forged.get::<u16>(kind::FIXED);
            forged.change(kind::MOBILITY, |of: &mut Vec<f32>| {
                for (cell, mobility) in of.iter_mut().enumerate() {
                    let is_fixed = fixed.contains(&(cell as u16));
                    let bound = bounds[cell / 8][nodal::BOUND][cell % 8];
                    *mobility = if is_fixed { 0.0 } else { 1.0 / bound };
                }
            });
            let words = [(params::DEGREE_BOUND, 1e31), (params::ENERGY_MAX, 9.9e17)];
            let image = with_words(forged, &words).sealed();
            if Model::from_bytes(image.as_bytes()).is_err() {
                continue;
            }
            taken += press(&image, Scheme::Track, false) + press(&image, Scheme::Track, true);
        }
    }
    assert!(taken > 1000, "{taken}");
}
