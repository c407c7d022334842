//! One box in every format that is read: the same model from each.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::{Path, PathBuf};

use chaincell_tests::files::{scratch, text};
use chaincell_tests::run;

fn mesh(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/meshes").join(name)
}

/// What the model consists of.
#[track_caller]
fn size(mesh: &Path, options: &[&str]) -> [serde_json::Value; 4] {
    let folder = scratch();
    let model = folder.path().join("model.chaincell");
    run([&["bake", text(mesh), "-o", text(&model)], options].concat()).with(0);
    let info = run(["info", text(&model), "--json"]).with(0).json();
    ["cells", "links", "fixed", "surface"].map(|key| info[key].clone())
}

/// The model's bytes.
#[track_caller]
fn baked(mesh: &Path, options: &[&str]) -> Vec<u8> {
    let folder = scratch();
    let model = folder.path().join("model.chaincell");
    run([&["bake", text(mesh), "-o", text(&model)], options].concat()).with(0);
    std::fs::read(&model).unwrap()
}

#[test]
fn every_msh_file_gives_the_same_model_with_its_groups() {
    let fix = ["--fix", "group:held below", "--units", "mm"];
    let wanted = baked(&mesh("box.msh41.ascii.msh"), &fix);
    for name in [
        "box.msh22.ascii.msh",
        "box.msh22.binary.msh",
        "box.msh41.binary.msh",
        "box.msh41.parametric.msh",
    ] {
        assert!(baked(&mesh(name), &fix) == wanted, "{name}");
    }
    let unfixed = baked(&mesh("box.msh41.binary.msh"), &["--units", "mm"]);
    assert!(unfixed != wanted, "the group fixes nothing");
}

#[test]
fn every_vtk_file_gives_the_body_of_the_msh_file() {
    let fix = ["--fix", "box:-1,1,-1,1,-0.001,0.001"];
    // Those of version 5.1 have no groups.
    let [old, new] = ["box", "box51"].map(|name| {
        let image = baked(&mesh(&format!("{name}.ascii.vtk")), &fix);
        assert!(baked(&mesh(&format!("{name}.binary.vtk")), &fix) == image, "{name}");
        image
    });
    assert!(old.len() > new.len(), "{} {}", old.len(), new.len());
    // The image of the .msh file has groups of its own.
    let sizes = size(&mesh("box.binary.vtk"), &fix);
    assert_eq!(sizes, size(&mesh("box.msh41.binary.msh"), &fix));
    assert_eq!((sizes[0].as_u64(), sizes[2].as_u64()), (Some(32), Some(12)));
    let ended = run(["bake", text(&mesh("box.binary.vtk")), "-o", "x", "--fix", "group:body"]);
    assert!(ended.with(2).err.contains("group"), "groups have their numbers for names");
    let of_group = |name: &str| baked(&mesh(name), &["--fix", "group:7"]);
    assert!(of_group("box.binary.vtk") == of_group("box.ascii.vtk"));
}

#[test]
fn unused_nodes_of_a_binary_file_are_refused_or_dropped() {
    let folder = scratch();
    let file = folder.path().join("a.msh");
    let mut bytes = std::fs::read(mesh("box.msh22.binary.msh")).unwrap();
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
