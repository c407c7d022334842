//! Bodies that can be cut: what their image holds, what is refused, and that they behave like others until then.
#![allow(clippy::unwrap_used)]

use std::sync::OnceLock;

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, Cuttable, ImageBytes, PerCell, bake};
use chaincell_host::engine::{Contact, Engine, Scheme, contact};
use chaincell_host::files::output::vtu;
use chaincell_host::mesh::{MeshOptions, load};
use chaincell_kernel::image::{cutting, kind, nodal};
use chaincell_kernel::{Choice, Model, ModelError, Network, TearLimit, ToolPose, cut_words};
use chaincell_tests::files::{scratch, text};
use chaincell_tests::forge::Forged;
use chaincell_tests::run;

const CELLS: usize = 5 * 5 * 4;
/// A tenth of the cells.
const SPARE: usize = 10;

fn options() -> BakeOptions {
    BakeOptions {
        tissue: Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45))),
        coarse_basis: BasisSpacing::Links(2.5),
        ..BakeOptions::default()
    }
}

fn baked(options: &BakeOptions) -> ImageBytes {
    let mesh = load("box:5x5x4x0.01", &Default::default()).unwrap();
    bake(&mesh, &mesh.default_fixed, options).unwrap()
}

fn plain() -> &'static ImageBytes {
    static IMAGE: OnceLock<ImageBytes> = OnceLock::new();
    IMAGE.get_or_init(|| baked(&options()))
}

fn cuttable() -> &'static ImageBytes {
    static IMAGE: OnceLock<ImageBytes> = OnceLock::new();
    IMAGE.get_or_init(|| baked(&BakeOptions { cuttable: Some(Cuttable::default()), ..options() }))
}

fn model(image: &ImageBytes) -> Model<'_> {
    Model::from_bytes(image.as_bytes()).unwrap()
}

#[test]
fn the_last_cells_are_spare_and_the_others_are_those_of_a_plain_body() {
    let (plain, cuttable) = (model(plain()), model(cuttable()));
    assert_eq!((plain.cells(), plain.body_cells(), plain.spare_cells()), (CELLS, CELLS, 0));
    assert_eq!((cuttable.cells(), cuttable.body_cells()), (CELLS + SPARE, CELLS));
    assert_eq!((cuttable.spare_cells(), cuttable.tetrahedra_to_cut()), (SPARE, 4 * 4 * 3 * 5));
    assert_eq!(cuttable.toughness_j_per_m2(), Some(160.0));
    assert_eq!((plain.tetrahedra_to_cut(), plain.toughness_j_per_m2()), (0, None));
    assert_eq!((cuttable.input_id(), cuttable.links()), (plain.input_id(), plain.links()));
    for cell in 0..CELLS {
        assert_eq!(cuttable.rest_position(cell), plain.rest_position(cell));
        assert_eq!(cuttable.elasticity(cell), plain.elasticity(cell));
        // The bound by tetrahedra is above the sum of the row, by 2 to 6 times in this box.
        let times = cuttable.cell_bound(cell) / plain.cell_bound(cell);
        assert!((1.2..8.0).contains(&times), "{cell}: {times}");
    }
    for cell in CELLS..CELLS + SPARE {
        assert_eq!((cuttable.rest_position(cell), cuttable.elasticity(cell)), ([0.0; 3], None));
        assert_eq!(cuttable.neighbours(cell).count(), 0);
    }
}

/// The bound is that of the tetrahedra taken one by one, so that it holds however they are joined.
#[test]
fn the_bound_is_the_sum_over_the_tetrahedra() {
    let stress = |model: &Model<'_>| {
        let [young, poisson] = model.elasticity(0).unwrap().map(f64::from);
        let mu = 0.5 * young / (1.0 + poisson);
        let unit_pa = 2.0 * f64::from(model.stiffness_n_per_m() / model.unit_m());
        (2.0 * mu + 6.0 * mu * poisson / (1.0 - 2.0 * poisson) + 8.0 * mu) / unit_pa
    };
    let model = model(cuttable());
    let weight = stress(&model);
    let rest: Vec<_> = (0..CELLS).map(|cell| model.rest_position(cell).map(f64::from)).collect();
    let mut sums = vec![0.0; CELLS];
    for corners in model.tetrahedra() {
        let (volume, gradients) =
            chaincell_host::bake::tissue::shape::element(&rest, corners.map(u32::from)).unwrap();
        for (&cell, one) in corners.iter().zip(&gradients) {
            for other in &gradients {
                let product: f64 = one.iter().zip(other).map(|(a, b)| a * b).sum();
                sums[usize::from(cell)] += weight * volume * product.abs();
            }
        }
    }
    for (cell, sum) in sums.iter().enumerate() {
        let bound = f64::from(model.cell_bound(cell));
        assert!((bound / sum - 1.0).abs() < 1e-4, "{cell}: {bound} {sum}");
    }
}

