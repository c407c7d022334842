//! Tools that are engaged inside the tissue or in contact with it: the force never points inwards, and
//! never jumps to more than what stays.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::tissue::Tissue;
use chaincell_host::bake::{BakeOptions, ContactSurface, ImageBytes, PerCell};
use chaincell_host::engine::{Arithmetic, Contact, Engine, Scheme};
use chaincell_kernel::Budget;
use chaincell_kernel::{Flags, Model, Network, Settings, TickOutput, ToolPart, ToolPose};
use chaincell_tests::bodies::baked;

/// Height of the top \[m\].
const TOP_M: f32 = 0.04;
const RADIUS_M: f32 = 0.01;
/// Beyond the middle of the top, off the nodes \[m\].
const ASIDE_M: f32 = 0.001;
/// Of the side along x \[m\].
const SIDE_M: f32 = 0.045;
/// What rounding makes of no force at all \[N\].
const NOTHING_N: f32 = 1e-6;

/// A body that a tool presses from above.
struct Case {
    name: String,
    image: ImageBytes,
    contact: Contact,
    /// From its centre to its lowest point \[m\].
    reach_m: f32,
}

fn image(is_shapes: bool, lean: bool) -> ImageBytes {
    let tissue = Tissue::new(PerCell::Uniform(2.0e4), PerCell::Uniform(0.45));
    let tissue = is_shapes.then_some(tissue);
    let contact_surface = ContactSurface::Yes;
    let options = BakeOptions { tissue, lean, contact_surface, ..BakeOptions::default() };
    baked("box:10x10x5x0.01", &options)
}

/// Every kind of tool on every kind of body.
fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let ball = ToolPart::sphere(RADIUS_M);
    let aside = |part: ToolPart, x: f32| ToolPart { centre_m: [x, 0.0, 0.0], ..part };
    let tools = [
        ("sphere", vec![ball], RADIUS_M),
        ("box", vec![ToolPart::rounded_box([0.006, 0.004, 0.002], 0.008)], 0.01),
        ("capsule", vec![ToolPart { half_m: [0.012, 0.0, 0.0], ..ball }], RADIUS_M),
        ("upright", vec![ToolPart::capsule(0.003, 0.007)], RADIUS_M),
        ("two parts", vec![aside(ball, -0.009), aside(ToolPart::sphere(0.007), 0.008)], RADIUS_M),
    ];
    for (kind, is_shapes, lean) in
        [("links", false, false), ("lean links", false, true), ("shapes", true, false)]
    {
        for (tool, parts, reach_m) in &tools {
            let image = image(is_shapes, lean);
            let contact = Contact::Tools { tools: vec![parts.clone()], friction: 0.0 };
            let (name, reach_m) = (format!("{kind}, {tool}"), *reach_m);
            cases.push(Case { name, image, contact, reach_m });
        }
    }
    cases
}

impl Case {
    fn engine(&self, scheme: Scheme, sweeps: u16) -> Engine<'_> {
        let model = Model::from_bytes(self.image.as_bytes()).unwrap();
        let settings = Settings { sweeps, ..Settings::for_model(&model) };
        let network = Network::new(model, settings).unwrap();
        Engine::with_contact(network, scheme, Arithmetic::F32, self.contact.clone()).unwrap()
    }
}

/// What a tool does in a tick: how far its middle is outside the body, and whether it is engaged.
type Act = (f32, u32);

/// From above, and from the side.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Way {
    Down,
    Aside,
}

impl Way {
    fn pose(self, (out_m, engaged): Act) -> ToolPose {
        let place = match self {
            Self::Down => [ASIDE_M, ASIDE_M, TOP_M + out_m],
            Self::Aside => [SIDE_M + out_m, ASIDE_M, 0.5 * TOP_M + ASIDE_M],
        };
        ToolPose::at(place.into(), engaged)
    }

    /// Force out of the body \[N\].
    fn outward_n(self, output: &TickOutput) -> f32 {
        match self {
            Self::Down => output.force_n.z,
            Self::Aside => output.force_n.x,
        }
    }
}

/// A tool that goes one way, and what must hold in each of its ticks.
struct Run<'a> {
    engine: Engine<'a>,
    way: Way,
    name: String,
}

