//! Tools on a contact surface: where their force is taken, friction, parts, turns and torque, several at once,
//! grips, and what each contact does.
#![allow(clippy::unwrap_used)]

use chaincell_host::bake::{BakeOptions, ImageBytes};
use chaincell_host::engine::{Contact, Engine, Scheme};
use chaincell_kernel::{Budget, Flags, ToolPart, ToolPose};
use chaincell_tests::bodies::{baked, nodal, under};
use nalgebra::Vector3;

/// Height of the top of the block \[m\].
const TOP_M: f32 = 0.04;

/// A block on a fixed ground, 40 mm high, with edges of about 8 mm.
const BLOCK: &str = "box:11x11x6x0.008";

/// Of liver.
fn block() -> ImageBytes {
    nodal(BLOCK, 5000.0)
}

/// The same of nodal shapes and of links.
fn blocks() -> [(&'static str, ImageBytes); 2] {
    [("shapes", block()), ("links", baked(BLOCK, &BakeOptions::default()))]
}

fn engine(image: &ImageBytes, tools: Vec<Vec<ToolPart>>, friction: f32, sweeps: u16) -> Engine<'_> {
    under(image, Contact::Tools { tools, friction }, (Scheme::Predict, sweeps), 0.01).unwrap()
}

fn pose(position_m: [f32; 3]) -> ToolPose {
    ToolPose::at(position_m.into(), 1)
}

/// About y by an angle \[rad\].
fn tilted(position_m: [f32; 3], angle: f32) -> ToolPose {
    let (sin, cos) = (0.5 * angle).sin_cos();
    ToolPose { orientation: [0.0, sin, 0.0, cos], ..pose(position_m) }
}

/// Forces of all contacts of a tool, along the normals and across them.
fn contacts(engine: &mut Engine<'_>, tool: u8) -> [Vector3<f32>; 2] {
    let of = engine.contact_forces();
    let own = || of.iter().filter(|contact| contact.tool == tool);
    [
        own().map(|c| Vector3::from(c.normal_n)).sum(),
        own().map(|c| Vector3::from(c.tangential_n)).sum(),
    ]
}

// REQ-CON-07
#[test]
fn a_tool_that_slips_is_held_back_by_the_coefficient() {
    let blocks = blocks();
    let cases =
        blocks.iter().flat_map(|block| [0.012_f32, 0.006].map(|radius_m| (block, radius_m)));
    for ((body, image), radius_m) in cases {
        let mut engine = engine(image, vec![vec![ToolPart::sphere(radius_m)]], 0.3, 8);
        let height = |depth_m: f32| TOP_M + radius_m - depth_m;
        let mut work = 0.0_f64;
        let mut tick = |engine: &mut Engine<'_>, x_m: f32, depth_m: f32| {
            work += f64::from(
                engine.tick_by(&[pose([x_m, 0.001, height(depth_m)])], Budget::All).work_j,
            );
        };
        for step in -20..=100_i16 {
            tick(&mut engine, -0.01, f32::from(step) * 3.0e-5);
        }
        let mut ratios = Vec::new();
        for step in 0..=200_u16 {
            tick(&mut engine, -0.01 + f32::from(step) * 1.0e-4, 0.003);
            if step > 120 {
                let [_, across] = contacts(&mut engine, 0);
                let pressed: f32 = (engine.contact_forces().iter())
                    .map(|contact| Vector3::from(contact.normal_n).norm())
                    .sum();
                ratios.push(across.norm() / pressed);
            }
        }
        let [low, high] = ratios.iter().fold([f32::MAX, 0.0], |[a, b], r| [a.min(*r), b.max(*r)]);
        // A triangle's samples press in several directions: less together than one by one.
        assert!(low > 0.27 && high <= 0.31, "{body}, {radius_m}: {low} to {high}");
        // Back and out: the whole cycle took energy from the hand.
        for step in (0..=200_u16).rev() {
            tick(&mut engine, -0.01 + f32::from(step) * 1.0e-4, 0.003);
        }
        for step in (-20..=100_i16).rev() {
            tick(&mut engine, -0.01, f32::from(step) * 3.0e-5);
        }
        assert!(work > 0.0, "{body}, {radius_m}: {work}");
    }
}

