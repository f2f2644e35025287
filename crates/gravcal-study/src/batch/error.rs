//! Why a study cannot be run, or its results not be put in place.

use std::path::PathBuf;

use gravcal_calibration::UnsuitableChoice;
use gravcal_recording::{WriteError, in_command};
use thiserror::Error;

/// A study cannot be run, or its results not be put in place. What was there before still is.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum BatchError {
    /// The folder holds the results of another study.
    #[error(
        "{}: here are results of another study, or of this one as it was before a change; they stay. Choose another folder, or \
         move them away",
        folder.display()
    )]
    Another {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder holds files of no study.
    #[error(
        "{}: this is no study's folder, and it is not empty (`{name}` is there); all in it stays. Name another folder, or one that is \
         not there yet",
        folder.display()
    )]
    Foreign {
        /// The folder.
        folder: PathBuf,
        /// The first of what is there.
        name: String,
    },
    /// A link stands in the place of a file of the study.
    #[error("{}: this is a link, and a study writes through none; delete it, or name another folder", path.display())]
    Link {
        /// The link.
        path: PathBuf,
    },
    /// There is no such folder.
    #[error("{}: there is no such folder; name one with the results of a study, which has a study.json", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// The folder holds no results of a study.
    #[error("{}: study.json cannot be read ({why}), so nothing tells of which study results here are; name another folder, or move \
         them away", folder.display())]
    NoStudy {
        /// The folder.
        folder: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// Another run is at work in the folder.
    #[error("{}: another `gravcal study` is at work here; wait for it, or choose another folder", folder.display())]
    AtWork {
        /// The folder.
        folder: PathBuf,
    },
    /// Parts are missing.
    #[error(
        "{missing} of {parts} parts are missing in {}: run what is missing (`gravcal study run` does only that), or name the \
         folders of the other shards, too",
        folders.iter().map(|folder| folder.display().to_string()).collect::<Vec<_>>().join(", ")
    )]
    Incomplete {
        /// How many are missing.
        missing: usize,
        /// Of how many.
        parts: usize,
        /// Where they were looked for.
        folders: Vec<PathBuf>,
    },
    /// All parts are there, but not in one table.
    #[error("{}: all parts are there, but not yet put together: `gravcal study merge {}`", folder.display(), in_command(folder))]
    NotMerged {
        /// The folder.
        folder: PathBuf,
    },
    /// A table cannot be read.
    #[error("{}: this is no table of trials ({why}); delete it, and run the study again", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        why: String,
    },
    /// An estimator or a solver does not go with what a session says.
    #[error("{point}{error}")]
    Choice {
        /// With which changes.
        point: String,
        /// Why.
        error: UnsuitableChoice,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The operating system refuses.
    #[error("{}: {cause}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What it says.
        cause: std::io::Error,
    },
}
