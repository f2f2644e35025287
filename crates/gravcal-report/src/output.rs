//! Where results go: a folder of their own, in which nothing is overwritten unless told.

use std::io;
use std::path::{Path, PathBuf};

use gravcal_recording::{NewFiles, WriteError, clear_abandoned, holds};
use thiserror::Error;

const CALIBRATION: &str = "calibration.json";
const TABLE: &str = "table.txt";
const PAGE: &str = "report.html";
const TIMING: &str = "timing.json";

/// The folder for one calibration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFolder {
    path: PathBuf,
    overwrite: bool,
}

/// What goes into the folder.
#[derive(Clone, Copy, Debug)]
pub struct Contents<'a> {
    /// `calibration.json`.
    pub calibration: &'a str,
    /// `table.txt`.
    pub table: &'a str,
    /// `report.html`: made from the same results, and replaced with them.
    pub page: &'a str,
    /// `timing.json`; differs from run to run and decides nothing.
    pub timing: &'a str,
}

/// What became of the contents.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Written {
    /// They were written.
    New,
    /// The same results were there already; nothing was touched.
    Unchanged,
}

/// Results cannot be put in place. Nothing was written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// Something else stands where a folder is wanted.
    #[error("{}: this is not a folder, so no results can be written there", path.display())]
    NotFolder {
        /// What stands there.
        path: PathBuf,
    },
    /// The operating system refuses.
    #[error("{}: results cannot be written here: {cause}", path.display())]
    Refused {
        /// The folder.
        path: PathBuf,
        /// What it says.
        cause: io::Error,
    },
    /// Other results are there already.
    #[error("other results are there already, and stay: {}", list(files))]
    Occupied {
        /// The files that differ.
        files: Vec<PathBuf>,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

fn list(files: &[PathBuf]) -> String {
    files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(", ")
}

impl OutputFolder {
    /// The folder at `path`, existing or not. With `overwrite`, results in it may be replaced.
    pub fn new(path: impl Into<PathBuf>, overwrite: bool) -> OutputFolder {
        OutputFolder { path: path.into(), overwrite }
    }

    /// Where results go if nobody says otherwise: `calibration` beside `session.toml`, `name-calibration` beside
    /// `name.toml`.
    pub fn beside(session: &Path) -> PathBuf {
        let stem = session.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        let name = if stem == "session" { "calibration".to_owned() } else { format!("{stem}-calibration") };
        session.with_file_name(name)
    }

    /// The folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The files that results are written to.
    pub fn files(&self) -> [PathBuf; 4] {
        [CALIBRATION, TABLE, PAGE, TIMING].map(|name| self.path.join(name))
    }

    /// Whether results can be written, as far as can be seen before there are any. Leaves nothing behind.
    ///
    /// # Errors
    /// Where the folder is none, or neither it nor the folder in which it would be created can be written to.
    pub fn check(&self) -> Result<(), OutputError> {
        let existing = self.existing_folder();
        if !existing.is_dir() {
            return Err(OutputError::NotFolder { path: existing });
        }
        // Rights alone do not tell: the file system may be read-only or full.
        match tempfile::Builder::new().prefix(".gravcal-").suffix(".tmp").tempfile_in(&existing) {
            Ok(_deleted_at_once) => Ok(()),
            // Only the kind of error: its text names the temporary file, which means nothing to anyone.
            Err(error) => Err(OutputError::Refused { path: existing, cause: error.kind().into() }),
        }
    }

    /// The folder, or the nearest above it that there is.
    fn existing_folder(&self) -> PathBuf {
        let above = self.path.ancestors().find(|path| path.as_os_str().is_empty() || path.exists());
        match above {
            Some(path) if !path.as_os_str().is_empty() => path.to_owned(),
            _ => PathBuf::from("."),
        }
    }

    /// Puts results in place, unless the same are there already.
    ///
    /// # Errors
    /// Where other results are there and may not be overwritten, or the operating system refuses.
    pub fn write(&self, contents: &Contents<'_>) -> Result<Written, OutputError> {
        clear_abandoned(&self.path);
        let results = [(CALIBRATION, contents.calibration), (TABLE, contents.table)];
        if !self.overwrite {
            let states = [self.state(CALIBRATION, contents.calibration)?, self.state(TABLE, contents.table)?];
            if states == [State::Same, State::Same] {
                if self.state(PAGE, contents.page)? != State::Same {
                    self.put(&[(PAGE, contents.page)])?;
                }
                return Ok(Written::Unchanged);
            }
            self.refuse_to_replace(states)?;
        }
        let [calibration, table] = results;
        self.put(&[calibration, table, (PAGE, contents.page), (TIMING, contents.timing)])?;
        Ok(Written::New)
    }

    /// All of them or none.
    fn put(&self, files: &[(&str, &str)]) -> Result<(), WriteError> {
        let mut new = NewFiles::begin(&self.path)?;
        files.iter().try_for_each(|(name, text)| new.write(Path::new(name), text.as_bytes()))?;
        new.finish()
    }

    fn state(&self, name: &str, text: &str) -> Result<State, OutputError> {
        match holds(&self.path.join(name), text.as_bytes()) {
            Ok(true) => Ok(State::Same),
            Ok(false) => Ok(State::Other),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(State::Absent),
            Err(cause) => Err(OutputError::Refused { path: self.path.join(name), cause }),
        }
    }

    fn refuse_to_replace(&self, [calibration, table]: [State; 2]) -> Result<(), OutputError> {
        // Page and times beside results are those of an earlier run; alone they are someone else's files.
        let alone = [calibration, table] == [State::Absent, State::Absent];
        let beside = |name: &str| if alone && self.path.join(name).exists() { State::Other } else { State::Absent };
        let files: Vec<PathBuf> =
            [(CALIBRATION, calibration), (TABLE, table), (PAGE, beside(PAGE)), (TIMING, beside(TIMING))]
                .into_iter()
                .filter(|(_, state)| *state == State::Other)
                .map(|(name, _)| self.path.join(name))
                .collect();
        if files.is_empty() { Ok(()) } else { Err(OutputError::Occupied { files }) }
    }
}

/// What stands in the place of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Absent,
    Same,
    Other,
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const CONTENTS: Contents<'_> = Contents { calibration: "{1}\n", table: "table\n", page: "<p>\n", timing: "{3}\n" };
    const OTHER: Contents<'_> = Contents { calibration: "{2}\n", ..CONTENTS };

    struct Place(tempfile::TempDir);

    impl Place {
        fn new() -> Place {
            Place(tempfile::tempdir().unwrap())
        }

        fn folder(&self) -> PathBuf {
            self.0.path().join("deep/calibration")
        }

        fn output(&self, overwrite: bool) -> OutputFolder {
            OutputFolder::new(self.folder(), overwrite)
        }

        fn read(&self, name: &str) -> String {
            fs::read_to_string(self.folder().join(name)).unwrap()
        }
    }

    #[test]
    fn folder_is_named_after_the_session() {
        let beside = |session: &str| OutputFolder::beside(Path::new(session));
        assert_eq!(beside("a/session.toml"), Path::new("a/calibration"));
        assert_eq!(beside("a/tilted.toml"), Path::new("a/tilted-calibration"));
        assert_eq!(beside("session.toml"), Path::new("calibration"));
    }

    #[test]
    fn folder_is_created_and_filled() {
        let place = Place::new();
        assert_eq!(place.output(false).write(&CONTENTS).unwrap(), Written::New);
        assert_eq!(
            ["calibration.json", "table.txt", "timing.json"].map(|n| place.read(n)),
            ["{1}\n", "table\n", "{3}\n"]
        );
    }

    #[test]
    fn same_results_are_left_alone() {
        let place = Place::new();
        place.output(false).write(&CONTENTS).unwrap();
        let later = Contents { timing: "{4}\n", ..CONTENTS };
        assert_eq!(place.output(false).write(&later).unwrap(), Written::Unchanged);
        assert_eq!(place.read("timing.json"), "{3}\n");
    }

    #[test]
    fn other_results_stay_unless_reported() {
        let place = Place::new();
        place.output(false).write(&CONTENTS).unwrap();
        let refused = place.output(false).write(&OTHER).unwrap_err().to_string();
        let file = place.folder().join("calibration.json");
        assert_eq!(refused, format!("other results are there already, and stay: {}", file.display()));
        assert_eq!(place.read("calibration.json"), "{1}\n");

        assert_eq!(place.output(true).write(&OTHER).unwrap(), Written::New);
        assert_eq!(place.read("calibration.json"), "{2}\n");
    }

    #[test]
    fn what_is_missing_of_the_same_results_is_added() {
        let place = Place::new();
        place.output(false).write(&CONTENTS).unwrap();
        fs::remove_file(place.folder().join("table.txt")).unwrap();
        assert_eq!(place.output(false).write(&CONTENTS).unwrap(), Written::New);
        assert_eq!(place.read("table.txt"), "table\n");
    }

    #[test]
    fn a_foreign_file_stays() {
        let place = Place::new();
        fs::create_dir_all(place.folder()).unwrap();
        fs::write(place.folder().join("timing.json"), "mine").unwrap();
        assert!(matches!(place.output(false).write(&CONTENTS), Err(OutputError::Occupied { .. })));
        assert_eq!(fs::read_dir(place.folder()).unwrap().count(), 1);
    }

    #[test]
    fn a_check_leaves_nothing_behind() {
        let place = Place::new();
        place.output(false).check().unwrap();
        assert_eq!(fs::read_dir(place.0.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_file_is_no_folder() {
        let place = Place::new();
        let file = place.0.path().join("deep");
        fs::write(&file, "").unwrap();
        for output in [OutputFolder::new(&file, false), place.output(true)] {
            let error = output.check().unwrap_err();
            assert!(matches!(&error, OutputError::NotFolder { path } if *path == file), "{error}");
        }
    }

    #[test]
    fn results_that_cannot_all_be_written_are_not_written_at_all() {
        let place = Place::new();
        fs::create_dir_all(place.folder().join("timing.json")).unwrap();
        let error = place.output(true).write(&CONTENTS).unwrap_err().to_string();
        assert!(error.starts_with(&place.folder().join("timing.json").display().to_string()), "{error}");
        assert_eq!(fs::read_dir(place.folder()).unwrap().count(), 1);
    }

    #[test]
    fn a_folder_in_the_place_of_a_file_is_named() {
        let place = Place::new();
        let file = place.folder().join("calibration.json");
        fs::create_dir_all(&file).unwrap();
        let error = place.output(false).write(&CONTENTS).unwrap_err().to_string();
        assert!(error.starts_with(&file.display().to_string()), "{error}");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn an_unwritable_folder_is_seen_beforehand() {
        // No user may write here, not even root, for whom access rights do not count.
        let error = OutputFolder::new("/proc/calibration", false).check().unwrap_err();
        assert_eq!(error.to_string(), "/proc: results cannot be written here: entity not found");
    }
}
