//! The estimate of the force's error beside the force of 100 sweeps in the same tick, on bodies and motions that took
//! no part in finding its factors.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::{Branch, Relaxation, Tissue};
use chaincell_host::bake::{BakeOptions, Cuttable, ImageBytes, PerCell};
use chaincell_host::engine::{Contact, Engine, Scheme, rest_m};
use chaincell_kernel::{Budget, Flags, Settings, ToolPart, ToolPose};
use chaincell_tests::bodies::{baked, model, under};
use nalgebra::{UnitQuaternion, Vector3};

/// Sweeps of the true force.
const MANY: u16 = 100;

/// What a body of tissue does beside being elastic.
#[derive(Debug, Clone, Copy)]
enum Kind {
    Elastic,
    /// It relaxes: moduli of its branches over the long-term one, and their times in seconds.
    Relaxing([[f64; 2]; 2]),
    Cuttable,
}

fn image(spec: &str, poisson: f64, kind: Kind) -> ImageBytes {
    let mut tissue = Tissue::new(PerCell::Uniform(5000.0), PerCell::Uniform(poisson));
    let mut cuttable = None;
    match kind {
        Kind::Elastic => {}
        Kind::Relaxing(branches) => {
            let branches = branches.map(|[ratio, time_s]| Branch { ratio, time_s }).to_vec();
            tissue.relaxation = Some(Relaxation { branches, is_instant: false, device_hz: 1000 });
        }
        Kind::Cuttable => {
            let toughness_j_per_m2 = 10.0;
            cuttable = Some(Cuttable {
                toughness_j_per_m2: PerCell::Uniform(toughness_j_per_m2),
                spare_share: 0.5,
                ..Cuttable::default()
            });
        }
    }
    baked(spec, &BakeOptions { tissue: Some(tissue), cuttable, ..BakeOptions::default() })
}

/// What touches a body: this many cells that are held, or balls of this radius in mean links, and their friction, or
/// a bar with that radius and half length, which turns.
#[derive(Debug, Clone, Copy)]
enum Touch {
    Held(usize),
    Balls { count: usize, radius: f64, friction: f32 },
    Bar { half: f64, radius: f64, friction: f32 },
}

impl Touch {
    /// Number of tools, each with an output of its own; 0 for held cells.
    fn tools(self) -> usize {
        match self {
            Self::Held(_) => 0,
            Self::Balls { count, .. } => count,
            Self::Bar { .. } => 1,
        }
    }
}

/// Balls: small, with friction, two at once.
const BALLS: [Touch; 3] = [
    Touch::Balls { count: 1, radius: 1.6, friction: 0.0 },
    Touch::Balls { count: 1, radius: 2.2, friction: 0.4 },
    Touch::Balls { count: 2, radius: 2.0, friction: 0.0 },
];

/// A body with its contact, at rest.
struct Scene<'a> {
    image: &'a ImageBytes,
    touch: Touch,
    unit_m: f64,
    /// The cell on top of the middle, and where it is \[m\].
    top_m: Vector3<f64>,
    contact: Contact,
}

impl<'a> Scene<'a> {
    fn new(image: &'a ImageBytes, touch: Touch) -> Self {
        let model = model(image);
        let unit_m = f64::from(model.unit_m());
        let places: Vec<Vector3<f64>> =
            (0..model.cells()).map(|cell| Vector3::from(rest_m(&model, cell))).collect();
        let (low, high) = (bound(&places, f64::min), bound(&places, f64::max));
        // Cells by their distance from the middle of the top, height counting twice.
        let top = Vector3::new(0.5 * (low.x + high.x), 0.5 * (low.y + high.y), high.z);
        let apart = |cell: usize| {
            let way = places[cell] - top;
            way.norm_squared() + 3.0 * way.z * way.z
        };
        let mut cells: Vec<usize> = (0..places.len()).collect();
        cells.sort_by(|&a, &b| apart(a).total_cmp(&apart(b)));
        let contact = match touch {
            Touch::Held(count) => {
                let mut held: Vec<u16> = cells[..count].iter().map(|&cell| cell as u16).collect();
                held.sort_unstable();
                Contact::Cells(held)
            }
            Touch::Balls { count, radius, friction } => {
                let ball = vec![ToolPart::sphere((radius * unit_m) as f32)];
                Contact::Tools { tools: vec![ball; count], friction }
            }
            Touch::Bar { half, radius, friction } => {
                let [half_m, radius_m] = [half, radius].map(|x| (x * unit_m) as f32);
                let bar = vec![ToolPart::capsule(half_m, radius_m)];
                Contact::Tools { tools: vec![bar], friction }
            }
        };
        Self { image, touch, unit_m, top_m: places[cells[0]], contact }
    }

