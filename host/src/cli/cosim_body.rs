//! The body of `chaincell cosim`: a model file, or the organ that is made here.

use std::path::{Path, PathBuf};

use chaincell_kernel::Model;

use super::model_file;
use crate::bake::tissue::{DEVICE_HZ, KnownTissue};
use crate::bake::{
    ImageBytes, ORGAN_POISSON, ORGAN_SIZE, ORGAN_TISSUE, ORGAN_YOUNG_PA, organ, organ_of_known,
};
use crate::engine::staged::check_tick;
use crate::error::{Error, Result};

/// Options of the body of a session.
#[derive(Debug, clap::Args)]
pub struct CosimBodyArgs {
    #[arg(help = format!(
        "Model file from `chaincell bake` [default: organ:{ORGAN_SIZE} of the tissue {ORGAN_TISSUE}, \
         {} kPa, Poisson's ratio {ORGAN_POISSON}]", 1e-3 * ORGAN_YOUNG_PA
    ))]
    pub model: Option<PathBuf>,
    /// Tissue of the default body, by name or from a table, as --tissue of `bake`: modulus, Poisson's
    /// ratio, branches and bands; without a model
    #[arg(long, value_name = "NAME")]
    pub tissue: Option<String>,
}

impl CosimBodyArgs {
    /// Reads or makes the model; returns it with the file from which both sides read it. That of a made one is in
    /// this folder, and is still to be written. Cost: tens of milliseconds for a made one.
    ///
    /// # Errors
    /// A tissue beside a model, one that is not known, a model file that cannot be read.
    pub fn image(&self, scratch: &Path) -> Result<(ImageBytes, PathBuf)> {
        let made = || scratch.join("organ.chaincell");
        match (&self.model, &self.tissue) {
            (Some(path), Some(name)) => Err(Error::input(format!(
                "--tissue {name}: {} is baked and has its own tissue; bake its mesh with bake --tissue {name}, or \
                 leave the model out",
                path.display()
            ))),
            (Some(path), None) => Ok((model_file::read(path)?, path.clone())),
            (None, Some(name)) => Ok((organ_of_known(&KnownTissue::find(name)?)?, made())),
            (None, None) => Ok((organ()?, made())),
        }
    }

    /// Returns the name of the body in words.
    pub fn name(&self) -> String {
        match (&self.model, &self.tissue) {
            (Some(path), _) => path.display().to_string(),
            (None, Some(tissue)) => format!("organ of {tissue}"),
            (None, None) => "organ".into(),
        }
    }

    /// Returns the model file as a page knows it; `None` for the organ that the page can make itself.
    pub fn shown<'a>(&self, model_path: &'a Path) -> Option<&'a Path> {
        (self.model.is_some() || self.tissue.is_some()).then_some(model_path)
    }
}

/// Refuses a body that was baked for another rate than that of the controller.
///
/// # Errors
/// That it was, with the remedy.
pub fn check_body_rate(model: &Model<'_>, path: &Path) -> Result<()> {
    check_tick(model, None).map_err(|_| {
        Error::input(format!(
            "{}: its branches of relaxation were not baked for the {DEVICE_HZ} poses a second that the controller of cosim \
             sends; bake it without `device_hz`, or take `run`, or `serve` with a device of its rate",
            path.display()
        ))
    })
}