impl Run<'_> {
    /// One tick; the force out of the body.
    fn tick(&mut self, act: Act) -> (f32, TickOutput) {
        let pose = self.way.pose(act);
        let output = self.engine.tick(&pose);
        let outward_n = self.way.outward_n(&output);
        assert!(outward_n >= -NOTHING_N, "{} {act:?}: {output:?}", self.name);
        if waits(&output) {
            let TickOutput { force_n, contacts, stiffness_n_per_m, .. } = output;
            let felt = (force_n.norm(), contacts, stiffness_n_per_m);
            assert_eq!(felt, (0.0, 0, 0.0), "{} {act:?}: {output:?}", self.name);
        }
        (outward_n, output)
    }

    /// Stays for a number of ticks; returns the last output.
    fn stay(&mut self, act: Act, ticks: u16) -> (f32, TickOutput) {
        (0..ticks).map(|_| self.tick(act)).last().unwrap()
    }

    /// Goes from one place to another, engaged, 0.1 mm a tick; the last tick.
    fn go(&mut self, from_m: f32, to_m: f32) -> (f32, TickOutput) {
        let ticks = ((to_m - from_m).abs() / 1.0e-4).round().max(1.0);
        let part = |tick: u16| from_m + (to_m - from_m) * f32::from(tick) / ticks;
        (1..=ticks as u16).map(|tick| self.tick((part(tick), 1))).last().unwrap()
    }
}

fn waits(output: &TickOutput) -> bool {
    output.flags.contains(Flags::STARTS_INSIDE)
}

