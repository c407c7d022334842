//! The images of the golden scenes, and of the tests of the kernel, are what the bake gives today.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;

use chaincell_host::bake::tissue::{Band, Branch, DEVICE_HZ, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, BasisSpacing, ContactSurface, Cuttable, PerCell, bake};
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::TearLimit;
use chaincell_scenes::{
    BLADE5, BOX7, ORGAN500, PLANE4, PLANE8, RELAX6, SCENES, TEAR4, TISSUE6, TOUCH6, VARIED300,
};

/// One value a node.
fn each(nodes: u32, value: fn(u32) -> u32, unit: f64) -> PerCell {
    PerCell::Each((0..nodes).map(|node| unit * f64::from(value(node))).collect())
}

fn baked(spec: &str, diagonals: bool, options: &BakeOptions) -> Vec<u8> {
    let mesh = load(spec, &MeshOptions { diagonals, ..MeshOptions::default() }).unwrap();
    bake(&mesh, &mesh.default_fixed, options).unwrap().as_bytes().to_vec()
}

#[track_caller]
fn check(name: &str, linked: &[u8], baked: &[u8]) {
    if linked != baked {
        let fresh = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        std::fs::write(&fresh, baked).unwrap();
        panic!(
            "tests/data/{name} is not what the bake gives; if that is meant, copy {} over it and \
             bring the goldens of its scenes up to date",
            fresh.display()
        );
    }
}

#[test]
fn the_linked_images_are_what_the_bake_gives() {
    let plain = BakeOptions {
        coarse_basis: BasisSpacing::None,
        contact_surface: ContactSurface::No,
        ..BakeOptions::default()
    };
    let nine = BakeOptions { lean: true, ..BakeOptions::default() };
    let linked = include_bytes!("../../data/plane9.chaincell");
    check("plane9.chaincell", linked, &baked("plane:9x9x0.01", true, &nine));
    let slack = |alpha| PerCell::Uniform(alpha);
    let four = BakeOptions { lean: true, ..plain.clone() };
    check("plane4.chaincell", PLANE4, &baked("plane:21x21x0.01", false, &four));
    let eight = BakeOptions { alpha: slack(0.02), ..plain.clone() };
    check("plane8.chaincell", PLANE8, &baked("plane:21x21x0.01", true, &eight));
    let block =
        BakeOptions { alpha: slack(0.03), coarse_basis: BasisSpacing::Links(2.5), ..plain.clone() };
    check("box7.chaincell", BOX7, &baked("box:7x7x5x0.01", false, &block));
    let organ = BakeOptions { coarse_basis: BasisSpacing::Links(3.5), lean: true, ..plain.clone() };
    check("organ500.chaincell", ORGAN500, &baked("organ:500", false, &organ));
    let tissue = Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.4));
    let tissue = BakeOptions {
        tissue: Some(tissue),
        coarse_basis: BasisSpacing::Links(2.5),
        ..plain.clone()
    };
    check("tissue6.chaincell", TISSUE6, &baked("box:6x6x4x0.01", false, &tissue));
    let touch = BakeOptions { contact_surface: ContactSurface::Yes, ..tissue };
    let blade = BakeOptions {
        cuttable: Some(Cuttable {
            spare_share: 0.3,
            toughness_j_per_m2: PerCell::Uniform(10.0),
            ..Cuttable::default()
        }),
        ..touch.clone()
    };
    check("blade5.chaincell", BLADE5, &baked("box:5x5x4x0.01", false, &blade));
    check("touch6.chaincell", TOUCH6, &baked("box:6x6x4x0.01", false, &touch));
    let branches = [(1.0, 0.02), (0.5, 12.0)].map(|(ratio, time_s)| Branch { ratio, time_s });
    let relaxation =
        Relaxation { branches: branches.to_vec(), is_instant: false, device_hz: DEVICE_HZ };
    let of_touch = touch.tissue.clone().map(|of| Tissue { relaxation: Some(relaxation), ..of });
    let relax = BakeOptions { tissue: of_touch, ..touch };
    check("relax6.chaincell", RELAX6, &baked("box:6x6x4x0.01", false, &relax));
    let varied = BakeOptions {
        alpha: each(299, |node| node * 7 % 31, 0.002),
        stiffness_n_per_m: each(299, |node| 1 + node * 13 % 17, 5.0),
        coarse_basis: BasisSpacing::Links(3.0),
        ..plain
    };
    check("varied300.chaincell", VARIED300, &baked("organ:300", false, &varied));
}

