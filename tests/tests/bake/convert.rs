//! Meshes in other formats: what is written gives the same model to the bit.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use chaincell_host::mesh::{Mesh, RawMesh, parse, write};
use chaincell_tests::files::{content, scratch, text};
use chaincell_tests::process::SHORT;
use chaincell_tests::{Running, run};
use proptest::prelude::*;
use rustix::process::Signal;

use super::readers::data;

/// The formats that keep everything.
const FORMATS: [&str; 5] = ["msh", "vtk", "vtu", "inp", "mesh"];

/// The model's bytes.
#[track_caller]
fn baked(mesh: &str, options: &[&str]) -> Vec<u8> {
    let folder = scratch();
    let model = folder.path().join("model.chaincell");
    run([&["bake", mesh, "-o", text(&model)], options].concat()).with(0);
    std::fs::read(&model).unwrap()
}

#[test]
fn what_is_converted_bakes_to_the_same_model() {
    let folder = scratch();
    let wanted = baked("organ:300", &["--fix", "nodes:0,1,2"]);
    for ending in FORMATS {
        let file = folder.path().join(format!("organ.{ending}"));
        let ended = run(["convert", "organ:300", text(&file), "--json"]).with(0).json();
        assert_eq!(
            (&ended["groups"], &ended["notes"]),
            (&serde_json::json!([]), &serde_json::json!([]))
        );
        assert!(baked(text(&file), &["--fix", "nodes:0,1,2"]) == wanted, "{ending}");
        // What is there is replaced.
        run(["convert", "organ:200", text(&file)]).with(0);
        assert!(baked(text(&file), &["--fix", "nodes:0,1,2"]) != wanted, "{ending}");
    }
    let source = data("box.msh41.ascii.msh");
    let fix = ["--fix", "group:held below"];
    for ending in ["msh", "inp"] {
        let file = folder.path().join(format!("box.{ending}"));
        run(["convert", text(&source), text(&file)]).with(0);
        assert!(baked(text(&file), &fix) == baked(text(&source), &fix), "{ending}");
    }
    // Formats without names say how the groups are called there.
    for ending in ["vtk", "vtu", "mesh"] {
        let file = folder.path().join(format!("box.{ending}"));
        let ended = run(["convert", text(&source), text(&file)]).with(0);
        assert!(ended.err.contains("group 'held below' is '2' in this file"), "{}", ended.err);
        let model = folder.path().join("box.chaincell");
        let groups = run(["bake", text(&file), "-o", text(&model), "--json"]).with(0).json();
        assert_eq!(groups["groups"], serde_json::json!({"1": 32, "2": 12}), "{ending}");
    }
}

#[test]
fn a_surface_is_filled_and_its_figures_are_printed() {
    let folder = scratch();
    let (stl, mesh) = (folder.path().join("organ.stl"), folder.path().join("organ.msh"));
    run(["convert", "organ:1000", text(&stl)]).with(0);
    let ended = run(["convert", text(&stl), text(&mesh), "--fill", "0.012"]).with(0);
    for part in ["surface", "bodies: 1", "mean edge", "angles between faces", "volume", "distance"]
    {
        assert!(ended.out.contains(part), "`{part}` is missing: {}", ended.out);
    }
    let model = folder.path().join("organ.chaincell");
    let of_mesh = run(["bake", text(&mesh), "-o", text(&model), "--json"]).with(0).json();
    let filled =
        run(["bake", text(&stl), "--fill", "0.012", "-o", text(&model), "--json"]).with(0).json();
    assert_eq!(filled["checksum"], of_mesh["checksum"]);
    assert_eq!(filled["cells"], filled["filled"]["nodes"]);
    assert!(filled["filled"]["volume_error"].as_f64().unwrap().abs() < 0.03, "{filled}");
    assert!(of_mesh.get("filled").is_none());
    let ended = run(["bake", text(&stl), "-o", text(&model)]).with(2);
    assert!(ended.err.contains("a surface; --fill SIZE fills it"), "{}", ended.err);
    let ended = run(["bake", text(&mesh), "--fill", "0.01", "-o", text(&model)]).with(2);
    assert!(ended.err.contains("--fill fills closed surfaces"), "{}", ended.err);
    let obj = folder.path().join("organ.obj");
    run(["convert", text(&mesh), text(&obj)]).with(0);
    assert!(std::fs::read_to_string(&obj).unwrap().starts_with("v "));
}

