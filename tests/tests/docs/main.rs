//! What the pages say is true where a machine can tell: links lead somewhere, shell lines run,
//! commands, options, test targets and JSON keys exist.
#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

mod commands;
mod keys;
mod links;
mod page;
mod shell;

use page::pages;

/// Largest README \[bytes\]: one page.
const README_BYTES_MAX: usize = 9_000;

#[test]
fn the_readme_is_one_page() {
    let pages = pages();
    let readme = pages.iter().find(|page| page.path == "README.md").unwrap();
    let bytes = readme.text.len();
    assert!(bytes <= README_BYTES_MAX, "{bytes} bytes, at most {README_BYTES_MAX}");
}
