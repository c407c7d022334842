//! Several tools of any shape between processes: what each feels, what is recorded, what a bad message
//! and a lost client do.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::PathBuf;
use std::time::Duration;

use chaincell_tests::files::{Table, text};
use chaincell_tests::outsider::tools::{Forces, Poses, ToolForce, ToolPose, ToolsOutsider};
use chaincell_tests::outsider::{
    BAD_SAMPLE, Commander, LATE, Order, RELEASE_FIRST, SAFE, STALE, size,
};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};
use rustix::process::Signal;

/// A capsule of 15 mm half length along x.
const CAPSULE: &str = "--tool=capsule:0.015,0.004/0,0.70710678,0,0.70710678";
/// Two of them.
const TOOLS: [&str; 2] = [CAPSULE, CAPSULE];
/// Flag: shortened to a limit.
const CLAMPED: u32 = 8;
/// Ticks of a press.
const TICKS: u64 = 40;
/// Height of the top \[m\], and where the sides are.
const TOP_M: f32 = 0.03;
const SIDE_M: f32 = 0.04;

/// What is wrong with a message.
type Fault<'a> = &'a dyn Fn(&mut Poses);

/// A block of 80 mm x 80 mm x 30 mm on a fixed ground.
fn block(test: &str) -> Place {
    Place::of(test, "box:9x9x4x0.01", &["--young-pa", "5000"])
}

/// A server of both tools.
fn serve(block: &Place, options: &[&str]) -> Running {
    block.serve(&[&TOOLS, options].concat())
}

/// A server to which no silence counts as one, and whose forces are published as they are.
const PLAIN: [&str; 7] = ["--watchdog-ms", "0", "--ramp-ms", "0", "--budget-us", "off", "--json"];

/// Ticks of two presses and twenty in between.
const ALL: u64 = TICKS + 1 + 20;

/// Where tool 0 and tool 1 are: half over the sides of the block, as deep as the tick is late.
fn position_m(tick: u64, tool: u32) -> [f32; 3] {
    let x = if tool == 0 { SIDE_M } else { -SIDE_M };
    [x, 0.001, TOP_M + 0.004 - 1.0e-4 * tick.min(TICKS) as f32]
}

/// Both tools, the second in the first place, released in the first tick.
fn poses(tick: u64) -> Poses {
    let tool = |number| ToolPose {
        number,
        engaged: u16::from(tick > 0),
        position_m: position_m(tick, number),
        orientation: [0.0, 0.0, 0.0, 1.0],
        ..ToolPose::default()
    };
    let mut poses = Poses { tick, send_ns: 7, tools: 2, ..Poses::default() };
    (poses.each[0], poses.each[1]) = (tool(1), tool(0));
    poses
}

/// What is told of a tool.
fn of(forces: &Forces, number: u32) -> ToolForce {
    let in_use = &forces.each[..forces.tools as usize];
    let mut own = in_use.iter().filter(|tool| tool.number == number);
    let found = *own.next().unwrap();
    assert!(own.next().is_none());
    found
}

fn answer(outsider: &ToolsOutsider, sent: Poses) -> Forces {
    outsider.send(sent);
    outsider.receive()
}

/// The last of all answers, each of which is waited for.
fn last<T>(mut answers: impl Iterator<Item = T>) -> T {
    let first = answers.next().unwrap();
    answers.fold(first, |_, answer| answer)
}

/// Presses both tools; the last answer.
fn press(outsider: &ToolsOutsider) -> Forces {
    last((0..=TICKS).map(|tick| answer(outsider, poses(tick))))
}

