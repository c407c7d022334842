//! Whole trajectories on the vector unit and without it: the same bits, tick by tick.
//!
//! `cargo test --release -p chaincell-tests --test kernel same_bits` checks the fully optimised build.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, BasisSpacing, ImageBytes, PerCell};
use chaincell_host::engine::threads::ThreadCount;
use chaincell_host::engine::{Engine, Scheme};
use chaincell_host::mesh::MeshOptions;
use chaincell_kernel::{Choice, Model, Network, Settings, TickOutput, ToolPose, Unloading};
use chaincell_kernel::{VectorUnit, parts};
use chaincell_lab::bodies::{Shape, Variant};
use chaincell_lab::states::State;
use nalgebra::Vector3;

/// Pseudo-random numbers, the same in every run.
struct Dice(u64);

impl Dice {
    fn throw(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (self.0 >> 32) as u32
    }

    /// From -`reach` to `reach`.
    fn within(&mut self, reach: f32) -> f32 {
        reach * (self.throw() as f32 / 2_147_483_648.0 - 1.0)
    }
}

/// A generated body; planes have diagonals.
fn body(spec: &str) -> Shape {
    let options = MeshOptions { diagonals: spec.starts_with("plane"), ..MeshOptions::default() };
    Shape::generated_with(spec, &options).unwrap()
}

/// One engine on the vector unit, one without, and for large bodies one with several threads.
struct Twins<'m>(Vec<Engine<'m>>);

impl<'m> Twins<'m> {
    fn new(model: Model<'m>, scheme: Scheme, unloading: Unloading) -> Self {
        // A super-step takes four sweeps.
        let sweeps = if scheme.goes_by_tick() { 9 } else { 3 };
        let settings = Settings { unloading, ..scheme.settings(&model, sweeps) };
        let network = Network::new(model, settings).unwrap();
        let free = (0..model.cells() as u16).filter(|&cell| !model.is_fixed(cell));
        let free: Vec<u16> = free.collect();
        let contacts = [free[free.len() / 3], free[free.len() / 2]];
        let engine = || Engine::new(network, scheme, &contacts).unwrap();
        let mut twins = vec![engine(), engine()];
        twins[1].go_scalar();
        if parts::count(model.cells()) > 1 {
            let mut shared = engine();
            match ThreadCount::Of(2).start(model.cells()) {
                Ok(threads) => shared.share(threads),
                Err(why) => println!("SKIPPED threads: {why}"),
            }
            twins.push(shared);
        }
        Self(twins)
    }

    /// One tick of both; the hash is that of the state after it.
    fn tick(&mut self, sample: &ToolPose, what: &str) -> u64 {
        let mut answers = self.0.iter_mut().map(|engine| {
            let TickOutput { force_n, energy_j, work_j, contacts, flags, .. } = engine.tick(sample);
            let force = force_n.data.0[0].map(f32::to_bits);
            (force, [energy_j, work_j].map(f32::to_bits), contacts, flags, engine.state_hash())
        });
        let vector = answers.next().unwrap();
        for (engine, other) in answers.enumerate() {
            assert_eq!(vector, other, "{what}, engine {}", engine + 1);
        }
        vector.4
    }
}

/// A press in one corner direction, a drag across, the way back, then the release.
fn stroke(tick: u16, length_m: f32) -> ToolPose {
    let way = |from: u16, to: u16| f32::from(tick.clamp(from, to) - from) / f32::from(to - from);
    let depth = way(0, 60) - way(100, 140);
    let position_m = Vector3::new(2.0 * way(60, 100), 0.5 * depth, -3.0 * depth) * length_m;
    ToolPose::at(position_m, u32::from(tick < 150))
}

fn is_here(test: &str) -> bool {
    let found = VectorUnit::find().is_some();
    if !found {
        println!("SKIPPED {test}: this processor has no vector unit that the kernel knows");
    }
    found
}

