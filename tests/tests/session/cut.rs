//! Bodies that can be cut, in a session: the summaries say how far they are, and the remedy where splits were refused.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeSet;

use chaincell_client::surface::{SurfaceHeader, SurfaceRow};
use chaincell_tests::files::{array, bake, play, scratch, summary, text, write_path};
use chaincell_tests::outsider::{Outsider, Pose, Reader};
use chaincell_tests::page::Page;
use chaincell_tests::place::Place;
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run, turn};
use serde_json::Value;

use super::view::view_of;

/// A body that tears soon, with too few spare cells.
const BODY: &[&str] =
    &["--young-pa", "5000", "--cuttable", "--cut-spare", "0", "--tear-stretch", "1.02"];
const REMEDY: &str = "bake it with more --cut-spare";

/// What a summary says of a body that has torn farther than its spare cells last.
#[track_caller]
fn check(found: &Value) {
    let number = |name: &str| found[name].as_u64().unwrap();
    assert!(number("torn_cells") > 0 && number("opened_faces") > 0, "{found}");
    assert!(number("copied_cells") > 0 && number("refused_splits") > 0, "{found}");
    assert_eq!(found["cut_area_m2"], 0.0);
}

#[test]
fn cosim_says_how_far_the_body_is_torn() {
    let _turn = turn();
    let folder = scratch();
    let model = bake(folder.path(), "box:7x7x5x0.01", BODY);
    let out = folder.path().join("out");
    let args = ["cosim", text(&model), "--seconds", "1", "--depth-m", "0.03", "--out", text(&out)];
    let said = run([&args[..], &["--late-share", "off"]].concat()).with(0);
    check(&summary(&out));
    assert_eq!(said.err.matches(REMEDY).count(), 1, "{}", said.err);
    assert!(said.out.contains("\n  cut   ") && said.out.contains(" torn"), "{}", said.out);
    assert!(said.out.contains("chaincell view"), "{}", said.out);
}

#[test]
fn serve_says_how_far_the_body_is_torn() {
    let _turn = turn();
    let place = Place::new("torn");
    let model = bake(place.file(".").as_path(), "box:7x7x5x0.01", BODY);
    let out = place.file("out");
    for json in [false, true] {
        let args = ["serve", text(&model), "--scene", &place.scene, "--ticks", "1000", "--force"];
        let args = [&args[..], &["--late-share", "off"]].concat();
        let json = if json { &["--json"][..] } else { &[] };
        let mut serve = Running::chaincell([&args[..], &["--out", text(&out)], json].concat());
        serve.wait_for_line("ready");
        let args = ["control", "--model", text(&model), "--scene", &place.scene, "--seconds", "1"];
        let more = ["--depth-m", "0.03", "--late-share", "off"];
        Running::chaincell([&args[..], &more].concat()).end(SHORT).with(0);
        let said = serve.end(SHORT).with(0);
        check(&summary(&out));
        assert!(said.err.contains(REMEDY), "{}", said.err);
        if json.is_empty() {
            assert!(said.out.contains("\n  cut         ") && said.out.contains(" torn"));
            assert!(said.out.contains("chaincell view"), "{}", said.out);
        } else {
            check(&said.json());
        }
    }
}

/// A body for a blade across its top at 30 mm, and the blade.
const SLAB: &[&str] = &[
    "--young-pa",
    "5000",
    "--poisson",
    "0.4",
    "--cuttable",
    "--toughness-j-per-m2",
    "10",
    "--cut-spare",
    "0.3",
];
const BLADE: [&str; 2] = ["--tool", "blade:0.032"];

/// Down by 0.1 mm a tick.
fn lowered(tick: u64) -> Pose {
    let down = 0.0001 * tick as f32;
    Pose { tick, position_m: [0.0, 0.0, 0.0305 - down], engaged: u32::from(tick > 0) }
}

