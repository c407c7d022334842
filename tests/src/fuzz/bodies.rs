//! Small bodies that targets run on, each with what another one lacks.

use std::sync::OnceLock;

use chaincell_host::bake::tissue::{Band, Branch, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell};
use chaincell_kernel::{Loose, Model, TearLimit, include_model};
use chaincell_lab::bodies::Shape;

use crate::graph::shape;

/// Nine by nine cells, diagonals, neither slices nor coarse functions.
static PLANE9: &[u8] = include_model!("../../data/plane9.chaincell");
/// 125 cells.
static BOX5: &[u8] = include_model!("../../data/box5.chaincell");
/// Cells with an embedded mesh.
static GROUPS: &[u8] = include_model!("../../data/box5_cells.chaincell");

fn grid(spec: &str, fixed: bool, options: BakeOptions) -> ImageBytes {
    let shape = Shape::generated(spec).unwrap();
    let shape = if fixed { shape } else { shape.floating() };
    shape.bake(&options).unwrap()
}

/// Two pairs and a chain that nothing joins or holds.
fn loose() -> ImageBytes {
    let nodes_m = (0..8).map(|i| [0.01 * f64::from(i), 0.002 * f64::from(i % 3), 0.0]).collect();
    let links = vec![[0, 1], [2, 3], [4, 5], [5, 6], [5, 7]];
    let options = BakeOptions { coarse_basis: BasisSpacing::None, ..BakeOptions::default() };
    shape(nodes_m, links, Vec::new()).bake(&options).unwrap()
}

/// Stiffness over nine decades, bands from none to nearly all.
fn contrasts() -> ImageBytes {
    let nodes = 4 * 3 * 3;
    let stiffness = (0..nodes).map(|i| 10_f64.powi((i * 7) % 10 - 5)).collect();
    let alphas = (0..nodes).map(|i| 0.99 * f64::from(i % 5) / 4.0).collect();
    let options = BakeOptions {
        alpha: PerCell::Each(alphas),
        stiffness_n_per_m: PerCell::Each(stiffness),
        coarse_basis: BasisSpacing::Links(2.0),
        ..BakeOptions::default()
    };
    grid("box:4x3x3x0.01", true, options)
}

/// A tool may load so much into it that cells saturate.
fn saturating() -> ImageBytes {
    let options = BakeOptions {
        saturation_m: Some(0.05),
        energy_max_j: Some(1e9),
        coarse_basis: BasisSpacing::None,
        ..BakeOptions::default()
    };
    grid("box:2x2x3x0.01", true, options)
}

/// Branches from a tick to hours, one of nearly nothing.
fn branches() -> Relaxation {
    let of = |(ratio, time_s)| Branch { ratio, time_s };
    let branches = [(2.0, 0.001), (20.0, 0.02), (1e-9, 0.5), (0.5, 1600.0)].map(of).to_vec();
    Relaxation { branches, is_instant: false, device_hz: 1000 }
}

/// Links that relax, some with slack.
fn relaxing() -> ImageBytes {
    let alphas = (0..27).map(|i| 0.1 * f64::from(i % 3)).collect();
    let options = BakeOptions {
        link_relaxation: Some(branches()),
        alpha: PerCell::Each(alphas),
        coarse_basis: BasisSpacing::Links(2.0),
        ..BakeOptions::default()
    };
    grid("box:3x3x3x0.01", true, options)
}

/// The images, those of files first.
pub fn images() -> &'static [ImageBytes] {
    static IMAGES: OnceLock<Vec<ImageBytes>> = OnceLock::new();
    IMAGES.get_or_init(|| {
        let slack = BakeOptions {
            alpha: PerCell::Uniform(0.1),
            coarse_basis: BasisSpacing::Links(2.0),
            ..BakeOptions::default()
        };
        let committed = [PLANE9, BOX5, GROUPS].map(ImageBytes::copy);
        let baked = [
            grid("box:3x3x3x0.01", true, slack),
            grid("box:2x2x2x0.01", false, BakeOptions::default()),
            loose(),
            contrasts(),
            saturating(),
            relaxing(),
        ];
        committed.into_iter().chain(baked).collect()
    })
}