// REQ-BIT-02
#[test]
fn trajectories_are_the_same_without_the_vector_unit() {
    if !is_here("trajectories_are_the_same_without_the_vector_unit") {
        return;
    }
    for spec in ["plane:21x21x0.01", "organ:500", "box:7x6x5x0.01"] {
        let shape = body(spec);
        for (coarse_functions, alpha) in [
            (BasisSpacing::None, 0.0),
            (BasisSpacing::None, 0.05),
            (BasisSpacing::Links(2.5), 0.0),
            (BasisSpacing::Links(3.0), 0.05),
        ] {
            let is_coarse = coarse_functions != BasisSpacing::None;
            let alpha = PerCell::Uniform(alpha);
            let options =
                BakeOptions { alpha, coarse_basis: coarse_functions, ..BakeOptions::default() };
            let image = shape.bake(&options).unwrap();
            let model = Model::from_bytes(image.as_bytes()).unwrap();
            assert!(model.is_sliced() && (model.coarse_functions() > 0) == is_coarse, "{spec}");
            for &scheme in Scheme::ALL {
                let mut twins = Twins::new(model, scheme, Unloading::Release);
                let rest = twins.0[0].state_hash();
                let mut hashes = vec![rest];
                for tick in 0..200 {
                    let what = format!("{spec} {options:?} {scheme:?} tick {tick}");
                    hashes.push(twins.tick(&stroke(tick, model.unit_m()), &what));
                }
                hashes.sort_unstable();
                hashes.dedup();
                assert!(hashes.len() > 150, "{spec} {scheme:?}: the body hardly moved");
            }
        }
    }
}

/// Tissue by Young's modulus and Poisson's ratio, pressed and let go.
// REQ-BIT-02, REQ-BIT-08
#[test]
fn trajectories_of_nodal_shapes_are_the_same_without_the_vector_unit() {
    if !is_here("trajectories_of_nodal_shapes_are_the_same_without_the_vector_unit") {
        return;
    }
    let of = PerCell::Uniform;
    for (spec, poisson, stretch_min) in [
        ("organ:500", 0.45, Some(0.95)),
        ("box:7x6x5x0.01", 0.0, None),
        ("organ:16800", 0.3, Some(0.7)),
    ] {
        let shape = body(spec);
        let tissue = Some(Tissue { stretch_min, ..Tissue::new(of(5000.0), of(poisson)) });
        for (coarse_basis, scheme) in [
            (BasisSpacing::None, Scheme::Track),
            (BasisSpacing::Links(5.0), Scheme::Track),
            (BasisSpacing::Links(5.0), Scheme::Predict),
        ] {
            let options =
                BakeOptions { tissue: tissue.clone(), coarse_basis, ..BakeOptions::default() };
            let image = shape.bake(&options).unwrap();
            let model = Model::from_bytes(image.as_bytes()).unwrap();
            assert!(model.is_nodal());
            let ticks = if parts::count(model.cells()) > 1 { 12 } else { 200 };
            let mut twins = Twins::new(model, scheme, Unloading::Release);
            let mut hashes = vec![twins.0[0].state_hash()];
            for tick in 0..ticks {
                let what = format!("{spec} {coarse_basis:?} {scheme:?} tick {tick}");
                let tick = tick * 200 / ticks;
                hashes.push(twins.tick(&stroke(tick, model.unit_m()), &what));
            }
            hashes.sort_unstable();
            hashes.dedup();
            assert!(hashes.len() > ticks as usize * 3 / 4, "{spec}: the body hardly moved");
        }
    }
}

/// Bodies of several parts, awake in all of them or in a few.
// REQ-BIT-08
#[test]
fn trajectories_of_large_bodies_are_the_same_with_several_threads() {
    let spec = "organ:16800";
    let shape = body(spec);
    for (coarse_basis, alpha) in [(BasisSpacing::Links(3.5), 0.0), (BasisSpacing::None, 0.05)] {
        let alpha = PerCell::Uniform(alpha);
        let options = BakeOptions { alpha, coarse_basis, ..BakeOptions::default() };
        let image = shape.bake(&options).unwrap();
        let model = Model::from_bytes(image.as_bytes()).unwrap();
        assert_eq!(parts::count(model.cells()), parts::PARTS);
        for scheme in [Scheme::Track, Scheme::Predict] {
            let mut twins = Twins::new(model, scheme, Unloading::Release);
            let mut hashes = vec![twins.0[0].state_hash()];
            for tick in 0..40 {
                let what = format!("{spec} {options:?} {scheme:?} tick {tick}");
                hashes.push(twins.tick(&stroke(4 * tick, model.unit_m()), &what));
            }
            hashes.dedup();
            assert!(hashes.len() > 30, "{scheme:?}: the body hardly moved");
        }
    }
}