    fn engine(&self, sweeps: u16) -> Engine<'a> {
        let step_m = Settings::for_model(&model(self.image)).max_tool_step_m;
        under(self.image, self.contact.clone(), (Scheme::Predict, sweeps), step_m).unwrap()
    }

    /// Poses at a tick: down, then a walk without a pattern or strokes to and fro with a tremor.
    fn poses(&self, seed: f64, tick: u32) -> Vec<ToolPose> {
        let time_s = 1.0e-3 * f64::from(tick);
        let down = (time_s / 0.08).min(1.0).powi(2);
        let wave = |hz: f64, phase: f64| (std::f64::consts::TAU * hz * time_s + phase).sin();
        let walk = |axis: f64| {
            let each = [1.3, 3.1, 4.7, 8.9].map(|hz| wave(hz, seed * (hz + 2.3 * axis)) / hz);
            each.iter().sum::<f64>()
        };
        let share = if seed < 1.5 {
            Vector3::new(0.3 * walk(0.0), 0.3 * walk(1.0), 0.2 * walk(2.0) - 0.8)
        } else {
            let tremor = 0.02 * wave(9.5, seed);
            Vector3::new(0.5 * wave(2.2, seed) + tremor, 0.2 * wave(0.9, 0.0), 0.1 * tremor - 0.8)
        };
        let way_m = 1.4 * self.unit_m * down * share;
        let pose = |at_m: Vector3<f64>| ToolPose::at(at_m.map(|x| x as f32), 1);
        let (count, radius) = match self.touch {
            Touch::Held(_) => return vec![pose(way_m)],
            Touch::Balls { count, radius, .. } => (count, radius),
            Touch::Bar { radius, .. } => (1, radius),
        };
        let above = Vector3::new(0.0, 0.0, (radius + 0.1) * self.unit_m);
        let aside = |tool: usize| {
            Vector3::new((tool as f64 - 0.5 * (count as f64 - 1.0)) * 2.6 * radius, 0.0, 0.0)
        };
        let mut poses: Vec<ToolPose> = (0..count)
            .map(|tool| pose(self.top_m + above + aside(tool) * self.unit_m + way_m))
            .collect();
        if let Touch::Bar { .. } = self.touch {
            // A bar lies on its side, turns about the vertical and tilts.
            let tilt = std::f64::consts::FRAC_PI_2 + 0.15 * wave(1.7, seed) * down;
            let turn = UnitQuaternion::from_euler_angles(0.0, tilt, 0.6 * wave(1.1, 0.3));
            poses[0].orientation = turn.coords.map(|x| x as f32).into();
        }
        poses
    }
}

fn bound(places: &[Vector3<f64>], of: fn(f64, f64) -> f64) -> Vector3<f64> {
    let first = places[0];
    places.iter().fold(first, |bound, place| bound.zip_map(place, of))
}

