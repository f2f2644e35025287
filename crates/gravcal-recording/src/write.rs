//! Files that are there in full or not at all.

use std::fs::{self, Permissions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::missing_folder;
use crate::write_temporary::{clear_abandoned, temporary_file};

/// Why a file could not be written. What stood there before still does.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The file's folder does not exist.
    #[error("{}: there is no such folder as {}; create it first", path.display(), folder.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The path is that of a folder.
    #[error("{}: this is a folder; name a file in it", path.display())]
    IsFolder {
        /// The folder.
        path: PathBuf,
    },
    /// There is such a file already.
    #[error("{}: there is such a file already, and it is not overwritten unless told", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// It is a device, a pipe or the like, which a recording cannot take the place of.
    #[error("{}: this is no file; name one", path.display())]
    NotAFile {
        /// The path.
        path: PathBuf,
    },
    /// The end of the name says of no kind of recording.
    #[error("{}: a recording is written as .mcap, .csv or .parquet, and its name must end so", path.display())]
    UnknownKind {
        /// The file.
        path: PathBuf,
    },
    /// A column has no place in the kind of file.
    #[error(
        "{}: column `{column}` has no place in a message of joint states, which has `time_s` and `.position`, `.velocity` \
         and `.effort` of each joint; write CSV or Parquet",
        path.display()
    )]
    NoPlace {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: String,
    },
    /// A message of joint states has its time as whole seconds in 32 bits.
    #[error("{}: row {row}: the time must be a number from 0 to 2147483647 s, found {found}", path.display())]
    Time {
        /// The file.
        path: PathBuf,
        /// The row, counted from 1.
        row: usize,
        /// The time, s.
        found: f64,
    },
    /// The operating system refuses.
    #[error("{}: cannot be written: {cause}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        cause: io::Error,
    },
    /// There are no columns.
    #[error("{}: the table cannot be written: it has no columns", path.display())]
    NoColumns {
        /// The file.
        path: PathBuf,
    },
    /// A column's name is empty or that of another column.
    #[error("{}: the table cannot be written: column name `{column}` is empty or used twice", path.display())]
    ColumnName {
        /// The file.
        path: PathBuf,
        /// The name.
        column: String,
    },
    /// A row has more or fewer cells than there are columns.
    #[error("{}: the table cannot be written: row {row} has {found} cells, expected {expected}", path.display())]
    Ragged {
        /// The file.
        path: PathBuf,
        /// The row, counted from 1.
        row: usize,
        /// Number of columns.
        expected: usize,
        /// Cells of the row.
        found: usize,
    },
    /// A number is infinite or none at all; a missing one is an empty cell.
    #[error("{}: the table cannot be written: row {row}, column `{column}` is {found}", path.display())]
    NotFinite {
        /// The file.
        path: PathBuf,
        /// The row, counted from 1.
        row: usize,
        /// Name of the column.
        column: String,
        /// The number.
        found: f64,
    },
    /// A text goes over more than one line.
    #[error("{}: the table cannot be written: {text:?} has a line break", path.display())]
    LineBreak {
        /// The file.
        path: PathBuf,
        /// The text.
        text: String,
    },
}

impl WriteError {
    /// The same of a file that was written under another name.
    #[must_use]
    pub fn at(mut self, file: &Path) -> WriteError {
        use WriteError::*;
        match &mut self {
            NoFolder { path, .. }
            | IsFolder { path }
            | Exists { path }
            | NotAFile { path }
            | UnknownKind { path }
            | NoPlace { path, .. }
            | Time { path, .. }
            | Io { path, .. }
            | NoColumns { path }
            | ColumnName { path, .. }
            | Ragged { path, .. }
            | NotFinite { path, .. }
            | LineBreak { path, .. } => file.clone_into(path),
        }
        self
    }
}

/// Writes a file so that, whatever happens, either the old or the new contents stand there in full.
///
/// The contents go into a new file in the same folder (renaming works within a file system only), reach the disk, and
/// then take the place of the old file, with its access rights. A link stays a link: what it points to is replaced. What is no file,
/// such as a pipe or a terminal, is written to directly.
///
/// # Errors
///
/// The folder does not exist, the path is that of a folder, or the operating system refuses (rights, full disk).
pub fn write_atomically(path: &Path, contents: &[u8]) -> Result<(), WriteError> {
    if path.is_dir() {
        return Err(WriteError::IsFolder { path: path.to_owned() });
    }
    if let Some(folder) = missing_folder(path) {
        return Err(WriteError::NoFolder { path: path.to_owned(), folder });
    }
    write(path, contents).map_err(|cause| WriteError::Io { path: path.to_owned(), cause })
}

fn write(path: &Path, contents: &[u8]) -> io::Result<()> {
    match fs::metadata(path) {
        Ok(old) if !old.is_file() => fs::write(path, contents),
        Ok(old) => replace(&fs::canonicalize(path)?, contents, Some(old.permissions())),
        Err(_) => replace(path, contents, None),
    }
}

