//! The response fields, and the effect of a prediction on force, bits and certificate.

use std::vec::Vec;

use nalgebra::Vector3;

use crate::contact::pose::ToolPose;
use crate::energy::state::term_states;
use crate::model::Model;
use crate::number::cell::{Cell, add, dot, scale, sub};
use crate::solver::{Dynamics, Predict, Track};
use crate::tick::budget::Budget;
use crate::tick::choices::Unloading;
use crate::tick::sample::{Flags, TickOutput};
use crate::tick::settings::{Network, Settings};
use crate::tick::tissue::{Tissue, TissueMut};

/// `chaincell bake organ:500`: 499 cells, alpha 0, 24 basis functions.
static ORGAN: &[u8] = crate::include_model!("../../../../tests/data/organ500.chaincell");
/// A block of nodal shapes: 144 cells, 48 basis functions.
#[cfg(feature = "nodal")]
static SHAPES: &[u8] = crate::include_model!("../../../../tests/data/tissue6.chaincell");
/// An organ with bands.
static SLACK: &[u8] = crate::include_model!("../../../../tests/data/varied300.chaincell");
const CELLS: usize = 499;
/// Input ids.
const HELD: [u32; 7] = [415, 435, 436, 438, 439, 457, 477];
/// The organ and, if the kernel supports nodal shapes, the block, with the nodes that the tool holds.
const BODIES: &[(&[u8], &[u32])] = &[
    (ORGAN, &HELD),
    #[cfg(feature = "nodal")]
    (SHAPES, &[59, 63, 83]),
];
const ROOM: usize = 160;
/// Index of the first field among the arrays of the scheme.
const TRACK: usize = <Track as Dynamics>::ARRAYS;

type Body<D> = Tissue<CELLS, D, 16, { term_states(CELLS) }>;