#[test]
fn what_cannot_be_cut_is_refused_by_name() {
    let mesh = load("box:5x5x4x0.01", &Default::default()).unwrap();
    let of = |cuttable: Cuttable| BakeOptions { cuttable: Some(cuttable), ..options() };
    let given = Cuttable::default();
    let links = BakeOptions { tissue: None, ..of(given.clone()) };
    let lean = BakeOptions { lean: true, ..links.clone() };
    let grouped = BakeOptions { cells: Some(20), ..links.clone() };
    let tough = |toughness_j_per_m2| of(Cuttable { toughness_j_per_m2, ..given.clone() });
    let mut one_bad = vec![160.0; CELLS];
    one_bad[7] = 1e7;
    for (options, parts) in [
        (lean, ["`lean` with `cuttable`", "leave one out"]),
        (grouped, ["`cells` with `cuttable`", "leave one out"]),
        (tough(PerCell::Uniform(0.0)), ["`toughness_j_per_m2` 0", "0.01 to"]),
        (tough(PerCell::Uniform(f64::NAN)), ["`toughness", "0.01 to 1e6"]),
        (tough(PerCell::Each(one_bad)), ["`toughness_j_per_m2`: value 10000000 of node 7", "1e6"]),
        (
            tough(PerCell::Each(vec![1.0])),
            ["`toughness_j_per_m2`: 1 values for 100 nodes", "one per"],
        ),
        (of(Cuttable { spare_share: -0.1, ..given.clone() }), ["`cut_spare` -0.1", "from 0 to 4"]),
        (
            of(Cuttable { tear_limit: Some(TearLimit::Stretch(1.0)), ..given.clone() }),
            ["`tear_stretch` 1", "from 1.01 to 10"],
        ),
    ] {
        let why = bake(&mesh, &mesh.default_fixed, &options).unwrap_err().to_string();
        assert!(parts.iter().all(|part| why.contains(part)), "{why}");
    }
    // Links are those of tetrahedra.
    for (mesh, parts) in [
        (load("plane:5x5x0.01", &MeshOptions::default()), ["`cuttable`", "no tetrahedra"]),
        (
            load("box:5x5x4x0.01", &MeshOptions { rings: 2, ..MeshOptions::default() }),
            ["`cuttable`: the link of nodes", "leave `rings`"],
        ),
    ] {
        let mesh = mesh.unwrap();
        let why = bake(&mesh, &mesh.default_fixed, &links).unwrap_err().to_string();
        assert!(parts.iter().all(|part| why.contains(part)), "{why}");
    }
}

/// Fixed point and the laws without sweeps name the ones that a body of links to be cut moves under.
#[test]
fn links_to_be_cut_move_under_two_laws() {
    let links = BakeOptions { tissue: None, cuttable: Some(Cuttable::default()), ..options() };
    let image = baked(&links);
    let model = model(&image);
    let held = contact::automatic(&model).unwrap();
    for &scheme in Scheme::ALL {
        let network = Network::new(model, scheme.settings(&model, 4)).unwrap();
        let engine = Engine::new(network, scheme, &held);
        match scheme {
            Scheme::Track | Scheme::Predict => assert!(engine.is_ok()),
            _ => {
                let why = engine.err().unwrap().to_string();
                assert!(why.contains("`scheme`") && why.contains("track or predict"), "{why}");
            }
        }
    }
}

