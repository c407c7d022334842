//! The committed header is what the sources say.
//!
//! `CHAINCELL_HEADER=renew cargo test -p chaincell-client-ffi --test header` writes it anew.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use similar::TextDiff;

fn generated(package: &Path) -> String {
    let config = cbindgen::Config::from_file(package.join("cbindgen.toml")).unwrap();
    let builder = cbindgen::Builder::new().with_config(config).with_src(package.join("src/lib.rs"));
    let mut header = Vec::new();
    builder.generate().unwrap().write(&mut header);
    // Rustdoc wants units in escaped brackets, C readers do not.
    let header = String::from_utf8(header).unwrap().replace("\\[", "[").replace("\\]", "]");
    header.replace(" * # Safety", " * Safety")
}

#[test]
fn the_header_is_what_the_sources_say() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = package.join("include/chaincell_client.h");
    let wanted = generated(package);
    if std::env::var("CHAINCELL_HEADER").is_ok_and(|value| value == "renew") {
        std::fs::write(&path, &wanted).unwrap();
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    let diff = TextDiff::from_lines(&committed, &wanted);
    assert!(
        committed == wanted,
        "include/chaincell_client.h is not what the sources say:\n{}\nrenew it with\n  \
         CHAINCELL_HEADER=renew cargo test -p chaincell-client-ffi --test header",
        diff.unified_diff().header("committed", "sources")
    );
}

/// A C program has one space of names for all it includes.
#[test]
fn every_name_is_the_librarys_own() {
    let header = generated(Path::new(env!("CARGO_MANIFEST_DIR")));
    let macros = header.lines().filter_map(|line| line.strip_prefix("#define "));
    let functions =
        header.lines().filter_map(|line| line.strip_prefix("typedef ")?.split("(*").nth(1));
    let types = header
        .lines()
        .filter_map(|line| line.strip_prefix("} ").filter(|line| line.ends_with(';')));
    let names: Vec<&str> = macros.chain(functions).chain(types).collect();
    let is_own = |name: &&&str| name.to_lowercase().starts_with("chaincell_");
    let foreign: Vec<&&str> = names.iter().filter(|name| !is_own(name)).collect();
    assert!(names.len() > 20 && foreign.is_empty(), "{foreign:?}");
}
