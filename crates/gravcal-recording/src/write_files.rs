//! Several files that appear together, or not at all.
//!
//! They are written into a temporary folder, and only when all of them reached the disk do they get their places:
//!
//! ```text
//!     folder that is not there yet     the temporary one becomes it, by one renaming
//!     folder that is there             staged/ ─► new/, all old files ─► old/, all new files ─► their places
//! ```
//!
//! At no time is a new file beside an old one. An error takes everything back; a program that is killed after `new/` has got its name has
//! its work completed by the next one that writes into the folder ([`clear_abandoned`]).

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::write::{WriteError, folder_of};
use crate::write_temporary::{COMPLETE, clear_abandoned, temporary_folder};

const STAGED: &str = "staged";
const OLD: &str = "old";

/// Files for one folder, none of which is there before [`finish`](Self::finish). Files of the same names are replaced, a link of
/// such a name too, and not what it points to; all else in the folder stays.
#[derive(Debug)]
pub struct NewFiles {
    folder: PathBuf,
    /// Whether the temporary folder becomes the folder.
    is_new: bool,
    stage: TempDir,
    _lock: File,
    names: Vec<PathBuf>,
}

impl NewFiles {
    /// Begins; the folder need not be there.
    ///
    /// # Errors
    ///
    /// Neither the folder nor the nearest one above it can be written to.
    pub fn begin(folder: &Path) -> Result<NewFiles, WriteError> {
        let is_new = !folder.exists();
        let within = folder.ancestors().find(|path| path.as_os_str().is_empty() || path.exists());
        let within = within.filter(|path| !path.as_os_str().is_empty()).unwrap_or(Path::new("."));
        clear_abandoned(within);
        let (stage, lock) = temporary_folder(within)
            // Only the kind of error: its text names the temporary folder, which means nothing to anyone.
            .map_err(|error| WriteError::Io { path: folder.to_owned(), cause: error.kind().into() })?;
        let files = NewFiles { folder: folder.to_owned(), is_new, stage, _lock: lock, names: Vec::new() };
        fs::create_dir(files.stage.path().join(STAGED)).map_err(|cause| files.refused(cause))?;
        Ok(files)
    }

    /// Where a file of this name is to be written before the end.
    ///
    /// # Errors
    ///
    /// There is a folder of that name, or what is neither file nor link.
    pub fn place(&mut self, name: &Path) -> Result<PathBuf, WriteError> {
        let path = self.folder.join(name);
        match fs::symlink_metadata(&path) {
            Ok(old) if old.is_dir() => return Err(WriteError::IsFolder { path }),
            Ok(old) if !old.is_file() && !old.is_symlink() => return Err(WriteError::NotAFile { path }),
            _ => {}
        }
        self.names.push(name.to_owned());
        Ok(self.staged(STAGED, name))
    }

    /// Takes the contents of a file.
    ///
    /// # Errors
    ///
    /// As [`place`](Self::place), or the operating system refuses, as where the disk is full.
    pub fn write(&mut self, name: &Path, contents: &[u8]) -> Result<(), WriteError> {
        let place = self.place(name)?;
        let written = File::create_new(place).and_then(|mut file| {
            io::Write::write_all(&mut file, contents)?;
            match fs::symlink_metadata(self.folder.join(name)) {
                Ok(old) if old.is_file() => file.set_permissions(old.permissions())?,
                _ => {}
            }
            file.sync_all()
        });
        written.map_err(|cause| WriteError::Io { path: self.folder.join(name), cause })
    }

    /// Puts all of them in place.
    ///
    /// # Errors
    ///
    /// The operating system refuses; then all is as it was before.
    pub fn finish(self) -> Result<(), WriteError> {
        let done = if self.is_new { self.become_the_folder() } else { self.replace() };
        done.map_err(|cause| self.refused(cause))
    }

    fn become_the_folder(&self) -> io::Result<()> {
        let above = folder_of(&self.folder);
        let missing: Vec<&Path> = above.ancestors().take_while(|path| !path.exists()).collect();
        let made = fs::create_dir_all(above).and_then(|()| fs::rename(self.stage.path().join(STAGED), &self.folder));
        if made.is_err() {
            // Only empty folders can be removed so.
            missing.iter().for_each(|path| drop(fs::remove_dir(path)));
        }
        made
    }

    fn replace(&self) -> io::Result<()> {
        let stage = self.stage.path();
        fs::create_dir(stage.join(OLD))?;
        fs::rename(stage.join(STAGED), stage.join(COMPLETE))?;
        let replaced = self.take_old_away().and_then(|()| self.put_new_in_place());
        if replaced.is_err() {
            self.names.iter().for_each(|name| self.take_back(name));
        }
        replaced
    }

    fn take_old_away(&self) -> io::Result<()> {
        let there = self.names.iter().map(|name| (self.folder.join(name), name));
        let mut there = there.filter(|(path, _)| fs::symlink_metadata(path).is_ok());
        there.try_for_each(|(path, name)| fs::rename(path, self.staged(OLD, name)))
    }

