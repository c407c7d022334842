//! Shared memory that is full: in a mount namespace of its own, with a small one.

use std::path::Path;
use std::process::Command;

use chaincell_tests::files::bake;
use chaincell_tests::process::unshared;
use chaincell_tests::{chaincell, turn};

use super::*;

/// Runs shell lines where /dev/shm has so many kilobytes and `$chaincell` is the command; `None`
/// with a line that says so where this user may not.
fn with_memory(test: &str, kilobytes: u32, lines: &str) -> Option<Ended> {
    let lines = format!("mount -t tmpfs -o size={kilobytes}k tmpfs /dev/shm || exit 99\n{lines}");
    let mut command = unshared(test, Path::new("/"), &lines)?;
    Some(Running::start(&mut command).end(SHORT))
}

/// What a session leaves in shared memory but iceoryx2's own lock.
const LEFT: &str = "ls /dev/shm | grep -v global_mgmt";

#[test]
fn too_little_of_it_is_told_and_nothing_is_left() {
    let _turn = turn();
    let place = Place::stiff("little");
    let serve = format!(
        "\"$chaincell\" serve {} --scene {} --contact 40 --seconds 1; code=$?; {LEFT}; exit $code",
        text(&place.model),
        place.scene
    );
    for kilobytes in [64, 1024, 3072, 6144] {
        let Some(ended) = with_memory("too_little", kilobytes, &serve) else { return };
        let ended = ended.with(2);
        assert!(ended.err.contains("shared memory is full: /dev/shm has"), "{}", ended.err);
        assert_eq!(ended.out, "", "left behind, or ready");
    }
    assert_eq!(with_memory("enough", 12_288, &serve).unwrap().with(0).out.lines().count(), 9);
}

#[test]
fn too_little_for_the_states_is_told_before_ready() {
    let _turn = turn();
    let place = Place::stiff("states");
    let model = bake(place.folder.path(), "plane:240x240x0.01", &["--coarse", "none", "--lean"]);
    let serve = format!(
        "\"$chaincell\" serve {} --scene {} --contact 28920 --seconds 1; code=$?; {LEFT}; exit $code",
        text(&model),
        place.scene
    );
    let Some(ended) = with_memory("states", 12_288, &serve) else { return };
    let ended = ended.with(2);
    assert!(ended.err.contains("shared memory is full"), "{}", ended.err);
    assert_eq!(ended.out, "", "left behind, or ready");
}

// REQ-COS-05
#[test]
fn a_session_goes_on_while_another_program_fills_it() {
    let _turn = turn();
    let place = Place::stiff("filled");
    let path = hold(&place, 1500);
    let (scene, folder) = (&place.scene, text(place.folder.path()));
    let lines = format!(
        "\"$chaincell\" serve {} --scene {scene} --contact 40 --json > {folder}/serve.out & s=$!
        until grep -q ready {folder}/serve.out || ! kill -0 $s; do sleep 0.01; done
        \"$chaincell\" control --late-share off --scene {scene} --path {} --json > {folder}/control.out & c=$!
        sleep 0.5
        dd if=/dev/zero of=/dev/shm/filler bs=64k 2> {folder}/dd.err
        df --output=avail /dev/shm | tail -1
        \"$chaincell\" control --late-share off --scene {scene} --seconds 0.1 2> {folder}/second.err; echo $?
        wait $c; echo $?
        rm /dev/shm/filler
        \"$chaincell\" control --late-share off --scene {scene} --seconds 0.1 > {folder}/third.out; echo $?
        kill -INT $s; wait $s; echo $?
        {LEFT}",
        text(&place.model),
        text(&path)
    );
    let Some(ended) = with_memory("filled", 16_384, &lines) else { return };
    let numbers: Vec<&str> = ended.out.split_whitespace().collect();
    assert_eq!(numbers, ["0", "2", "0", "0", "130"], "{ended:?}");
    let read = |name: &str| std::fs::read_to_string(place.folder.path().join(name)).unwrap();
    let last =
        |name: &str| -> Value { serde_json::from_str(read(name).lines().last().unwrap()).unwrap() };
    assert!(read("second.err").contains("shared memory is full"), "{}", read("second.err"));
    let (control, serve) = (last("control.out"), last("serve.out"));
    assert_eq!((count(&control, "ticks_answered"), count(&control, "ticks_unanswered")), (1500, 0));
    assert_eq!((count(&serve, "ticks_executed"), count(&serve, "sends_failed")), (1600, 0));
    let step_n = control["largest_force_step_n"].as_f64().unwrap();
    tell("shared memory filled by another program", 1600, 0, step_n, f64::NAN);
}

