//! The place of iceoryx2's files.

use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::path::PathBuf;

use iceoryx2::prelude::*;

use crate::error::{Error, Kind, Result};
use crate::owner;

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
    /// Returns iceoryx2's built-in configuration with this prefix and folder: no configuration file is read. The
    /// folder is made if it is missing.
    ///
    /// # Errors
    /// A prefix or folder that it does not accept; a folder of another user.
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
        owner::take(OsStr::from_bytes(config.global.root_path().as_bytes()).as_ref())?;
        Ok(config)
    }
}