/// Writes a new file beside `path` and renames it. On the way out by error the new file is deleted.
fn replace(path: &Path, contents: &[u8], permissions: Option<Permissions>) -> io::Result<()> {
    let mut file = temporary_file(folder_of(path))?;
    file.write_all(contents)?;
    if let Some(permissions) = permissions {
        file.as_file().set_permissions(permissions)?;
    }
    // Without this, a power failure after the renaming could leave an empty file under the final name.
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

/// The folder that `path` stands in.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file that is written bit by bit under a temporary name beside its own, which it has in full or not at all. What programs that were
/// killed have left in its folder is cleared away first: it may be as large as a recording.
#[derive(Debug)]
pub struct NewFile {
    path: PathBuf,
    file: BufWriter<NamedTempFile>,
    overwrite: bool,
}

impl NewFile {
    /// Begins a file. One that is there is replaced at the end if `overwrite`, else it is an error.
    ///
    /// # Errors
    ///
    /// There is such a file and it is not to be replaced, or the operating system refuses.
    pub fn create(path: &Path, overwrite: bool) -> Result<NewFile, WriteError> {
        check_target(path, overwrite)?;
        clear_abandoned(folder_of(path));
        let file = temporary_file(folder_of(path)).map_err(|cause| io_error(path, cause))?;
        Ok(NewFile { path: path.to_owned(), file: BufWriter::with_capacity(1 << 18, file), overwrite })
    }

    /// Gives it its name.
    ///
    /// # Errors
    ///
    /// Another file has got the name meanwhile and is not to be replaced, or the operating system refuses.
    pub fn finish(self) -> Result<(), WriteError> {
        let NewFile { path, file, overwrite } = self;
        let file = file.into_inner().map_err(|error| io_error(&path, error.into_error()))?;
        file.as_file().sync_all().map_err(|cause| io_error(&path, cause))?;
        let (renamed, path) = match overwrite {
            // A link stays a link.
            true => (file.persist(fs::canonicalize(&path).unwrap_or(path.clone())), path),
            false => (file.persist_noclobber(&path), path),
        };
        match renamed {
            Ok(_) => Ok(()),
            Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Err(WriteError::Exists { path }),
            Err(error) => Err(WriteError::Io { path, cause: error.error }),
        }
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for NewFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

/// Whether a recording may take this name.
pub(crate) fn check_target(path: &Path, overwrite: bool) -> Result<(), WriteError> {
    let path_owned = || path.to_owned();
    if let Some(folder) = missing_folder(path) {
        return Err(WriteError::NoFolder { path: path_owned(), folder });
    }
    match fs::metadata(path) {
        Err(_) => Ok(()),
        Ok(old) if old.is_dir() => Err(WriteError::IsFolder { path: path_owned() }),
        Ok(old) if !old.is_file() => Err(WriteError::NotAFile { path: path_owned() }),
        Ok(_) if overwrite => Ok(()),
        Ok(_) => Err(WriteError::Exists { path: path_owned() }),
    }
}

fn io_error(path: &Path, cause: io::Error) -> WriteError {
    WriteError::Io { path: path.to_owned(), cause }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names_in(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
        entries.map(|name| name.into_string().unwrap()).collect()
    }

    #[test]
    fn old_contents_are_replaced_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("result.csv");
        for contents in ["long long long", "short", ""] {
            write_atomically(&path, contents.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), contents);
        }
        assert_eq!(names_in(folder.path()), ["result.csv"]);
    }

    #[test]
    fn an_absent_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let absent = folder.path().join("absent");
        let path = absent.join("result.csv");
        assert_eq!(
            write_atomically(&path, b"x").unwrap_err().to_string(),
            format!("{}: there is no such folder as {}; create it first", path.display(), absent.display())
        );
    }

    #[test]
    fn a_folder_is_not_overwritten() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(
            write_atomically(folder.path(), b"x").unwrap_err().to_string(),
            format!("{}: this is a folder; name a file in it", folder.path().display())
        );
        assert!(folder.path().is_dir());
    }

    #[test]
    fn what_the_operating_system_refuses_names_path_and_cause() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        // The "folder" is a file, which no operating system lets one write into.
        let path = file.join("result.csv");
        let error = write_atomically(&path, b"x").unwrap_err();
        let WriteError::Io { cause, .. } = &error else { panic!("{error}") };
        assert_eq!(error.to_string(), format!("{}: cannot be written: {cause}", path.display()));
        assert_eq!(names_in(folder.path()), ["file"]);
    }

    #[cfg(unix)]
    mod unix {
        use std::os::unix::fs::{PermissionsExt, symlink};

        use super::*;

        fn mode(path: &Path) -> u32 {
            fs::metadata(path).unwrap().permissions().mode() & 0o777
        }

        #[test]
        fn access_rights_are_the_usual_ones_or_those_of_the_old_file() {
            let folder = tempfile::tempdir().unwrap();
            let (usual, path) = (folder.path().join("usual"), folder.path().join("result.csv"));
            fs::write(&usual, "").unwrap();
            write_atomically(&path, b"new").unwrap();
            assert_eq!(mode(&path), mode(&usual));

            fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
            write_atomically(&path, b"newer").unwrap();
            assert_eq!(mode(&path), 0o600);
        }

        #[test]
        fn a_link_stays_a_link() {
            let folder = tempfile::tempdir().unwrap();
            let (target, link) = (folder.path().join("target"), folder.path().join("link"));
            fs::write(&target, "old").unwrap();
            symlink(&target, &link).unwrap();
            write_atomically(&link, b"new").unwrap();
            assert!(link.is_symlink());
            assert_eq!(fs::read(&target).unwrap(), b"new");
        }

        #[test]
        fn a_device_is_written_to_and_not_replaced() {
            use std::os::unix::fs::FileTypeExt;
            // Through a link, so that a mistake in the code under test replaces the link and not the device.
            let folder = tempfile::tempdir().unwrap();
            let link = folder.path().join("null");
            symlink("/dev/null", &link).unwrap();
            write_atomically(&link, b"x").unwrap();
            assert!(fs::metadata(&link).unwrap().file_type().is_char_device());
            assert_eq!(names_in(folder.path()), ["null"]);
        }
    }
}
