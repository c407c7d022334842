use chaincell_kernel::Model;
use rand_pcg::Pcg64;
use rand_pcg::rand_core::{Rng, SeedableRng};

use super::super::layout::lay_out;
use super::super::{BakeOptions, BasisSpacing, bake};
use super::elasticity::OWN_PART;
use super::*;
use crate::mesh::{MeshOptions, load};

fn tissue(young_pa: f64, poisson: f64) -> Tissue {
    Tissue::new(PerCell::Uniform(young_pa), PerCell::Uniform(poisson))
}

fn refused(mesh: &Mesh, options: &BakeOptions) -> String {
    bake(mesh, &mesh.default_fixed, options).unwrap_err().to_string()
}

/// Rest positions of the cells \[mean link lengths\].
fn rest(spec: &str) -> Vec<[f32; 3]> {
    let mesh = load(spec, &MeshOptions::default()).unwrap();
    lay_out(&mesh, &mesh.default_fixed).unwrap().rest
}

fn shapes(spec: &str, tissue: &Tissue) -> Shapes {
    let mesh = load(spec, &MeshOptions::default()).unwrap();
    let body = lay_out(&mesh, &mesh.default_fixed).unwrap();
    Shapes::new(&mesh, &body, tissue, false).unwrap()
}

/// A number from -1 to 1.
fn throw(source: &mut Pcg64) -> f64 {
    f64::from(source.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
}

// REQ-MOD-05
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
        (&inverted, good(), ["`young_pa`", "nodes [1, 5, 21, 6]"]),
        (&block, of(tissue(0.0, 0.3)), ["`young_pa` 0", "above 0"]),
        (&block, of(tissue(f64::NAN, 0.3)), ["`young_pa` NaN", "above 0"]),
        (&block, of(tissue(5000.0, 0.5)), ["`poisson` 0.5", "to 0.495"]),
        (&block, of(tissue(5000.0, -0.1)), ["`poisson` -0.1", "from 0"]),
        (&block, of(each(vec![1.0; 3])), ["`young_pa`: 3 values for 64 nodes", "one per node"]),
        (&block, BakeOptions { alpha: PerCell::Uniform(0.1), ..good() }, ["`alpha`", "no slack"]),
        (&block, BakeOptions { lean: true, ..good() }, ["`lean`", "slices"]),
        (&block, BakeOptions { cells: Some(20), ..good() }, ["`cells`", "groups"]),
    ] {
        let why = refused(mesh, &options);
        assert!(places.iter().all(|place| why.contains(place)), "{why}");
    }
}

/// Returns a wheel of `count` tetrahedra around the edge from node 0 to node 1.
fn wheel(count: u32) -> Mesh {
    let angle = |k: u32| f64::from(k) / f64::from(count) * std::f64::consts::TAU;
    let rim = (0..count).map(|k| [angle(k).cos(), angle(k).sin(), 0.5]);
    let nodes_m = [[0.0; 3], [0.0, 0.0, 1.0]].into_iter().chain(rim).collect();
    let around = (0..count).map(|k| [0, 1, 2 + k, 2 + (k + 1) % count]);
    let tetrahedra: Vec<[u32; 4]> = around.map(|[a, b, c, d]| [a, c, d, b]).collect();
    let mut links = vec![[0, 1]];
    for k in 0..count {
        let (here, next) = (2 + k, 2 + (k + 1) % count);
        links.extend([[0, here], [1, here], [here.min(next), here.max(next)]]);
    }
    links.sort_unstable();
    Mesh {
        nodes_m,
        links,
        triangles: Vec::new(),
        tetrahedra,
        flat_tetrahedra: 0,
        groups: Default::default(),
        border: Vec::new(),
        default_fixed: vec![1],
        unused: Vec::new(),
        filled: None,
    }
}