// REQ-FOR-08
#[test]
fn the_force_is_that_at_the_points_of_the_next_pass_and_the_level_bounds_it() {
    let blocks = blocks();
    for ((body, image), friction) in blocks.iter().flat_map(|block| [(block, 0.0), (block, 0.3)]) {
        let mut engine = engine(image, vec![vec![ToolPart::sphere(0.01)]], friction, 1);
        let (mut ahead, mut discarded) = (0, 0);
        for step in 0..=400_u16 {
            // From 1 mm above 9 mm deep at 0.4 m/s, then still.
            let depth_m = 4.0e-4 * f32::from(step.min(25)) - 0.001;
            let at = pose([0.001, 0.002, TOP_M + 0.01 - depth_m]);
            let output = engine.tick_by(&[at], Budget::All);
            let (force_n, [normal_n, across_n]) = (output.force_n, contacts(&mut engine, 0));
            let off_n = (normal_n + across_n - force_n).norm();
            assert!(off_n <= 1e-4 * force_n.norm(), "{body}, tick {step}: {off_n} N");
            assert!(output.contacts > 0 || force_n.norm() == 0.0, "{body}, tick {step}");
            let most_n = (2.0 * output.stiffness_n_per_m * output.energy_j).sqrt();
            let is_bounded = friction > 0.0 || force_n.norm() <= 1.001 * most_n;
            assert!(is_bounded, "{body}, tick {step}: {force_n} N, {most_n} N");
            let is_ahead = engine.contact_positions(0) != engine.positions();
            let is_discarded = output.flags.contains(Flags::ROLLED_BACK);
            assert!(
                !is_ahead || (friction == 0.0 && *body == "shapes" && !is_discarded),
                "{body}, tick {step}"
            );
            ahead += usize::from(is_ahead);
            discarded += usize::from(is_discarded);
        }
        assert_eq!(
            ahead > 20,
            friction == 0.0 && *body == "shapes",
            "{body}: {ahead} ticks, {discarded} discarded"
        );
        // A body at rest is where its next pass will be.
        let (next, here) = (engine.contact_positions(0), engine.positions());
        let pairs = next.as_flattened().iter().zip(here.as_flattened());
        let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4, "{body}: {off} mean link lengths");
    }
}

// REQ-CON-08
#[test]
fn friction_sticks_until_it_slips() {
    let image = block();
    let mut engine = engine(&image, vec![vec![ToolPart::sphere(0.01)]], 0.3, 8);
    let at = |x_m: f32, depth_m: f32| pose([x_m, 0.0, TOP_M + 0.01 - depth_m]);
    for step in 0..=100_u8 {
        engine.tick_by(&[at(0.0, f32::from(step) * 3.0e-5)], Budget::All);
    }
    // Pressed in, the tissue slides along the sphere's sides.
    let [_, start] = contacts(&mut engine, 0);
    let drag = |engine: &mut Engine<'_>, from_m: f32, to_m: f32| {
        for step in 0..=40_u8 {
            let x_m = from_m + (to_m - from_m) * f32::from(step) / 40.0;
            engine.tick_by(&[at(x_m, 0.003)], Budget::All);
        }
        contacts(engine, 0)
    };
    // A tenth of a millimetre holds, and back leaves little.
    let [normal, across] = drag(&mut engine, 0.0, 1.0e-4);
    let held = start.x - across.x;
    assert!(held > 0.01 * normal.norm() && held < 0.2 * normal.norm(), "{held} {normal}");
    let [_, back] = drag(&mut engine, 1.0e-4, 0.0);
    assert!((back.x - start.x).abs() < 0.5 * held, "{back} {start} {held}");
    // Five millimetres slip.
    let [normal, across] = drag(&mut engine, 0.0, 5.0e-3);
    assert!(across.norm() > 0.27 * normal.norm(), "{across} {normal}");
}

/// Work of a slow press with every kind of part, turned on the way: what the body holds, and nothing
/// behind a closed cycle.
// REQ-CON-07
#[test]
fn work_of_force_and_torque_is_the_energy() {
    let image = block();
    for part in [
        ToolPart::capsule(0.008, 0.004),
        ToolPart::rounded_box([0.006, 0.004, 0.003], 0.004),
        ToolPart::half_space(0.004),
    ] {
        let mut engine = engine(&image, vec![vec![part]], 0.0, 16);
        // A half space is what lies below its plane: turned over.
        let (over, reach_m) = if part.is_half_space() {
            (std::f32::consts::PI, 0.0)
        } else {
            (0.0, part.half_m[2] + part.radius_m)
        };
        let path = |share: f32| {
            let depth_m = 0.002 * share - 0.0005;
            tilted([0.001, 0.0, TOP_M + reach_m - depth_m], over + 0.1 * share)
        };
        let mut work = 0.0;
        for step in 0..=400_u16 {
            work += f64::from(engine.tick_by(&[path(f32::from(step) / 400.0)], Budget::All).work_j);
        }
        let pressed = engine.tick_by(&[path(1.0)], Budget::All);
        let output = engine.tool_output(0);
        let energy = f64::from(pressed.energy_j);
        assert!(output.force_n.z > 0.01 && output.torque_n_m.norm() > 1e-5, "{output:?}");
        assert!((work / energy - 1.0).abs() < 0.02, "{part:?}: {work} {energy}");
        for step in (0..=400_u16).rev() {
            work += f64::from(engine.tick_by(&[path(f32::from(step) / 400.0)], Budget::All).work_j);
        }
        assert!(work.abs() < 0.01 * energy, "{part:?}: {work} of {energy}");
    }
}

