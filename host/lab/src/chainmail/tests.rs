//! What is known of the method, checked on planes, boxes and a generated body.

use chaincell_kernel::Model;
use proptest::prelude::*;

use super::*;
use crate::reference::profile::{in_input_order, middle_row, nonlinearity};
use crate::reference::vectors::farthest;
use chaincell_host::bake::{BakeOptions, bake};
use chaincell_host::engine::rest_m;
use chaincell_host::mesh::{Mesh, MeshOptions, load};

/// A power of two, so that sums of few spacings are exact \[m\].
const SPACING_M: f64 = 1.0 / 128.0;
/// Rounding of sums of coordinates below a metre \[m\].
const ROUNDING_M: f64 = 1e-14;

fn body(spec: &str, diagonals: bool) -> Mesh {
    load(&format!("{spec}x{SPACING_M}"), &MeshOptions { diagonals, ..MeshOptions::default() })
        .unwrap()
}

fn limits(alpha: f64) -> Limits {
    Limits::of_alpha(alpha).unwrap()
}

fn chain(mesh: &Mesh, fixed: &[u32], alpha: f64) -> ChainMail {
    ChainMail::new(&mesh.nodes_m, &mesh.links, fixed, limits(alpha)).unwrap()
}

/// How far a link is outside its bounds \[m\].
fn violation(chain: &ChainMail, limits: &Limits, [i, j]: [usize; 2]) -> f64 {
    let region = limits.region(minus(chain.rest_m()[j], chain.rest_m()[i]));
    let offset = minus(chain.positions_m()[j], chain.positions_m()[i]);
    let out = offset.iter().zip(region).map(|(x, [low, high])| (low - x).max(x - high));
    out.fold(0.0, f64::max)
}

/// Whether an element is within its bounds towards one of its neighbours at least.
fn is_led(chain: &ChainMail, limits: &Limits, element: usize) -> bool {
    let mut neighbours = chain.neighbours[element].iter();
    neighbours.any(|&next| violation(chain, limits, [next as usize, element]) < ROUNDING_M)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// On a free lattice every link is within its bounds, whatever the moves; on any graph an element
    /// that moves is within those towards the one that led there.
    #[test]
    fn a_chain_keeps_its_bounds(
        moves in prop::collection::vec((0_usize..60, prop::array::uniform3(-0.03..0.03)), 1..6),
    ) {
        let mesh = body("box:5x4x3", false);
        let is_along_an_axis = |&[i, j]: &[u32; 2]| {
            let way = minus(mesh.nodes_m[j as usize], mesh.nodes_m[i as usize]);
            way.iter().filter(|x| **x != 0.0).count() == 1
        };
        let links: Vec<[u32; 2]> = mesh.links.iter().copied().filter(is_along_an_axis).collect();
        let mut lattice = ChainMail::new(&mesh.nodes_m, &links, &[], limits(0.2)).unwrap();
        let mut graph = chain(&mesh, &[], 0.2);
        for (element, by) in moves {
            let before = graph.positions_m().to_vec();
            for chain in [&mut lattice, &mut graph] {
                let to = plus(chain.positions_m()[element], 1.0, by);
                chain.move_to(&[(element, to)]).unwrap();
            }
            for ends in &links {
                let off = violation(&lattice, &limits(0.2), ends.map(|end| end as usize));
                prop_assert!(off < ROUNDING_M, "{ends:?}: {off}");
            }
            for e in (0..60).filter(|&e| e != element && graph.positions_m()[e] != before[e]) {
                prop_assert!(is_led(&graph, &limits(0.2), e), "{e}");
            }
        }
    }
}

/// The centre of a plane pulled up to where the fixed border is just reached.
#[test]
fn a_pulled_plane_is_a_linear_pyramid() {
    let mesh = body("plane:21x21", false);
    let depth = 10.0 * 0.25 * SPACING_M;
    let to = [(220, [0.0, 0.0, depth])];
    let mut pulled = chain(&mesh, &mesh.default_fixed, 0.25);
    pulled.move_to(&to).unwrap();
    let down = |p: &[f64; 3]| (p[0].abs() + p[1].abs()) * 0.25;
    let exact: Vec<[f64; 3]> =
        (mesh.nodes_m.iter()).map(|p| [p[0], p[1], (depth - down(p)).max(0.0)]).collect();
    assert!(farthest(pulled.positions_m(), &exact) < ROUNDING_M);
    let profile = middle_row(pulled.positions_m(), [21, 21]).unwrap();
    assert!(nonlinearity(&profile) < 1e-12);
    // Across a diagonal the front comes first where it is slackest: nowhere above the pyramid, and
    // below it here and there.
    let mut diagonal = chain(&body("plane:21x21", true), &mesh.default_fixed, 0.25);
    diagonal.move_to(&to).unwrap();
    let heights = diagonal.positions_m().iter().zip(&exact);
    let below: Vec<f64> = heights.map(|(p, exact)| exact[2] - p[2]).collect();
    assert!(below.iter().all(|&d| d > -ROUNDING_M) && below.iter().any(|&d| d > 0.2 * SPACING_M));
}