/// Every case, each way and under the schemes with most and least sweeps.
fn each(mut check: impl FnMut(&Case, Scheme, &mut dyn FnMut() -> Run<'static>)) {
    for case in cases() {
        let case: &'static Case = Box::leak(Box::new(case));
        for (scheme, sweeps) in [(Scheme::Track, 4), (Scheme::Predict, 1)] {
            for way in [Way::Down, Way::Aside] {
                // Others reach another way aside than down.
                let is_round = case.name.ends_with("sphere");
                if way == Way::Aside && !is_round {
                    continue;
                }
                let name = format!("{}, {scheme:?}, {way:?}", case.name);
                let mut run = || {
                    let engine = case.engine(scheme, sweeps);
                    Run { engine, way, name: name.clone() }
                };
                check(case, scheme, &mut run);
            }
        }
    }
}

/// It has no force and says so until it was outside; then it presses as any other.
// REQ-CON-10
#[test]
fn a_tool_engaged_inside_waits_until_it_was_outside() {
    each(|case, scheme, start| {
        for depth_m in [0.0005, 0.0025, 0.019] {
            let mut run = start();
            let (_, output) = run.stay((-depth_m, 1), 30);
            assert!(waits(&output), "{}: {output:?}", run.name);
            let (out_m, pressed_m) = (2.5 * RADIUS_M, case.reach_m - 0.003);
            let (_, output) = run.go(-depth_m, out_m);
            assert!(!waits(&output), "{}: {output:?}", run.name);
            let (force_n, _) = run.go(out_m, pressed_m);
            let mut fresh = start();
            fresh.stay((out_m, 1), 1);
            let (wanted_n, _) = fresh.go(out_m, pressed_m);
            // A tick with one sweep is far from the equilibrium, and so are two of them.
            let most = if scheme == Scheme::Track { 0.01 } else { 0.3 };
            let is_near = (force_n - wanted_n).abs() <= most * wanted_n;
            assert!(wanted_n > 1.0e-3 && is_near, "{}: {force_n} {wanted_n}", run.name);
        }
    });
}

/// A clutch, a new controller (a release of a tick) and a reset, with the middle below the surface.
// REQ-CON-10
#[test]
fn a_tool_that_takes_hold_again_is_not_drawn_in() {
    each(|case, _, start| {
        for gap in [Some(1), Some(2), Some(5), Some(50), None] {
            let mut run = start();
            run.stay((case.reach_m + 1.0e-3, 1), 1);
            let pressed = (-0.0025, 1);
            let (force_n, _) = run.go(case.reach_m + 1.0e-3, pressed.0);
            assert!(force_n > 0.01, "{}: {force_n}", run.name);
            match gap {
                Some(ticks) => drop(run.stay((pressed.0, 0), ticks)),
                None => run.engine.reset().unwrap(),
            }
            let (_, output) = run.stay(pressed, 100);
            let is_slow = gap.is_none_or(|ticks| ticks > 20);
            assert!(waits(&output) || !is_slow, "{} {gap:?}: {output:?}", run.name);
        }
    });
}

/// The force of a tool that is engaged in contact goes up along a ramp.
// REQ-CON-11
#[test]
fn a_tool_engaged_in_contact_presses_along_a_ramp() {
    each(|case, scheme, start| {
        if case.name.contains("upright") {
            return;
        }
        for deep in [0.25, 0.5] {
            let mut run = start();
            let act = (case.reach_m - deep * RADIUS_M, 1);
            let forces: Vec<f32> = (0..200).map(|_| run.tick(act).0).collect();
            let (first, end) = (forces[0], forces[199]);
            let most = forces.iter().fold(0.0, |most: f32, force| most.max(*force));
            let name = format!("{}, {deep}: {first} {most} {end}", run.name);
            assert!(end > 1.0e-3 && first <= 1.05 * end, "{name}");
            assert!(most < if scheme == Scheme::Track { 1.05 } else { 1.5 } * end, "{name}");
        }
    });
}

/// A snapshot of a tool that waits, or grows, goes on with the same bits.
// REQ-CON-10
#[test]
fn a_snapshot_knows_that_a_tool_waits() {
    for case in cases() {
        for start_m in [-0.003, 0.6 * case.reach_m] {
            let run = || Run {
                engine: case.engine(Scheme::Predict, 2),
                way: Way::Down,
                name: case.name.clone(),
            };
            let (mut one, mut other) = (run(), run());
            one.stay((start_m, 1), 10);
            other.stay((0.5, 1), 3);
            let saved = one.engine.save().unwrap();
            other.engine.restore(&saved).unwrap();
            for tick in 0..400_u16 {
                let up_m = start_m + 1.0e-4 * f32::from(tick.min(200));
                let act = (up_m - 1.0e-4 * f32::from(tick.saturating_sub(200)), 1);
                let [a, b] = [&mut one, &mut other].map(|run| {
                    let (_, output) = run.tick(act);
                    (output, run.engine.state_hash())
                });
                assert_eq!(a, b, "{} {start_m} tick {tick}", case.name);
            }
        }
    }
}

/// Late ticks and bad poses neither end the wait nor forget it.
// REQ-CON-10
#[test]
fn a_late_tick_and_a_bad_pose_leave_a_tool_waiting() {
    for case in cases() {
        let mut engine = case.engine(Scheme::Track, 4);
        let mut tick = |act, sweeps, is_bad| {
            let mut pose = Way::Down.pose(act);
            if is_bad {
                pose.position_m.x = f32::NAN;
            }
            engine.tick_by(&[pose], Budget::again(sweeps))
        };
        for n in 0..40 {
            // A surface is looked at in ticks with sweeps alone.
            let sweeps = (n % 3 == 2).then_some(0);
            let output = tick((-0.002, 1), sweeps, n % 5 == 4);
            let name = format!("{} tick {n}: {output:?}", case.name);
            assert!(waits(&output) && output.force_n.norm() == 0.0, "{name}");
        }
        let output = tick((0.5, 1), None, false);
        assert!(!waits(&output), "{}: {output:?}", case.name);
    }
}

/// Of two tools one waits and the other presses as if it were alone.
// REQ-CON-10
#[test]
fn one_of_two_tools_waits() {
    let ball = vec![ToolPart::sphere(RADIUS_M)];
    for is_shapes in [false, true] {
        let image = image(is_shapes, false);
        let force_n = |tools: Vec<Vec<ToolPart>>, inside: bool| {
            let contact = Contact::Tools { tools, friction: 0.0 };
            let case = Case { name: String::new(), image: image.clone(), contact, reach_m: 0.0 };
            let mut engine = case.engine(Scheme::Track, 4);
            let at = |x: f32, z: f32| ToolPose::at([x, ASIDE_M, TOP_M + z].into(), 1);
            let mut last = [0.0; 2];
            for tick in 0..200_u16 {
                let down_m = 1.2 * RADIUS_M - 1.0e-4 * f32::from(tick.min(60));
                let poses = [at(-0.02, down_m), at(0.025, -0.012)];
                let output = engine.tick_by(if inside { &poses } else { &poses[..1] }, Budget::All);
                assert_eq!(waits(&output), inside);
                last = [0, 1].map(|tool| engine.tool_output(tool).force_n.z);
            }
            last
        };
        let [alone_n, _] = force_n(vec![ball.clone()], false);
        let [presses_n, waits_n] = force_n(vec![ball.clone(), ball.clone()], true);
        assert!(
            alone_n > 0.05 && (presses_n / alone_n - 1.0).abs() < 0.01,
            "{alone_n} {presses_n}"
        );
        assert_eq!(waits_n, 0.0);
    }
}

/// All that lies below a plane pushes all tissue the same way: it has no inside.
// REQ-CON-10
#[test]
fn a_half_space_presses_wherever_it_is() {
    let image = image(true, false);
    let contact = Contact::Tools { tools: vec![vec![ToolPart::half_space(0.02)]], friction: 0.0 };
    let case = Case { name: "half space".into(), image, contact, reach_m: 0.0 };
    let mut engine = case.engine(Scheme::Track, 4);
    // From above, upside down.
    let pose =
        |z| ToolPose { orientation: [1.0, 0.0, 0.0, 0.0], ..ToolPose::at([0.0, 0.0, z].into(), 1) };
    let outputs: Vec<_> =
        (0..100).map(|_| engine.tick_by(&[pose(TOP_M - 0.003)], Budget::All)).collect();
    assert!(!outputs.iter().any(waits));
    assert!(outputs[99].force_n.z > 1.0 && outputs[0].force_n.z <= outputs[99].force_n.z);
}