/// Refuses a surface of which two triangles do not meet at each edge, once in each direction.
#[track_caller]
fn check_closed(triangles: impl Iterator<Item = [u32; 3]>) {
    let edges: Vec<_> = triangles.flat_map(|[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
    let all: BTreeSet<_> = edges.iter().copied().collect();
    assert!(all.len() == edges.len() && edges.iter().all(|&(from, to)| all.contains(&(to, from))));
}

#[test]
fn outside_readers_and_late_pages_see_the_wound_until_a_reset() {
    let _turn = turn();
    let place = Place::of("wound", "box:5x5x4x0.01", SLAB);
    let options = ["--watchdog-ms", "0", "--ramp-ms", "0", "--json", "--budget-us", "off"];
    let serve = place.serve(&[&options[..], &BLADE, &["--state-hz", "1000"]].concat());
    let reader = Reader::<SurfaceRow, SurfaceHeader>::join(&place.scene);
    let outsider = Outsider::join(&place.scene, true);
    let (whole, rows) = reader.after(0);
    assert_eq!((whole.nodes, whole.copies, rows.len()), (100, 0, whole.triangles as usize));
    outsider.play(0..150, lowered);
    // What an offline run of the same poses comes to: nodes by cell, and the copies after them.
    let (path, offline) = (place.file("path.csv"), place.file("offline"));
    write_path(&path, (0..150).map(|tick| (tick, lowered(tick).position_m, lowered(tick).engaged)));
    play(&place.model, &path, &offline, &BLADE).with(0);
    let vtu = std::fs::read_to_string(offline.join("final.vtu")).unwrap();
    let (header, rows) = reader.after(150);
    let cells = (header.nodes + header.copies) as usize;
    assert!(header.copies > 1 && header.triangles > whole.triangles + 4, "{header:?}");
    assert_eq!((header.nodes, rows.len()), (100, cells.max(header.triangles as usize)));
    let (ids, at_m) = (array(&vtu, "node"), array(&vtu, "position_m"));
    let written = ids.iter().zip(at_m.chunks(3)).map(|(&id, at)| (id as u32, at));
    let (mut wanted, of_copies): (Vec<_>, Vec<_>) =
        (written.clone().take(100).collect(), written.skip(100).collect());
    wanted.sort_unstable_by_key(|(id, _)| *id);
    wanted.extend(of_copies);
    assert_eq!(wanted.len(), cells);
    for (of, (id, at_m)) in rows.iter().zip(wanted) {
        let off_m = of.position_m.iter().zip(at_m).map(|(sent, at)| (f64::from(*sent) - at).abs());
        assert!(of.node == id && off_m.fold(0.0, f64::max) < 1e-8, "{of:?} is at {at_m:?}");
    }
    let corners = || rows[..header.triangles as usize].iter().map(|of| of.corners);
    check_closed(corners());
    // A page that comes now has the same surface: cells lie where the rows say.
    let (view, address) = view_of(&place.model, &place.scene, &[BLADE[0], BLADE[1]]);
    let frame = Page::open(&address).frame(|_| true);
    assert_eq!((frame.hash, frame.positions_m.len()), (header.state_hash, cells));
    let drawn =
        frame.triangles.iter().map(|of| [0, 1, 2].map(|k| frame.positions_m[of[k] as usize]));
    assert!(drawn.eq(corners().map(|of| of.map(|row| rows[row as usize].position_m))));
    let origins = frame.triangles.iter().flat_map(|of| of[3..].to_vec());
    assert!(origins.max() < Some(100));
    // After a reset it is whole, also for who comes then.
    place.command(&["reset"]).with(0);
    let (reset, _) = loop {
        let (header, rows) = reader.after(150);
        if header.copies == 0 {
            break (header, rows);
        }
    };
    assert_eq!(reset.triangles, whole.triangles);
    let mut page = Page::open(&address);
    let frame = page.frame(|frame| frame.triangles.is_empty());
    assert_eq!(frame.positions_m.len(), 100);
    view.interrupt().with(0);
    let served = serve.interrupt().with(130).json();
    assert!(served["surfaces_sent"].as_u64().unwrap() > 2, "{served}");
}