/// A link that no tetrahedron has is refused in an image of links.
// REQ-MOD-02
#[test]
fn errors_name_what_is_wrong_with_links_to_be_cut() {
    let image =
        baked(&BakeOptions { tissue: None, cuttable: Some(Cuttable::default()), ..options() });
    let error = |change: &dyn Fn(&mut Forged)| {
        let mut forged = Forged::of(image.as_bytes());
        change(&mut forged);
        Model::from_bytes(forged.sealed().as_bytes()).unwrap_err()
    };
    assert!(model(&image).elasticity(0).is_none() && model(&image).spare_cells() == SPARE);
    // Without a tetrahedron that alone has an edge.
    let whole: Vec<[u16; 4]> = Forged::of(image.as_bytes()).get(kind::CUT_CORNERS);
    let count = |of: &[u16]| whole.iter().filter(|at| of.iter().all(|id| at.contains(id))).count();
    let alone = |at: &[u16; 4]| {
        let mut ends = at.iter().flat_map(|&one| at.iter().map(move |&other| [one, other]));
        at.iter().all(|&id| count(&[id]) > 1) && ends.any(|ends| count(&ends) == 1)
    };
    let gone = whole.iter().position(alone).unwrap();
    let mut fewer = whole.clone();
    fewer.remove(gone);
    let cells = model(&image).cells();
    let (mut rows, mut stars) = (vec![0], Vec::new());
    for cell in 0..cells {
        let here = (0_u32..).zip(&fewer).filter(|(_, at)| at.contains(&(cell as u16)));
        stars.extend(here.map(|(number, _)| number));
        rows.push(stars.len() as u32);
    }
    let lost = error(&|image| {
        image.change(kind::CUT_CORNERS, |of: &mut Vec<[u16; 4]>| of.clone_from(&fewer));
        image.change(kind::CUT_STAR_ROWS, |of: &mut Vec<u32>| of.clone_from(&rows));
        image.change(kind::CUT_STARS, |of: &mut Vec<u32>| of.clone_from(&stars));
    });
    assert!(matches!(lost, ModelError::Index(kind::UPPER, _)), "{lost:?}");
}

fn error(change: impl FnOnce(&mut Forged)) -> ModelError {
    let mut forged = Forged::of(cuttable().as_bytes());
    change(&mut forged);
    Model::from_bytes(forged.sealed().as_bytes()).unwrap_err()
}

// REQ-MOD-02
#[test]
fn errors_name_what_is_wrong_with_a_body_to_be_cut() {
    let word = |word: usize, value: u32| {
        error(|image| image.change(kind::CUTTING, |of: &mut Vec<u32>| of[word] = value))
    };
    assert_eq!(word(cutting::VERSION, 3), ModelError::SectionVersion(kind::CUTTING));
    // A body that tears has two words more.
    assert_eq!(word(cutting::VERSION, 2), ModelError::SectionSize(kind::CUTTING));
    for toughness in [0.0, -1.0, 1.0e-3, 2.0e6, f32::NAN, f32::INFINITY] {
        let why = word(cutting::TOUGHNESS_J_PER_M2, toughness.to_bits());
        assert_eq!(why, ModelError::Value(kind::CUTTING, 3), "{toughness}");
    }
    assert_eq!(word(cutting::SPARE_GROUPS, u32::MAX), ModelError::Value(kind::CUTTING, 2));
    assert_eq!(word(cutting::SPARE_CELLS, u32::MAX), ModelError::Value(kind::CUTTING, 1));
    // A spare cell more than there are input ids left out.
    let more = word(cutting::SPARE_CELLS, SPARE as u32 + 1);
    assert_eq!(more, ModelError::SectionSize(kind::INPUT_ID));
    let long = error(|image| image.change(kind::CUTTING, |of: &mut Vec<u32>| of.push(0)));
    assert_eq!(long, ModelError::SectionSize(kind::CUTTING));
    // Corners: a spare cell, one twice, two swapped, and two tetrahedra with each other's.
    let corners = |change: fn(&mut Vec<[u16; 4]>)| {
        error(|image| image.change(kind::CUT_CORNERS, |of: &mut Vec<[u16; 4]>| change(of)))
    };
    let named = ModelError::Index(kind::CUT_CORNERS, 3);
    assert_eq!(corners(|of| of[3][1] = CELLS as u16), named);
    assert_eq!(corners(|of| of[3][1] = u16::MAX), named);
    assert_eq!(corners(|of| of[3][2] = of[3][0]), named);
    assert_eq!(corners(|of| of[3].swap(0, 1)), ModelError::Value(kind::CUT_CORNERS, 3));
    assert!(matches!(corners(|of| of.swap(3, 100)), ModelError::Index(kind::CUT_STARS, _)));
    assert_eq!(corners(|of| of.truncate(20)), ModelError::SectionSize(kind::CUT_STARS));
    assert_eq!(corners(Vec::clear), ModelError::SectionSize(kind::CUT_STARS));
    // Stars: their starts and their order.
    let rows = |at: usize, value: u32| {
        error(|image| image.change(kind::CUT_STAR_ROWS, |of: &mut Vec<u32>| of[at] = value))
    };
    assert_eq!(rows(0, 1), ModelError::Index(kind::CUT_STAR_ROWS, 0));
    assert_eq!(rows(2, u32::MAX), ModelError::Index(kind::CUT_STAR_ROWS, 3));
    let last = CELLS + SPARE;
    assert_eq!(rows(last, 0), ModelError::Index(kind::CUT_STAR_ROWS, last as u32));
    let stars = |change: fn(&mut Vec<u32>)| {
        error(|image| image.change(kind::CUT_STARS, |of: &mut Vec<u32>| change(of)))
    };
    assert_eq!(stars(|of| of[1] = of[0]), ModelError::Index(kind::CUT_STARS, 1));
    assert_eq!(stars(|of| of[0] = u32::MAX), ModelError::Index(kind::CUT_STARS, 0));
    assert_eq!(stars(|of| _ = of.pop()), ModelError::SectionSize(kind::CUT_STARS));
}