#[test]
fn what_cannot_be_written_leaves_nothing_behind() {
    let folder = scratch();
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("cut.msh"), "$MeshFormat\n").unwrap();
    std::fs::write(
        at("open.stl"),
        "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
        vertex 0 1 0\nendloop\nendfacet\nendsolid\n",
    )
    .unwrap();
    let before = content(folder.path());
    for (args, parts) in [
        (["organ:200", "a.node"], ["unknown format", ".msh, .vtk, .vtu, .inp, .mesh, .stl, .obj"]),
        (["organ:200", "a"], ["unknown format", ".vtu"]),
        (["plane:3x3x0.01", "a.msh"], ["no tetrahedra", ".stl or .obj"]),
        (["cut.msh", "a.vtu"], ["cut.msh:", "cut off"]),
        (["open.stl", "a.vtu"], ["a surface", "--fill SIZE"]),
        (["organ:200", "none/a.vtu"], ["cannot write", "none/a.vtu"]),
    ] {
        let [from, to] = args.map(|name| {
            if name.starts_with(['o', 'p']) && name.contains(':') { name.into() } else { at(name) }
        });
        let ended = run(["convert", text(&from), text(&to)]).with(2);
        assert!(parts.iter().all(|part| ended.err.contains(part)), "{}", ended.err);
        assert!(ended.err.lines().count() == 1 && ended.out.is_empty(), "{}", ended.err);
    }
    let ended =
        run(["convert", text(&at("open.stl")), text(&at("a.vtu")), "--fill", "0.1"]).with(2);
    assert!(ended.err.contains("3 edges with a triangle on one side alone"), "{}", ended.err);
    assert!(content(folder.path()) == before, "something was left behind");
}

/// A mesh of random tetrahedra over random places, with groups.
fn meshes() -> impl Strategy<Value = Mesh> {
    let places = prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 4..12);
    places.prop_flat_map(|places| {
        let nodes = places.len() as u32;
        let tetrahedra = prop::collection::vec(
            prop::sample::subsequence((0..nodes).collect::<Vec<_>>(), 4),
            1..8,
        );
        let names = prop::sample::select(vec![
            "a",
            "held below",
            "7",
            "12",
            "-3",
            "07",
            "points:3",
            "Skin-2",
        ]);
        let members = prop::sample::subsequence((0..nodes).collect::<Vec<_>>(), 1..=nodes as usize);
        let groups = prop::collection::btree_map(names.prop_map(str::to_owned), members, 0..4);
        (Just(places), tetrahedra, groups).prop_map(|(nodes_m, tetrahedra, groups)| {
            let tetrahedra = tetrahedra.into_iter().map(|ids| ids.try_into().unwrap()).collect();
            RawMesh { nodes_m, tetrahedra, groups }.into()
        })
    })
}

/// Nodes of each group, whatever its name.
fn members(groups: &BTreeMap<String, Vec<u32>>) -> Vec<&Vec<u32>> {
    let mut all: Vec<_> = groups.values().collect();
    all.sort_unstable();
    all
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Every digit, every tetrahedron in its order and every node of every group comes back.
    #[test]
    fn round_trips_lose_nothing(mesh in meshes()) {
        for ending in FORMATS {
            let name = format!("a.{ending}");
            let path = Path::new(&name);
            let written = match write(&mesh, path) {
                Ok(written) => written,
                Err(why) => {
                    let why = why.to_string();
                    prop_assert!(ending == "mesh" && why.contains("write .msh or .inp"), "{}", why);
                    continue;
                }
            };
            let read = parse(path, written.text.as_bytes(), 1.0).unwrap();
            prop_assert_eq!(&read.nodes_m, &mesh.nodes_m);
            prop_assert_eq!(&read.tetrahedra, &mesh.tetrahedra);
            if matches!(ending, "msh" | "inp") {
                prop_assert_eq!(&read.groups, &mesh.groups);
            } else {
                prop_assert_eq!(members(&read.groups), members(&mesh.groups));
            }
        }
    }
}