/// Force of each tool, or its torque.
fn felt(
    engine: &mut Engine<'_>,
    poses: &[ToolPose],
    scene: &Scene<'_>,
    of: Of,
    budget: Budget<'_>,
) -> Vec<Vector3<f32>> {
    let output = engine.tick_by(poses, budget);
    let outputs = (0..scene.touch.tools()).map(|tool| engine.tool_output(tool));
    match (of, scene.touch) {
        (Of::Force, Touch::Held(_)) => vec![output.force_n],
        (Of::Force, _) => outputs.map(|of| of.force_n).collect(),
        (Of::Torque, _) => outputs.map(|of| of.torque_n_m).collect(),
    }
}

/// What is estimated.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Of {
    Force,
    Torque,
}

/// Estimates in a motion.
struct Found {
    of: Of,
    /// Late ticks in a row at whose end an estimate is looked at; 0 for ticks in time.
    late: u32,
    /// Estimate and true error, over the true force, of each tick looked at.
    pairs: Vec<[f32; 2]>,
    unknown: usize,
}

impl Found {
    /// Adds a motion, in which every `every`th tick is looked at.
    fn add(&mut self, scene: &Scene<'_>, (seed, sweeps): (f64, u16), every: u32) {
        let (mut few, mut many) = (scene.engine(sweeps), scene.engine(MANY));
        let mut largest_n = 0.0_f32;
        for tick in 0..300 {
            let poses = scene.poses(seed, tick);
            // The ticks before one that is looked at, and itself, may be late; the first ones are in time.
            let phase = tick % every;
            let is_late = tick >= every && (1..=self.late).contains(&phase);
            if phase != self.late.max(1) {
                few.tick_by(&poses, if is_late { Budget::LATE } else { Budget::All });
                continue;
            }
            // The same tick with many sweeps, from the same state.
            many.restore(&few.save().unwrap()).unwrap();
            let truth = felt(&mut many, &poses, scene, self.of, Budget::All);
            let budget = if is_late { Budget::LATE } else { Budget::All };
            let own = felt(&mut few, &poses, scene, self.of, budget);
            for (tool, (own_n, true_n)) in own.iter().zip(&truth).enumerate() {
                let size_n = true_n.norm();
                largest_n = largest_n.max(size_n);
                if size_n > 0.02 * largest_n && own_n.norm() > 0.0 {
                    let estimate = match self.of {
                        Of::Force => few.force_error_n(tool),
                        Of::Torque => few.torque_error_n_m(tool),
                    };
                    match estimate {
                        Some(error) => {
                            self.pairs.push([error, (own_n - true_n).norm()].map(|x| x / size_n));
                        }
                        None => self.unknown += 1,
                    }
                }
            }
        }
    }

    /// Share of the errors within the estimate; median of estimate over error, of the errors above 0.3 % of the force.
    fn covered_and_width(&self) -> [f64; 2] {
        let within = self.pairs.iter().filter(|[estimate, error]| error <= estimate).count();
        let counting = self.pairs.iter().filter(|[_, error]| *error > 0.003);
        let mut widths: Vec<f32> = counting.map(|[estimate, error]| estimate / error).collect();
        widths.sort_by(f32::total_cmp);
        [within as f64 / self.pairs.len() as f64, widths[widths.len() / 2].into()]
    }
}

/// True for more bodies and ticks than a test of every build has.
fn is_slow() -> bool {
    std::env::var_os("CHAINCELL_SLOW").is_some()
}

/// Asks an estimate for the contacts `touches`, after so many late ticks in a row: at least `least` of the errors
/// within it, and not wider than `most`.
fn check(name: &str, what: (Of, u32), touches: &[Touch], bounds: [f64; 2]) {
    check_kind(name, Kind::Elastic, what, touches, bounds);
}

