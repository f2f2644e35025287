//! The folder in which a study's results are.
//!
//! `study.json` says which study they are of; `parts/` holds what is done, until `trials.parquet` holds all of it; `times.csv` says
//! how long it took, which differs from run to run and is in no other file.
//!
//! A folder is a study's if its `study.json` says so; another one is taken only if it is empty. Nothing is written through a link.

use std::collections::BTreeSet;
use std::fs::{self, File, TryLockError};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use gravcal_recording::{
    Digest, LARGEST_DOCUMENT, LARGEST_RESULTS, NewFiles, clear_abandoned, is_temporary, read_whole, write_atomically,
};

use super::BatchError;
use super::manifest::Manifest;
use super::part::Part;
use super::row::Row;
use super::table::TableReader;
use super::trial::Took;

const MANIFEST: &str = "study.json";
const PARTS: &str = "parts";
const TRIALS: &str = "trials.parquet";
const TIMES: &str = "times.csv";
const LOCK: &str = "lock";
/// How the names of a part's files end, behind its number.
const PART: &str = ".parquet";
const PART_TIMES: &str = ".times.csv";
/// Cell of the latter that has the digest of the former, behind point, trials and times.
const DIGEST_CELL: usize = 4;

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
    /// The results of another study are there, or files of no study; another program writes there, or the operating system refuses.
    pub fn begin(path: &Path, manifest: Manifest) -> Result<StudyFolder, BatchError> {
        let refused = |cause| BatchError::Io { path: path.to_owned(), cause };
        let there = names_in(path).map_err(refused)?;
        let before = match there.iter().any(|name| name == MANIFEST) {
            true => Some(StudyFolder::open(path)?.manifest),
            false => check_empty(path, &there).map(|()| None)?,
        };
        fs::create_dir_all(path).map_err(refused)?;
        let folder = StudyFolder { path: path.to_owned(), manifest, _lock: None }.locked()?;
        let begun = folder.is_complete() || !folder.done()?.is_empty();
        if begun && before.as_ref() != Some(&folder.manifest) {
            return Err(BatchError::Another { folder: path.to_owned() });
        }
        let text = serde_json::to_string_pretty(&folder.manifest);
        let text = text.map_err(|error| BatchError::NoStudy { folder: path.to_owned(), why: error.to_string() })?;
        folder.put(MANIFEST, format!("{text}\n").as_bytes())?;
        fs::create_dir_all(path.join(PARTS)).map_err(refused)?;
        Ok(folder)
    }

    /// Opens a folder that has results, to write there.
    ///
    /// # Errors
    /// There are none, or another program writes there.
    pub fn open_to_write(path: &Path) -> Result<StudyFolder, BatchError> {
        StudyFolder::open(path)?.locked()
    }

    /// Opens a folder that has results, to read them.
    ///
    /// # Errors
    /// There are none.
    pub fn open(path: &Path) -> Result<StudyFolder, BatchError> {
        if !path.exists() {
            return Err(BatchError::NoFolder { folder: path.to_owned() });
        }
        let refuse = |why: String| BatchError::NoStudy { folder: path.to_owned(), why };
        let text = read_whole(&path.join(MANIFEST), LARGEST_RESULTS).map_err(|error| refuse(error.to_string()))?;
        let manifest: Manifest = serde_json::from_slice(&text).map_err(|error| refuse(error.to_string()))?;
        manifest.check().map_err(|why| refuse(why.to_owned()))?;
        Ok(StudyFolder { path: path.to_owned(), manifest, _lock: None })
    }

    /// Keeps others out, and clears away what killed runs have left.
    fn locked(self) -> Result<StudyFolder, BatchError> {
        [MANIFEST, PARTS, TRIALS, TIMES, LOCK].iter().try_for_each(|name| refuse_link(&self.path.join(name)))?;
        let lock = lock(&self.path)?;
        [self.path.clone(), self.path.join(PARTS)].iter().for_each(|folder| clear_abandoned(folder));
        Ok(StudyFolder { _lock: Some(lock), ..self })
    }

    /// Writes a report, by the names of its files and what they hold: all of them or none.
    ///
    /// # Errors
    /// A link stands in the place of one, or they cannot be written.
    pub fn put_report(&self, files: &[(String, String)]) -> Result<(), BatchError> {
        let mut new = NewFiles::begin(&self.path)?;
        for (name, contents) in files {
            refuse_link(&self.path.join(name))?;
            new.write(name.as_ref(), contents.as_bytes())?;
        }
        Ok(new.finish()?)
    }

    fn put(&self, name: &str, contents: &[u8]) -> Result<(), BatchError> {
        let path = self.path.join(name);
        refuse_link(&path)?;
        Ok(write_atomically(&path, contents)?)
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The table of all trials.
    pub fn trials(&self) -> PathBuf {
        self.path.join(TRIALS)
    }

    /// How long trials took.
    pub(super) fn write_times(&self, text: &str) -> Result<(), BatchError> {
        self.put(TIMES, text.as_bytes())
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
        self.path.join(part_name(number, PART))
    }

    pub(super) fn part_times(&self, number: usize) -> PathBuf {
        self.path.join(part_name(number, PART_TIMES))
    }

    /// How many parts the trials of its study make.
    pub fn parts(&self) -> usize {
        self.manifest.parts().len()
    }

    /// How many of them are done here.
    ///
    /// # Errors
    /// The operating system refuses.
    pub fn parts_done(&self) -> Result<usize, BatchError> {
        Ok(self.done()?.len())
    }

    /// Numbers of the parts that are done, are as they were written, and can be read.
    pub(super) fn done(&self) -> Result<BTreeSet<usize>, BatchError> {
        let folder = self.path.join(PARTS);
        let entries = match fs::read_dir(&folder) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(BTreeSet::new()),
            Err(cause) => return Err(BatchError::Io { path: folder, cause }),
        };
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let columns = self.manifest.columns();
        let numbers = names.filter_map(|name| number_of(&name, PART));
        let sound =
            |number: &usize| self.is_as_written(*number) && TableReader::open(&self.part(*number), &columns).is_ok();
        Ok(numbers.filter(sound).collect())
    }

    /// Whether a part is the one that was written: a flipped bit of a number makes another number, which nothing else tells. Older programs wrote no digest.
    fn is_as_written(&self, number: usize) -> bool {
        let beside = read_whole(&self.part_times(number), LARGEST_DOCUMENT).unwrap_or_default();
        let beside = String::from_utf8_lossy(&beside);
        let Some(written) = beside.trim().split(',').nth(DIGEST_CELL) else { return true };
        Digest::of(&self.part(number)).is_ok_and(|found| found.sha256 == written)
    }

    /// Puts a part in place, behind how long it took and its digest.
    pub(super) fn write(&self, part: &Part, rows: &[Row], took: Took) -> Result<(), BatchError> {
        let path = self.part(part.number);
        let failed =
            |error: parquet::errors::ParquetError| BatchError::Table { path: path.clone(), why: error.to_string() };
        let bytes = self.manifest.columns().file(rows).map_err(failed)?;
        let trials = part.trials.end - part.trials.start;
        let Took { simulating, calibrating } = took;
        let digest = Digest::of_bytes(&bytes).sha256;
        let times = format!("{},{trials},{simulating},{calibrating},{digest}\n", part.point);
        self.put(&part_name(part.number, PART_TIMES), times.as_bytes())?;
        self.put(&part_name(part.number, PART), &bytes)
    }

    /// Takes the parts away; what else is among them stays.
    pub(super) fn forget_parts(&self) -> Result<(), BatchError> {
        let folder = self.path.join(PARTS);
        for name in names_in(&folder).map_err(|cause| BatchError::Io { path: folder.clone(), cause })? {
            if [PART, PART_TIMES].iter().any(|ending| number_of(&name, ending).is_some()) {
                let path = folder.join(&name);
                fs::remove_file(&path).map_err(|cause| BatchError::Io { path, cause })?;
            }
        }
        match fs::remove_dir(&folder) {
            Err(cause) if ![ErrorKind::NotFound, ErrorKind::DirectoryNotEmpty].contains(&cause.kind()) => {
                Err(BatchError::Io { path: folder, cause })
            }
            _ => Ok(()),
        }
    }
}

