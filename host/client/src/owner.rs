//! The folder of iceoryx2's files belongs to one user: no other user may take part in a scene or
//! disturb it.
//!
//! A user who may write in the folder could replace the files of a service. So the folder is made
//! before iceoryx2 makes it, for its owner alone, and one that belongs to another user, is a link, or
//! may be written by others is refused with the remedy.

use std::fs;
use std::io;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, PermissionsExt};
use std::path::Path;

use crate::error::{Error, Kind, Result};

/// Permissions of the folder: all for its owner, none for others.
const OWNER_ALL: u32 = 0o700;
/// Write permissions of the group and of others.
const FOREIGN_WRITES: u32 = 0o022;

/// Makes the folder if it is missing, for this user alone; its parents with the usual permissions.
///
/// # Errors
/// A folder of another user, or one that others may write.
pub(crate) fn take(root: &Path) -> Result<()> {
    if let Some(above) = root.parent() {
        fs::create_dir_all(above).map_err(|why| Error::file("create folder", above, why))?;
    }
    match fs::DirBuilder::new().mode(OWNER_ALL).create(root) {
        Err(why) if why.kind() != io::ErrorKind::AlreadyExists => {
            return Err(Error::file("create folder", root, why));
        }
        _ => {}
    }
    let found = fs::symlink_metadata(root).map_err(|why| Error::file("look at", root, why))?;
    let user = rustix::process::geteuid().as_raw();
    let fault = if !found.is_dir() {
        "is no folder: remove it".to_owned()
    } else if found.uid() != user {
        format!(
            "belongs to user {}, and only its owner may connect: run as that user, or end that \
             user's programs and remove it",
            found.uid()
        )
    } else if found.permissions().mode() & FOREIGN_WRITES != 0 {
        format!("may be written by other users: chmod 700 {}", root.display())
    } else {
        return Ok(());
    };
    Err(Error::new(
        Kind::Permission,
        format!(
            "cannot use shared memory: {}, the folder of iceoryx2's files, {fault}",
            root.display()
        ),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::{chown, symlink};

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[track_caller]
    fn refusal(root: &Path) -> String {
        let error = take(root).unwrap_err();
        assert_eq!(error.kind(), Kind::Permission);
        error.to_string()
    }

    #[test]
    fn a_missing_folder_is_made_for_its_owner_alone() {
        let place = tempfile::tempdir().unwrap();
        let root = place.path().join("above/iceoryx2");
        take(&root).unwrap();
        assert_eq!(mode(&root), 0o700);
        take(&root).unwrap();
        // As iceoryx2 makes it: the group may read, only the owner may write.
        fs::set_permissions(&root, fs::Permissions::from_mode(0o750)).unwrap();
        take(&root).unwrap();
        assert_eq!(mode(&root), 0o750);
    }

    #[test]
    fn a_folder_that_others_may_write_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let root = place.path().join("iceoryx2");
        fs::create_dir(&root).unwrap();
        for open in [0o777, 0o720, 0o1702] {
            fs::set_permissions(&root, fs::Permissions::from_mode(open)).unwrap();
            let text = refusal(&root);
            assert!(text.contains("chmod 700"), "{text}");
        }
    }

    #[test]
    fn a_link_or_a_file_in_its_place_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let (link, file) = (place.path().join("link"), place.path().join("file"));
        symlink(place.path(), &link).unwrap();
        fs::write(&file, "").unwrap();
        for root in [link, file] {
            assert!(refusal(&root).contains("is no folder"));
        }
    }

    #[test]
    fn a_folder_of_another_user_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let root = place.path().join("iceoryx2");
        fs::create_dir(&root).unwrap();
        if chown(&root, Some(65_534), None).is_err() {
            println!("SKIPPED a_folder_of_another_user_is_refused: not root");
            return;
        }
        let text = refusal(&root);
        assert!(text.contains("belongs to user 65534, and only its owner may connect"), "{text}");
    }
}
