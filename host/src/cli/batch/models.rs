//! The models of a batch: each file is read and checked once, for all jobs that name it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use sha1_smol::Sha1;

use super::super::model_file;
use crate::bake::ImageBytes;
use crate::error::Result;

/// Bytes of models that are kept: beyond it all are let go, and those still named are read again.
const BYTES_MAX: usize = 1 << 30;

/// A model file.
#[derive(Debug)]
pub struct Loaded {
    pub image: ImageBytes,
    /// SHA-1 of its bytes.
    pub sha1: String,
}

/// A file that is read when its first job asks for it.
type Slot = Arc<OnceLock<Result<Arc<Loaded>>>>;

/// The files by their paths, and the bytes that they hold.
#[derive(Debug, Default)]
pub struct Models(Mutex<(BTreeMap<PathBuf, Slot>, usize)>);

impl Models {
    /// The model of a path.
    ///
    /// # Errors
    /// A file that cannot be read or is no model.
    pub fn get(&self, path: &Path) -> Result<Arc<Loaded>> {
        let slot = {
            let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            Arc::clone(kept.0.entry(path.to_owned()).or_default())
        };
        let mut bytes = 0;
        let found = slot.get_or_init(|| {
            let loaded = read(path)?;
            bytes = loaded.image.as_bytes().len();
            Ok(Arc::new(loaded))
        });
        let found = found.clone();
        // The one that read it counts it.
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.1 += bytes;
        if kept.1 > BYTES_MAX {
            *kept = (BTreeMap::new(), 0);
        }
        found
    }
}

fn read(path: &Path) -> Result<Loaded> {
    let image = model_file::read(path)?;
    model_file::parse(&image, path)?;
    let sha1 = Sha1::from(image.as_bytes()).digest().to_string();
    Ok(Loaded { image, sha1 })
}
