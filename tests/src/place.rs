//! A small model to serve, on a scene of its own.

use std::path::PathBuf;
use std::process::Command;

use crate::files::{bake, scratch, text};
use crate::{Ended, Running, chaincell, run, scene};

/// A folder with a baked model, and a scene's name.
pub struct Place {
    /// Removed with its content at the end.
    pub folder: tempfile::TempDir,
    /// The model in it.
    pub model: PathBuf,
    /// The scene.
    pub scene: String,
}

impl Place {
    /// A plane of 81 cells for a test.
    #[must_use]
    pub fn new(test: &str) -> Self {
        Self::of(test, "plane:9x9x0.01", &["--alpha", "0.02"])
    }

    /// Any body.
    #[must_use]
    pub fn of(test: &str, spec: &str, options: &[&str]) -> Self {
        let folder = scratch();
        let model = bake(folder.path(), spec, options);
        Self { folder, model, scene: scene(test) }
    }

    /// A plane without slack whose middle pushes back with some newtons.
    #[must_use]
    pub fn stiff(test: &str) -> Self {
        Self::of(test, "plane:9x9x0.01", &["--alpha", "0", "--stiffness-n-per-m", "1000"])
    }

    /// A box of 245 cells of soft tissue with a contact surface: its top is at 40 mm.
    #[must_use]
    pub fn on_surface(test: &str) -> Self {
        Self::of(test, "box:7x7x5x0.01", &["--young-pa", "5000"])
    }

    /// A place in the folder.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A server that holds the plane's middle, unless the options name a contact or tools, and has said
    /// that it is ready. How late its answers are is the machine's matter, unless the options say otherwise.
    #[must_use]
    pub fn serve(&self, options: &[&str]) -> Running {
        let args = ["serve", text(&self.model), "--scene", &self.scene];
        let is_named = |option: &&str| *option == "--contact" || option.starts_with("--tool");
        let named = options.iter().any(is_named);
        let contact = if named { &[][..] } else { &["--contact", "40"] };
        let judged = options.contains(&"--late-share");
        let late = if judged { &[][..] } else { &["--late-share", "off"] };
        let mut serve = Running::chaincell([&args, contact, options, late].concat());
        serve.wait_for_line("ready");
        serve
    }

    /// A command to its server.
    #[track_caller]
    pub fn command(&self, action: &[&str]) -> Ended {
        run([&["command", "--scene", &self.scene, "--json"], action].concat())
    }

    /// The command line of a controller on its scene; how late the answers are is not the question.
    #[must_use]
    pub fn control(&self, options: &[&str]) -> Command {
        let mut command = chaincell();
        command.args(["control", "--scene", &self.scene, "--json", "--late-share", "off"]);
        command.args(options);
        command
    }
}
