//! The place of iceoryx2's files.

use std::path::PathBuf;

use iceoryx2::prelude::*;

use crate::error::{Error, Kind, Result};

/// Prefix and folder of the files of iceoryx2; programs with different ones never meet.
///
/// ```
/// use chaincell_client::{Options, services::Domain};
///
/// let domain = Domain { prefix: Some("test_7_".to_owned()), ..Domain::default() };
/// let options = Options { domain, ..Options::default() };
/// assert_ne!(options.domain, Domain::default()); // meets no program of the default
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Domain {
    /// Prefix of all file names; iceoryx2's own default if absent.
    pub prefix: Option<String>,
    /// Folder of the files; iceoryx2's own default if absent.
    pub root: Option<PathBuf>,
}

impl Domain {
    /// Returns iceoryx2's built-in configuration with this prefix and folder: no configuration file is read.
    pub(crate) fn config(&self) -> Result<Config> {
        let mut config = Config::default();
        if let Some(prefix) = &self.prefix {
            config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|why| {
                Error::new(
                    Kind::Argument,
                    format!("iceoryx2 prefix \"{prefix}\" is no file name ({why:?})"),
                )
            })?;
        }
        if let Some(root) = &self.root {
            let path = Path::new(root.as_os_str().as_encoded_bytes()).map_err(|why| {
                Error::new(
                    Kind::Argument,
                    format!("iceoryx2 folder {} is no path it accepts ({why:?})", root.display()),
                )
            })?;
            config.global.set_root_path(&path);
        }
        Ok(config)
    }
}