/// The same of bodies of a kind.
fn check_kind(
    name: &str,
    kind: Kind,
    (of, late): (Of, u32),
    touches: &[Touch],
    [least, most]: [f64; 2],
) {
    let bodies = [("organ:420", 0.42), ("box:8x9x5x0.012", 0.35), ("organ:560", 0.47)];
    let (count, every) = if is_slow() { (3, 2) } else { (2, 9) };
    let every = every + late;
    let mut found = Found { of, late, pairs: Vec::new(), unknown: 0 };
    for (spec, poisson) in &bodies[..count] {
        let image = image(spec, *poisson, kind);
        for &touch in touches {
            let scene = Scene::new(&image, touch);
            for motion in [(1.0, 1), (2.0, 1), (1.2, 2), (2.4, 2), (1.4, 4), (2.8, 4)] {
                found.add(&scene, motion, every);
            }
        }
    }
    let ([covered, width], ticks) = (found.covered_and_width(), found.pairs.len());
    println!(
        "{name}, {late} late: {ticks} ticks, {:.2} % covered, width {width:.2}",
        100.0 * covered
    );
    assert!(found.unknown * 50 < ticks, "{name}: unknown in {} of {ticks}", found.unknown);
    assert!(
        ticks > 300 / (1 + late as usize) && covered >= least && width < most,
        "{name}: {covered} {width}"
    );
}

// REQ-FOR-09
#[test]
fn the_estimate_covers_the_force_of_held_cells_in_99_of_100_ticks() {
    check("held cells", (Of::Force, 0), &[Touch::Held(1), Touch::Held(5)], [0.985, 5.0]);
}

// REQ-FOR-09
#[test]
fn the_estimate_covers_the_force_of_tools_in_99_of_100_ticks() {
    let ball = |count, radius, friction| Touch::Balls { count, radius, friction };
    let touches = [ball(1, 1.6, 0.0), ball(1, 2.5, 0.0), ball(1, 2.2, 0.4), ball(2, 2.0, 0.0)];
    check("tools", (Of::Force, 0), &touches, [0.985, 7.0]);
}

// REQ-FOR-09
#[test]
fn the_estimate_covers_force_and_torque_of_a_bar_that_turns() {
    let bar = |half, radius, friction| Touch::Bar { half, radius, friction };
    let touches = [bar(1.5, 1.2, 0.0), bar(2.5, 1.6, 0.0), bar(2.0, 1.5, 0.4)];
    check("force of bars", (Of::Force, 0), &touches, [0.985, 7.0]);
    check("torque of bars", (Of::Torque, 0), &touches, [0.985, 7.0]);
}

/// Branches faster than a motion and slower ones, weak and stiff ones.
// REQ-FOR-09
#[test]
fn the_estimate_covers_the_force_of_bodies_that_relax() {
    let all = [[[3.0, 0.02], [2.0, 0.3]], [[1.0, 0.1], [1.0, 2.0]], [[0.3, 0.005], [0.5, 1.0]]];
    let (count, late): (_, &[u32]) = if is_slow() { (3, &[0, 1, 3, 10]) } else { (1, &[0, 3]) };
    for branches in all[..count].iter().copied() {
        println!("branches of g, tau: {branches:?}");
        let kind = Kind::Relaxing(branches);
        let held = [Touch::Held(1), Touch::Held(5)];
        check_kind("held cells", kind, (Of::Force, 0), &held, [0.985, 5.0]);
        for &late in late {
            let least = if late == 0 { 0.985 } else { 0.98 };
            check_kind("tools", kind, (Of::Force, late), &BALLS, [least, 9.0]);
        }
    }
}

// REQ-FOR-09
#[test]
fn the_estimate_covers_the_force_of_bodies_that_are_not_cut_yet() {
    check_kind("tools", Kind::Cuttable, (Of::Force, 0), &BALLS, [0.985, 7.0]);
    check_kind("held cells", Kind::Cuttable, (Of::Force, 0), &[Touch::Held(5)], [0.985, 5.0]);
}

// REQ-FOR-09
#[test]
fn the_estimate_covers_the_repeated_forces_of_late_ticks() {
    let bar = [Touch::Bar { half: 1.5, radius: 1.2, friction: 0.0 }];
    for late in [1, 3, 10] {
        check("held cells", (Of::Force, late), &[Touch::Held(1), Touch::Held(5)], [0.985, 5.0]);
        check("tools", (Of::Force, late), &BALLS, [0.985, 9.0]);
        check("force of bars", (Of::Force, late), &bar, [0.985, 9.0]);
        check("torque of bars", (Of::Torque, late), &bar, [0.985, 9.0]);
    }
}

