//! Grips by command, as outside programs and `chaincell command` see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_tests::files::text;
use chaincell_tests::outsider::{Commander, Order, Outsider, Pose, Reply, Watcher, largest_step_n};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{run, turn};

use crate::dragging::{DEEP, pose, serve};

#[test]
fn a_grip_by_command_drags_the_tissue_along_and_is_replayed_to_the_same_bits() {
    let _turn = turn();
    let mut dragged_n = Vec::new();
    for grips in [false, true] {
        let place = Place::on_surface("grip");
        let out = place.file("out");
        let serve = serve(&place, &["--ticks", "280", "--out", text(&out), "--state-hz", "1000"]);
        let watcher = Watcher::join(&place.scene);
        let outsider = Outsider::join(&place.scene, true);
        outsider.play(0..DEEP + 1, pose);
        if grips {
            let reply = place.command(&["grip"]).with(0).json();
            assert_eq!((&reply["tick"], &reply["ticks_answered"]), (&40.into(), &41.into()));
        }
        let dragged = outsider.play(DEEP + 1..160, pose);
        dragged_n.push(dragged.last().unwrap().force_n[0]);
        if grips {
            let (_, touches) = watcher.after(160);
            let pull_n: f32 = touches.iter().map(|of| of.tangential_n[0]).sum();
            assert!(pull_n < 0.9 * dragged_n[1], "{pull_n} N of {} N", dragged_n[1]);
            place.command(&["let-go", "--ticks", "40"]).with(0);
        }
        let last = [dragged.last().copied().into_iter().collect(), outsider.play(160..280, pose)];
        let last = last.concat();
        if grips {
            // It goes over to the force of a sphere that holds nothing, and does not jump there.
            let (free_n, rest_n) = (dragged_n[0], last.last().unwrap().force_n[0]);
            assert!((rest_n - free_n).abs() < 0.05 * dragged_n[1].abs(), "{rest_n} of {free_n}");
            let step_n = largest_step_n(&last);
            assert!(step_n < 0.2 * f64::from(dragged_n[1].abs()), "a step of {step_n} N");
        }
        let served = serve.end(SHORT).with(0).json();
        assert_eq!(served["commands_done"], if grips { 2 } else { 0 });
        let replayed = run(["replay", text(&out), "--json"]).with(0).json();
        assert_eq!(replayed["state_hash"], served["state_hash"]);
        assert_eq!(replayed["hashes_compared"], if grips { 282 } else { 280 });
    }
    let [free_n, gripped_n] = dragged_n[..] else { panic!("{dragged_n:?}") };
    assert!(gripped_n < 10.0 * free_n.min(-0.001), "{gripped_n} N with a grip, {free_n} N without");
}

#[test]
fn what_cannot_be_gripped_is_refused_and_changes_nothing() {
    let _turn = turn();
    let grip = |tool| Order { kind: 5, parameter: tool, ..Order::default() };
    let let_go = |tool, ticks| Order { kind: 6, parameter: tool, value: ticks, ..Order::default() };
    let place = Place::on_surface("grip-refused");
    let out = place.file("out");
    let serve = serve(&place, &["--ticks", "120", "--out", text(&out)]);
    let commander = Commander::join(&place.scene);
    let refused = |order: Order, reason: u32, state: (u64, u64, u64)| {
        let (tick, ticks_answered, state_hash) = state;
        let wanted = Reply { tick, ticks_answered, state_hash, result: 1, reason };
        assert_eq!(commander.order(order), wanted, "{order:?}");
    };
    let outsider = Outsider::join(&place.scene, true);
    let away = outsider.play(0..6, pose)[5];
    assert_eq!(away.contacts, 0);
    let state = (5, 6, away.state_hash);
    refused(grip(0), 10, state);
    refused(let_go(0, 20.0), 10, state);
    refused(grip(1), 9, state);
    refused(let_go(7, 20.0), 9, state);
    refused(grip(u32::MAX), 9, state);
    refused(Order { value: 1.0, ..grip(0) }, 3, state);
    refused(let_go(0, 0.0), 3, state);
    refused(let_go(0, 70_000.0), 3, state);
    let nothing = place.command(&["grip"]).with(2).err;
    assert!(nothing.contains("reason 10") && nothing.contains("in contact"), "{nothing}");
    let nobody = place.command(&["let-go", "--tool", "3"]).with(2).err;
    assert!(nobody.contains("reason 9"), "{nobody}");
    let deep = outsider.play(6..60, pose)[53];
    assert!(deep.contacts > 0);
    refused(let_go(0, 20.0), 10, (59, 60, deep.state_hash));
    assert_eq!(commander.order(grip(0)).result, 0);
    outsider.play(60..100, pose);
    // Not engaged it lets go by itself.
    outsider.send(Pose { engaged: 0, ..pose(100) });
    let free = outsider.receive();
    refused(let_go(0, 20.0), 10, (100, 101, free.state_hash));
    outsider.play(101..120, pose);
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&served["commands_done"], &served["commands_refused"]), (&1.into(), &12.into()));
    let replayed = run(["replay", text(&out), "--json"]).with(0).json();
    assert_eq!(replayed["state_hash"], served["state_hash"]);
}

#[test]
fn cells_that_are_held_are_not_gripped() {
    let _turn = turn();
    let place = Place::new("grip-cells");
    let serve = place.serve(&["--json"]);
    let refused = place.command(&["grip"]).with(2).err;
    assert!(
        refused.contains("reason 8") && refused.contains("--contact probe:RADIUS"),
        "{refused}"
    );
    let out_of_range = place.command(&["let-go", "--ticks", "0"]).with(2).err;
    assert!(out_of_range.contains("--ticks"), "{out_of_range}");
    serve.interrupt().with(130);
}
