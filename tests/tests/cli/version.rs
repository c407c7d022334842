//! `--version`: the release, the commit, the features, the target; and the build script that finds
//! the commit.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use chaincell_tests::files::scratch;
use chaincell_tests::run;

/// A tree with the host's folder in it, and its build script as a program.
struct Tree {
    folder: tempfile::TempDir,
    script: PathBuf,
}

impl Tree {
    fn new() -> Self {
        let folder = scratch();
        let host = folder.path().join("tree/host");
        fs::create_dir_all(host.join("src")).unwrap();
        fs::write(host.join("Cargo.toml"), "[package]\n").unwrap();
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/build.rs");
        let script = folder.path().join("script");
        let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
        let built = Command::new(rustc)
            .args(["--edition", "2024", "-o"])
            .args([&script, &source])
            .output()
            .unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        Self { folder, script }
    }

    fn host(&self) -> PathBuf {
        self.folder.path().join("tree/host")
    }

    /// A command in the tree that knows no repository above it and no settings of the user.
    fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command.current_dir(self.host()).env("GIT_CEILING_DIRECTORIES", self.folder.path());
        for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "CHAINCELL_COMMIT"] {
            command.env_remove(name);
        }
        command.env("GIT_CONFIG_GLOBAL", "/dev/null").env("TARGET", "a-target");
        command
    }

    #[track_caller]
    fn git(&self, arguments: &[&str]) -> String {
        let names = ["-c", "user.name=x", "-c", "user.email=x@example.org"];
        let said = self.command("git").args(names).args(arguments).output().unwrap();
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
        String::from_utf8(said.stdout).unwrap().trim().to_owned()
    }

    /// All that the script says in a build of a profile.
    #[track_caller]
    fn said(&self, profile: &str, given: &[(&str, &str)]) -> String {
        let mut command = self.command(&self.script);
        let said = command.env("PROFILE", profile).envs(given.iter().copied()).output().unwrap();
        assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
        String::from_utf8(said.stdout).unwrap()
    }

    #[track_caller]
    fn commit(&self, profile: &str, given: &[(&str, &str)]) -> String {
        let said = self.said(profile, given);
        let found = said.lines().find_map(|line| line.split_once("CHAINCELL_BUILD_COMMIT="));
        found.unwrap().1.to_owned()
    }
}

#[test]
fn the_version_tells_what_was_built() {
    let short = run(["-V"]).with(0).out;
    let long = run(["--version"]).with(0).out;
    assert_eq!(short.lines().count(), 1, "{short}");
    let lines: Vec<&str> = long.lines().collect();
    assert_eq!(lines[0], short.trim_end());
    assert_eq!(lines[0], format!("chaincell {}", env!("CARGO_PKG_VERSION")));
    let value = |name: &str| {
        let found = lines.iter().find_map(|line| line.strip_prefix(name)?.strip_prefix(": "));
        found.unwrap_or_else(|| panic!("no {name} in {long}")).to_owned()
    };
    let is_commit = |text: &str| {
        let digits = text.strip_suffix("-dirty").unwrap_or(text);
        digits.len() == 12 && digits.bytes().all(|b| b.is_ascii_hexdigit())
    };
    let commit = value("commit");
    let is_debug = cfg!(debug_assertions) && commit == "not asked for in a debug build";
    assert!(is_debug || commit == "unknown" || is_commit(&commit), "{commit}");
    assert_eq!(value("kernel features"), "cut, nodal, pins, relax, surface");
    let memory = value("shared memory");
    assert!(memory.starts_with("iceoryx2 ") && memory.contains('.'), "{memory}");
    assert!(value("target").contains(std::env::consts::ARCH));
}

#[test]
fn the_laboratory_tells_the_same() {
    let lab = Path::new(chaincell_tests::chaincell().get_program()).with_file_name("chaincell-lab");
    let said = Command::new(lab).arg("--version").output().unwrap();
    let of_lab = String::from_utf8(said.stdout).unwrap();
    assert_eq!(of_lab.replace("chaincell-lab ", "chaincell "), run(["--version"]).with(0).out);
}

#[test]
fn the_build_script_finds_the_commit() {
    let tree = Tree::new();
    assert_eq!(tree.commit("release", &[]), "unknown");
    tree.git(&["init", "--quiet", ".."]);
    tree.git(&["commit", "--quiet", "--allow-empty", "--message", "none"]);
    assert_eq!(tree.commit("release", &[]), "unknown", "a folder that git does not track");
    tree.git(&["add", "--all"]);
    tree.git(&["commit", "--quiet", "--message", "one"]);
    let head = tree.git(&["rev-parse", "HEAD"]);
    assert_eq!(tree.commit("release", &[]), head[..12]);
    assert_eq!(tree.commit("debug", &[]), "not asked for in a debug build");
    for profile in ["release", "debug"] {
        assert_eq!(tree.commit(profile, &[("CHAINCELL_COMMIT", "mine")]), "mine");
    }
    fs::write(tree.host().join("Cargo.toml"), "[package]\n\n").unwrap();
    assert_eq!(tree.commit("release", &[]), format!("{}-dirty", &head[..12]));
    let info = format!("{{\n  \"git\": {{\n    \"sha1\": \"{}\"\n  }}\n}}", "abc1".repeat(10));
    fs::write(tree.host().join(".cargo_vcs_info.json"), info).unwrap();
    assert_eq!(tree.commit("release", &[]), "abc1abc1abc1", "a package tells of itself");
}

#[test]
fn a_build_follows_the_commit_and_nothing_else_of_git() {
    let tree = Tree::new();
    tree.git(&["init", "--quiet", "--initial-branch", "line", ".."]);
    tree.git(&["add", "--all"]);
    tree.git(&["commit", "--quiet", "--message", "one"]);
    let said = tree.said("release", &[]);
    let watched: Vec<&str> =
        said.lines().filter_map(|line| line.strip_prefix("cargo::rerun-if-changed=")).collect();
    for path in ["HEAD", "logs/HEAD", "refs/heads/line"] {
        assert!(watched.iter().any(|watched| watched.ends_with(&format!(".git/{path}"))), "{said}");
    }
    assert!(!watched.iter().any(|path| path.ends_with("index")), "{said}");
    assert!(watched.contains(&"src"), "{said}");
    // A path that is not there would run the script in each build.
    for path in watched.iter().filter(|path| **path != "build.rs") {
        assert!(tree.host().join(path).exists(), "{path}");
    }
    assert!(!tree.said("debug", &[]).contains(".git"), "a debug build follows no commit");
}
