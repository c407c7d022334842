//! A small model to serve, on a scene of its own.

use std::path::PathBuf;

use crate::files::{bake, scratch, text};
use crate::{Running, scene};

/// A folder with a baked plane of 81 cells, and a scene's name.
pub struct Place {
    /// Removed with its content at the end.
    pub folder: tempfile::TempDir,
    /// The model in it.
    pub model: PathBuf,
    /// The scene.
    pub scene: String,
}

impl Place {
    /// A place for a test.
    #[must_use]
    pub fn new(test: &str) -> Self {
        let folder = scratch();
        let model = bake(folder.path(), "plane:9x9x0.01", &["--alpha", "0.02"]);
        Self { folder, model, scene: scene(test) }
    }

    /// A server that holds the plane's middle, and has said that it is ready. How late its answers
    /// are is the machine's matter, unless the options say otherwise.
    #[must_use]
    pub fn serve(&self, options: &[&str]) -> Running {
        let args = ["serve", text(&self.model), "--scene", &self.scene, "--contact", "40"];
        let judged = options.contains(&"--late-share");
        let late = if judged { &[][..] } else { &["--late-share", "off"] };
        let mut serve = Running::chaincell([&args, options, late].concat());
        serve.wait_for_line("ready");
        serve
    }
}