/// A capsule that lies half beside the block is turned upwards at the end that lies on it.
#[test]
fn each_tool_feels_its_own_force_and_torque_and_the_session_replays() {
    let _turn = turn();
    let block = block("two-tools");
    let out = block.file("out");
    let server =
        serve(&block, &[&PLAIN[..], &["--ticks", &ALL.to_string(), "--out", text(&out)]].concat());
    let outsider = ToolsOutsider::join(&block.scene);
    let pressed = press(&outsider);
    for (number, sign) in [(0, 1.0), (1, -1.0)] {
        let ToolForce { force_n, torque_n_m, contacts, flags, .. } = of(&pressed, number);
        assert!(force_n[2] > 0.02 && contacts > 1 && flags == pressed.flags, "{pressed:?}");
        // The middle of what it lies on is some millimetres off its own.
        let arm_m = sign * torque_n_m[1] / force_n[2];
        assert!((0.001..0.015).contains(&arm_m), "tool {number}: {arm_m} m");
    }
    // One lets go: its force is gone at once, the other's stays; then it is turned with the block.
    let let_go = (TICKS + 1..TICKS + 11).map(|tick| {
        let mut sent = poses(tick);
        sent.each[0].engaged = 0;
        let found = answer(&outsider, sent);
        let gone = of(&found, 1);
        assert_eq!((gone.force_n, gone.torque_n_m, gone.contacts), ([0.0; 3], [0.0; 3], 0));
        of(&found, 0)
    });
    assert!(last(let_go).force_n[2] > 0.02);
    let turned = (TICKS + 11..TICKS + 21).map(|tick| {
        let mut sent = poses(tick);
        // About y by 0.4 rad: the end that lies on the block goes up.
        sent.each[1].orientation = [0.0, 0.198_669_33, 0.0, 0.980_066_6];
        of(&answer(&outsider, sent), 0).force_n[2]
    });
    let turned: Vec<f32> = turned.collect();
    let before = of(&pressed, 0).force_n[2];
    assert!(turned[9] < 0.9 * before, "{before} N, turned {turned:?}");
    let served = server.end(SHORT).with(0).json();
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
    assert_eq!(replayed["ticks"], ALL);
    let again = block.file("again");
    let (path, folder) = (out.join("path.csv"), text(&again));
    let args = ["run", text(&block.model), "--path", text(&path), "--recorded", "--out", folder];
    let args = [&args[..], &TOOLS, &["--json"]].concat();
    let recorded = run(args).with(0).json();
    assert_eq!(recorded["state_hash"], served["state_hash"]);
    // Both estimate the errors of the same forces.
    assert_eq!(recorded["force_error_estimate"], served["force_error_estimate"]);
    assert!(served["force_error_estimate"]["ticks"].as_u64() > Some(TICKS), "{served}");
    for name in ["tools.csv", "force.csv"] {
        let read = |folder: &PathBuf| std::fs::read_to_string(folder.join(name)).unwrap();
        assert_eq!(read(&again), read(&out), "{name}");
    }
    let table = Table::read(&out.join("tools.csv"));
    assert_eq!(
        table.header,
        "tick,tool,fx_n,fy_n,fz_n,tx_n_m,ty_n_m,tz_n_m,contacts,flags,force_error_n,torque_error_n_m"
    );
    assert_eq!(table.whole("tool")[..4], [0, 1, 0, 1]);
    assert_eq!(table.vectors("fx_n").len(), 2 * ALL as usize);
    let written = table.vectors("tx_n_m")[2 * TICKS as usize];
    assert_eq!(written.map(|x| x as f32), of(&pressed, 0).torque_n_m);
}