#[test]
fn the_linked_bodies_that_are_cut_are_what_the_bake_gives() {
    let soft = Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.3));
    let cut = BakeOptions {
        tissue: Some(Tissue { stretch_min: None, ..soft }),
        coarse_basis: BasisSpacing::Links(2.0),
        cuttable: Some(Cuttable { spare_share: 1.0, ..Cuttable::default() }),
        ..BakeOptions::default()
    };
    let linked = include_bytes!("../../data/cut4.chaincell");
    check("cut4.chaincell", linked, &baked("box:4x4x3x0.01", false, &cut));
    let stiffening = ["0.05=4000", "short:0.1=8000", "long:0.2=20000"];
    let stiffening = stiffening.map(|band| band.parse().unwrap()).to_vec();
    let stiff = cut.tissue.clone().map(|of| Tissue { stiffening, ..of });
    let bands = BakeOptions { tissue: stiff, ..cut.clone() };
    let linked = include_bytes!("../../data/bands4.chaincell");
    check("bands4.chaincell", linked, &baked("box:4x4x3x0.01", false, &bands));
    let links = BakeOptions {
        tissue: None,
        alpha: each(48, |node| node * 7 % 31, 0.002),
        stiffness_n_per_m: each(48, |node| 1 + node * 13 % 17, 5.0),
        ..cut
    };
    let linked = include_bytes!("../../data/links4.chaincell");
    check("links4.chaincell", linked, &baked("box:4x4x3x0.01", false, &links));
}

/// Bands a thousand times as stiff as their tissue: the coarse level is within its range.
#[test]
fn bands_of_any_modulus_are_baked() {
    for modulus_pa in [3e5, 5e7] {
        let soft = Tissue::new(PerCell::Uniform(300.0), PerCell::Uniform(0.3));
        let options = BakeOptions {
            tissue: Some(Tissue { stiffening: vec![Band::new(0.01, modulus_pa)], ..soft }),
            coarse_basis: BasisSpacing::Links(2.0),
            ..BakeOptions::default()
        };
        baked("box:5x3x7x0.1", false, &options);
    }
}

#[test]
fn the_linked_bar_that_tears_is_what_the_bake_gives() {
    let cuttable = Cuttable {
        spare_share: 0.1,
        tear_limit: Some(TearLimit::Stretch(1.2)),
        ..Cuttable::default()
    };
    let tears = BakeOptions {
        tissue: Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.4))),
        coarse_basis: BasisSpacing::None,
        contact_surface: ContactSurface::No,
        cuttable: Some(cuttable),
        ..BakeOptions::default()
    };
    check("tear4.chaincell", TEAR4, &baked("box:4x4x6x0.01", false, &tears));
}

#[test]
fn the_scenes_cover_every_scheme_and_kind_of_body() {
    use chaincell_kernel::{Choice, Model, Scheme};
    for scheme in Scheme::ALL {
        assert!(SCENES.iter().any(|scene| scene.scheme == scheme.name()), "{scheme:?}");
    }
    let models = SCENES.map(|scene| Model::from_bytes(scene.image).unwrap());
    for kind in [false, true] {
        assert!(models.iter().any(|model| model.is_sliced() == kind));
        assert!(models.iter().any(|model| model.is_nodal() == kind));
        assert!(models.iter().any(|model| (model.coarse_functions() > 0) == kind));
        assert!(models.iter().any(|model| (model.alpha() > 0.0) == kind));
        assert!(models.iter().any(|model| (model.alpha_varies() && model.weight_varies()) == kind));
    }
}
