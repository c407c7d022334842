//! Meshes that cannot be baked: refused with file, line and remedy, and nothing is left behind.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::Path;

use chaincell_tests::files::{content, scratch, text};
use chaincell_tests::run;

/// Five nodes, two tetrahedra, format 2.2.
const SOUND: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n\
    $Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$EndNodes\n\
    $Elements\n2\n1 4 2 1 1 1 2 3 4\n2 4 2 1 1 2 3 4 5\n$EndElements\n";

/// Bakes `mesh` where it lies and expects a refusal that holds all `parts`.
#[track_caller]
fn refused(folder: &Path, mesh: &Path, options: &[&str], parts: &[&str]) {
    let before = content(folder);
    let model = folder.join("model.chaincell");
    let args = ["bake", text(mesh), "-o", text(&model)];
    let ended = run([&args, options].concat()).with(2);
    assert_eq!(ended.out, "");
    for part in parts.iter().chain([&text(mesh)]) {
        assert!(ended.err.contains(part), "`{part}` is missing: {}", ended.err);
    }
    assert!(ended.err.lines().count() == 1, "{}", ended.err);
    assert!(content(folder) == before, "something was left behind");
}

#[track_caller]
fn text_refused(mesh: &str, parts: &[&str]) {
    let folder = scratch();
    let file = folder.path().join("body.msh");
    std::fs::write(&file, mesh).unwrap();
    refused(folder.path(), &file, &[], parts);
}

#[test]
fn what_is_not_read_names_the_way_out() {
    for (from, to, parts) in [
        ("2.2 0 8", "4.0 0 8", &["body.msh:2", "4.0", "gmsh -save"]),
        ("2 1 0 0", "2 1 NaN 0", &["body.msh:7", "NaN", "mend"]),
        ("2 1 0 0", "2 1e300 0 0", &["body.msh:7", "1e300", "--units"]),
    ] {
        assert!(SOUND.contains(from));
        text_refused(&SOUND.replacen(from, to, 1), parts);
    }
    text_refused("", &["empty"]);
    text_refused("\u{0}\u{1}\u{2}", &["$MeshFormat"]);
    text_refused("solid body\nendsolid\n", &["a surface", "--fill SIZE"]);
    let folder = scratch();
    let file = folder.path().join("body.stl");
    std::fs::write(&file, "solid body\nendsolid\n").unwrap();
    refused(folder.path(), &file, &[], &["a surface", "--fill SIZE"]);
    let file = folder.path().join("body.step");
    std::fs::write(&file, "ISO-10303-21;\n").unwrap();
    refused(folder.path(), &file, &[], &["unknown format", "Gmsh", "Abaqus", "STL"]);
    for name in ["body.msh", "body.vtk", "body.msh.gz"] {
        let packed = folder.path().join(name);
        std::fs::write(&packed, b"\x1f\x8b\x08\0\0").unwrap();
        refused(
            folder.path(),
            &packed,
            &[],
            &["it is gzip-compressed: unpack it first with gunzip"],
        );
    }
}

// REQ-MOD-05
#[test]
fn bodies_that_no_network_can_carry() {
    text_refused(
        &SOUND.replacen("2 4 2 1 1 2 3 4 5\n", "", 1).replacen("$Elements\n2", "$Elements\n1", 1),
        &["1 node without a link: 4", "--drop-unused"],
    );
    text_refused(&SOUND.replacen("5 1 1 1", "5 0 0 1", 1), &["nodes 3 and 4", "merge"]);
    let far = "6 9 9 9\n7 10 9 9\n8 9 10 9\n9 9 9 10\n$EndNodes";
    let two_parts = SOUND
        .replacen("$Nodes\n5", "$Nodes\n9", 1)
        .replacen("$EndNodes", far, 1)
        .replacen("$Elements\n2", "$Elements\n3", 1)
        .replacen("$EndElements", "3 4 2 1 1 6 7 8 9\n$EndElements", 1);
    text_refused(&two_parts, &["2 unconnected parts", "--allow-parts"]);
}

#[test]
fn files_that_are_no_files() {
    let folder = scratch();
    refused(folder.path(), &folder.path().join("none.msh"), &[], &["organ[:NODES]"]);
    refused(
        folder.path(),
        folder.path(),
        &[],
        &["cannot open mesh", "it is a folder: give a file"],
    );
    // Nobody writes into the pipe: it is not waited for.
    let pipe = folder.path().join("pipe.msh");
    let mode = rustix::fs::Mode::RWXU;
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
    let ended = run(["bake", text(&pipe), "-o", "x", "--fix", "none"]).with(2);
    assert!(ended.err.contains("pipe.msh: it is a named pipe: give a file"), "{}", ended.err);
    refused(folder.path(), &folder.path().join("none/none.msh"), &[], &["cannot open mesh"]);
}

#[test]
fn generators_with_bad_sizes() {
    let folder = scratch();
    for spec in [
        "plane:3x3",
        "plane:18446744073709551616x3x1",
        "plane:3x3x0.01x3",
        "box:99x99x99x0.01",
        "box:",
        "organ:9999999",
        "organ:",
        "cube:3",
        "",
        ":",
        "plane",
        "box",
    ] {
        refused(folder.path(), Path::new(spec), &[], &[]);
    }
    refused(folder.path(), Path::new("box:3x3x3x0.01"), &["--diagonals"], &["--diagonals"]);
}

#[test]
fn unused_nodes_of_a_binary_file_are_refused_or_dropped() {
    let folder = scratch();
    let file = folder.path().join("a.msh");
    let mut bytes = std::fs::read(super::readers::data("box.msh22.binary.msh")).unwrap();
    // One node more, of tag 999, that no element has.
    let at = bytes.windows(10).position(|window| window == b"$Nodes\n32\n").unwrap() + 7;
    bytes[at + 1] = b'3';
    let mut node = 999_i32.to_le_bytes().to_vec();
    node.extend([0; 24]);
    bytes.splice(at + 3..at + 3, node);
    std::fs::write(&file, &bytes).unwrap();
    let model = folder.path().join("model.chaincell");
    let args = ["bake", text(&file), "-o", text(&model), "--fix", "group:held below", "--json"];
    let refused = run(args).with(2);
    assert!(refused.err.contains("--drop-unused"), "{}", refused.err);
    let ended = run([&args[..], &["--drop-unused"]].concat()).with(0);
    assert_eq!(ended.json()["cells"], 32);
    // A cut file is refused with its place, and leaves nothing behind.
    std::fs::write(&file, &bytes[..1000]).unwrap();
    std::fs::remove_file(&model).unwrap();
    let refused = run(args).with(2);
    assert!(refused.err.contains("a.msh: byte") && !model.exists(), "{}", refused.err);
}