// REQ-MOD-02
#[test]
fn spare_cells_that_are_not_dormant_are_refused() {
    let spare = CELLS as u32;
    let rest = error(|image| {
        image.change(kind::REST, |of: &mut Vec<[f32; 3]>| of[CELLS][1] = 0.5);
    });
    assert_eq!(rest, ModelError::Value(kind::REST, spare));
    let moving = error(|image| {
        image.change(kind::MOBILITY, |of: &mut Vec<f32>| of[CELLS] = 1.0 / nodal::MU_MIN);
    });
    assert_eq!(moving, ModelError::Value(kind::MOBILITY, spare));
    for (row, value) in [(nodal::VOLUME, 0.5), (nodal::MU, 1.0), (nodal::LAMBDA_3, 1.0)] {
        let why = error(|image| {
            image.change(kind::NODAL_CELLS, |of: &mut Vec<[[f32; 8]; nodal::CELL_ROWS]>| {
                of[CELLS / 8][row][CELLS % 8] = value;
            });
        });
        assert_eq!(why, ModelError::Value(kind::NODAL_CELLS, spare), "{row}");
    }
    for kind in [kind::FIXED, kind::SURFACE, kind::TRIANGLES, kind::TETRAHEDRA] {
        let mut place = 0;
        let why = error(|image| {
            image.change(kind, |of: &mut Vec<u16>| {
                place = of.len() - 1;
                of[place] = CELLS as u16;
            });
        });
        assert_eq!(why, ModelError::Index(kind, place as u32));
    }
}

/// Force of a press of 4 mm that then holds still, with these sweeps [N].
fn force_n(image: &ImageBytes, contact: Contact, sweeps: u16) -> [f32; 3] {
    let model = model(image);
    let network = Network::new(model, Scheme::Predict.settings(&model, sweeps)).unwrap();
    let touch_m = [0.0, 0.0, 0.03 + contact.radius_m().unwrap_or(0.0)];
    let mut engine =
        Engine::with_contact(network, Scheme::Predict, Default::default(), contact).unwrap();
    let mut force = [0.0; 3];
    for tick in 0..160_u16 {
        let depth_m = 5.0e-5 * f32::from(tick.min(80));
        let place = [touch_m[0], touch_m[1], touch_m[2] - depth_m];
        force = engine.tick(&ToolPose::at(place.into(), 1)).force_n.into();
    }
    force
}

#[test]
fn a_body_that_is_not_cut_pushes_back_like_a_plain_one() {
    let held = || Contact::Cells(contact::automatic(&model(plain())).unwrap());
    for contact in [held, || Contact::sphere(0.015, 0.0)] as [fn() -> Contact; 2] {
        let [wanted, force] = [plain(), cuttable()].map(|image| force_n(image, contact(), 64));
        let size = wanted.map(|x| x * x).iter().sum::<f32>().sqrt();
        assert!(size > 0.02, "{wanted:?}");
        for (wanted, force) in wanted.iter().zip(force) {
            assert!((force - wanted).abs() < 1.0e-3 * size, "{force} {wanted} of {size}");
        }
    }
}