/// One of them.
pub fn model(choice: u8) -> Model<'static> {
    let images = images();
    Model::from_bytes(images[usize::from(choice) % images.len()].as_bytes()).unwrap()
}

/// Nodal shapes with a contact surface: liver; floating, nearly of constant volume, stiffening, into
/// which a tool may load little; without a coarse level and without the band of stretches; one that relaxes; bodies
/// that can be cut and tear, of a toughness by place: one that stiffens, and one of links.
fn tissues() -> &'static [ImageBytes] {
    static IMAGES: OnceLock<Vec<ImageBytes>> = OnceLock::new();
    IMAGES.get_or_init(|| {
        let of = |poisson| Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(poisson));
        let stiffening = vec![Band::new(0.05, 12_000.0)];
        let liver = BakeOptions {
            tissue: Some(of(0.45)),
            coarse_basis: BasisSpacing::Links(2.0),
            ..BakeOptions::default()
        };
        let loose = BakeOptions {
            tissue: Some(Tissue { stiffening, ..of(0.49) }),
            energy_max_j: Some(1e-4),
            ..BakeOptions::default()
        };
        let bare = BakeOptions {
            tissue: Some(Tissue { stretch_min: None, ..of(0.3) }),
            coarse_basis: BasisSpacing::None,
            ..BakeOptions::default()
        };
        let relaxing = BakeOptions {
            tissue: Some(Tissue { relaxation: Some(branches()), ..of(0.45) }),
            ..BakeOptions::default()
        };
        let cuttable = |nodes: i32| {
            let toughness = (0..nodes).map(|i| 10_f64.powi(i % 4 - 2)).collect();
            Cuttable { toughness_j_per_m2: PerCell::Each(toughness), ..Cuttable::default() }
        };
        let stiffening = vec![Band::new(0.02, 20_000.0), Band::new(0.3, 5000.0)];
        let tears = Cuttable {
            spare_share: 0.5,
            tear_limit: Some(TearLimit::Stretch(1.4)),
            loose: Loose::Drop,
            ..cuttable(36)
        };
        let tearing = BakeOptions {
            tissue: Some(Tissue { stiffening, ..of(0.3) }),
            cuttable: Some(tears),
            ..BakeOptions::default()
        };
        let tears =
            Cuttable { spare_share: 1.0, tear_limit: Some(TearLimit::Toughness), ..cuttable(36) };
        let links = BakeOptions { cuttable: Some(tears), ..BakeOptions::default() };
        vec![
            grid("box:4x3x3x0.01", true, liver),
            grid("box:2x3x3x0.01", false, loose),
            grid("box:3x3x2x0.01", true, bare),
            grid("box:3x3x3x0.01", true, relaxing),
            grid("box:4x3x3x0.01", true, tearing),
            grid("box:4x3x3x0.01", true, links),
        ]
    })
}

/// One of the bodies with a contact surface.
pub fn tissue(choice: u8) -> Model<'static> {
    let images = tissues();
    Model::from_bytes(images[usize::from(choice) % images.len()].as_bytes()).unwrap()
}

/// Up to `count` cells that a tool may hold, spread over the body from `from` on; ascending.
pub fn free_cells(model: &Model<'_>, from: u8, count: usize) -> Vec<u16> {
    let free: Vec<u16> = (0..model.cells() as u16).filter(|&cell| !model.is_fixed(cell)).collect();
    let mut cells: Vec<u16> = (0..count.min(free.len()))
        .map(|at| free[(usize::from(from) + at * 5) % free.len()])
        .collect();
    cells.sort_unstable();
    cells.dedup();
    cells
}
