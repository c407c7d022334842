//! Reading a baked model, with errors that name the file.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use chaincell_kernel::Model;

use crate::bake::ImageBytes;
use crate::error::{Error, Result};

/// Largest image that is read: 65,535 cells with 2,000,000 nodes stay below it.
const BYTES_MAX: u64 = 1 << 30;

/// The bytes of a model file, aligned as the kernel reads them.
pub fn read(path: &Path) -> Result<ImageBytes> {
    let failed = |why: std::io::Error| Error::file("read model", path, why);
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(|why| {
        Error::file("read model", path, format!("{why}; a model is made by chaincell bake"))
    })?;
    file.take(BYTES_MAX + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > BYTES_MAX {
        return Err(Error::file("read model", path, format_args!("more than {BYTES_MAX} bytes")));
    }
    Ok(ImageBytes::copy(&bytes))
}

/// The model in those bytes.
pub fn parse<'a>(image: &'a ImageBytes, path: &Path) -> Result<Model<'a>> {
    let refuse = |why: &dyn std::fmt::Display| Error::file("read model", path, why);
    let model = Model::from_bytes(image.as_bytes()).map_err(|why| refuse(&why))?;
    let mut ids = model.input_id().to_vec();
    ids.sort_unstable();
    match ids.windows(2).find(|pair| pair[0] == pair[1]) {
        None => Ok(model),
        Some(pair) => {
            Err(refuse(&format_args!("two cells have the input id {}: bake again", pair[0])))
        }
    }
}