#[test]
fn two_tools_feel_what_two_parts_of_one_feel() {
    let image = block();
    let ball = ToolPart::sphere(0.006);
    let beside = ToolPart { centre_m: [0.02, 0.0, 0.0], ..ball };
    let mut one = engine(&image, vec![vec![ball, beside]], 0.2, 6);
    let mut two = engine(&image, vec![vec![ball], vec![ball]], 0.2, 6);
    for step in 0..120_u8 {
        let depth_m = f32::from(step.min(60)) * 4.0e-5;
        let x_m = -0.01 + f32::from(step.saturating_sub(60)) * 1.0e-4;
        let at = [x_m, 0.0, TOP_M + 0.006 - depth_m];
        one.tick_by(&[pose(at)], Budget::All);
        two.tick_by(&[pose(at), pose([at[0] + 0.02, at[1], at[2]])], Budget::All);
    }
    let [a, b] = [two.tool_output(0), two.tool_output(1)];
    let whole = one.tool_output(0);
    let sum = a.force_n + b.force_n;
    assert!((sum - whole.force_n).norm() < 1e-3 * sum.norm(), "{sum} {}", whole.force_n);
    // Torque about the first ball: the second one's force on an arm of 20 mm.
    let torque = a.torque_n_m + b.torque_n_m + Vector3::new(0.02, 0.0, 0.0).cross(&b.force_n);
    assert!((torque - whole.torque_n_m).norm() < 2e-3 * torque.norm(), "{torque} {whole:?}");
    // A tool that lets go feels nothing, and the other stays.
    let mut free = pose([0.0, 0.0, TOP_M]);
    free.engaged = 0;
    let kept = pose([0.016, 0.0, TOP_M + 0.006 - 0.0024]);
    two.tick_by(&[free, kept], Budget::All);
    assert_eq!(two.tool_output(0).force_n.norm(), 0.0);
    assert!(two.tool_output(1).force_n.z > 0.01);
}

// REQ-CON-08
#[test]
fn a_grip_pulls_until_it_is_let_go_without_a_jump() {
    for (body, image) in blocks() {
        grip_and_let_go(body, &image);
    }
}

fn grip_and_let_go(body: &str, image: &ImageBytes) {
    let mut engine = engine(image, vec![vec![ToolPart::sphere(0.008)]], 0.0, 8);
    let at = |height_m: f32| pose([0.0, 0.0, TOP_M + 0.008 + height_m]);
    for step in 0..=60_u8 {
        engine.tick_by(&[at(-5.0e-5 * f32::from(step))], Budget::All);
    }
    let before = engine.tool_output(0).force_n;
    assert!(engine.grip(0) > 4);
    engine.tick_by(&[at(-0.003)], Budget::All);
    assert!((engine.tool_output(0).force_n - before).norm() < 0.02 * before.norm());
    // Up again: from the surface on it pulls the tissue along.
    for step in 0..=120_u8 {
        engine.tick_by(&[at(-0.003 + 5.0e-5 * f32::from(step))], Budget::All);
    }
    let mut last = engine.tool_output(0).force_n;
    assert!(last.z < -0.01, "{body}: {last}");
    let pulled = last.norm();
    engine.let_go(0, 50);
    let mut largest = 0.0_f32;
    for _ in 0..60 {
        engine.tick_by(&[at(0.003)], Budget::All);
        let force = engine.tool_output(0).force_n;
        largest = largest.max((force - last).norm());
        last = force;
    }
    assert!(
        largest < 0.08 * pulled && last.norm() < 0.01 * pulled,
        "{body}: {largest} {last} {pulled}"
    );
}

/// A square sheet of links, 160 mm wide, whose border is fixed.
fn sheet() -> ImageBytes {
    baked("plane:17x17x0.01", &BakeOptions::default())
}

