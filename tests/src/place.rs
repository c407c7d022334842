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

    /// A box of 245 cells of soft tissue with a contact surface: its top is at 40 mm.
    #[must_use]
    pub fn on_surface(test: &str) -> Self {
        let folder = scratch();
        let options = ["--young-pa", "5000"];
        let model = bake(folder.path(), "box:7x7x5x0.01", &options);
        Self { folder, model, scene: scene(test) }
    }

    /// A server that holds the plane's middle, unless the options name a contact, and has said that it is ready. How late its answers
    /// are is the machine's matter, unless the options say otherwise.
    #[must_use]
    pub fn serve(&self, options: &[&str]) -> Running {
        let args = ["serve", text(&self.model), "--scene", &self.scene];
        let named = options.contains(&"--contact");
        let contact = if named { &[][..] } else { &["--contact", "40"] };
        let judged = options.contains(&"--late-share");
        let late = if judged { &[][..] } else { &["--late-share", "off"] };
        let mut serve = Running::chaincell([&args, contact, options, late].concat());
        serve.wait_for_line("ready");
        serve
    }
}