/// A file in the place of what it was made of would be lost.
#[test]
fn the_input_is_not_overwritten() {
    let folder = scratch();
    let mesh = folder.path().join("box.vtu");
    std::fs::copy(data("box.vtk.raw.vtu"), &mesh).unwrap();
    let before = std::fs::read(&mesh).unwrap();
    let link = folder.path().join("link.vtu");
    std::os::unix::fs::symlink(&mesh, &link).unwrap();
    for output in [&mesh, &link] {
        for args in [
            vec!["bake", text(&mesh), "-o", text(output)],
            vec!["convert", text(&mesh), text(output)],
        ] {
            let ended = run(args).with(2);
            assert!(ended.err.contains("it is the input; name another file"), "{}", ended.err);
            assert!(std::fs::read(&mesh).unwrap() == before);
        }
    }
}

/// A link stays one: the file is written that it leads to.
#[test]
fn an_output_that_is_a_link_is_written_through() {
    let folder = scratch();
    let (target, link) = (folder.path().join("body.vtu"), folder.path().join("link.vtu"));
    std::fs::write(&target, "old").unwrap();
    std::os::unix::fs::symlink(&target, &link).unwrap();
    run(["convert", "organ:200", text(&link)]).with(0);
    assert!(link.is_symlink() && std::fs::read_to_string(&target).unwrap().starts_with("<?xml"));
}

/// An L of two faces with six corners and six with four, its comment in another encoding.
#[test]
fn faces_of_many_corners_are_cut_whatever_their_first_one_is() {
    let outline = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]];
    for first in 0..6 {
        let mut obj = b"# f\xfcr\n".to_vec();
        for z in [0, 1] {
            let points = outline.iter().map(|[x, y]| format!("v 0.0{x} 0.0{y} 0.0{z}\n"));
            points.for_each(|line| obj.extend(line.into_bytes()));
        }
        let face = |ids: Vec<usize>| {
            let ids: Vec<String> = ids.iter().map(|id| (id + 1).to_string()).collect();
            format!("f {}\n", ids.join(" ")).into_bytes()
        };
        let around = |place: usize| (first + place) % 6;
        obj.extend(face((0..6).rev().map(around).collect()));
        obj.extend(face((0..6).map(|place| 6 + around(place)).collect()));
        for side in 0..6 {
            let next = (side + 1) % 6;
            obj.extend(face(vec![side, next, 6 + next, 6 + side]));
        }
        let folder = scratch();
        let (mesh, out) = (folder.path().join("l.obj"), folder.path().join("l.msh"));
        std::fs::write(&mesh, obj).unwrap();
        let ended = run(["convert", text(&mesh), text(&out), "--fill", "0.003", "--json"]).with(0);
        let error = ended.json()["filled"]["volume_error"].as_f64().unwrap();
        assert!(error.abs() < 0.01, "{first}: {error}");
    }
}

#[test]
fn ctrl_c_ends_a_fill_at_once_and_leaves_nothing() {
    let folder = scratch();
    let (surface, body) = (folder.path().join("box.stl"), folder.path().join("box.msh"));
    run(["convert", "box:9x9x9x0.01", text(&surface)]).with(0);
    // Takes tens of seconds.
    let line = ["convert", text(&surface), text(&body), "--fill", "0.0009"];
    let mut convert = Running::chaincell(line);
    std::thread::sleep(Duration::from_secs(2));
    assert!(convert.is_running(), "the fill is too short for this test");
    convert.signal(Signal::INT);
    let ended = convert.end(SHORT).with(130);
    assert!(ended.err.contains("interrupted") && ended.out.is_empty(), "{ended:?}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}