#[test]
fn a_message_with_a_fault_in_one_tool_is_a_bad_sample_for_all() {
    let _turn = turn();
    let block = block("bad-tools");
    let out = block.file("out");
    let server = serve(&block, &[&PLAIN[..], &["--out", text(&out)]].concat());
    let outsider = ToolsOutsider::join(&block.scene);
    // A release in it is none.
    let bad = Poses { tools: 0, ..poses(0) };
    assert_eq!(answer(&outsider, bad).flags & BAD_SAMPLE, BAD_SAMPLE);
    assert_eq!(answer(&outsider, poses(1)).flags & RELEASE_FIRST, RELEASE_FIRST);
    let later = |tick| Poses { tick: tick + 2, ..poses(tick) };
    let mut last = last((0..=TICKS).map(|tick| answer(&outsider, later(tick))));
    let faults: [(&str, Fault<'_>); 9] = [
        ("a tool twice", &|sent| sent.each[0].number = 0),
        ("a tool that is not chosen in the place of one", &|sent| sent.each[0].number = 9),
        ("one missing", &|sent| sent.tools = 1),
        ("lost count", &|sent| sent.tools = 77),
        ("a quaternion of length 2", &|sent| sent.each[0].orientation = [0.0, 0.0, 0.0, 2.0]),
        ("a quaternion of no number", &|sent| sent.each[1].orientation[2] = f32::NAN),
        ("a position of no number", &|sent| sent.each[0].position_m[1] = f32::NAN),
        ("engaged 2", &|sent| sent.each[0].engaged = 2),
        ("a reserved word", &|sent| sent.each[0].reserved = 1),
    ];
    let mut tick = TICKS + 2;
    for (what, fault) in faults {
        tick += 1;
        let mut sent = poses(tick);
        fault(&mut sent);
        let bad = answer(&outsider, sent);
        assert_eq!(bad.flags & (BAD_SAMPLE | SAFE), BAD_SAMPLE, "{what}: {bad:?}");
        assert_eq!(bad.tools, 2, "{what}");
        for number in [0, 1] {
            let [before, held] = [&last, &bad].map(|forces| of(forces, number));
            assert_eq!(held.flags, bad.flags, "{what}");
            let change = size(std::array::from_fn(|x| held.force_n[x] - before.force_n[x]));
            assert!(change < 0.05 * size(before.force_n), "{what}: by {change} N");
        }
        tick += 1;
        last = answer(&outsider, poses(tick));
        assert_eq!(last.flags & BAD_SAMPLE, 0, "{what}");
    }
    // Ten of them are borne.
    let mut bad = poses(0);
    bad.tools = 0;
    let held = (0..12).map(|_| {
        tick += 1;
        let mut sent = bad;
        sent.tick = tick;
        answer(&outsider, sent)
    });
    let held: Vec<Forces> = held.collect();
    assert!(held[..10].iter().all(|bad| bad.flags & SAFE == 0 && of(bad, 1).force_n[2] > 0.01));
    for safe in &held[10..] {
        assert_eq!(safe.flags & (BAD_SAMPLE | SAFE), BAD_SAMPLE | SAFE);
        for number in [0, 1] {
            let ToolForce { force_n, torque_n_m, flags, .. } = of(safe, number);
            assert_eq!((force_n, torque_n_m, flags & SAFE), ([0.0; 3], [0.0; 3], SAFE));
        }
    }
    let served = server.interrupt().with(130).json();
    assert_eq!(served["flag_ticks"]["bad_sample"], 1 + 9 + 12);
    let path = std::fs::read_to_string(out.join("path.csv")).unwrap();
    // In two of them the message is sound, and the pose is not.
    assert_eq!(path.lines().filter(|row| row.contains("NaN,NaN,NaN")).count(), 2 * 20, "{path}");
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
}

#[test]
fn a_tool_counts_as_released_until_it_was_released_itself() {
    let _turn = turn();
    let block = block("release-each");
    let server = serve(&block, &PLAIN);
    let outsider = ToolsOutsider::join(&block.scene);
    for tick in 0..TICKS {
        let mut sent = poses(tick + 1);
        sent.tick = tick;
        sent.each[1].engaged = u16::from(tick > 0);
        let found = answer(&outsider, sent);
        let [first, second] = [0, 1].map(|number| of(&found, number));
        assert_eq!((first.flags & RELEASE_FIRST, second.flags & RELEASE_FIRST), (0, RELEASE_FIRST));
        assert_eq!((found.flags & RELEASE_FIRST, second.force_n), (RELEASE_FIRST, [0.0; 3]));
        assert!(tick < TICKS - 1 || first.force_n[2] > 0.02, "{first:?}");
    }
    // Released above the block, it presses as the other one did.
    let held = last((0..=TICKS).map(|step| {
        let mut sent = poses(TICKS);
        sent.tick = TICKS + step;
        sent.each[0].engaged = u16::from(step > 0);
        sent.each[0].position_m = position_m(step, 1);
        let found = answer(&outsider, sent);
        assert_eq!(found.flags & RELEASE_FIRST, 0);
        found
    }));
    assert!(held.flags & RELEASE_FIRST == 0 && size(of(&held, 1).force_n) > 0.001, "{held:?}");
    server.interrupt().with(130);
}

#[test]
fn forces_and_torques_of_a_lost_client_fall_together_along_a_line_to_exactly_0() {
    let _turn = turn();
    let block = block("lost-client");
    let server = serve(&block, &["--budget-us", "off", "--json", "--watchdog-ms", "200"]);
    let outsider = ToolsOutsider::join(&block.scene);
    let held = slow_press(&outsider);
    let mut falling = Vec::new();
    while falling.last().is_none_or(|last: &Forces| last.flags & SAFE == 0) {
        falling.push(outsider.receive());
    }
    assert_eq!(falling.len(), 20, "one message a millisecond of the ramp");
    for (step, found) in (1_u8..).zip(&falling) {
        let left = f64::from(20 - step) / 20.0;
        let zero = if step == 20 { SAFE } else { 0 };
        assert_eq!(found.flags & (STALE | SAFE), STALE | zero);
        for number in [0, 1] {
            let [now, before] = [found, &held].map(|forces| of(forces, number));
            assert_eq!(now.flags, found.flags);
            for (now, before) in
                [(now.force_n, before.force_n), (now.torque_n_m, before.torque_n_m)]
            {
                assert!(size(before) > 0.0);
                for axis in 0..3 {
                    let wanted = left * f64::from(before[axis]);
                    let off = (f64::from(now[axis]) - wanted).abs();
                    assert!(off <= 1e-5 * size(before), "step {step}: {now:?} of {before:?}");
                }
                assert!(step < 20 || now == [0.0; 3], "{now:?}");
            }
        }
    }
    // It comes again from 0, and a pause takes all of it away at once and for good.
    let again = answer(&outsider, poses(TICKS + 1));
    assert!(size(of(&again, 1).force_n) < 0.2 * size(of(&held, 1).force_n), "{again:?}");
    let commander = Commander::join(&block.scene);
    let paused = commander.order(Order { kind: 2, ..Order::default() });
    assert_eq!(paused.result, 0);
    let mut paused = again;
    for tick in 2..60 {
        paused = answer(&outsider, poses(TICKS + tick));
        std::thread::sleep(Duration::from_millis(1));
    }
    for number in [0, 1] {
        let ToolForce { force_n, torque_n_m, flags, .. } = of(&paused, number);
        assert_eq!((force_n, torque_n_m, flags & SAFE), ([0.0; 3], [0.0; 3], SAFE));
    }
    let served = server.interrupt().with(130).json();
    assert_eq!(served["watchdog_fired"], 1);
}

/// Presses with a message a millisecond, until the ramp at the beginning is over; the last answer.
fn slow_press(outsider: &ToolsOutsider) -> Forces {
    let answers = (0..=TICKS).map(|tick| {
        std::thread::sleep(Duration::from_millis(1));
        let found = answer(outsider, poses(tick));
        assert_eq!((found.tick, found.flags & STALE), (tick, 0), "the machine stood still");
        found
    });
    last(answers)
}

#[test]
fn a_tool_that_lets_go_in_a_late_tick_has_no_force_at_once() {
    let _turn = turn();
    let block = block("late-tools");
    let out = block.file("out");
    let options = ["--watchdog-ms", "0", "--ramp-ms", "0", "--json", "--out", text(&out)];
    let server = serve(&block, &options);
    let outsider = ToolsOutsider::join(&block.scene);
    let before = press(&outsider);
    server.signal(Signal::STOP);
    // A process that was told to stop does so a little later.
    std::thread::sleep(Duration::from_millis(50));
    let late = TICKS + 1..TICKS + 10;
    for tick in late.clone() {
        let mut sent = poses(tick);
        // Tool 0, whose force a late answer repeats.
        sent.each[1].engaged = u16::from(tick < TICKS + 5);
        outsider.send(sent);
    }
    server.signal(Signal::CONT);
    for tick in late {
        let found = outsider.receive();
        let is_late = tick < TICKS + 9;
        assert_eq!((found.tick, found.flags & LATE != 0), (tick, is_late), "{found:?}");
        assert_eq!((found.sweeps == 0, found.send_ns), (is_late, 7));
        assert_eq!(found.force_tick, if is_late { TICKS } else { tick }, "{found:?}");
        let [first, second] = [0, 1].map(|number| of(&found, number));
        if tick < TICKS + 5 {
            assert_eq!(first.force_n, of(&before, 0).force_n);
            assert_eq!(first.torque_n_m, of(&before, 0).torque_n_m);
        } else {
            assert_eq!((first.force_n, first.torque_n_m, first.contacts), ([0.0; 3], [0.0; 3], 0));
        }
        assert!(!is_late || second.force_n == of(&before, 1).force_n);
        assert!(second.force_n[2] > 0.02);
    }
    let served = server.interrupt().with(130).json();
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
    let again = block.file("again");
    let path = out.join("path.csv");
    let args = ["run", text(&block.model), "--path", text(&path), "--out", text(&again), "--json"];
    let played = run([&args[..], &TOOLS].concat()).with(0).json();
    assert_eq!(played["state_hash"], served["state_hash"]);
}

#[test]
fn torques_and_forces_are_shortened_for_each_tool_by_itself() {
    let _turn = turn();
    let block = block("shortened");
    let free = {
        let server = serve(&block, &PLAIN);
        let found = press(&ToolsOutsider::join(&block.scene));
        server.interrupt().with(130);
        found
    };
    let [torque_n_m, force_n] =
        [size(of(&free, 1).torque_n_m) * 0.5, size(of(&free, 1).force_n) * 0.5];
    for (option, most) in [("--max-torque-n-m", torque_n_m), ("--max-force-n", force_n)] {
        let (of_torque, most_text) = (option == "--max-torque-n-m", most.to_string());
        let server = serve(&block, &[&PLAIN[..], &[option, &most_text]].concat());
        let outsider = ToolsOutsider::join(&block.scene);
        // Tool 0 stays just above the block.
        let found = (0..=TICKS).map(|tick| {
            let mut sent = poses(tick);
            sent.each[1].position_m[2] = TOP_M + 0.0039;
            answer(&outsider, sent)
        });
        let found = last(found);
        let [first, second] = [0, 1].map(|number| of(&found, number));
        let limited = size(if of_torque { second.torque_n_m } else { second.force_n });
        assert!(limited <= most && limited > 0.999 * most, "{limited} of {most}");
        assert_eq!((second.flags & CLAMPED, found.flags & CLAMPED), (CLAMPED, CLAMPED));
        assert!(first.flags & CLAMPED == 0, "{first:?}");
        server.interrupt().with(130);
    }
}

/// A path of two tools by `control`, against the same path offline.
#[test]
fn a_controller_plays_a_path_of_two_tools() {
    let _turn = turn();
    let block = block("control-two");
    let path = block.file("two.csv");
    let mut rows = String::from("tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged\n");
    for tick in 0..60 {
        for tool in 0..2 {
            let [x, y, z] = position_m(tick, tool);
            rows += &format!("{tick},{tool},{x:?},{y:?},{z:?},0,0.1,0,0.99498744,1\n");
        }
    }
    std::fs::write(&path, rows).unwrap();
    let out = block.file("out");
    let server =
        serve(&block, &["--budget-us", "off", "--json", "--ticks", "61", "--out", text(&out)]);
    let control = &mut block.control(&["--path", text(&path)]);
    let told = Running::start(control).end(SHORT).with(0).json();
    assert_eq!((&told["ticks_answered"], &told["has_touched"]), (&61.into(), &true.into()));
    let served = server.end(SHORT).with(0).json();
    assert_eq!(told["state_hash"], served["state_hash"]);
    let again = block.file("again");
    let sent = out.join("path.csv");
    let args = ["run", text(&block.model), "--path", text(&sent), "--out", text(&again), "--json"];
    let played = run([&args[..], &TOOLS].concat()).with(0).json();
    assert_eq!(played["state_hash"], served["state_hash"]);
    let sent = std::fs::read_to_string(sent).unwrap();
    let rows: Vec<&str> = sent.lines().collect();
    assert_eq!(rows.len(), 1 + 2 * 61);
    // A release ahead of the first row, which is engaged.
    assert!(rows[1].starts_with("0,0,") && rows[1].ends_with(",0"), "{}", rows[1]);
    for (row, tool) in [(rows[3], "1,0,"), (rows[4], "1,1,")] {
        assert!(row.starts_with(tool) && row.ends_with(",1"), "{row}");
    }
}

/// Whatever ends a tick, its sweeps are recorded.
#[test]
fn ticks_that_end_when_their_forces_are_exact_enough_are_played_again() {
    let _turn = turn();
    let block = block("tools-exact");
    let out = block.file("out");
    let options = ["--force-error", "0.1", "--sweeps", "60", "--budget-us", "1000000", "--json"];
    let quiet = ["--watchdog-ms", "0", "--ramp-ms", "0", "--out", text(&out)];
    let server = serve(&block, &[&options[..], &quiet].concat());
    let outsider = ToolsOutsider::join(&block.scene);
    let pressed: Vec<Forces> = (0..60).map(|tick| answer(&outsider, poses(tick))).collect();
    let is_short = |forces: &&Forces| of(forces, 0).contacts > 0 && forces.sweeps < 30;
    assert!(pressed.iter().filter(is_short).count() > 10, "{pressed:?}");
    let served = server.interrupt().with(130).json();
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
    assert!(served["force_error_estimate"]["median"].as_f64() < Some(0.1), "{served}");
    // Where all sweeps are made, nothing ends a tick.
    let off = [&TOOLS[..], &["--force-error", "0.1", "--budget-us", "off"]].concat();
    let args = ["serve", text(&block.model), "--scene", &block.scene];
    assert!(run([&args[..], &off].concat()).with(2).err.contains("leave one of them out"));
}
