//! The folder in which a study's results are.
//!
//! `study.json` says which study they are of; `parts/` holds what is done, until `trials.parquet` holds all of it; `times.csv` says
//! how long it took, which differs from run to run and is in no other file.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use gravcal_recording::write_atomically;
use serde::{Deserialize, Serialize};

use super::BatchError;
use super::part::{Part, parts};
use super::row::Row;
use super::table::{Columns, TableReader};
use super::trial::Took;
use crate::plan::{Axis, Study, told};

/// What stands in `study.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Version of the program.
    pub gravcal: String,
    /// SHA-256 of all that the results depend on.
    pub fingerprint: String,
    /// Trials at each point.
    pub trials: u64,
    /// Names of the estimators.
    pub estimators: Vec<String>,
    /// Names of the solvers.
    pub solvers: Vec<String>,
    /// What is varied.
    pub axes: Vec<Axis>,
    /// The grid: of each point the place on each axis.
    pub points: Vec<Vec<usize>>,
    /// Name and unit of each quantity.
    pub quantities: Vec<(String, String)>,
}

impl Manifest {
    /// That of a study with these solvers.
    pub fn new(study: &Study, solvers: &[String]) -> Manifest {
        Manifest {
            gravcal: env!("CARGO_PKG_VERSION").to_owned(),
            fingerprint: study.fingerprint.clone(),
            trials: study.trials,
            estimators: study.estimators.iter().map(ToString::to_string).collect(),
            solvers: solvers.to_vec(),
            axes: study.axes.clone(),
            points: study.points.iter().map(|point| point.places.clone()).collect(),
            quantities: study.quantities.clone(),
        }
    }

    /// The columns of its tables.
    pub fn columns(&self) -> Columns {
        Columns {
            estimators: self.estimators.clone(),
            solvers: self.solvers.clone(),
            quantities: self.quantities.iter().map(|(name, _)| name.clone()).collect(),
        }
    }

    pub(super) fn parts(&self) -> Vec<Part> {
        parts(self.points.len(), self.trials)
    }

    /// `noise = 0.3 count, range = 90 deg`; nothing where nothing is varied.
    pub fn told(&self, point: usize) -> String {
        told(&self.axes, &self.points[point])
    }
}

const MANIFEST: &str = "study.json";
const PARTS: &str = "parts";
const TRIALS: &str = "trials.parquet";
const TIMES: &str = "times.csv";
const LOCK: &str = "lock";

/// A folder with the results of a study, or a part of them.
#[derive(Debug)]
pub struct StudyFolder {
    path: PathBuf,
    /// Of which study.
    pub manifest: Manifest,
    /// Keeps others from writing there, where it is written to.
    _lock: Option<File>,
}

impl StudyFolder {
    /// Opens the folder of a study to write there; it is made if it is missing.
    ///
    /// # Errors
    /// The results of another study are there, another program writes there, or the operating system refuses.
    pub fn begin(path: &Path, manifest: Manifest) -> Result<StudyFolder, BatchError> {
        fs::create_dir_all(path.join(PARTS)).map_err(|cause| BatchError::Io { path: path.to_owned(), cause })?;
        let folder = StudyFolder { path: path.to_owned(), manifest, _lock: Some(lock(path)?) };
        let begun = folder.is_complete() || !folder.done()?.is_empty();
        if begun && StudyFolder::open(path)?.manifest != folder.manifest {
            return Err(BatchError::Another { folder: path.to_owned() });
        }
        let text = serde_json::to_string_pretty(&folder.manifest);
        let text = text.map_err(|error| BatchError::NoStudy { folder: path.to_owned(), why: error.to_string() })?;
        write_atomically(&path.join(MANIFEST), format!("{text}\n").as_bytes())?;
        Ok(folder)
    }

    /// Opens a folder that has results, to write there.
    ///
    /// # Errors
    /// There are none, or another program writes there.
    pub fn open_to_write(path: &Path) -> Result<StudyFolder, BatchError> {
        let folder = StudyFolder::open(path)?;
        Ok(StudyFolder { _lock: Some(lock(path)?), ..folder })
    }