/// A server that says that it is ready has room for a controller and a viewer; else it says what is needed.
#[test]
fn a_server_is_ready_only_where_others_can_join() {
    let _turn = turn();
    let place = Place::stiff("joins");
    let path = hold(&place, 20);
    let (scene, folder) = (&place.scene, text(place.folder.path()));
    let lines = format!(
        ": > {folder}/out
        \"$chaincell\" serve {} --scene {scene} --contact 40 --late-share off > {folder}/out 2> {folder}/err & s=$!
        until grep -q ready {folder}/out || ! kill -0 $s; do sleep 0.01; done
        if grep -q ready {folder}/out; then
            \"$chaincell\" control --late-share off --scene {scene} --path {} > /dev/null; echo $?
            \"$chaincell\" command --scene {scene} pause > /dev/null; echo $?
            kill -INT $s
        fi
        wait $s; echo $?; cat {folder}/err >&2; {LEFT}",
        text(&place.model),
        text(&path)
    );
    let mut ready = 0;
    for kilobytes in [6400, 7168, 8192, 9216, 10_240] {
        let Some(ended) = with_memory("joins", kilobytes, &lines) else { return };
        match ended.out.split_whitespace().collect::<Vec<_>>()[..] {
            ["0", "0", "130"] => ready += 1,
            ["2"] => {
                assert!(ended.err.contains("what joins a server takes up to"), "{}", ended.err)
            }
            _ => panic!("{kilobytes} kB: {ended:?}"),
        }
    }
    assert!((3..5).contains(&ready), "{ready}");
}

/// Each piece of shared memory is an open file.
#[test]
fn too_few_open_files_are_told_before_ready() {
    let _turn = turn();
    let place = Place::stiff("files");
    let serve = |limit: &str| {
        let line = format!(
            "ulimit {limit}; exec \"$0\" serve {} --scene {} --contact 40 --seconds 0.1",
            text(&place.model),
            place.scene
        );
        let mut command = Command::new("sh");
        Running::start(command.args(["-c", &line]).arg(chaincell().get_program())).end(SHORT)
    };
    for limit in ["-n 36", "-n 60", "-n 100"] {
        let ended = serve(limit).with(2);
        assert!(ended.err.contains("raise the limit with ulimit -n"), "{}", ended.err);
        assert_eq!(ended.out, "");
    }
    // Its own limit it raises by itself.
    assert!(serve("-Sn 36").with(0).out.starts_with("ready"));
}

#[test]
fn files_that_somebody_removed_are_named_as_the_cause() {
    let _turn = turn();
    let place = Place::stiff("removed");
    let (scene, folder) = (&place.scene, text(place.folder.path()));
    let lines = format!(
        "\"$chaincell\" serve {} --scene {scene} --contact 40 > {folder}/out & s=$!
        until grep -q ready {folder}/out; do sleep 0.01; done
        rm /dev/shm/*
        \"$chaincell\" command --scene {scene} pause; echo $? $s
        kill -INT $s; wait $s; echo $?",
        text(&place.model)
    );
    let Some(ended) = with_memory("removed", 65_536, &lines) else { return };
    let numbers: Vec<&str> = ended.out.split_whitespace().collect();
    assert!(matches!(numbers[..], ["2", _, "130"]), "{ended:?}");
    let wanted = format!("files in /dev/shm are gone, although process {} has it open", numbers[1]);
    assert!(ended.err.contains(&wanted), "{}", ended.err);
}