fn network(image: &'static [u8], sweeps: u16) -> Network<'static> {
    let model = Model::from_bytes(image).unwrap();
    let settings = Settings::for_model(&model);
    let settings = Settings { sweeps, unloading: Unloading::Off, ..settings };
    Network::new(model, Settings { max_tool_step_m: 1.0, ..settings }).unwrap()
}

/// The organ's cells that the tool holds.
fn held() -> Vec<u16> {
    cells(ORGAN, &HELD)
}

/// The cells of input nodes.
fn cells(image: &'static [u8], ids: &[u32]) -> Vec<u16> {
    let model = Model::from_bytes(image).unwrap();
    let mut cells: Vec<u16> = ids.iter().filter_map(|&id| model.cell_of_input(id)).collect();
    cells.sort_unstable();
    cells
}

/// A body at rest with its held cells chosen.
fn body<D: Dynamics>(network: &Network<'_>, held: &[u16]) -> std::boxed::Box<Body<D>> {
    let mut body = std::boxed::Box::new(Body::<D>::new());
    body.reset(network).unwrap();
    body.choose_contacts(network, held).unwrap();
    body
}

/// A press with a sideways motion, `way` mean link lengths per tick.
fn sample(model: &Model<'_>, tick: u16, way: f32) -> ToolPose {
    let depth = way * f32::from(tick) * model.unit_m();
    ToolPose::at(Vector3::new(0.4 * depth, -0.2 * depth, -depth), 1)
}

fn press<D: Dynamics>(
    network: &Network<'_>,
    prepare: impl Fn(&mut TissueMut<'_, D>),
) -> (Vec<TickOutput>, Vec<u64>) {
    let mut body = body::<D>(network, &held());
    prepare(&mut body.view());
    let tick = |tick| {
        let output = body.tick(network, &[sample(network.model(), tick, 0.01)], Budget::All);
        (output, body.view().state_hash(network.model()))
    };
    (0..120).map(tick).unzip()
}

#[test]
fn a_field_is_the_answer_to_a_small_move() {
    let (few, many) = (network(ORGAN, 1), network(ORGAN, 400));
    let model = *many.model();
    let mut asked = body::<Predict<ROOM>>(&few, &held());
    assert!(asked.view().head.dynamics.is_known);
    let mut moved = body::<Track<ROOM>>(&many, &held());
    for tick in [0, 1, 1, 1, 1] {
        moved.tick(&many, &[sample(&model, tick, 0.02)], Budget::All);
    }
    let way = [0.008, -0.004, -0.02_f32];
    let (asked, moved) = (asked.view(), moved.view());
    let (mut off, mut size) = (0.0_f64, 0.0_f64);
    let is_held = |cell: usize| held().contains(&(cell as u16));
    for cell in (0..CELLS).filter(|&cell| !is_held(cell)) {
        let there = sub(moved.position(&model, cell).unwrap(), model.rest_position(cell));
        let field = |axis: usize| scale(way[axis], asked.own[(TRACK + axis) * CELLS + cell].xyz());
        let foreseen = add(add(field(0), field(1)), field(2));
        off += f64::from(dot(sub(foreseen, there), sub(foreseen, there)));
        size += f64::from(dot(there, there));
    }
    assert!(size > 0.001 && (off / size).sqrt() < 0.03, "{off} of {size}");
}

#[test]
fn one_sweep_with_prediction_is_nearer_than_two_without() {
    let force = |(outputs, _): (Vec<TickOutput>, Vec<u64>)| -> Vec<Vector3<f32>> {
        outputs.iter().map(|output| output.force_n).collect()
    };
    let exact = force(press::<Track<ROOM>>(&network(ORGAN, 100), |_| {}));
    let size = |f: Vector3<f32>| f.dot(&f).sqrt();
    let error = |of: Vec<Vector3<f32>>| {
        let each = of.iter().zip(&exact).skip(30).map(|(f, exact)| size(f - exact) / size(*exact));
        each.fold(0.0, f32::max)
    };
    let two = error(force(press::<Track<ROOM>>(&network(ORGAN, 2), |_| {})));
    let one = error(force(press::<Predict<ROOM>>(&network(ORGAN, 1), |_| {})));
    assert!(one < 0.02 && one < 0.5 * two, "{one}, without prediction {two}");
}

/// Poses too late for a sweep move no point of the sweeps; the next pass starts where it would without them.
#[test]
fn a_late_pose_leaves_the_fields_to_the_next_pass() {
    let network = network(ORGAN, 1);
    let model = *network.model();
    let free = |cell: &usize| !held().contains(&(*cell as u16));
    let points = |body: &mut Body<Predict<ROOM>>| -> Vec<Cell> {
        let own = body.view().own.to_vec();
        (0..CELLS).filter(free).map(|cell| own[cell]).collect()
    };
    let mut bodies = [(); 2].map(|()| body::<Predict<ROOM>>(&network, &held()));
    for body in &mut bodies {
        (0..40)
            .for_each(|tick| _ = body.tick(&network, &[sample(&model, tick, 0.01)], Budget::All));
    }
    let [late, straight] = &mut bodies;
    let before = points(late);
    for tick in 40..44 {
        late.tick(&network, &[sample(&model, tick, 0.01)], Budget::LATE);
    }
    assert_eq!(points(late), before);
    let forces = [late, straight].map(|body| {
        let force = body.tick(&network, &[sample(&model, 44, 0.01)], Budget::All).force_n;
        assert_ne!(points(body), before);
        force.dot(&force).sqrt()
    });
    assert!((forces[0] - forces[1]).abs() < 1e-4 * forces[1], "{forces:?}");
}

#[test]
fn every_unit_and_any_sleep_give_the_same_bits() {
    let network = network(ORGAN, 2);
    let plain = press::<Predict<ROOM>>(&network, |_| {});
    assert_eq!(plain, press::<Predict<ROOM>>(&network, |tissue| tissue.go_scalar()));
    assert_eq!(
        plain,
        press::<Predict<ROOM>>(&network, |tissue| tissue.forbid_sleep(network.model()))
    );
    // The path differs from that of `track`.
    assert_ne!(plain.1, press::<Track<ROOM>>(&network, |_| {}).1);
}

// REQ-TCK-07
#[test]
fn with_slack_it_is_track() {
    let network = network(SLACK, 3);
    let model = *network.model();
    let held = [285, 286];
    let mut bodies = (body::<Predict<ROOM>>(&network, &held), body::<Track<ROOM>>(&network, &held));
    assert!(!bodies.0.view().head.dynamics.is_known);
    let mut same = |tick: u16, sample: &ToolPose| {
        let outputs = (
            bodies.0.tick(&network, &[*sample], Budget::All),
            bodies.1.tick(&network, &[*sample], Budget::All),
        );
        assert_eq!(outputs.0, outputs.1, "tick {tick}");
        assert_eq!(bodies.0.view().state_hash(&model), bodies.1.view().state_hash(&model));
    };
    (0..60).for_each(|tick| same(tick, &sample(&model, tick, 0.02)));
    same(60, &ToolPose { engaged: 0, ..sample(&model, 60, 0.0) });
}

#[test]
fn the_fields_outlive_positions_from_outside_and_end_with_the_choice() {
    let network = network(ORGAN, 1);
    let model = *network.model();
    let mut body = body::<Predict<ROOM>>(&network, &held());
    let fields = |body: &mut Body<Predict<ROOM>>| body.view().own[TRACK * CELLS..].to_vec();
    let before = fields(&mut body);
    let rest: Vec<[f32; 3]> = (0..CELLS).map(|cell| model.rest_position(cell)).collect();
    body.view().set_positions(&network, &rest).unwrap();
    assert!(body.view().head.dynamics.is_known);
    assert_eq!(fields(&mut body), before);
    body.choose_contacts(&network, &held()[..2]).unwrap();
    assert_ne!(fields(&mut body), before);
    body.choose_contacts(&network, &[]).unwrap();
    assert!(!body.view().head.dynamics.is_known);
    assert_ne!(fields(&mut body), before);
}

/// Choosing the same cells again costs nothing and gives the bits of a first choice.
// REQ-TCK-07
#[test]
fn the_fields_outlive_a_reset_and_are_worked_out_anew_after_other_cells() {
    for &(image, ids) in BODIES {
        let (network, held) = (network(image, 1), cells(image, ids));
        let fields = TRACK * network.model().cells();
        let press = |body: &mut Body<Predict<ROOM>>| -> Vec<TickOutput> {
            (0..40)
                .map(|tick| {
                    body.tick(&network, &[sample(network.model(), tick, 0.02)], Budget::All)
                })
                .collect()
        };
        let mut body = body::<Predict<ROOM>>(&network, &held);
        let first = press(&mut body);
        // A mark that computing the fields anew would remove.
        let mark = |body: &mut Body<Predict<ROOM>>| body.view().own[fields].0[3] == 7.0;
        body.view().own[fields].0[3] = 7.0;
        body.reset(&network).unwrap();
        body.choose_contacts(&network, &held).unwrap();
        assert!(mark(&mut body));
        assert_eq!(press(&mut body), first);
        body.reset(&network).unwrap();
        body.choose_contacts(&network, &held[..1]).unwrap();
        body.choose_contacts(&network, &held).unwrap();
        assert!(!mark(&mut body));
        assert_eq!(press(&mut body), first);
    }
}

/// Meaningless fields: the guard discards their passes, and the level holds.
// REQ-TCK-07
#[test]
fn wrong_fields_cost_a_discarded_pass_and_never_the_certificate() {
    for (&(image, ids), (strength, is_discarded)) in BODIES.iter().flat_map(|body| {
        [(-30.0, true), (1.0e3, true), (1.0e30, false)].map(|fields| (body, fields))
    }) {
        let network = network(image, 4);
        let model = *network.model();
        let mut body = body::<Predict<ROOM>>(&network, &cells(image, ids));
        for field in &mut body.view().own[TRACK * model.cells()..] {
            *field = Cell::at(scale(strength, field.xyz()));
        }
        let (mut discarded, mut level_j) = (false, 0.0);
        for tick in 0..60 {
            let output = body.tick(&network, &[sample(&model, tick.min(30), 0.02)], Budget::All);
            discarded |= output.flags.contains(Flags::ROLLED_BACK);
            assert!(output.force_n.iter().all(|f| f.is_finite()));
            assert!(tick <= 30 || output.energy_j <= level_j, "tick {tick}");
            level_j = output.energy_j;
        }
        assert_eq!(discarded, is_discarded, "{strength}");
        let peak = |cell| body.view().position(&model, cell).unwrap().map(f32::abs);
        assert!((0..model.cells()).flat_map(peak).all(|x| x <= model.saturation()));
    }
}
