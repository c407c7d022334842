//! The committed corpora through every fuzz body: what a fuzzer once reached stays sound.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fs::File;
use std::io::Read as _;
use std::panic::catch_unwind;
use std::path::Path;

use chaincell_tests::fuzz::{TARGETS, canary};
use flate2::read::GzDecoder;
use tar::Archive;

/// Most bytes of all corpora: they are minimised before they are committed.
const BYTES_MAX: u64 = 900_000;

/// The inputs of a target by their names, in the archive's order.
fn corpus(target: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus");
    let place = folder.join(format!("{target}.tar.gz"));
    let mut archive = Archive::new(GzDecoder::new(File::open(&place).unwrap()));
    let mut inputs = Vec::new();
    for entry in archive.entries().unwrap() {
        let mut entry = entry.unwrap();
        if entry.header().entry_type().is_file() {
            let name = entry.path().unwrap().display().to_string();
            let mut bytes = Vec::new();
            entry.read_to_end(&mut bytes).unwrap();
            inputs.push((name, bytes));
        }
    }
    assert!(!inputs.is_empty(), "{} is empty", place.display());
    inputs
}

/// Runs a body over a corpus; the first input that breaks a promise is named.
fn replay(target: &str, body: fn(&[u8])) {
    for (name, bytes) in corpus(target) {
        assert!(catch_unwind(|| body(&bytes)).is_ok(), "{name} breaks {target}");
    }
}

// REQ-HRD-03
#[test]
fn every_committed_input_keeps_every_promise() {
    for (target, body) in TARGETS {
        replay(target, body);
    }
    replay("canary", canary);
}

// REQ-HRD-03
#[test]
fn the_planted_defect_is_one() {
    let path = b"tick,x_m,y_m,z_m,engaged\n0,0,0,0,2\n";
    assert!(catch_unwind(|| canary(path)).is_err());
}

#[test]
fn corpora_stay_small() {
    let all = TARGETS.iter().map(|(target, _)| *target).chain(["canary"]);
    let bytes: u64 = all.flat_map(corpus).map(|(_, bytes)| bytes.len() as u64).sum();
    assert!(bytes < BYTES_MAX, "{bytes} bytes: minimise them with `tests/fuzz/run --minimise`");
}
