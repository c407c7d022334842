//! A model, a path and a folder, and that a command refuses and leaves all as it is.

#![allow(clippy::unwrap_used, reason = "a failing helper fails its test")]

use std::path::{Path, PathBuf};

use chaincell_tests::files::{bake, content, scratch, text, write_path};
use chaincell_tests::run;

/// A baked plane and a path of five ticks.
pub struct Place {
    pub folder: tempfile::TempDir,
    pub model: PathBuf,
    pub path: PathBuf,
}

impl Place {
    pub fn new() -> Self {
        let folder = scratch();
        let model = bake(folder.path(), "plane:5x5x0.01", &[]);
        let path = folder.path().join("path.csv");
        write_path(&path, (0..5).map(|tick| (tick, [0.0; 3], 1)));
        Self { folder, model, path }
    }

    pub fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let file = self.folder.path().join(name);
        std::fs::write(&file, content).unwrap();
        file
    }

    /// Expects exit code 2, a message with every part, and a folder as it was.
    #[track_caller]
    pub fn refuses(&self, args: &[&str], parts: &[&str]) {
        let before = content(self.folder.path());
        let ended = run(args).with(2);
        for part in parts {
            assert!(ended.err.contains(part), "{args:?}: `{part}` is missing: {}", ended.err);
        }
        assert!(ended.err.len() > 20, "{args:?}: {}", ended.err);
        assert!(content(self.folder.path()) == before, "{args:?}: something was left behind");
    }

    /// Arguments of `run` with results in `out`.
    pub fn run_into<'a>(&'a self, out: &'a Path) -> [&'a str; 6] {
        ["run", text(&self.model), "--path", text(&self.path), "--out", text(out)]
    }

    /// Expects that `run` with these options is refused.
    #[track_caller]
    pub fn refuses_run(&self, options: &[&str], parts: &[&str]) {
        self.refuses_into(&self.folder.path().join("out"), options, parts);
    }

    /// Expects that `run` with results in `out` is refused.
    #[track_caller]
    pub fn refuses_into(&self, out: &Path, options: &[&str], parts: &[&str]) {
        self.refuses(&[&self.run_into(out), options].concat(), parts);
    }

    /// Expects that `bake` with these options is refused.
    #[track_caller]
    pub fn refuses_bake(&self, options: &[&str], parts: &[&str]) {
        let model = self.folder.path().join("other.chaincell");
        let args = ["bake", "plane:5x5x0.01", "-o", text(&model)];
        self.refuses(&[&args, options].concat(), parts);
    }
}
