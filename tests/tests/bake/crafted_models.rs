//! Model images that nobody baked: what they claim is not believed.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::process::Command;

use chaincell_host::bake::ImageBytes;
use chaincell_kernel::image::{kind, params};
use chaincell_kernel::{Model, include_model};
use chaincell_tests::chaincell;
use chaincell_tests::files::{scratch, text, write_path};
use chaincell_tests::forge::Forged;

static PLANE9: &[u8] = include_model!("../../data/plane9.chaincell");
/// Address space of the command \[KiB\]: a list of all those nodes' places does not fit.
const ADDRESS_SPACE_KIB: u32 = 2_000_000;

/// `PLANE9` with this number of input nodes.
fn numbered(input_nodes: u32) -> ImageBytes {
    let mut image = Forged::of(PLANE9);
    image.change(kind::PARAMS, |words: &mut Vec<u32>| words[params::INPUT_NODES] = input_nodes);
    image.sealed()
}

// REQ-HRD-03
#[test]
fn a_numbering_far_beyond_the_nodes_takes_no_memory() {
    let image = numbered(1 << 27);
    assert_eq!(Model::from_bytes(image.as_bytes()).unwrap().input_nodes(), 1 << 27);
    let folder = scratch();
    let (model, path) = (folder.path().join("m.chaincell"), folder.path().join("p.csv"));
    std::fs::write(&model, image.as_bytes()).unwrap();
    write_path(&path, (0..3).map(|tick| (tick, [0.0; 3], 1)));
    let run = |contact: &str, out: &str| {
        Command::new("sh")
            .args(["-c", &format!("ulimit -v {ADDRESS_SPACE_KIB}; exec \"$0\" \"$@\"")])
            .arg(chaincell().get_program())
            .args(["run", text(&model), "--path", text(&path), "--contact", contact])
            .args(["--out", text(&folder.path().join(out))])
            .output()
            .unwrap()
    };
    let held = run("cells:40", "a");
    assert!(held.status.success(), "{}", String::from_utf8_lossy(&held.stderr));
    let beyond = run("cells:134217727", "b");
    let said = String::from_utf8_lossy(&beyond.stderr);
    assert_eq!(beyond.status.code(), Some(2), "{said}");
    assert!(said.contains("is no cell of the model"), "{said}");
}