    /// Opens a folder that has results, to read them.
    ///
    /// # Errors
    /// There are none.
    pub fn open(path: &Path) -> Result<StudyFolder, BatchError> {
        let refuse = |why: String| BatchError::NoStudy { folder: path.to_owned(), why };
        let text = fs::read_to_string(path.join(MANIFEST)).map_err(|error| refuse(error.to_string()))?;
        let manifest = serde_json::from_str(&text).map_err(|error| refuse(error.to_string()))?;
        Ok(StudyFolder { path: path.to_owned(), manifest, _lock: None })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The table of all trials.
    pub fn trials(&self) -> PathBuf {
        self.path.join(TRIALS)
    }

    pub(super) fn times(&self) -> PathBuf {
        self.path.join(TIMES)
    }

    /// Whether all trials are there.
    pub fn is_complete(&self) -> bool {
        self.trials().is_file()
    }

    /// Sees to it that all trials are there.
    ///
    /// # Errors
    /// Parts are missing, or were not put together.
    pub fn check_complete(&self) -> Result<(), BatchError> {
        if self.is_complete() {
            return Ok(());
        }
        let (parts, done) = (self.manifest.parts().len(), self.done()?.len());
        let folders = vec![self.path.clone()];
        match parts.saturating_sub(done) {
            0 => Err(BatchError::NotMerged { folder: self.path.clone() }),
            missing => Err(BatchError::Incomplete { missing, parts, folders }),
        }
    }

    pub(super) fn part(&self, number: usize) -> PathBuf {
        self.path.join(PARTS).join(format!("{number:08}.parquet"))
    }

    pub(super) fn part_times(&self, number: usize) -> PathBuf {
        self.path.join(PARTS).join(format!("{number:08}.times.csv"))
    }

    /// Numbers of the parts that are done, and can be read.
    pub(super) fn done(&self) -> Result<BTreeSet<usize>, BatchError> {
        let folder = self.path.join(PARTS);
        let entries = match fs::read_dir(&folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeSet::new()),
            Err(cause) => return Err(BatchError::Io { path: folder, cause }),
        };
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let columns = self.manifest.columns();
        let numbers = names.filter_map(|name| name.strip_suffix(".parquet")?.parse().ok());
        Ok(numbers.filter(|number| TableReader::open(&self.part(*number), &columns).is_ok()).collect())
    }

    /// Puts a part in place, with how long it took.
    pub(super) fn write(&self, part: &Part, rows: &[Row], took: Took) -> Result<(), BatchError> {
        let path = self.part(part.number);
        let failed =
            |error: parquet::errors::ParquetError| BatchError::Table { path: path.clone(), why: error.to_string() };
        let bytes = self.manifest.columns().file(rows).map_err(failed)?;
        let trials = part.trials.end - part.trials.start;
        let Took { simulating, calibrating } = took;
        let times = format!("{},{trials},{simulating},{calibrating}\n", part.point);
        write_atomically(&self.part_times(part.number), times.as_bytes())?;
        Ok(write_atomically(&path, &bytes)?)
    }

    /// Takes the parts away.
    pub(super) fn forget_parts(&self) -> Result<(), BatchError> {
        let folder = self.path.join(PARTS);
        match fs::remove_dir_all(&folder) {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => Err(BatchError::Io { path: folder, cause }),
            _ => Ok(()),
        }
    }
}

/// Held as long as what it gives lives, however the program ends.
fn lock(folder: &Path) -> Result<File, BatchError> {
    let path = folder.join(LOCK);
    let file = File::create(&path).map_err(|cause| BatchError::Io { path: path.clone(), cause })?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(BatchError::AtWork { folder: folder.to_owned() }),
        Err(TryLockError::Error(cause)) => Err(BatchError::Io { path, cause }),
    }
}
