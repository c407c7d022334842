//! What is known of the method, checked on planes, boxes and a generated body.

use chaincell_kernel::Model;
use proptest::prelude::*;

use super::*;
use crate::reference::profile::{in_input_order, middle_row, nonlinearity};
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

fn lattice(mesh: &Mesh, nodes: [usize; 3], fixed: &[u32], alpha: f64) -> Lattice {
    Lattice::new(nodes, &mesh.nodes_m, fixed, limits(alpha)).unwrap()
}

fn graph(mesh: &Mesh, fixed: &[u32], alpha: f64) -> Graph {
    Graph::new(&mesh.nodes_m, &mesh.links, fixed, limits(alpha)).unwrap()
}

fn plus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| a[axis] + b[axis])
}

/// How far a link is outside its bounds \[m\].
fn violation(chain: &impl Chain, limits: &Limits, [i, j]: [usize; 2]) -> f64 {
    let apart = |p: &[[f64; 3]]| std::array::from_fn(|axis| p[j][axis] - p[i][axis]);
    let region = limits.region(apart(chain.elements().rest_m()));
    let offset: [f64; 3] = apart(chain.elements().positions_m());
    let out = offset.iter().zip(region).map(|(x, [low, high])| (low - x).max(x - high));
    out.fold(0.0, f64::max)
}

fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let cells = a.iter().zip(b).flat_map(|(a, b)| (0..3).map(move |x| (a[x] - b[x]).abs()));
    cells.fold(0.0, f64::max)
}

