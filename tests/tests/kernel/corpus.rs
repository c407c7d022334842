//! The committed corpora through every fuzz body: what a fuzzer once reached stays sound.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::panic::catch_unwind;
use std::path::{Path, PathBuf};

use chaincell_tests::fuzz::{TARGETS, canary};

/// Most bytes of all corpora: they are minimised before they are committed.
const BYTES_MAX: u64 = 900_000;

fn corpus(target: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(target);
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} is empty", folder.display());
    files
}

/// Runs a body over a corpus; the first file that breaks a promise is named.
fn replay(target: &str, body: fn(&[u8])) {
    for file in corpus(target) {
        let bytes = std::fs::read(&file).unwrap();
        assert!(catch_unwind(|| body(&bytes)).is_ok(), "{} breaks {target}", file.display());
    }
}

#[test]
fn every_committed_input_keeps_every_promise() {
    for (target, body) in TARGETS {
        replay(target, body);
    }
    replay("canary", canary);
}

#[test]
fn the_planted_defect_is_one() {
    let path = b"tick,x_m,y_m,z_m,engaged\n0,0,0,0,2\n";
    assert!(catch_unwind(|| canary(path)).is_err());
}

#[test]
fn corpora_stay_small() {
    let all = TARGETS.iter().map(|(target, _)| *target).chain(["canary"]);
    let bytes: u64 = all.flat_map(corpus).map(|file| file.metadata().unwrap().len()).sum();
    assert!(bytes < BYTES_MAX, "{bytes} bytes: minimise them with `cargo fuzz cmin`");
}
