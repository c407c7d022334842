//! What a client feels is what was recorded.

use chaincell_client::{Flags, Notes, Outcome, ToolPose};
use chaincell_tests::files::{Table, summary, text};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{run, turn};

use super::{SOME_N, WAIT_NS, answered, options, pose, press, size_n};
use chaincell_client::Client;

/// All sweeps of every tick, and forces that are published as they are.
const PLAIN: [&str; 7] = ["--watchdog-ms", "0", "--ramp-ms", "0", "--budget-us", "off", "--json"];

#[test]
fn forces_and_hash_are_those_of_the_record_and_of_its_replay() {
    let _turn = turn();
    let place = Place::new("client-press");
    let out = place.folder.path().join("out");
    let serve = place.serve(&[&PLAIN[..], &["--out", text(&out)]].concat());
    let mut client = Client::open(&options(&place)).unwrap();
    let answers = press(&mut client, 0..=60);
    drop(client);
    let served = serve.interrupt().with(130).json();
    assert_eq!(served["ticks_executed"], 61);
    let last = answers.last().unwrap();
    assert_eq!(served["state_hash"], format!("{:016x}", last.state_hash));
    assert_eq!(summary(&out)["state_hash"], served["state_hash"]);
    let recorded = Table::read(&out.join("force.csv")).vectors("fx_n");
    assert_eq!(recorded.len(), answers.len());
    for (tick, (answer, recorded)) in (1..).zip(answers.iter().zip(&recorded)) {
        let force_n = answer.tools[0].force_n;
        assert_eq!(force_n, recorded.map(|x| x as f32), "tick {tick}");
        assert_eq!((answer.tick, answer.force_tick, answer.answers), (tick, tick, tick));
        assert!(answer.round_trip_ns > 0 && answer.notes == Notes::default(), "{answer:?}");
    }
    assert!(last.tools[0].contacts > 0 && size_n(last) > SOME_N, "{last:?}");
    run(["replay", text(&out)]).with(0);
}

#[test]
fn sending_and_receiving_apart_give_the_same() {
    let _turn = turn();
    let place = Place::new("client-apart");
    let serve = place.serve(&PLAIN);
    let mut client = Client::open(&options(&place)).unwrap();
    assert_eq!(client.try_receive().unwrap().0, Outcome::NoAnswer);
    for number in 1..=5 {
        assert_eq!(client.send(&[pose(number - 1)]).unwrap(), number);
    }
    let start = std::time::Instant::now();
    let mut seen = 0;
    while seen < 5 {
        assert!(start.elapsed() < SHORT, "{seen} answers");
        let (outcome, answer) = client.try_receive().unwrap();
        assert_eq!(outcome == Outcome::Answered, answer.answers > seen);
        seen = answer.answers;
    }
    let (outcome, last) = client.try_receive().unwrap();
    assert_eq!((outcome, last.tick), (Outcome::NoAnswer, 5));
    drop(client);
    let served = serve.interrupt().with(130).json();
    assert_eq!((&served["ticks_executed"], &served["poses_refused"]), (&5.into(), &0.into()));
}

#[test]
fn two_tools_turn_and_feel_a_torque_each() {
    let _turn = turn();
    let place = Place::on_surface("client-tools");
    // A rod along x by the turn of its pose: 15 mm half length, over the side of the top at 40 mm.
    let tool = ["--tool", "capsule:0.015,0.004", "--tool", "sphere:0.006"];
    let args = ["serve", text(&place.model), "--scene", &place.scene, "--late-share", "off"];
    let mut serve = chaincell_tests::Running::chaincell([&args[..], &tool, &PLAIN].concat());
    serve.wait_for_line("ready");
    let mut client = Client::open(&options(&place)).unwrap();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let mut last = None;
    for tick in 0..40_u8 {
        let z = 0.043 - 1e-4 * f32::from(tick);
        let rod = ToolPose {
            orientation: [0.0, half, 0.0, half],
            ..ToolPose::at([0.03, 0.0, z].into(), u32::from(tick > 0))
        };
        last = Some(answered(&mut client, &[rod, ToolPose::at([-0.02, 0.0, z].into(), 0)]));
    }
    let [rod, ball, none, ..] = last.unwrap().tools;
    assert!(rod.force_n[2] > 0.01 && rod.torque_n_m[1].abs() > 1e-5, "{rod:?}");
    assert_eq!((ball.force_n, ball.contacts), ([0.0; 3], 0), "not engaged");
    assert!(Flags(none.flags).contains(Flags::SAFE_STATE), "the server has no tool 2");
    drop(client);
    assert_eq!(serve.interrupt().with(130).json()["flag_ticks"].get("bad_sample"), None);
}

#[test]
fn a_deadline_that_passes_leaves_the_last_force_and_says_so() {
    let _turn = turn();
    let place = Place::new("client-deadline");
    let serve = place.serve(&PLAIN);
    let mut client = Client::open(&options(&place)).unwrap();
    let last = press(&mut client, 0..=30).pop().unwrap();
    serve.signal(rustix::process::Signal::STOP);
    let (outcome, held) = client.step(&[pose(31)], 2_000_000).unwrap();
    assert_eq!((outcome, held.tick, held.tools), (Outcome::NoAnswer, last.tick, last.tools));
    assert!(held.age_ns >= 2_000_000);
    serve.signal(rustix::process::Signal::CONT);
    assert_eq!(client.step(&[pose(32)], WAIT_NS).unwrap().0, Outcome::Answered);
    serve.interrupt().with(130);
}
