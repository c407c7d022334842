//! Where a session is recorded, found by what its user names.

use std::path::{Path, PathBuf};

use chaincell_client::error::Kind;
use chaincell_client::recording;

use crate::error::{Error, Result};
use crate::files::recording::trace_of;
use crate::session::ipc::services::Domain;

/// Where a session is recorded.
#[derive(Debug, Clone)]
pub struct Place {
    /// The trace.
    pub trace: PathBuf,
    /// The model; `None` for that beside the trace.
    pub model: Option<PathBuf>,
}

impl Place {
    /// A session that is named by its trace, by the folder of its run, or, where no such file is, by the scene of the
    /// server that records it.
    ///
    /// # Errors
    /// Neither such a file nor a server that records on such a scene; files of another user.
    pub fn find(session: &Path, model: Option<PathBuf>) -> Result<Self> {
        // A name with a slash is a path, also where nothing is there.
        let name = session.to_str().filter(|name| !session.exists() && !name.contains('/'));
        let Some(name) = name else {
            return Ok(Self { trace: trace_of(session), model });
        };
        let trace = match recording::of(Some(name), &Domain::default()) {
            // It cannot name a scene either.
            Err(why) if why.kind() == Kind::Argument => None,
            found => found?,
        };
        let trace = trace.ok_or_else(|| {
            let why = "no such file, and no server records on a scene of this name: start serve with --out or \
                       --record; a session that has ended goes by its folder";
            Error::file("read trace", session, why)
        })?;
        Ok(Self { trace, model })
    }
}
