//! Model images that nobody baked: what they claim is not believed.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::process::Command;

use chaincell_host::bake::ImageBytes;
use chaincell_kernel::image::{CHECKSUM_OFFSET, checksum};
use chaincell_kernel::{Model, include_model};
use chaincell_tests::chaincell;
use chaincell_tests::files::{scratch, text, write_path};

static PLANE9: &[u8] = include_model!("../../data/plane9.chaincell");
/// Where the number of the input's nodes stands: the last word of the parameters, the first
/// section of an image as the bake writes it.
const INPUT_NODES_WORD: usize = 15;
/// Address space of the command \[KiB\]: a list of all those nodes' places does not fit.
const ADDRESS_SPACE_KIB: u32 = 2_000_000;

/// `PLANE9` with this number of input nodes.
fn numbered(input_nodes: u32) -> Vec<u8> {
    let mut image = PLANE9.to_vec();
    let parameters = 32 + 16 * u32::from_le_bytes(*image[16..].first_chunk().unwrap()) as usize;
    let at = parameters.next_multiple_of(16) + 4 * INPUT_NODES_WORD;
    image[at..at + 4].copy_from_slice(&input_nodes.to_le_bytes());
    let right = checksum(&image);
    image[CHECKSUM_OFFSET..CHECKSUM_OFFSET + 4].copy_from_slice(&right.to_le_bytes());
    image
}

#[test]
fn a_numbering_far_beyond_the_nodes_takes_no_memory() {
    let image = numbered(1 << 27);
    let copy = ImageBytes::copy(&image);
    assert_eq!(Model::from_bytes(copy.as_bytes()).unwrap().input_nodes(), 1 << 27);
    let folder = scratch();
    let (model, path) = (folder.path().join("m.chaincell"), folder.path().join("p.csv"));
    std::fs::write(&model, &image).unwrap();
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
