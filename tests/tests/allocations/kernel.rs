//! The kernel as firmware uses it: a model linked into the program, a tissue in static memory, no
//! allocation; the same bits as the host's engine.
use std::sync::Mutex;

use chaincell_host::bake::{BakeOptions, bake};
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::mesh::load;
use chaincell_kernel::ContactError;
use chaincell_kernel::{
    Budget, Dynamics, Euler, Head, Model, Network, ResetError, Rkl2, Settings, TermState, Tissue,
    TissueMut, ToolPose, Track, include_model, term_states,
};
use chaincell_scenes::{Scene, tissue6_track};
use chaincell_tests::allocations::so_far;
use nalgebra::Vector3;

/// `chaincell bake plane:9x9x0.01 --diagonals --lean -o tests/data/plane9.chaincell`
static IMAGE: &[u8] = include_model!("../../data/plane9.chaincell");

fn sample(tick: u16) -> ToolPose {
    let position_m = Vector3::new(0.0, 0.0002 * f32::from(tick % 40), 0.001 * f32::from(tick % 60));
    ToolPose::at(position_m, u32::from(tick % 100 < 80))
}

fn network(image: &[u8]) -> Network<'_> {
    let model = Model::from_bytes(image).unwrap();
    Network::new(model, Settings::for_model(&model)).unwrap()
}

/// The middle of the linked model.
fn centre() -> u16 {
    network(IMAGE).model().cell_of_input(40).unwrap()
}

// REQ-TCK-01
#[test]
fn a_static_tissue_gives_the_bits_of_the_heap_and_allocates_nothing() {
    static TISSUE: Mutex<Tissue<81, Track, 8>> = Mutex::new(Tissue::new());
    static SHAPES: Mutex<tissue6_track::Body> = Mutex::new(Tissue::new());
    is_the_heaps(IMAGE, &[40], TISSUE.lock().unwrap().view());
    let Scene { image, held, .. } = tissue6_track::SCENE;
    is_the_heaps(image, held, SHAPES.lock().unwrap().view());
}

/// A tissue in static memory against the host's.
fn is_the_heaps<D: Dynamics>(image: &[u8], held: &[u32], mut tissue: TissueMut<'_, D>) {
    let network = network(image);
    let cells = held.iter().map(|&id| network.model().cell_of_input(id).unwrap());
    let mut contact: Vec<u16> = cells.collect();
    contact.sort_unstable();
    let mut engine = Engine::new(network, Scheme::Track, &contact).unwrap();
    tissue.reset(&network).unwrap();
    tissue.choose_contacts(&network, &contact).unwrap();
    assert!(so_far().0 > 0, "nothing is counted");
    for tick in 0..500 {
        let before = so_far();
        let own = tissue.tick(&network, &[sample(tick)], Budget::All);
        let hash = tissue.state_hash(network.model());
        let host = engine.tick(&sample(tick));
        assert_eq!(so_far(), before, "tick {tick} allocates");
        assert_eq!((own, hash), (host, engine.state_hash()), "tick {tick}");
    }
}

#[test]
fn euler_carries_no_momentum() {
    let (track, euler) = (Tissue::<81, Track, 1>::RAM_BYTES, Tissue::<81, Euler, 1>::RAM_BYTES);
    // To the nearest: a tissue is a multiple of its alignment.
    let arrays = |bytes: usize| (bytes + 81 * 8) / (81 * 16);
    assert_eq!(arrays(euler - Tissue::<1, Euler, 1>::RAM_BYTES), 2);
    assert_eq!(arrays(track - euler), 2);
    assert_eq!(arrays(Tissue::<81, Rkl2, 1>::RAM_BYTES - euler), 3);
}

/// A body of links has no states of terms; one of nodal shapes has them in the tissue.
#[test]
fn states_of_terms_take_memory_where_there_are_some() {
    let whole = |states: usize| {
        let arrays = size_of::<Head<Track>>() + 81 * 64 + 16 + states * size_of::<TermState>();
        arrays.next_multiple_of(align_of::<TermState>())
    };
    assert!(size_of::<TermState>() > 0);
    assert_eq!(Tissue::<81, Track, 1>::RAM_BYTES, whole(0));
    assert_eq!(Tissue::<81, Track, 1, { term_states(81) }>::RAM_BYTES, whole(term_states(81)));
    assert_eq!(Model::from_bytes(IMAGE).unwrap().kept_states(), 0);
}

// REQ-MOD-04
#[test]
fn a_tissue_that_is_too_small_says_so() {
    let network = network(IMAGE);
    let refused = Tissue::<80, Track>::new().reset(&network);
    assert_eq!(refused, Err(ResetError::Capacity { needed: 81, capacity: 80 }));
}

/// Cells are chosen from the body that the tissue has, and found by their input ids.
// REQ-CON-01
#[test]
fn contacts_of_a_body_that_is_not_there_are_refused() {
    let network = network(IMAGE);
    let mut tissue = Tissue::<81, Track>::new();
    let (model, cell) = (network.model(), centre());
    assert_eq!(model.input_id()[usize::from(cell)], 40);
    assert_eq!(model.cell_of_input(81), None);
    assert_eq!(tissue.choose_contacts(&network, &[cell]), Err(ContactError::Model));
    tissue.reset(&network).unwrap();
    assert_eq!(tissue.choose_contacts(&network, &[cell]), Ok(()));
}

/// A network that the tissue was not reset for is answered by the safe state, not by nonsense.
// REQ-TCK-05
#[test]
fn another_model_than_that_of_the_reset_is_safe() {
    only_its_own(IMAGE, 40, &mut Tissue::<81, Euler>::new().view());
    let Scene { image, held, .. } = tissue6_track::SCENE;
    only_its_own(image, held[0], &mut tissue6_track::Body::new().view());
}

fn only_its_own<D: Dynamics>(image: &[u8], held: u32, tissue: &mut TissueMut<'_, D>) {
    let network = network(image);
    let held = network.model().cell_of_input(held).unwrap();
    let output = tissue.tick(&network, &[sample(1)], Budget::All);
    assert_eq!((output.force_n, output.flags.0), (Vector3::zeros(), 16));
    // A smaller body, for which there would be room.
    let mesh = load("plane:5x5x0.01", &Default::default()).unwrap();
    let small = bake(&mesh, &mesh.border, &BakeOptions::default()).unwrap();
    let other = self::network(small.as_bytes());
    tissue.reset(&network).unwrap();
    tissue.choose_contacts(&network, &[held]).unwrap();
    tissue.tick(&network, &[sample(1)], Budget::All);
    assert!(tissue.tick(&network, &[sample(9)], Budget::All).force_n.norm() > 0.0);
    let hash = tissue.state_hash(network.model());
    let output = tissue.tick(&other, &[sample(20)], Budget::All);
    assert_eq!((output.force_n, output.flags.0), (Vector3::zeros(), 16));
    assert_eq!(tissue.state_hash(network.model()), hash);
    assert_eq!(tissue.tick(&network, &[sample(20)], Budget::All).flags.0 & 16, 0);
}