/// Relaxation to the rest offsets bends the pyramid: each free height is its neighbours' mean.
#[test]
fn relaxation_bends_the_pyramid() {
    let mesh = body("plane:21x21", false);
    let held = [0.0, 0.0, 10.0 * 0.25 * SPACING_M];
    let mut pulled = chain(&mesh, &mesh.default_fixed, 0.25);
    pulled.move_to(&[(220, held)]).unwrap();
    let mut slack = pulled.clone();
    (0..2000).for_each(|_| pulled.relax(&Limits::RIGID));
    let p = pulled.positions_m();
    for (i, j) in (1..20).flat_map(|i| (1..20).map(move |j| (i, j))) {
        let at = i * 21 + j;
        let mean = [at - 21, at + 21, at - 1, at + 1].map(|n| p[n][2]).iter().sum::<f64>() / 4.0;
        assert!(at == 220 || (p[at][2] - mean).abs() < 1e-12);
    }
    assert_eq!(p[220], held);
    assert!(mesh.default_fixed.iter().all(|&e| p[e as usize] == mesh.nodes_m[e as usize]));
    let bent = nonlinearity(&middle_row(p, [21, 21]).unwrap());
    assert!(bent > 0.2, "{bent}");
    // Within the limits at equilibrium nothing strives anywhere.
    let before = slack.positions_m().to_vec();
    slack.relax(&limits(0.26));
    assert_eq!(slack.positions_m(), before);
}

/// An element that is fixed passes nothing on; the front goes round it.
#[test]
fn the_front_goes_round_a_fixed_element() {
    let mesh = body("plane:5x5", false);
    let mut pulled = chain(&mesh, &[17], 0.25);
    pulled.move_to(&[(12, [0.0, 0.0, 2.0 * SPACING_M])]).unwrap();
    assert!(pulled.positions_m()[4 * 5 + 2][2] > 0.5 * SPACING_M);
    assert_eq!(pulled.positions_m()[17], mesh.nodes_m[17]);
}

/// A model's chain is that of its mesh, its elements in the model's order.
#[test]
fn of_a_model_as_of_its_mesh() {
    let mesh = load("organ:300", &MeshOptions::default()).unwrap();
    let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default()).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let of_mesh = chain(&mesh, &mesh.default_fixed, 0.1);
    let mut of_model = ChainMail::of_model(&model, limits(0.1)).unwrap();
    let cell = (0..model.cells()).find(|&cell| !model.is_fixed(cell as u16)).unwrap();
    of_model.move_to(&[(cell, plus(rest_m(&model, cell), 1.0, [0.0, 0.0, 0.01]))]).unwrap();
    let pairs = of_model.positions_m().iter().zip(of_model.rest_m());
    let moved: Vec<usize> =
        (0..).zip(pairs).filter(|(_, (at, rest))| at != rest).map(|(e, _)| e).collect();
    assert!(moved.len() > 20);
    assert!(moved.iter().all(|&e| e == cell || is_led(&of_model, &limits(0.1), e)));
    let rest = in_input_order(&model, of_model.rest_m());
    assert!(farthest(&rest, of_mesh.rest_m()) < 1e-7);
}

#[test]
fn bad_input_is_refused() {
    for [low, high, shear] in [[1.1, 1.2, 0.0], [0.9, 0.9, 0.0], [0.9, 1.1, -0.1]] {
        assert!(Limits::new(low, high, shear).is_err());
    }
    assert!(Limits::of_alpha(1.0).is_err() && Limits::of_alpha(f64::NAN).is_err());
    let mesh = body("plane:3x3", false);
    assert!(ChainMail::new(&mesh.nodes_m, &[[0, 9]], &[], limits(0.1)).is_err());
    assert!(ChainMail::new(&mesh.nodes_m, &mesh.links, &[9], limits(0.1)).is_err());
    let mut chain = chain(&mesh, &[0], 0.1);
    for (element, position, name) in
        [(9, [0.0; 3], "has 9 elements"), (0, [0.0; 3], "is fixed"), (4, [f64::NAN; 3], "finite")]
    {
        let text = chain.move_to(&[(element, position)]).unwrap_err().to_string();
        assert!(text.contains(name), "{text}");
    }
    assert_eq!(chain.positions_m(), mesh.nodes_m);
}

/// A ball pressed into a box, as `tests/view/chainmail.json` has it: the page of `chaincell view` has the method in
/// JavaScript, and `tests/view/chainmail.mjs` comes to the same positions.
#[test]
fn the_page_compares_itself_with_this_press() {
    let press: serde_json::Value =
        serde_json::from_str(include_str!("../../../../tests/view/chainmail.json")).unwrap();
    let places =
        |name: &str| -> Vec<[f64; 3]> { serde_json::from_value(press[name].clone()).unwrap() };
    let links: Vec<[u32; 2]> = serde_json::from_value(press["links"].clone()).unwrap();
    let fixed: Vec<u32> = serde_json::from_value(press["fixed"].clone()).unwrap();
    let triangles: Vec<[u32; 3]> = serde_json::from_value(press["triangles"].clone()).unwrap();
    let [alpha, radius_m] = ["alpha", "radius_m"].map(|name| press[name].as_f64().unwrap());
    let mut surface = triangles.as_flattened().to_vec();
    surface.retain(|element| !fixed.contains(element));
    surface.sort_unstable();
    surface.dedup();
    let limits = Limits::of_alpha(alpha).unwrap();
    let mut pressed = ChainMail::new(&places("rest_m"), &links, &fixed, limits).unwrap();
    for centre in places("path_m") {
        let inside = surface.iter().filter_map(|&element| {
            let off = minus(pressed.positions_m()[element as usize], centre);
            let scale = radius_m / off.iter().map(|x| x * x).sum::<f64>().sqrt();
            (scale > 1.0).then(|| (element as usize, plus(centre, scale, off)))
        });
        let held: Vec<_> = inside.collect();
        if !held.is_empty() {
            pressed.move_to(&held).unwrap();
        }
    }
    assert!(farthest(pressed.positions_m(), &places("held_m")) < 1e-12);
    (0..8).for_each(|_| pressed.relax(&Limits::RIGID));
    assert!(farthest(pressed.positions_m(), &places("relaxed_m")) < 1e-12);
}