// REQ-FOR-09
#[test]
fn nothing_is_said_where_nothing_is_known() {
    let image = image("organ:300", 0.45, Kind::Elastic);
    let ball = Touch::Balls { count: 1, radius: 2.0, friction: 0.0 };
    let scene = Scene::new(&image, ball);
    let mut engine = scene.engine(2);
    // Away from the tissue, in contact, and late.
    engine.tick_by(&scene.poses(1.0, 0), Budget::All);
    assert_eq!(engine.force_error_n(0), None);
    for tick in 1..80 {
        engine.tick_by(&scene.poses(1.0, tick), Budget::All);
    }
    let known_n = engine.force_error_n(0).unwrap();
    assert!(known_n > 0.0);
    assert_eq!(engine.force_error_n(1), None);
    // A late tick is as far off as the last one where nothing moves, and else farther.
    engine.tick_by(&scene.poses(1.0, 79), Budget::LATE);
    assert_eq!(engine.force_error_n(0), Some(known_n));
    engine.tick_by(&scene.poses(1.0, 80), Budget::LATE);
    assert!(engine.force_error_n(0).unwrap() > known_n);
    // After a restore a late tick has nothing to begin from; nor has one after a release.
    let saved = engine.save().unwrap();
    engine.restore(&saved).unwrap();
    engine.tick_by(&scene.poses(1.0, 80), Budget::LATE);
    assert_eq!(engine.force_error_n(0), None);
    engine.tick_by(&scene.poses(1.0, 80), Budget::All);
    assert!(engine.force_error_n(0).is_some());
    let mut away = scene.poses(1.0, 80);
    away[0].engaged = 0;
    engine.tick_by(&away, Budget::LATE);
    engine.tick_by(&scene.poses(1.0, 80), Budget::LATE);
    assert_eq!(engine.force_error_n(0), None);
    engine.tick_by(&scene.poses(1.0, 80), Budget::All);
    // Held back by a limit.
    engine.tick_by(&scene.poses(1.0, 81), Budget::All);
    let mut deep = scene.poses(1.0, 81)[0];
    deep.position_m.z -= 0.5;
    let output = engine.tick(&deep);
    assert!(output.flags.contains(Flags::MOTION_CLAMPED));
    assert_eq!(engine.force_error_n(0), None);
    // Another scheme, and links.
    let step_m = Settings::for_model(&model(&image)).max_tool_step_m;
    let links = baked("organ:300", &BakeOptions::default());
    for (image, scheme) in [(&image, Scheme::Track), (&links, Scheme::Predict)] {
        let mut engine = under(image, scene.contact.clone(), (scheme, 2), step_m).unwrap();
        for tick in 0..80 {
            engine.tick_by(&scene.poses(1.0, tick), Budget::All);
        }
        assert!(engine.tool_output(0).contacts > 0);
        assert_eq!(engine.force_error_n(0), None);
    }
}