/// The tool lifts off while its grip is released, and the sheet falls back out of its reach.
// REQ-CON-08
#[test]
fn a_grip_that_is_let_go_while_the_tool_lifts_off_fades_and_never_comes_back() {
    const RADIUS_M: f32 = 0.012;
    let image = sheet();
    for step_m in [5.0e-5_f32, 2.0e-4, 1.0e-3] {
        let mut engine = engine(&image, vec![vec![ToolPart::sphere(RADIUS_M)]], 0.0, 8);
        let tick = |engine: &mut Engine<'_>, height_m: f32| {
            engine.tick_by(&[pose([0.0, 0.0, height_m + RADIUS_M])], Budget::All);
            engine.tool_output(0).force_n
        };
        // Press, grip and lift the sheet.
        for step in 0..80_u8 {
            tick(&mut engine, 0.001 - 5.0e-5 * f32::from(step));
        }
        assert!(engine.grip(0) > 0);
        let mut last = Vector3::zeros();
        for step in 0..500_u16 {
            last = tick(&mut engine, 5.0e-5 * f32::from(step) - 0.003);
        }
        assert!(last.z < -0.02, "{last}");
        // Let go while lifting off: the pull falls smoothly to exactly 0.
        engine.let_go(0, 50);
        let (mut largest, mut jump) = (last.norm(), 0.0_f32);
        for number in 1..=60_u8 {
            let force = tick(&mut engine, 0.022 + step_m * f32::from(number));
            jump = jump.max((force - last).norm());
            largest = largest.max(force.norm());
            last = force;
        }
        assert!(jump < 0.1 * largest, "{step_m}: {jump} of {largest}");
        assert_eq!((engine.gripped(0), last.norm()), (0, 0.0), "{step_m}");
        // Back to the sheet, and into it: nothing pulls any more.
        for step in 0..150_u8 {
            last = tick(&mut engine, 0.001 - 5.0e-5 * f32::from(step));
            assert!(last.z >= 0.0, "{step_m}, {step}: {last}");
        }
        assert!(last.z > 0.0, "{step_m}: {last}");
    }
}

#[test]
fn contacts_are_where_the_tool_is() {
    for (body, image) in blocks() {
        let mut engine = engine(&image, vec![vec![ToolPart::sphere(0.012)]], 0.3, 6);
        for step in 0..150_u8 {
            let x_m = f32::from(step.saturating_sub(80)) * 5.0e-5;
            engine.tick_by(
                &[pose([x_m, 0.0, TOP_M + 0.012 - f32::from(step.min(80)) * 4.0e-5])],
                Budget::All,
            );
        }
        let each = engine.contact_forces();
        assert_eq!(each.len(), engine.tool_output(0).contacts as usize, "{body}");
        for contact in &each {
            let place = Vector3::from(contact.position_m);
            assert!((place.z - TOP_M).abs() < 0.004 && contact.area_m2 > 0.0, "{contact:?}");
            assert!((contact.tool, contact.part) == (0, 0));
        }
    }
}

// REQ-CON-09
#[test]
fn tools_that_cannot_be_are_refused_by_name() {
    let image = block();
    let why = |tools: Vec<Vec<ToolPart>>, friction| {
        let contact = Contact::Tools { tools, friction };
        under(&image, contact, (Scheme::Track, 4), 0.01).map(drop).unwrap_err().to_string()
    };
    let ball = || vec![ToolPart::sphere(0.01)];
    assert!(why(vec![], 0.0).contains("1 to 8"));
    assert!(why(vec![ball(); 9], 0.0).contains("1 to 8"));
    assert!(why(vec![ball(), vec![]], 0.0).contains("tool 1 must have 1 to 8 parts"));
    assert!(why(vec![vec![ToolPart::sphere(-1.0)]], 0.0).contains("part 0 of tool 0"));
    assert!(why(vec![ball()], -0.1).contains("friction must be 0 to 10"));
    assert!(why(vec![ball()], f32::NAN).contains("friction must be"));
    assert!(why(vec![vec![ToolPart::sphere(1.0e-5)]], 0.0).contains("radius"));
}

/// An upright capsule that the tissue has stopped, turned out of it until it lies above the surface.
#[test]
fn a_tool_that_turns_out_of_the_tissue_is_free() {
    for (body, image) in blocks() {
        for aside_m in [0.0, 0.003] {
            let mut engine = engine(&image, vec![vec![ToolPart::capsule(0.01, 0.004)]], 0.0, 4);
            let mut tick = |z_m: f32, angle: f32| {
                engine.tick_by(&[tilted([aside_m, 0.001, TOP_M + z_m], angle)], Budget::All)
            };
            let mut stopped = 0;
            for step in 0..500_u16 {
                let output = tick(0.019 - 0.012 * f32::from(step) / 500.0, 0.0);
                stopped += u32::from(output.flags.contains(Flags::MOTION_CLAMPED));
            }
            assert!(stopped > 0, "{body}: never stopped");
            for step in 0..500_u16 {
                tick(0.007, 1.6 * f32::from(step) / 500.0);
            }
            let last = (0..300).map(|_| tick(0.007, 1.6)).last().unwrap();
            assert!(!last.flags.contains(Flags::MOTION_CLAMPED), "{body}, {aside_m}: {last:?}");
            assert!(last.force_n == Vector3::zeros(), "{body}, {aside_m}: {last:?}");
        }
    }
}