#[test]
fn spare_cells_are_not_shown_and_not_held() {
    let model = model(cuttable());
    let network = Network::new(model, Scheme::Predict.settings(&model, 4)).unwrap();
    let spare = vec![CELLS as u16];
    assert!(Engine::new(network, Scheme::Predict, &spare).is_err());
    let held = contact::automatic(&model).unwrap();
    assert_eq!(held, contact::automatic(&Model::from_bytes(plain().as_bytes()).unwrap()).unwrap());
    let mut engine = Engine::new(network, Scheme::Predict, &held).unwrap();
    let nodes = engine.nodes();
    assert_eq!((nodes.ids.len(), nodes.positions_m.len()), (CELLS, CELLS));
    assert_eq!((engine.node_count(), engine.positions().len()), (CELLS, CELLS + SPARE));
    let text = vtu(&mut engine, &nodes);
    assert!(text.contains(&format!("NumberOfPoints=\"{CELLS}\"")), "{}", &text[..300]);
}

#[test]
fn the_command_bakes_it_and_info_says_what_it_costs() {
    let folder = scratch();
    let file = folder.path().join("model.chaincell");
    let bake = |options: &[&str]| {
        run([&["bake", "box:5x5x4x0.01", "-o", text(&file), "--json"], options].concat())
    };
    let tissue = ["--young-pa", "5000"];
    let plain = bake(&tissue).with(0).json();
    assert_eq!(plain.get("cutting"), None);
    let more = ["--cuttable", "--toughness-j-per-m2", "80", "--cut-spare", "0.25"];
    let report = bake(&[&tissue[..], &more].concat()).with(0).json();
    let cutting = &report["cutting"];
    assert_eq!(report["cells"], CELLS);
    assert_eq!(report["mean_link_m"], plain["mean_link_m"]);
    assert_eq!(report["bounding_box_m"], plain["bounding_box_m"]);
    assert_eq!((&cutting["tetrahedra"], &cutting["spare_cells"]), (&240.into(), &25.into()));
    assert_eq!(cutting["toughness_j_per_m2"], 80.0);
    let image = ImageBytes::copy(&std::fs::read(&file).unwrap());
    assert_eq!(cutting["ram_bytes"], 4 * cut_words(&model(&image)));
    // The image is longer by that, but for the table, and slots and padding of the slices.
    let grown = report["image_bytes"].as_f64().unwrap() - plain["image_bytes"].as_f64().unwrap();
    let said = cutting["image_bytes"].as_f64().unwrap();
    assert!((grown / said - 1.0).abs() < 0.1, "{grown} {said}");
    let said = run(["info", text(&file)]).with(0).out;
    assert!(said.contains("240 tetrahedra at 80 J/m^2, 25 spare cells"), "{said}");
    // A body of links, which tears too.
    let report = bake(&["--cuttable", "--tears"]).with(0).json();
    assert_eq!(report["cutting"]["tetrahedra"], 240);
    assert_eq!(report["cutting"]["tears"], "toughness");
    // Options that need each other.
    for option in [["--toughness-j-per-m2", "80"], ["--cut-spare", "0.1"]] {
        let why = bake(&[&tissue[..], &option].concat()).with(2).err;
        assert!(why.contains("--cuttable"), "{why}");
    }
}