/// A body whose links differ in alpha, in stiffness over six decades, in both or in neither.
fn varied(shape: &Shape, varied: [bool; 2], coarse_basis: BasisSpacing) -> ImageBytes {
    let mut dice = Dice(7);
    let nodes = shape.mesh.nodes_m.len();
    let mut each = |value: fn(f64) -> f64| {
        PerCell::Each((0..nodes).map(|_| value(f64::from(dice.within(1.0)))).collect())
    };
    let alpha = if varied[0] { each(|x| 0.45 * (1.0 + x)) } else { PerCell::Uniform(0.02) };
    let stiff = if varied[1] { each(|x| 10.0_f64.powf(3.0 * x)) } else { PerCell::Uniform(20.0) };
    // Far out: positions up to 9e5 mean link lengths are within K.
    let saturation_m = Some(9.0e3);
    let options = BakeOptions {
        alpha,
        stiffness_n_per_m: stiff,
        saturation_m,
        coarse_basis,
        ..Default::default()
    };
    shape.bake(&options).unwrap()
}

/// Nodal shapes that reach as far as they may.
fn nodal(shape: &Shape, coarse_basis: BasisSpacing) -> ImageBytes {
    let tissue = Some(Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(0.45)));
    let saturation_m = Some(5.0e2);
    let options = BakeOptions { tissue, saturation_m, coarse_basis, ..Default::default() };
    shape.bake(&options).unwrap()
}

/// States that no tool reaches in a few ticks, scattered ones within `far` [mean link lengths].
fn degenerate(far: f32) -> [State; 8] {
    [
        State::Rest,
        State::Stretched,
        State::Inverted,
        State::Flattened,
        State::Grid,
        State::Denormal,
        State::Scattered(far),
        State::Mixed(far),
    ]
}

// REQ-BIT-02
#[test]
fn degenerate_states_are_the_same_without_the_vector_unit() {
    if !is_here("degenerate_states_are_the_same_without_the_vector_unit") {
        return;
    }
    let mut seed = 0;
    let links = [[false, false], [true, false], [false, true], [true, true]].map(Some);
    for spec in ["plane:9x7x0.01", "organ:150", "box:4x4x5x0.01"] {
        let shape = body(spec);
        let shapes = (!shape.mesh.tetrahedra.is_empty()).then_some(None);
        for links in links.into_iter().chain(shapes) {
            for coarse_functions in [BasisSpacing::None, BasisSpacing::Links(2.0)] {
                let image = match links {
                    Some(links) => varied(&shape, links, coarse_functions),
                    None => nodal(&shape, coarse_functions),
                };
                let model = Model::from_bytes(image.as_bytes()).unwrap();
                assert!(model.is_sliced(), "{spec}");
                let far = 0.99 * model.saturation();
                let singles = Variant::singles_of(&model).into_iter();
                for (Variant { scheme, .. }, state) in
                    singles.flat_map(|of| degenerate(far).map(|state| (of, state)))
                {
                    let what =
                        format!("{spec} {links:?} {coarse_functions:?} {scheme:?} {state:?}");
                    let mut twins = Twins::new(model, scheme, Unloading::Off);
                    seed += 1;
                    let places = state.positions(&model, seed);
                    for engine in &mut twins.0 {
                        engine.set_positions(&places).unwrap();
                    }
                    for tick in 0..12_u16 {
                        let far = model.unit_m() * f32::from(tick);
                        let position_m = Vector3::new(0.1, 0.2, -0.3) * far;
                        let engaged = u32::from((3..9).contains(&tick));
                        let sample = ToolPose::at(position_m, engaged);
                        twins.tick(&sample, &format!("{what} tick {tick}"));
                    }
                }
            }
        }
    }
}