#[test]
fn a_node_of_too_many_edges_is_refused_by_name() {
    let options = BakeOptions {
        tissue: Some(tissue(5000.0, 0.3)),
        coarse_basis: BasisSpacing::None,
        ..BakeOptions::default()
    };
    let most = wheel(1023);
    assert!(bake(&most, &most.default_fixed, &options).is_ok());
    let why = refused(&wheel(1024), &options);
    assert!(why.contains("node 0 has 1025 edges, at most 1024: refine"), "{why}");
}

/// For any field d, d' L d is at most the sum of W d^2: every certificate relies on it.
#[test]
fn the_bound_is_above_the_curvature_of_every_field() {
    let mut source = Pcg64::seed_from_u64(5);
    for (spec, poisson, stretch_min) in
        [("box:5x4x4x0.01", 0.0, None), ("organ:300", 0.45, Some(0.7)), ("organ:300", 0.495, None)]
    {
        let shapes = shapes(spec, &Tissue { stretch_min, ..tissue(5000.0, poisson) });
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

/// Soft and stiff nodes keep their values in the model.
#[test]
fn each_node_has_its_own_modulus() {
    let mesh = load("box:4x4x4x0.01", &MeshOptions::default()).unwrap();
    let young: Vec<f64> = (0..64).map(|node| 1000.0 * f64::from(1 + node % 5)).collect();
    let tissue = Tissue { young_pa: PerCell::Each(young.clone()), ..tissue(1.0, 0.3) };
    let coarse_basis = BasisSpacing::None;
    let options = BakeOptions { tissue: Some(tissue), coarse_basis, ..BakeOptions::default() };
    let image = bake(&mesh, &mesh.default_fixed, &options).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    for (cell, &id) in model.input_id().iter().enumerate() {
        let [found, poisson] = model.elasticity(cell).unwrap();
        let off = f64::from(found) / young[id as usize] - 1.0;
        assert!(off.abs() < 1e-5 && (poisson - 0.3).abs() < 1e-5, "{id}: {found} {poisson}");
    }
}

/// K is symmetric; a homogeneous strain has Hooke's energy, a rigid motion has none.
#[test]
fn the_elasticity_is_hookes() {
    let (mu, lambda) = (0.5 / 1.45, 0.45 / (1.45 * 0.1));
    for spec in ["box:4x4x3x0.01", "organ:150"] {
        let shapes = shapes(spec, &tissue(5000.0, 0.45));
        let cells = shapes.bound.len();
        let matrix = shapes.elasticity(cells, |cell| vec![(usize::from(cell), 1.0)]);
        assert!((&matrix - matrix.transpose()).amax() < 1e-9 * matrix.amax());
        let volume: f64 = (0..cells).map(|cell| shapes.shape.volume_m3(cell)).sum();
        let at = rest(spec);
        // Moduli are in units of mu.
        let unit = shapes.mu[0] / mu;
        for (slope, strain) in [
            ([[0.1, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], 2.0 * mu * 0.01 + lambda * 0.01),
            ([[0.0, 0.2, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]], 2.0 * mu * 0.02),
            ([[0.0, 0.2, -0.3], [-0.2, 0.0, 0.1], [0.3, -0.1, 0.0]], 0.0),
        ] {
            let mut u = nalgebra::DVector::zeros(3 * cells);
            for (cell, x) in at.iter().enumerate() {
                for axis in 0..3 {
                    let along: f64 = (0..3).map(|k| slope[axis][k] * f64::from(x[k])).sum();
                    u[axis * cells + cell] = along + 1.0;
                }
            }
            let found = u.dot(&(&matrix * &u));
            let wanted = unit * volume * strain;
            assert!((found - wanted).abs() < 1e-4 * unit * volume, "{spec}: {found} {wanted}");
        }
        for (cell, factor) in shapes.factors().into_iter().enumerate() {
            let own: f64 = (0..3).map(|axis| axis * cells + cell).map(|i| matrix[(i, i)]).sum();
            let part = f64::from(factor) * own / (3.0 * f64::from(shapes.bound[cell]));
            assert!((part - OWN_PART).abs() < 1e-4 || factor == 1.0, "{spec}: {cell}: {part}");
        }
    }
}

#[test]
fn bands_that_are_none_are_refused_by_name() {
    let mesh = load("box:4x4x3x0.01", &MeshOptions::default()).unwrap();
    let band = Band::new;
    let why = |stiffening: &[Band]| {
        let tissue = Tissue { stiffening: stiffening.to_vec(), ..tissue(5000.0, 0.3) };
        refused(&mesh, &BakeOptions { tissue: Some(tissue), ..BakeOptions::default() })
    };
    let good = band(0.1, 1000.0);
    assert!(why(&[good, good]).contains("half-width 0.1 twice"));
    for side in [BandSide::Short, BandSide::Long] {
        assert!(why(&[good, Band { side, ..good }]).contains("half-width 0.1 twice"));
    }
    let seven = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7].map(|half_width| band(half_width, 1000.0));
    assert!(why(&seven).contains("7 bands, at most 6"));
    for half_width in [0.0, 1.0, -0.1, f64::NAN] {
        assert!(why(&[band(half_width, 1000.0)]).contains("half-width"), "{half_width}");
    }
    for modulus_pa in [0.0, -1.0, f64::INFINITY, f64::NAN] {
        assert!(why(&[band(0.1, modulus_pa)]).contains("modulus"), "{modulus_pa}");
    }
    // 5 kPa and 0.3 have a shear modulus of 1,923 Pa; the range is 1e-6 to 1e6 of it.
    for modulus_pa in [1.8e-3, 2.0e9] {
        let why = why(&[good, band(0.2, modulus_pa)]);
        assert!(why.contains("from 1.923e-3 to 1.923e9 [Pa] on this body"), "{why}");
    }
}

/// The order of the bands does not matter, and the bound counts all of them.
#[test]
fn the_bound_counts_the_bands() {
    let mesh = load("box:4x4x3x0.01", &MeshOptions::default()).unwrap();
    let of = |stiffening: &[(f64, f64)]| {
        let bands = stiffening.iter();
        let stiffening =
            bands.map(|&(half_width, modulus_pa)| Band::new(half_width, modulus_pa)).collect();
        let tissue = Tissue { stiffening, ..tissue(5000.0, 0.3) };
        let options = BakeOptions { tissue: Some(tissue), ..BakeOptions::default() };
        bake(&mesh, &mesh.default_fixed, &options).unwrap()
    };
    let image = of(&[(0.1, 1000.0), (0.3, 4000.0)]);
    assert_eq!(image.as_bytes(), of(&[(0.3, 4000.0), (0.1, 1000.0)]).as_bytes());
    let (model, plain) = (Model::from_bytes(image.as_bytes()).unwrap(), of(&[]));
    let plain = Model::from_bytes(plain.as_bytes()).unwrap();
    let mut bands = Vec::new();
    model.each_stiffening(|half_width, modulus_pa| bands.push((half_width, modulus_pa.round())));
    assert_eq!(bands, [(0.1, 1000.0), (0.3, 4000.0)]);
    plain.each_stiffening(|_, _| panic!("there is none"));
    let mut around = vec![0.0; model.cells()];
    for nodes in &mesh.tetrahedra {
        let volume = shape::volume_m3(&mesh.nodes_m, *nodes);
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))).filter(|(i, j)| i != j) {
            let [a, b] = [nodes[i], nodes[j]].map(|node| mesh.nodes_m[node as usize]);
            let squared: f64 = a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum();
            around[usize::from(model.cell_of_input(nodes[i]).unwrap())] += volume / squared;
        }
    }
    for (cell, around) in around.into_iter().enumerate() {
        // The stiffness of a link is E V / l0^2.
        let added = f64::from(model.cell_bound(cell) - plain.cell_bound(cell));
        let wanted = 5000.0 * around / f64::from(model.stiffness_n_per_m());
        assert!((added / wanted - 1.0).abs() < 1e-4, "{cell}: {added} {wanted}");
    }
}