/// One random move: cost and sponsors are what the positions tell.
fn moves_as_it_says(chain: &mut impl Chain, limits: &Limits, element: usize, by: [f64; 3]) {
    let before = chain.elements().positions_m().to_vec();
    let cost = chain.move_to(&[(element, plus(before[element], by))]).unwrap();
    let elements = chain.elements();
    let moved = (0..before.len()).filter(|&e| elements.positions_m()[e] != before[e]);
    assert_eq!(moved.filter(|&e| e != element).count(), cost.moved);
    let led = (0..before.len()).filter_map(|e| Some([elements.sponsor(e)?, e]));
    let led: Vec<[usize; 2]> = led.collect();
    assert_eq!(led.len(), cost.visited, "each element at most once");
    for link in led {
        assert!(violation(chain, limits, link) < ROUNDING_M, "{link:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// After any moves of a free lattice every link is within its bounds, and the front came the
    /// way of the six lists: along z first, then x, then y.
    #[test]
    fn a_lattice_keeps_all_its_bounds(
        moves in prop::collection::vec((0_usize..60, prop::array::uniform3(-0.03..0.03)), 1..6),
    ) {
        let mesh = body("box:5x4x3", false);
        let mut chain = lattice(&mesh, [5, 4, 3], &[], 0.2);
        let place = |e: usize| [e / 12, e / 3 % 4, e % 3];
        for (element, by) in moves {
            moves_as_it_says(&mut chain, &limits(0.2), element, by);
            for (e, stride) in (0..60).flat_map(|e| [12, 3, 1].map(|stride| (e, stride))) {
                let (a, b) = (place(e), place((e + stride) % 60));
                if (0..3).map(|axis| a[axis].abs_diff(b[axis])).sum::<usize>() == 1 {
                    let off = violation(&chain, &limits(0.2), [e, e + stride]);
                    prop_assert!(off < ROUNDING_M, "{e} {stride}: {off}");
                }
            }
            for e in 0..60 {
                let Some(sponsor) = chain.elements().sponsor(e) else { continue };
                let (here, from, start) = (place(e), place(sponsor), place(element));
                let axis = [1, 0, 2].into_iter().find(|&axis| here[axis] != start[axis]).unwrap();
                prop_assert!(here[axis] != from[axis], "{here:?} by {from:?} from {start:?}");
            }
        }
    }

    /// On a graph a moved element is within its bounds towards the element that led there.
    #[test]
    fn a_graph_keeps_the_bounds_towards_its_sponsors(
        moves in prop::collection::vec((0_usize..60, prop::array::uniform3(-0.03..0.03)), 1..6),
    ) {
        let mesh = body("box:5x4x3", false);
        let mut chain = graph(&mesh, &[], 0.2);
        for (element, by) in moves {
            moves_as_it_says(&mut chain, &limits(0.2), element, by);
        }
    }
}

/// The centre of a plane pulled up to where the fixed border is just reached.
#[test]
fn a_pulled_plane_is_a_linear_pyramid() {
    let mesh = body("plane:21x21", false);
    let depth = 10.0 * 0.25 * SPACING_M;
    let to = [(220, [0.0, 0.0, depth])];
    let mut by_lists = lattice(&mesh, [21, 21, 1], &mesh.default_fixed, 0.25);
    let mut by_front = graph(&mesh, &mesh.default_fixed, 0.25);
    let costs = [by_lists.move_to(&to), by_front.move_to(&to)];
    let down = |p: &[f64; 3]| (p[0].abs() + p[1].abs()) * 0.25;
    let exact: Vec<[f64; 3]> =
        (mesh.nodes_m.iter()).map(|p| [p[0], p[1], (depth - down(p)).max(0.0)]).collect();
    let moved = exact.iter().filter(|p| p[2] > 0.0).count() - 1;
    for (chain, cost) in [by_lists.elements(), by_front.elements()].into_iter().zip(costs) {
        assert!(farthest(chain.positions_m(), &exact) < ROUNDING_M);
        let profile = middle_row(chain.positions_m(), [21, 21]).unwrap();
        assert!(nonlinearity(&profile) < 1e-12);
        assert_eq!(cost.unwrap().moved, moved);
    }
    // Across a diagonal the front comes first where it is slackest: nowhere above the pyramid, and
    // below it here and there.
    let mut diagonal = graph(&body("plane:21x21", true), &mesh.default_fixed, 0.25);
    diagonal.move_to(&to).unwrap();
    let heights = diagonal.elements().positions_m().iter().zip(&exact);
    let below: Vec<f64> = heights.map(|(p, exact)| exact[2] - p[2]).collect();
    assert!(below.iter().all(|&d| d > -ROUNDING_M) && below.iter().any(|&d| d > 0.2 * SPACING_M));
}

/// Relaxation to the rest offsets bends the pyramid: each free height is its neighbours' mean.
#[test]
fn relaxation_bends_the_pyramid() {
    let mesh = body("plane:21x21", false);
    let depth = 10.0 * 0.25 * SPACING_M;
    let held = [0.0, 0.0, depth];
    let mut chain = lattice(&mesh, [21, 21, 1], &mesh.default_fixed, 0.25);
    let mut twin = graph(&mesh, &mesh.default_fixed, 0.25);
    chain.move_to(&[(220, held)]).unwrap();
    twin.move_to(&[(220, held)]).unwrap();
    for _ in 0..2000 {
        let cost = chain.relax(&Limits::RIGID);
        assert_eq!(cost.visited, 19 * 19 - 1);
        twin.relax(&Limits::RIGID);
    }
    let p = chain.elements().positions_m();
    assert!(farthest(p, twin.elements().positions_m()) < ROUNDING_M);
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
    let mut slack = lattice(&mesh, [21, 21, 1], &mesh.default_fixed, 0.25);
    slack.move_to(&[(220, held)]).unwrap();
    assert_eq!(slack.relax(&limits(0.26)).moved, 0);
}

/// An element that is fixed passes nothing on; the front goes round it.
#[test]
fn the_front_goes_round_a_fixed_element() {
    let mesh = body("plane:5x5", false);
    let far = 4 * 5 + 2;
    for mut chain in [lattice(&mesh, [5, 5, 1], &[17], 0.25), lattice(&mesh, [5, 5, 1], &[], 0.25)]
    {
        chain.move_to(&[(12, [0.0, 0.0, 2.0 * SPACING_M])]).unwrap();
        assert!(chain.elements().positions_m()[far][2] > 0.5 * SPACING_M);
    }
    let mut chain = lattice(&mesh, [5, 5, 1], &[17], 0.25);
    chain.move_to(&[(12, [0.0, 0.0, 2.0 * SPACING_M])]).unwrap();
    assert_eq!(chain.elements().positions_m()[17], mesh.nodes_m[17]);
}

/// A model's chain is that of its mesh, its elements in the model's order.
#[test]
fn of_a_model_as_of_its_mesh() {
    let mesh = load("organ:300", &MeshOptions::default()).unwrap();
    let image = bake(&mesh, &mesh.default_fixed, &BakeOptions::default()).unwrap();
    let model = Model::from_bytes(image.as_bytes()).unwrap();
    let mut of_mesh = graph(&mesh, &mesh.default_fixed, 0.1);
    let mut of_model = Graph::of_model(&model, limits(0.1)).unwrap();
    let cell = (0..model.cells()).find(|&cell| !model.is_fixed(cell as u16)).unwrap();
    let by = [0.0, 0.0, 0.01];
    let rest_m = rest_m(&model, cell);
    let moved = of_model.move_to(&[(cell, plus(rest_m, by))]).unwrap();
    let node = model.input_id()[cell] as usize;
    of_mesh.move_to(&[(node, plus(mesh.nodes_m[node], by))]).unwrap();
    assert!(moved.moved > 20);
    // Another numbering orders the front otherwise, so each is held against its own sponsors.
    for e in 0..model.cells() {
        let sponsor = of_model.elements().sponsor(e);
        let off = sponsor.map_or(0.0, |from| violation(&of_model, &limits(0.1), [from, e]));
        assert!(off < 1e-12 || model.is_fixed(e as u16), "{off}");
    }
    let rest = in_input_order(&model, of_model.elements().rest_m());
    assert!(farthest(&rest, of_mesh.elements().rest_m()) < 1e-7);
}

#[test]
fn bad_input_is_refused() {
    let refused = |what: Result<Cost>, name: &str| {
        let text = what.unwrap_err().to_string();
        assert!(text.contains(name), "{text}");
    };
    for [low, high, shear] in [[1.1, 1.2, 0.0], [0.9, 0.9, 0.0], [0.9, 1.1, -0.1]] {
        assert!(Limits::new(low, high, shear).is_err());
    }
    assert!(Limits::of_alpha(1.0).is_err() && Limits::of_alpha(f64::NAN).is_err());
    let mesh = body("plane:3x3", false);
    assert!(Lattice::new([3, 2, 1], &mesh.nodes_m, &[], limits(0.1)).is_err());
    assert!(Lattice::new([3, 3, 1], &mesh.nodes_m, &[9], limits(0.1)).is_err());
    assert!(Graph::new(&mesh.nodes_m, &[[0, 9]], &[], limits(0.1)).is_err());
    let mut chain = graph(&mesh, &[0], 0.1);
    refused(chain.move_to(&[(9, [0.0; 3])]), "has 9 elements");
    refused(chain.move_to(&[(0, [0.0; 3])]), "is fixed");
    refused(chain.move_to(&[(4, [f64::NAN; 3])]), "finite");
    assert_eq!(chain.elements().positions_m(), mesh.nodes_m);
}
