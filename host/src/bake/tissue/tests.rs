use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::super::{BakeOptions, BasisSpacing, bake, lay_out};
use super::*;
use crate::mesh::{MeshOptions, load};

fn tissue(young_pa: f64, poisson: f64) -> Tissue {
    Tissue { young_pa: PerCell::Uniform(young_pa), poisson: PerCell::Uniform(poisson) }
}

fn refused(mesh: &Mesh, options: &BakeOptions) -> String {
    bake(mesh, &mesh.default_fixed, options).unwrap_err().to_string()
}

fn shapes(spec: &str, tissue: &Tissue) -> Shapes {
    let mesh = load(spec, &MeshOptions::default()).unwrap();
    let body = lay_out(&mesh, &mesh.default_fixed).unwrap();
    Shapes::new(&mesh, &body, tissue).unwrap()
}

/// A number from -1 to 1.
fn throw(source: &mut Pcg64) -> f64 {
    f64::from(source.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
}

#[test]
fn what_is_no_tissue_is_refused_by_name() {
    let block = load("box:4x4x4x0.01", &MeshOptions::default()).unwrap();
    let plane = load("plane:5x5x0.01", &MeshOptions::default()).unwrap();
    let rings = MeshOptions { rings: 2, ..MeshOptions::default() };
    let far = load("box:4x4x4x0.01", &rings).unwrap();
    let of = |tissue| BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
    let good = || of(tissue(5000.0, 0.45));
    let each = |values| Tissue { young_pa: PerCell::Each(values), ..tissue(1.0, 0.3) };
    let mut inverted = block.clone();
    inverted.tetrahedra[7].swap(0, 1);
    for (mesh, options, places) in [
        (&plane, good(), ["`young_pa`", "no tetrahedra"]),
        (&far, good(), ["`young_pa`", "`rings`"]),
        (&inverted, good(), ["`young_pa`", "tetrahedron 7"]),
        (&block, of(tissue(0.0, 0.3)), ["`young_pa` 0", "above 0"]),
        (&block, of(tissue(f64::NAN, 0.3)), ["`young_pa` NaN", "above 0"]),
        (&block, of(tissue(5000.0, 0.5)), ["`poisson` 0.5", "to 0.495"]),
        (&block, of(tissue(5000.0, -0.1)), ["`poisson` -0.1", "from 0"]),
        (&block, of(each(vec![1.0; 3])), ["`young_pa`: 3 values for 64 nodes", "one per node"]),
        (&block, BakeOptions { alpha: PerCell::Uniform(0.1), ..good() }, ["`alpha`", "no slack"]),
        (&block, BakeOptions { colours: true, ..good() }, ["`colours`", "gauss-seidel"]),
        (&block, BakeOptions { lean: true, ..good() }, ["`lean`", "slices"]),
        (&block, BakeOptions { cells: Some(20), ..good() }, ["`cells`", "groups"]),
    ] {
        let why = refused(mesh, &options);
        assert!(places.iter().all(|place| why.contains(place)), "{why}");
    }
}

/// For any field d, d' L d is at most the sum of W d^2: what every certificate rests on.
#[test]
fn the_bound_is_above_the_curvature_of_every_field() {
    let mut source = Pcg64::seed_from_u64(5);
    for (spec, poisson) in [("box:5x4x4x0.01", 0.0), ("organ:300", 0.45), ("organ:300", 0.495)] {
        let shapes = shapes(spec, &tissue(5000.0, poisson));
        let cells = shapes.bound.len();
        let mut largest = 0.0_f64;
        for _ in 0..50 {
            // Single cells, patches and the whole body.
            let width = 1 + source.next_u32() as usize % cells;
            let d: Vec<f64> = (0..cells)
                .map(|cell| if cell < width { throw(&mut source) } else { 0.0 })
                .collect();
            let mut curvature = 0.0;
            shapes.each_map(|map, weight| {
                let along: f64 = map.iter().map(|&(cell, factor)| factor * d[cell]).sum();
                curvature += weight * along * along;
            });
            let bound: f64 = d.iter().zip(&shapes.bound).map(|(d, w)| f64::from(*w) * d * d).sum();
            assert!(curvature >= -1e-9 * bound, "{spec}: {curvature}");
            largest = largest.max(curvature / bound);
        }
        assert!((0.1..=1.0).contains(&largest), "{spec}, {poisson}: {largest}");
        // A translation has no energy.
        let mut most = 0.0_f64;
        shapes.each_map(|map, _| {
            most = most.max(map.iter().map(|(_, factor)| factor).sum::<f64>().abs());
        });
        assert!(most < 1e-12, "{most}");
    }
}

/// Values of the nodes, soft and stiff, and what the model tells of them.
#[test]
fn each_node_has_its_own_modulus() {
    let mesh = load("box:4x4x4x0.01", &MeshOptions::default()).unwrap();
    let young: Vec<f64> = (0..64).map(|node| 1000.0 * f64::from(1 + node % 5)).collect();
    let tissue = Tissue { young_pa: PerCell::Each(young.clone()), ..tissue(1.0, 0.3) };
    let coarse_basis = BasisSpacing::None;
    let options = BakeOptions { tissue: Some(tissue), coarse_basis, ..BakeOptions::default() };
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    let model = chaincell_kernel::Model::from_bytes(image.as_bytes()).unwrap();
    for (cell, &id) in model.input_id().iter().enumerate() {
        let [found, poisson] = model.elasticity(cell).unwrap();
        let off = f64::from(found) / young[id as usize] - 1.0;
        assert!(off.abs() < 1e-5 && (poisson - 0.3).abs() < 1e-5, "{id}: {found} {poisson}");
    }
}