/// A body that tears differs from one that does not by the version and two words more.
#[test]
fn a_limit_of_tears_is_two_words_more() {
    let plain = Forged::of(cuttable().as_bytes());
    let before: Vec<u32> = plain.get(kind::CUTTING);
    assert_eq!((before.len(), before[cutting::VERSION]), (cutting::WORDS, 1));
    assert_eq!(model(cuttable()).tear_limit(), None);
    for (limit, added) in [
        (TearLimit::Toughness, [cutting::BY_TOUGHNESS, 0]),
        (TearLimit::Stretch(1.5), [cutting::BY_STRETCH, 1.5_f32.to_bits()]),
    ] {
        let given = Cuttable { tear_limit: Some(limit), ..Cuttable::default() };
        let image = baked(&BakeOptions { cuttable: Some(given), ..options() });
        assert_eq!(model(&image).tear_limit(), Some(limit));
        let mut forged = Forged::of(image.as_bytes());
        let words: Vec<u32> = forged.get(kind::CUTTING);
        assert_eq!((words[0], &words[1..4], &words[4..]), (2, &before[1..], &added[..]));
        forged.change(kind::CUTTING, |of: &mut Vec<u32>| of.clone_from(&before));
        assert_eq!(forged.sealed().as_bytes(), plain.sealed().as_bytes());
        // Bad words of the limit.
        for (word, value) in [
            (cutting::TEAR_RULE, 0),
            (cutting::TEAR_RULE, 3),
            (cutting::TEAR_STRETCH, 1.0_f32.to_bits()),
            (cutting::TEAR_STRETCH, f32::NAN.to_bits()),
            (cutting::TEAR_STRETCH, 10.5_f32.to_bits()),
        ] {
            let mut bad = Forged::of(image.as_bytes());
            bad.change(kind::CUTTING, |of: &mut Vec<u32>| of[word] = value);
            let why = Model::from_bytes(bad.sealed().as_bytes()).unwrap_err();
            assert_eq!(why, ModelError::Value(kind::CUTTING, word as u32), "{limit:?} {value}");
        }
    }
}

/// Toughness of the nodes of the box, half of it tough.
fn halves() -> Vec<f64> {
    (0..CELLS).map(|node| if node < CELLS / 2 { 2.0 } else { 8.0 }).collect()
}

fn of_toughness(toughness_j_per_m2: PerCell) -> ImageBytes {
    let given = Cuttable { toughness_j_per_m2, ..Cuttable::default() };
    baked(&BakeOptions { cuttable: Some(given), ..options() })
}

/// Cells of one toughness have the image of a body that was given one; others a section more.
#[test]
fn a_toughness_of_each_cell_is_a_section_more() {
    let uniform = of_toughness(PerCell::Uniform(8.0));
    let each = of_toughness(PerCell::Each(vec![8.0; CELLS]));
    assert_eq!(each.as_bytes(), uniform.as_bytes());
    assert_eq!(model(&uniform).cell_toughness_j_per_m2(0), Some(8.0));
    let halves = halves();
    let image = of_toughness(PerCell::Each(halves.clone()));
    let read = model(&image);
    assert_eq!(read.toughness_j_per_m2(), Some(8.0));
    for cell in 0..CELLS {
        let wanted = halves[read.input_id()[cell] as usize] as f32;
        assert_eq!(read.cell_toughness_j_per_m2(cell), Some(wanted), "{cell}");
    }
    assert_eq!(read.cell_toughness_j_per_m2(CELLS), None);
    assert_eq!(model(plain()).cell_toughness_j_per_m2(0), None);
    // All else is as in the body of the largest.
    let mut forged = Forged::of(image.as_bytes());
    forged.remove(kind::CUT_TOUGHNESS);
    assert_eq!(forged.sealed().as_bytes(), Forged::of(uniform.as_bytes()).sealed().as_bytes());
    // The sum of the work takes two words.
    assert_eq!(cut_words(&read), cut_words(&model(&uniform)) + 2);
}

// REQ-MOD-02
#[test]
fn errors_name_a_bad_toughness_of_a_cell() {
    let image = of_toughness(PerCell::Each(halves()));
    let error = |kind: u32, change: &dyn Fn(&mut Vec<f32>)| {
        let mut forged = Forged::of(image.as_bytes());
        forged.change(kind, |of: &mut Vec<f32>| change(of));
        Model::from_bytes(forged.sealed().as_bytes()).unwrap_err()
    };
    for toughness in [0.0, -1.0, 1.0e-3, 2.0e6, f32::NAN, f32::INFINITY] {
        let why = error(kind::CUT_TOUGHNESS, &|of| of[5] = toughness);
        assert_eq!(why, ModelError::Value(kind::CUT_TOUGHNESS, 5), "{toughness}");
    }
    for count in [CELLS - 1, CELLS + 1, CELLS + SPARE] {
        let why = error(kind::CUT_TOUGHNESS, &|of| of.resize(count, 2.0));
        assert_eq!(why, ModelError::SectionSize(kind::CUT_TOUGHNESS), "{count}");
    }
    // That of the body is the largest.
    let word = cutting::TOUGHNESS_J_PER_M2;
    for (kind, at, toughness) in
        [(kind::CUTTING, word, 7.0), (kind::CUTTING, word, 9.0), (kind::CUT_TOUGHNESS, 5, 9.0)]
    {
        let why = error(kind, &|of| of[at] = toughness);
        assert_eq!(why, ModelError::Value(kind::CUTTING, word as u32), "{toughness}");
    }
}

