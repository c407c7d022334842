//! Writes files that appear whole or not at all.

use std::fs;
use std::io::Write;
use std::path::Path;

use crate::error::{Error, Result};
use crate::input;

/// The first letters of a file's name until it is whole.
pub const UNFINISHED: &str = ".chaincell-";

/// Returns the folder that contains a file.
#[must_use]
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Refuses an output path that is the input file.
///
/// # Errors
/// An output that is the input, possibly under another name.
pub fn keep_input(input: &str, output: &Path) -> Result<()> {
    let same = |a: &Path, b: &Path| {
        fs::canonicalize(a).is_ok_and(|a| fs::canonicalize(b).is_ok_and(|b| a == b))
    };
    if same(Path::new(input), output) {
        return Err(Error::file("write", output, "it is the input; name another file"));
    }
    Ok(())
}

/// Refuses a place that [`write_whole`] could not write, before the work whose result is to stand there.
///
/// # Errors
/// As [`write_whole`]; a folder in its place.
pub fn check_writable(path: &Path) -> Result<()> {
    input::keep(path)?;
    if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
        return Err(Error::file("write", path, "it is there and no file; name another one"));
    }
    let failed = |why: std::io::Error| Error::file("write", path, cause(&why));
    tempfile::tempfile_in(folder_of(path)).map(|_| ()).map_err(failed)
}

/// Writes a file under another name in the same folder first, so that it appears whole or not at all.
/// Refuses devices, sockets and pipes, which a new file would replace. If the path is a link, its target is
/// written.
///
/// # Errors
/// The system's error, with the path; a path that is an input or not a file; a link to nothing.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<()> {
    let failed = |why: std::io::Error| Error::file("write", path, cause(&why));
    input::keep(path)?;
    if fs::metadata(path).is_ok_and(|there| !there.is_file()) {
        return Err(Error::file("write", path, "it is there and no file; name another one"));
    }
    let target = if path.is_symlink() {
        fs::canonicalize(path).map_err(|why| {
            Error::file("write", path, format!("{why}: the link leads to no file; remove it"))
        })?
    } else {
        path.to_owned()
    };
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        // Like any new file: rw for all, reduced by the user's mask.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    let mut file = builder.prefix(UNFINISHED).tempfile_in(folder_of(&target)).map_err(failed)?;
    file.write_all(content).and_then(|()| file.flush()).map_err(failed)?;
    file.persist(&target).map_err(|why| failed(why.error))?;
    Ok(())
}

/// Returns the system's message without the temporary name of the file, which `tempfile` appends.
fn cause(why: &std::io::Error) -> String {
    let text = why.to_string();
    text.split_once(" at path ").map_or(text.as_str(), |(cause, _)| cause).to_owned()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_link_stays_and_its_file_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("other")).unwrap();
        fs::write(at("other/file"), "old").unwrap();
        std::os::unix::fs::symlink("other/file", at("link")).unwrap();
        std::os::unix::fs::symlink("link", at("link to link")).unwrap();
        for name in ["link", "link to link", "other/file"] {
            write_whole(&at(name), name.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(at("other/file")).unwrap(), name);
            assert!(at("link").is_symlink() && at("link to link").is_symlink());
        }
        std::os::unix::fs::symlink("none", at("dangling")).unwrap();
        let why = write_whole(&at("dangling"), b"").unwrap_err().to_string();
        assert!(why.contains("the link leads to no file; remove it"), "{why}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4);
    }

    #[test]
    fn errors_name_the_file_alone() {
        let folder = tempfile::tempdir().unwrap();
        let why = write_whole(&folder.path().join("none/a.msh"), b"").unwrap_err().to_string();
        assert!(why.contains("none/a.msh: ") && !why.contains(".chaincell-"), "{why}");
    }
}