    fn put_new_in_place(&self) -> io::Result<()> {
        self.names.iter().try_for_each(|name| fs::rename(self.staged(COMPLETE, name), self.folder.join(name)))
    }

    /// As it was before. What fails here fails because nothing was changed yet.
    fn take_back(&self, name: &Path) {
        let (path, old) = (self.folder.join(name), self.staged(OLD, name));
        let is_new = fs::symlink_metadata(self.staged(COMPLETE, name)).is_err();
        let was_there = fs::symlink_metadata(&old).is_ok();
        let _: io::Result<()> = match (was_there, is_new) {
            (true, _) => fs::rename(old, path),
            (false, true) => fs::remove_file(path),
            (false, false) => Ok(()),
        };
    }

    fn staged(&self, part: &str, name: &Path) -> PathBuf {
        self.stage.path().join(part).join(name)
    }

    fn refused(&self, cause: io::Error) -> WriteError {
        WriteError::Io { path: self.folder.clone(), cause }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn write(folder: &Path, files: &[(&str, &str)]) -> Result<(), WriteError> {
        let mut new = NewFiles::begin(folder)?;
        files.iter().try_for_each(|(name, text)| new.write(Path::new(name), text.as_bytes()))?;
        new.finish()
    }

    fn contents(folder: &Path) -> Vec<(String, String)> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
        let mut found: Vec<(String, String)> = entries
            .map(|entry| {
                let text = fs::read_to_string(entry.path()).unwrap_or_else(|_| "a folder".to_owned());
                (entry.file_name().into_string().unwrap(), text)
            })
            .collect();
        found.sort();
        found
    }

    fn owned(files: &[(&str, &str)]) -> Vec<(String, String)> {
        files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
    }

    #[test]
    fn a_folder_appears_with_all_its_files() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("deep/results");
        let mut new = NewFiles::begin(&folder).unwrap();
        new.write(Path::new("a"), b"1").unwrap();
        new.write(Path::new("b"), b"2").unwrap();
        assert!(!place.path().join("deep").exists());
        new.finish().unwrap();
        assert_eq!(contents(&folder), owned(&[("a", "1"), ("b", "2")]));
        assert_eq!(contents(place.path()), owned(&[("deep", "a folder")]));
    }

    #[test]
    fn what_is_there_is_replaced_together_and_all_else_stays() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("mine"), "mine").unwrap();
        write(folder.path(), &[("a", "1"), ("b", "2")]).unwrap();
        write(folder.path(), &[("a", "3"), ("c", "4")]).unwrap();
        assert_eq!(contents(folder.path()), owned(&[("a", "3"), ("b", "2"), ("c", "4"), ("mine", "mine")]));
    }

    #[test]
    fn what_is_not_finished_leaves_nothing() {
        let place = tempfile::tempdir().unwrap();
        for folder in [place.path().to_owned(), place.path().join("deep/results")] {
            let mut new = NewFiles::begin(&folder).unwrap();
            new.write(Path::new("a"), b"1").unwrap();
            drop(new);
            assert_eq!(contents(place.path()), []);
        }
    }

    #[test]
    fn an_error_at_the_end_takes_everything_back() {
        let folder = tempfile::tempdir().unwrap();
        let old = [("a", "old"), ("b", "old"), ("d", "old")];
        write(folder.path(), &old).unwrap();
        let mut new = NewFiles::begin(folder.path()).unwrap();
        for name in ["a", "n", "b", "d"] {
            new.write(Path::new(name), b"new").unwrap();
        }
        fs::remove_file(new.staged(STAGED, Path::new("b"))).unwrap();
        let error = new.finish().unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: cannot be written", folder.path().display())), "{error}");
        assert_eq!(contents(folder.path()), owned(&old));
    }

    #[test]
    fn a_folder_in_the_place_of_a_file_is_named_and_nothing_is_written() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("b")).unwrap();
        let error = write(folder.path(), &[("a", "1"), ("b", "2")]).unwrap_err();
        assert!(matches!(&error, WriteError::IsFolder { path } if *path == folder.path().join("b")), "{error}");
        assert_eq!(contents(folder.path()), owned(&[("b", "a folder")]));
    }

    #[cfg(unix)]
    #[test]
    fn what_a_link_points_to_stays_and_access_rights_do_too() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let (folder, elsewhere) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let target = elsewhere.path().join("target");
        fs::write(&target, "mine").unwrap();
        symlink(&target, folder.path().join("a")).unwrap();
        fs::write(folder.path().join("b"), "old").unwrap();
        fs::set_permissions(folder.path().join("b"), fs::Permissions::from_mode(0o600)).unwrap();
        write(folder.path(), &[("a", "1"), ("b", "2")]).unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), "mine");
        assert_eq!(contents(folder.path()), owned(&[("a", "1"), ("b", "2")]));
        assert_eq!(fs::metadata(folder.path().join("b")).unwrap().permissions().mode() & 0o777, 0o600);
    }
}
