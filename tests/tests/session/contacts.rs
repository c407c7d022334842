//! Contacts of tools on a surface as outside programs and `chaincell contacts` see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::time::Duration;

use chaincell_client::contacts::{Contact, ContactsHeader};
use chaincell_tests::files::{Table, play, write_path};
use chaincell_tests::outsider::{Outsider, Pose, Watcher, size};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};

/// A sphere of 6 mm that rubs.
const TOOL: [&str; 4] = ["--contact", "probe:0.006", "--friction", "0.4"];

fn serve(place: &Place, options: &[&str]) -> Running {
    let always = ["--watchdog-ms", "0", "--ramp-ms", "0", "--json", "--budget-us", "off"];
    place.serve(&[&always[..], &TOOL, options].concat())
}

/// Down by 0.1 mm a tick to 4 mm, then along.
fn pose(tick: u64) -> Pose {
    let (down, along) = (tick.min(50) as f32, tick.saturating_sub(50) as f32);
    let position_m = [0.0001 * along, 0.002, 0.047 - 0.0001 * down];
    Pose { tick, position_m, engaged: u32::from(tick > 0) }
}

fn sum_n(touches: &[Contact]) -> [f64; 3] {
    std::array::from_fn(|axis| {
        let along = |of: &Contact| f64::from(of.normal_n[axis]) + f64::from(of.tangential_n[axis]);
        touches.iter().map(along).sum()
    })
}

fn assert_near(found: [f64; 3], wanted: [f32; 3]) {
    for (here, there) in found.into_iter().zip(wanted) {
        assert!((here - f64::from(there)).abs() <= 1e-5 * size(wanted), "{found:?} of {wanted:?}");
    }
}

#[test]
fn an_outside_reader_sees_the_contacts_whose_sum_is_the_force() {
    let _turn = turn();
    let place = Place::on_surface("contacts");
    let serve = serve(&place, &["--ticks", "82", "--state-hz", "1000"]);
    let watcher = Watcher::join(&place.scene);
    // Whoever joins sees at once that there is nothing.
    assert_eq!(watcher.after(0), (ContactsHeader::default(), Vec::new()));
    let outsider = Outsider::join(&place.scene, true);
    let pressed = outsider.play(0..80, pose);
    let last = pressed[79];
    let (stamp, touches) = watcher.after(80);
    let wanted =
        ContactsHeader { tick: 79, ticks_answered: 80, contacts: last.contacts, flags: last.flags };
    assert_eq!(stamp, wanted);
    assert!(touches.len() > 3 && touches.len() == last.contacts as usize, "{touches:?}");
    assert!(last.force_n[2] > 0.01 && last.force_n[0] < -0.001, "{last:?}");
    assert_near(sum_n(&touches), last.force_n);
    assert!(touches.iter().all(|of| of.area_m2 > 0.0 && of.tool == 0 && of.part == 0));
    std::thread::sleep(Duration::from_millis(20));
    assert!(watcher.try_receive().is_none(), "contacts that nothing has changed");
    let args = ["contacts", "--scene", &place.scene, "--once", "--json"];
    let seen = run(args).with(0).json();
    assert_eq!((&seen["tick"], &seen["contacts"]), (&79.into(), &last.contacts.into()));
    let axis = |axis: usize| seen["force_n"][axis].as_f64().unwrap();
    assert_near([axis(0), axis(1), axis(2)], last.force_n);
    assert!(seen["largest_pressure_pa"].as_f64().unwrap() > 100.0, "{seen}");
    // The rows of an offline run of the same poses, to the bit.
    let path = place.file("path.csv");
    write_path(&path, (0..80).map(|tick| (tick, pose(tick).position_m, pose(tick).engaged)));
    let offline = place.file("offline");
    play(&place.model, &path, &offline, &TOOL).with(0);
    let table = Table::read(&offline.join("contacts.csv"));
    let rows: Vec<&Vec<f64>> = table.rows.iter().filter(|row| row[0] == 79.0).collect();
    assert_eq!(rows.len(), touches.len());
    for (row, of) in rows.iter().zip(&touches) {
        let whole = [of.tool, of.part, of.node].map(f64::from);
        let vectors = [of.position_m, of.normal_n, of.tangential_n];
        let same: Vec<f32> = row[4..].iter().map(|x| *x as f32).collect();
        assert_eq!(row[1..4], whole);
        assert_eq!(same, [vectors.as_flattened(), &[of.area_m2]].concat());
    }
    outsider.send(Pose { engaged: 0, ..pose(80) });
    assert_eq!(outsider.receive().contacts, 0);
    let (stamp, touches) = watcher.after(81);
    assert_eq!((stamp.tick, stamp.contacts, touches.len()), (80, 0, 0));
    outsider.send(Pose { engaged: 0, ..pose(81) });
    let served = serve.end(SHORT).with(0).json();
    assert!(served["contacts_sent"].as_u64().unwrap() >= 4, "{served}");
    assert_eq!(served["states_sent"], 0, "nobody reads states");
}

