//! Temporary files and folders beside what they become, and what killed programs left of theirs.
//!
//! Whoever writes one holds a lock on it, which ends with the program, however that ends. One that another can lock was left behind, and
//! is cleared away by the next who writes into that folder. Where a file system has no locks, nothing is cleared.

use std::ffi::OsStr;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use tempfile::{Builder, NamedTempFile, TempDir};

const PREFIX: &str = ".gravcal-";
const SUFFIX: &str = ".tmp";
/// In a temporary folder, the file that is locked.
const LOCK: &str = "lock";
/// In a temporary folder, files that are complete: they are to be put into the folder that it stands in, be it by the next program.
pub(crate) const COMPLETE: &str = "new";

/// Whether a file or folder of this name is a temporary one of this program, such as one that was killed has left.
pub fn is_temporary(name: &OsStr) -> bool {
    name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX))
}

/// Takes away the temporary files in a folder that killed programs have left, and completes what they had begun to put in place
/// together. What cannot be taken away stays: it is in nobody's way.
pub fn clear_abandoned(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten().filter(|entry| is_temporary(&entry.file_name())) {
        let _: io::Result<()> = match entry.file_type() {
            Ok(kind) if kind.is_dir() => clear_folder(&entry.path(), folder),
            Ok(kind) if kind.is_file() => clear_file(&entry.path()),
            _ => Ok(()),
        };
    }
}

fn clear_file(path: &Path) -> io::Result<()> {
    match lock(&File::options().read(true).write(true).open(path)?)? {
        Locked::ByUs => fs::remove_file(path),
        Locked::ByAnother | Locked::Never => Ok(()),
    }
}

fn clear_folder(path: &Path, folder: &Path) -> io::Result<()> {
    let file = match File::options().read(true).write(true).open(path.join(LOCK)) {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::NotFound => return clear_unlocked(path),
        Err(error) => return Err(error),
    };
    if lock(&file)? != Locked::ByUs {
        return Ok(());
    }
    if let Ok(complete) = fs::read_dir(path.join(COMPLETE)) {
        for entry in complete {
            let entry = entry?;
            fs::rename(entry.path(), folder.join(entry.file_name()))?;
        }
    }
    fs::remove_dir_all(path)
}

/// Killed before it had a lock, it is empty. Killed while it was taken away, the lock may have been the first to go: what is left is nothing
/// that anyone needs.
fn clear_unlocked(path: &Path) -> io::Result<()> {
    let empty = fs::remove_dir(path);
    // Another may have locked it since.
    if empty.is_ok() || path.join(LOCK).exists() { empty } else { fs::remove_dir_all(path) }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Locked {
    ByUs,
    ByAnother,
    /// The file system has no locks.
    Never,
}

fn lock(file: &File) -> io::Result<Locked> {
    match file.try_lock() {
        Ok(()) => Ok(Locked::ByUs),
        Err(TryLockError::WouldBlock) => Ok(Locked::ByAnother),
        Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Interrupted => Ok(Locked::ByAnother),
        Err(TryLockError::Error(_)) => Ok(Locked::Never),
    }
}

/// A new temporary file in a folder.
pub(crate) fn temporary_file(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = builder();
    // Temporary files are readable by their owner only; a result is readable by whom the user's umask lets.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    loop {
        let file = builder.tempfile_in(folder)?;
        // Before it was locked, another may have taken it for abandoned.
        if lock(file.as_file())? != Locked::ByAnother && file.path().exists() {
            return Ok(file);
        }
    }
}

/// A new temporary folder in a folder. It is locked as long as the file lives.
pub(crate) fn temporary_folder(folder: &Path) -> io::Result<(TempDir, File)> {
    loop {
        let made = builder().tempdir_in(folder)?;
        let path: PathBuf = made.path().join(LOCK);
        let file = match File::create_new(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => continue,
            file => file?,
        };
        if lock(&file)? != Locked::ByAnother && path.exists() {
            return Ok((made, file));
        }
    }
}

fn builder() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    builder
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn what_a_killed_program_left_is_cleared_and_what_another_writes_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path(".gravcal-killed.tmp"), "half a recording").unwrap();
        fs::create_dir(path(".gravcal-empty.tmp")).unwrap();
        fs::create_dir_all(path(".gravcal-staged.tmp/staged")).unwrap();
        fs::write(path(".gravcal-staged.tmp").join(LOCK), "").unwrap();
        fs::create_dir_all(path(".gravcal-half-gone.tmp/staged")).unwrap();
        fs::write(path(".gravcal-mine"), "").unwrap();
        fs::write(path("mine.tmp"), "").unwrap();
        let at_work = (temporary_file(folder.path()).unwrap(), temporary_folder(folder.path()).unwrap());

        clear_abandoned(folder.path());
        let mut expected = [at_work.0.path(), at_work.1.0.path(), &path(".gravcal-mine"), &path("mine.tmp")]
            .map(|path| path.file_name().unwrap().to_str().unwrap().to_owned());
        expected.sort();
        assert_eq!(names_in(folder.path()), expected);
    }

    #[test]
    fn what_was_being_put_in_place_is_completed() {
        let folder = tempfile::tempdir().unwrap();
        let stage = folder.path().join(".gravcal-killed.tmp");
        for (name, contents) in [("lock", ""), ("new/b", "new"), ("old/a", "old"), ("old/b", "old")] {
            fs::create_dir_all(stage.join(name).parent().unwrap()).unwrap();
            fs::write(stage.join(name), contents).unwrap();
        }
        fs::write(folder.path().join("a"), "new").unwrap();
        clear_abandoned(folder.path());
        assert_eq!(names_in(folder.path()), ["a", "b"]);
        assert_eq!(["a", "b"].map(|name| fs::read_to_string(folder.path().join(name)).unwrap()), ["new", "new"]);
    }

    #[cfg(unix)]
    #[test]
    fn a_link_of_such_a_name_leads_nowhere() {
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        fs::write(elsewhere.path().join("lock"), "mine").unwrap();
        std::os::unix::fs::symlink(elsewhere.path(), folder.path().join(".gravcal-a.tmp")).unwrap();
        std::os::unix::fs::symlink(elsewhere.path().join("lock"), folder.path().join(".gravcal-b.tmp")).unwrap();
        clear_abandoned(folder.path());
        assert_eq!(names_in(elsewhere.path()), ["lock"]);
        assert_eq!(names_in(folder.path()).len(), 2);
    }
}
