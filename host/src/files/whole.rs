//! Files that appear whole or not at all.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};

/// The folder that a file stands in.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Refuses to write what was made of a file in its place.
///
/// # Errors
/// The output is the input, by whatever name.
pub fn keep_input(input: &str, output: &Path) -> Result<()> {
    let same = |a: &Path, b: &Path| {
        fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b))
    };
    if same(Path::new(input), output) {
        return Err(Error::file("write", output, "it is the input; name another file"));
    }
    Ok(())
}

/// Writes a file under another name beside it first, so that it appears whole or not at all.
/// Devices, sockets and pipes stay what they are: a new file in their place would replace them.
///
/// # Errors
/// What the system says, with the path; a place that holds something other than a file.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<()> {
    let failed = |why: std::io::Error| Error::file("write", path, why);
    if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
        return Err(Error::file("write", path, "it is there and no file; name another one"));
    }
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // As any new file: what the user's mask leaves of rw for all.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.prefix(".chaincell-").tempfile_in(folder_of(path)).map_err(failed)?;
    file.write_all(content).and_then(|()| file.flush()).map_err(failed)?;
    file.persist(path).map_err(|why| failed(why.error))?;
    Ok(())
}