/// Cells held in a body that relaxes wait in late ticks; of a body that can be cut nothing is known once a face is
/// open.
// REQ-FOR-09
#[test]
fn nothing_is_said_of_held_cells_that_wait_and_of_a_cut_body() {
    let image_of = |kind| image("organ:300", 0.45, kind);
    let relaxing = image_of(Kind::Relaxing([[1.0, 0.1], [1.0, 2.0]]));
    let scene = Scene::new(&relaxing, Touch::Held(3));
    let mut engine = scene.engine(2);
    (0..80).for_each(|tick| _ = engine.tick_by(&scene.poses(1.0, tick), Budget::All));
    assert!(engine.force_error_n(0).is_some());
    engine.tick_by(&scene.poses(1.0, 80), Budget::LATE);
    assert_eq!(engine.force_error_n(0), None);
    engine.tick_by(&scene.poses(1.0, 80), Budget::All);
    assert!(engine.force_error_n(0).is_some());
    // A ball that presses, and a blade that comes down beside it.
    let cuttable = image_of(Kind::Cuttable);
    let mut scene = Scene::new(&cuttable, Touch::Balls { count: 1, radius: 2.0, friction: 0.0 });
    if let Contact::Tools { tools, .. } = &mut scene.contact {
        tools.push(vec![ToolPart::edge((2.0 * scene.unit_m) as f32)]);
    }
    let mut engine = scene.engine(2);
    let mut opened = 0;
    for tick in 0..400 {
        let below_m = scene.unit_m * (1.0 - 0.01 * f64::from(tick));
        let blade_m = scene.top_m + Vector3::new(2.5 * scene.unit_m, 0.0, below_m);
        let mut poses = scene.poses(1.0, tick.min(80));
        poses.push(ToolPose::at(blade_m.map(|x| x as f32), 1));
        // Ends by the error, where that is known.
        let output = engine.tick_by(&poses, Budget::Within { share: 0.5, more: None });
        let cut = engine.cut().unwrap();
        if tick > 60 {
            assert_eq!(engine.force_error_n(0).is_some(), cut.opened_faces == 0, "tick {tick}");
            assert!(opened == 0 || output.sweeps == 2, "tick {tick}: {} sweeps", output.sweeps);
        }
        opened = cut.opened_faces;
    }
    assert!(opened > 0);
}

/// Mean sweeps of a motion in contact, and the 99th percentile of the error over the largest force.
fn sweeps_and_error(
    scene: &Scene<'_>,
    budget: impl Fn() -> Budget<'static>,
    most: u16,
) -> [f64; 2] {
    let (mut few, mut many) = (scene.engine(most), scene.engine(MANY));
    let (mut sweeps, mut errors, mut largest_n) = (Vec::new(), Vec::new(), 0.0_f32);
    for tick in 0..600 {
        let poses = scene.poses(2.2, tick);
        let truth = (tick % 5 == 0).then(|| {
            many.restore(&few.save().unwrap()).unwrap();
            many.tick_by(&poses, Budget::All).force_n
        });
        let output = few.tick_by(&poses, budget());
        if output.contacts > 0 && output.force_n.norm() > 0.0 {
            sweeps.push(f64::from(output.sweeps));
            largest_n = largest_n.max(output.force_n.norm());
            errors.extend(truth.map(|truth| (output.force_n - truth).norm()));
        }
    }
    errors.sort_by(f32::total_cmp);
    let mean = sweeps.iter().sum::<f64>() / sweeps.len() as f64;
    [mean, (errors[errors.len() * 99 / 100] / largest_n).into()]
}

#[test]
fn a_tick_that_ends_by_its_error_saves_sweeps() {
    let image = image("organ:420", 0.42, Kind::Elastic);
    let scene = Scene::new(&image, Touch::Balls { count: 1, radius: 2.0, friction: 0.0 });
    let fixed: Vec<[f64; 2]> =
        (1..=8).map(|most| sweeps_and_error(&scene, || Budget::All, most)).collect();
    println!("fixed sweeps, error: {fixed:.4?}");
    for (share, most) in [(0.01, 0.9), (0.03, 0.85), (0.1, 0.9)] {
        let [mean, error] = sweeps_and_error(&scene, || Budget::Within { share, more: None }, 8);
        // As many fixed sweeps as reach that error.
        let enough =
            fixed.iter().find(|[_, of_fixed]| *of_fixed <= error).map_or(9.0, |[of, _]| *of);
        println!("within {share}: {mean:.2} sweeps, error {error:.4}; as {enough} fixed ones");
        assert!(mean > 1.0 && mean < most * enough, "{share}: {mean} {error} {fixed:?}");
    }
}
