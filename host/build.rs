//! Tells `chaincell --version` the commit and the target.
//!
//! The commit comes from the first of these that knows it: the variable `CHAINCELL_COMMIT`; the file
//! that `cargo package` leaves in a package; git, where this folder is part of its tree. A debug
//! build does not ask git: each commit would build the host and all that uses it again.

use std::path::Path;
use std::process::Command;
use std::{env, fs};

/// Digits of a commit that are shown.
const DIGITS: usize = 12;
/// What decides, beside the sources here, whether a build has changes that are not committed.
const SOURCES: [&str; 6] =
    ["src", "Cargo.toml", "../Cargo.toml", "../Cargo.lock", "../kernel/src", "client/src"];

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed=CHAINCELL_COMMIT");
    let is_release = env::var("PROFILE").is_ok_and(|profile| profile == "release");
    let commit = given()
        .or_else(packed)
        .or_else(|| {
            if is_release { from_git() } else { Some("not asked for in a debug build".into()) }
        })
        .unwrap_or_else(|| "unknown".into());
    println!("cargo::rustc-env=CHAINCELL_BUILD_COMMIT={commit}");
    let target = env::var("TARGET").unwrap_or_else(|_| "unknown".into());
    println!("cargo::rustc-env=CHAINCELL_BUILD_TARGET={target}");
}

/// What whoever builds says.
fn given() -> Option<String> {
    env::var("CHAINCELL_COMMIT").ok().filter(|commit| !commit.is_empty())
}

/// What `cargo package` wrote down.
fn packed() -> Option<String> {
    let file = fs::read_to_string(".cargo_vcs_info.json").ok()?;
    let (_, rest) = file.split_once("\"sha1\"")?;
    let commit = rest.split('"').nth(1)?;
    Some(shown(commit, file.contains("\"dirty\": true")))
}

fn from_git() -> Option<String> {
    // The tree of another project may hold a copy of this folder that it does not track.
    git(&["ls-files", "--error-unmatch", "Cargo.toml"])?;
    let commit = git(&["rev-parse", "HEAD"])?;
    // What moves with a commit or a checkout: the head, its log, its branch.
    let branch = git(&["symbolic-ref", "--quiet", "HEAD"]);
    for name in ["HEAD", "logs/HEAD", "packed-refs"].into_iter().chain(branch.as_deref()) {
        watch(&git(&["rev-parse", "--git-path", name])?);
    }
    SOURCES.into_iter().for_each(watch);
    let changed = git(&["status", "--porcelain", "--untracked-files=no"])?;
    Some(shown(&commit, !changed.is_empty()))
}

/// Runs this script again when a file changes; for one that is not there it would run each time.
fn watch(path: &str) {
    if Path::new(path).exists() {
        println!("cargo::rerun-if-changed={path}");
    }
}

fn shown(commit: &str, is_dirty: bool) -> String {
    let commit: String = commit.chars().take(DIGITS).collect();
    if is_dirty { format!("{commit}-dirty") } else { commit }
}

/// The output of git, `None` where there is none or it refuses.
fn git(arguments: &[&str]) -> Option<String> {
    // It leaves its own files as they are: a new index would be a change.
    let said = Command::new("git").arg("--no-optional-locks").args(arguments).output().ok()?;
    let text = String::from_utf8(said.stdout).ok()?;
    said.status.success().then(|| text.trim().to_owned())
}
