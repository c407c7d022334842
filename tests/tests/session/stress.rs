//! Strain and stress as outside programs and `chaincell state --stress` see them.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use chaincell_client::stress::{NodeStress, StressHeader};
use chaincell_tests::files::{Table, array, play, text, write_path};
use chaincell_tests::outsider::{Header, Outsider, Pose, Reader};
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{run, turn};

const TOOL: [&str; 2] = ["--contact", "probe:0.006"];

/// Down by 0.1 mm a tick to 4 mm.
fn pose(tick: u64) -> Pose {
    let down = tick.min(50) as f32;
    Pose { tick, position_m: [0.0, 0.002, 0.047 - 0.0001 * down], engaged: u32::from(tick > 0) }
}

#[test]
fn an_outside_reader_sees_the_stress_of_an_offline_run_and_the_limit_warns_without_a_reader() {
    let _turn = turn();
    let place = Place::on_surface("stress");
    let options = ["--watchdog-ms", "0", "--ramp-ms", "0", "--json", "--budget-us", "off"];
    let limit = ["--ticks", "81", "--state-hz", "1000", "--stress-limit-pa", "100"];
    let serve = place.serve(&[&options[..], &TOOL, &limit].concat());
    let reader = Reader::<NodeStress, StressHeader>::join(&place.scene);
    let outsider = Outsider::join(&place.scene, true);
    outsider.play(0..80, pose);
    // A whole pass after the last tick.
    let (header, nodes) =
        reader.after(StressHeader { first_tick: 79, ..Default::default() }.ticks_answered());
    assert_eq!((header.tick, header.first_tick, header.nodes as usize), (79, 79, nodes.len()));
    assert!(nodes.is_sorted_by_key(|of| of.node));
    // What an offline run of the same poses comes to.
    let path = place.file("path.csv");
    write_path(&path, (0..80).map(|tick| (tick, pose(tick).position_m, pose(tick).engaged)));
    let offline = place.file("offline");
    play(&place.model, &path, &offline, &TOOL).with(0);
    let vtu = std::fs::read_to_string(offline.join("final.vtu")).unwrap();
    let order: Vec<usize> = {
        let ids = array(&vtu, "node");
        let mut order: Vec<usize> = (0..ids.len()).collect();
        order.sort_by(|&a, &b| ids[a].total_cmp(&ids[b]));
        order
    };
    for (name, width, mine) in [
        ("node", 1, nodes.iter().map(|of| of.node as f32).collect::<Vec<_>>()),
        ("von_mises_pa", 1, nodes.iter().map(|of| of.von_mises_pa).collect()),
        ("mean_stress_pa", 1, nodes.iter().map(|of| of.mean_pa).collect()),
        ("stretches", 3, nodes.iter().flat_map(|of| of.stretches).collect()),
    ] {
        let written = array(&vtu, name);
        let of_node = |&at: &usize| &written[width * at..width * (at + 1)];
        let wanted: Vec<f32> = order.iter().flat_map(of_node).map(|of| *of as f32).collect();
        assert_eq!(mine, wanted, "{name}");
    }
    // The command shows the same.
    let csv = place.file("stress.csv");
    let args =
        ["state", "--stress", "--scene", &place.scene, "--once", "--json", "--csv", text(&csv)];
    let shown = run(args).with(0).json();
    let most = nodes.iter().max_by(|a, b| a.von_mises_pa.total_cmp(&b.von_mises_pa)).unwrap();
    assert_eq!((&shown["tick"], &shown["node"]), (&79.into(), &most.node.into()));
    let mises_pa = Table::read(&csv).column("von_mises_pa");
    assert!(mises_pa.iter().map(|of| *of as f32).eq(nodes.iter().map(|of| of.von_mises_pa)));
    drop(reader);
    outsider.send(Pose { engaged: 0, ..pose(80) });
    let ended = serve.end(SHORT).with(0);
    assert_eq!(ended.err.matches("WARNING: tick").count(), 1, "{}", ended.err);
    let served = ended.json();
    assert!(served["stress"]["nodes_above"].as_u64().unwrap() > 0, "{served}");
    assert!(served["stresses_sent"].as_u64().unwrap() >= 2, "{served}");
}

#[test]
fn without_readers_and_limit_no_stress_is_computed_and_links_have_none() {
    let _turn = turn();
    let place = Place::on_surface("stress-unread");
    let serve = place.serve(&[&["--ticks", "30", "--json"][..], &TOOL].concat());
    Outsider::join(&place.scene, true).play(0..30, pose);
    let served = serve.end(SHORT).with(0).json();
    assert_eq!((&served["stresses_sent"], &served["stress_ns"]["max"]), (&0.into(), &0.into()));
    // Refused before a scene is joined or another server waited for.
    let limit = ["--state-hz", "0", "--stress-limit-pa", "5", "--scene", &place.scene];
    let refused = run([&["serve", text(&place.model)][..], &TOOL, &limit].concat()).with(2).err;
    assert!(refused.contains("--state-hz above 0"), "{refused}");
    let links = Place::new("stress-links");
    let server = links.serve(&["--json"]);
    let args = ["state", "--stress", "--scene", &links.scene, "--once"];
    let refused = run(args).with(2).err;
    assert!(refused.contains("--young-pa"), "{refused}");
    server.interrupt().with(130);
}
