//! A folder for `XDG_RUNTIME_DIR` where the session has none, as in containers and over ssh.
//!
//! Drivers look there for a Wayland display, and libwayland prints an error each time when the
//! variable is missing. Those lines would stand before every result of the command line.

use std::io;
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;

const VARIABLE: &str = "XDG_RUNTIME_DIR";

/// Starts the program again in its own process with the variable set, where it is missing.
/// To change the environment of a running process is not safe. Returns where the variable is
/// there, and where no folder can be made: the program works without one.
pub fn ensure() {
    if std::env::var_os(VARIABLE).is_some_and(|value| !value.is_empty()) {
        return;
    }
    let (Ok(program), Ok(folder)) = (std::env::current_exe(), private_folder(&std::env::temp_dir())) else { return };
    let mut arguments = std::env::args_os();
    let mut command = Command::new(program);
    if let Some(name) = arguments.next() {
        command.arg0(name);
    }
    // Returns only where it fails.
    let _ = command.args(arguments).env(VARIABLE, folder).exec();
}

/// A folder in `parent` that only this user can read, the same in every run.
fn private_folder(parent: &Path) -> io::Result<PathBuf> {
    let user = std::fs::metadata("/proc/self")?.uid();
    let folder = std::path::absolute(parent.join(format!("defocus-runtime-{user}")))?;
    match std::fs::DirBuilder::new().mode(0o700).create(&folder) {
        Err(error) if error.kind() != io::ErrorKind::AlreadyExists => return Err(error),
        _ => {}
    }
    // Another user could have made it, or a link in its place.
    let found = std::fs::symlink_metadata(&folder)?;
    match found.is_dir() && found.uid() == user && found.mode() & 0o077 == 0 {
        true => Ok(folder),
        false => Err(io::Error::other("the folder belongs to another user")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    #[test]
    fn the_folder_is_private_and_the_same_each_time() -> io::Result<()> {
        let parent = tempfile::tempdir()?;
        let folder = private_folder(parent.path())?;
        assert_eq!(std::fs::metadata(&folder)?.mode() & 0o777, 0o700);
        assert_eq!(private_folder(parent.path())?, folder);
        Ok(())
    }

    #[test]
    fn a_folder_that_others_can_read_is_not_taken() -> io::Result<()> {
        let parent = tempfile::tempdir()?;
        let folder = private_folder(parent.path())?;
        std::fs::set_permissions(&folder, std::fs::Permissions::from_mode(0o755))?;
        assert!(private_folder(parent.path()).is_err());
        Ok(())
    }

    #[test]
    fn a_link_in_its_place_is_not_followed() -> io::Result<()> {
        let parent = tempfile::tempdir()?;
        let folder = private_folder(parent.path())?;
        std::fs::remove_dir(&folder)?;
        let elsewhere = tempfile::tempdir()?;
        std::os::unix::fs::symlink(elsewhere.path(), &folder)?;
        assert!(private_folder(parent.path()).is_err());
        Ok(())
    }
}