#[test]
fn a_reader_that_stops_reading_or_is_killed_harms_nothing() {
    let _turn = turn();
    let place = Place::on_surface("contacts-stuck");
    let serve = serve(&place, &["--ticks", "300", "--state-hz", "1000"]);
    let stuck = Watcher::join(&place.scene);
    let mut killed = Running::chaincell(["contacts", "--scene", &place.scene, "--json"]);
    let outsider = Outsider::join(&place.scene, true);
    for tick in 0..299 {
        assert_eq!(outsider.play(tick..tick + 1, pose)[0].tick, tick);
        std::thread::sleep(Duration::from_millis(1));
        if tick == 150 {
            assert!(killed.is_running());
            killed.signal(rustix::process::Signal::KILL);
        }
    }
    // Whoever joins now is sent the newest, and so are the others; older ones are not kept.
    assert_eq!(Watcher::join(&place.scene).after(299).0.tick, 298);
    assert_eq!(stuck.try_receive().map(|(stamp, _)| stamp.tick), Some(298));
    assert!(stuck.try_receive().is_none());
    let last = outsider.play(299..300, pose);
    assert!(last[0].contacts > 0);
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&served["ticks_executed"], &served["sends_failed"]), (&300.into(), &0.into()));
    assert!(served["contacts_sent"].as_u64().unwrap() > 20, "{served}");
}

#[test]
fn contacts_are_there_for_tools_on_a_surface_alone() {
    let _turn = turn();
    let args = |place: &Place| ["contacts", "--scene", &place.scene, "--once"].map(str::to_owned);
    let contacts = |place: &Place| run(args(place)).with(2).err;
    let cells = Place::new("contacts-cells");
    let server = cells.serve(&["--json"]);
    let refused = contacts(&cells);
    assert!(refused.contains("--contact probe:RADIUS"), "{refused}");
    server.interrupt().with(130);
    let off = Place::on_surface("contacts-off");
    let server = serve(&off, &["--state-hz", "0"]);
    assert!(contacts(&off).contains("--state-hz above 0"));
    server.interrupt().with(130);
    let wait = ["--wait-for-server-s", "0.2"].map(str::to_owned);
    let refused = run([&args(&off)[..], &wait].concat()).with(2).err;
    assert!(refused.contains("start chaincell serve"), "{refused}");
    let refused = run(["contacts", "--seconds", "0"]).with(2).err;
    assert!(refused.contains("--seconds"), "{refused}");
}

#[test]
fn the_command_ends_when_its_time_is_up() {
    let _turn = turn();
    let place = Place::on_surface("contacts-seconds");
    let server = serve(&place, &[]);
    let said = run(["contacts", "--scene", &place.scene, "--seconds", "0.3"]).with(0).out;
    assert!(said.starts_with("tick 0, 0 answered, 0 contacts, normal 0.0000 N"), "{said}");
    server.interrupt().with(130);
}