#[test]
fn the_command_takes_a_toughness_of_nodes_and_of_groups() {
    let folder = scratch();
    let file = folder.path().join("model.chaincell");
    let bake = |mesh: &str, options: &[&str]| {
        run([&["bake", mesh, "-o", text(&file), "--json"], options].concat())
    };
    let values = folder.path().join("toughness.txt");
    let lines: Vec<String> = halves().iter().map(f64::to_string).collect();
    std::fs::write(&values, lines.join("\n")).unwrap();
    let from_file = format!("file:{}", text(&values));
    let tissue = ["--young-pa", "5000", "--cuttable", "--toughness-j-per-m2"];
    let report = bake("box:5x5x4x0.01", &[&tissue[..], &[&from_file]].concat()).with(0).json();
    let range = |report: &serde_json::Value| {
        let of = |name: &str| report["cutting"][name].as_f64();
        [of("toughness_min_j_per_m2"), of("toughness_j_per_m2")]
    };
    assert_eq!(range(&report), [Some(2.0), Some(8.0)]);
    let said = run(["info", text(&file)]).with(0).out;
    assert!(said.contains("240 tetrahedra at 2 to 8 J/m^2, 10 spare cells"), "{said}");
    let image = ImageBytes::copy(&std::fs::read(&file).unwrap());
    assert_eq!(report["cutting"]["ram_bytes"], 4 * cut_words(&model(&image)));
    // Groups, of shapes and of links, by the option and by the material.
    let mesh = super::readers::data("box.msh41.ascii.msh");
    let grouped = |options: &[&str]| bake(text(&mesh), &[&["--cuttable"], options].concat());
    let bytes = || std::fs::read(&file).unwrap();
    let shapes = ["--young-pa", "5000"];
    let by_option = ["--toughness-j-per-m2", "100,group:held below=300"];
    let report = grouped(&[&shapes[..], &by_option].concat()).with(0).json();
    assert_eq!(range(&report), [Some(100.0), Some(300.0)]);
    let first = bytes();
    let by_material = "group:held below,toughness-j-per-m2=300";
    let by_material = ["--toughness-j-per-m2", "100", "--material", by_material];
    grouped(&[&shapes[..], &by_material].concat()).with(0);
    assert!(bytes() == first);
    assert_eq!(range(&grouped(&by_option).with(0).json()), [Some(100.0), Some(300.0)]);
    // The tissue's, but in the group.
    let tissue = ["--tissue", "liver", "--material", "group:held below,toughness-j-per-m2=300"];
    assert_eq!(range(&grouped(&tissue).with(0).json()), [Some(164.0), Some(300.0)]);
    let of_one = grouped(&["--tissue", "liver"]).with(0).json();
    assert_eq!(range(&of_one), [None, Some(164.0)]);
    // Refusals name the option.
    for (options, parts) in [
        (
            &["--young-pa", "5000", "--toughness-j-per-m2", "100,group:front=1"][..],
            ["--toughness-j-per-m2: the mesh has no group 'front'", "held below"],
        ),
        (
            &["--young-pa", "5000", "--material", "group:held below,toughness-j-per-m2=1e9"],
            ["--toughness-j-per-m2: value 1000000000 of node", "from 0.01 to 1e6"],
        ),
    ] {
        let why = grouped(options).with(2).err;
        assert!(parts.iter().all(|part| why.contains(part)), "{why}");
    }
    let whole = [&shapes[..], &["--material", "group:held below,toughness-j-per-m2=300"]].concat();
    let why = bake(text(&mesh), &whole).with(2).err;
    assert!(
        why.contains("--material group:held below: toughness-j-per-m2")
            && why.contains("--cuttable")
    );
}