/// A part's file within the folder.
fn part_name(number: usize, ending: &str) -> String {
    format!("{PARTS}/{number:08}{ending}")
}

/// The number of the part that has this file.
fn number_of(name: &str, ending: &str) -> Option<usize> {
    let number = name.strip_suffix(ending)?.parse().ok()?;
    part_name(number, ending).ends_with(&format!("/{name}")).then_some(number)
}

/// Names in a folder, in order; none where there is no folder.
fn names_in(folder: &Path) -> std::io::Result<Vec<String>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    let mut names = names.collect::<std::io::Result<Vec<String>>>()?;
    names.sort();
    Ok(names)
}

/// That a folder that is no study's holds nothing but what a run has left that was killed when it had just begun.
fn check_empty(folder: &Path, names: &[String]) -> Result<(), BatchError> {
    let is_lock = |name: &str| {
        name == LOCK && fs::symlink_metadata(folder.join(name)).is_ok_and(|lock| lock.is_file() && lock.len() == 0)
    };
    let foreign = names.iter().find(|name| !is_temporary(name.as_ref()) && !is_lock(name));
    foreign.map_or(Ok(()), |name| Err(BatchError::Foreign { folder: folder.to_owned(), name: name.clone() }))
}

fn refuse_link(path: &Path) -> Result<(), BatchError> {
    match path.is_symlink() {
        true => Err(BatchError::Link { path: path.to_owned() }),
        false => Ok(()),
    }
}

/// Held as long as what it gives lives, however the program ends.
fn lock(folder: &Path) -> Result<File, BatchError> {
    let path = folder.join(LOCK);
    if path.exists() && !path.is_file() {
        let cause =
            std::io::Error::new(ErrorKind::InvalidInput, "it is no file, as the lock of a study is: take it away");
        return Err(BatchError::Io { path, cause });
    }
    let file = File::options().create(true).write(true).truncate(false).open(&path);
    let file = file.map_err(|cause| BatchError::Io { path: path.clone(), cause })?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(BatchError::AtWork { folder: folder.to_owned() }),
        Err(TryLockError::Error(cause)) => Err(BatchError::Io { path, cause }),
    }
}
