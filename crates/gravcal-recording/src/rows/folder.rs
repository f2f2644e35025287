//! A folder as rosbag2 writes it: a recording in several files, and `metadata.yaml` that names them.

use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::Rows;
use super::mcap::{self, McapRows};
use super::sqlite::{self, SqliteRows};
use crate::error::ReadError;
use crate::file::{LARGEST_DOCUMENT, file_name, opened, read_whole};

/// Opens the recording in a folder. Where it lies there both in MCAP and in SQLite, `metadata.yaml` says which one counts, else MCAP does.
pub(super) fn open(folder: &Path) -> Result<Box<dyn Rows + Send>, ReadError> {
    let files = listed(folder)?;
    let named = named_in_metadata(folder);
    let of = |ending: &str| {
        let found: Vec<PathBuf> = files.iter().filter(|path| ends(path.as_os_str(), ending)).cloned().collect();
        of_the_recording(found, &named)
    };
    let is_named = |ending: &str| named.iter().any(|name| ends(name.as_ref(), ending));
    let ((mcap, other_mcap), (sqlite, other_sqlite)) = (of("mcap"), of("db3"));
    let ((mcap, empty_mcap), (sqlite, empty_sqlite)) = (without_empty(mcap), without_empty(sqlite));
    let mut remarks = remarks(folder, &named);
    remarks.extend(beside(&[other_mcap, other_sqlite].concat()));
    remarks.extend(
        [empty_mcap, empty_sqlite].concat().iter().map(|path| format!("{} is empty and left out", file_name(path))),
    );
    if mcap.is_empty() && sqlite.is_empty() {
        return Err(ReadError::NotRecording { path: folder.to_owned(), what: nothing_to_read(&files) });
    }
    if mcap.is_empty() || !sqlite.is_empty() && is_named("db3") && !is_named("mcap") {
        let first_time = |path: &Path| {
            // SQLite would wait for who writes into a pipe.
            opened(path).map_err(|cause| ReadError::opening(path, cause))?;
            Ok(sqlite::first_time(path))
        };
        let files = in_order(sqlite, first_time)?;
        return Ok(Box::new(SqliteRows::open(folder, files, remarks)?));
    }
    Ok(Box::new(McapRows::open_files(folder, in_order(mcap, mcap::first_time)?, remarks)?))
}

fn ends(name: &OsStr, ending: &str) -> bool {
    Path::new(name).extension().is_some_and(|found| found == ending)
}

/// The files of a folder, by their names.
fn listed(folder: &Path) -> Result<BTreeSet<PathBuf>, ReadError> {
    let io = |cause| ReadError::Io { path: folder.to_owned(), cause };
    let entries = std::fs::read_dir(folder).map_err(io)?;
    entries.map(|entry| Ok(entry.map_err(io)?.path())).collect()
}

/// The files that `metadata.yaml` names, and others that lie beside them; where it names none of these, all are of the recording.
fn of_the_recording(found: Vec<PathBuf>, named: &[String]) -> (Vec<PathBuf>, Vec<PathBuf>) {
    let is_named = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default();
        named.iter().any(|named| Path::new(named.strip_suffix(".zstd").unwrap_or(named)).file_name() == Some(name))
    };
    match found.iter().any(is_named) {
        true => found.into_iter().partition(is_named),
        false => (found, Vec::new()),
    }
}

/// Those that hold something, and the others: a recorder that is killed may leave one. Where none holds anything, they are all looked at.
fn without_empty(files: Vec<PathBuf>) -> (Vec<PathBuf>, Vec<PathBuf>) {
    let holds = |path: &PathBuf| std::fs::metadata(path).map_or(true, |found| found.len() > 0 || !found.is_file());
    match files.iter().any(holds) {
        true => files.into_iter().partition(holds),
        false => (files, Vec::new()),
    }
}

/// What lies in the folder and is not read.
fn beside(others: &[PathBuf]) -> Option<String> {
    let names: Vec<String> = others.iter().map(|path| file_name(path)).collect();
    (!names.is_empty()).then(|| {
        format!(
            "metadata.yaml does not list {}, which is left out: list it there, or give it by itself",
            names.join(", ")
        )
    })
}

/// By the times of their first messages, ns, which `first_time` tells.
fn in_order(
    files: Vec<PathBuf>,
    first_time: impl Fn(&Path) -> Result<u64, ReadError>,
) -> Result<Vec<PathBuf>, ReadError> {
    let timed = files.into_iter().map(|path| Ok((first_time(&path)?, path)));
    let mut timed = timed.collect::<Result<Vec<_>, ReadError>>()?;
    timed.sort();
    Ok(timed.into_iter().map(|(_, path)| path).collect())
}

fn nothing_to_read(files: &BTreeSet<PathBuf>) -> String {
    match files.iter().find(|path| ends(path.as_os_str(), "zstd")).and_then(|path| path.file_name()) {
        Some(name) => {
            format!("the files of this bag are compressed as a whole: unpack them first (unzstd {})", name.display())
        }
        None => "the folder has no .mcap file and no .db3 file, as a recording of ROS 2 has".to_owned(),
    }
}

/// What `metadata.yaml` names and cannot be read.
fn remarks(folder: &Path, named: &[String]) -> Vec<String> {
    let remark = |name: &String| match (folder.join(name).exists(), name.strip_suffix(".zstd")) {
        (false, None) => Some(format!("metadata.yaml names {name}, which is not there")),
        // Unpacked, or lost.
        (false, Some(plain)) if folder.join(plain).exists() => None,
        (false, Some(_)) => Some(format!("metadata.yaml names {name}, which is not there")),
        (true, Some(plain)) if !folder.join(plain).exists() => {
            Some(format!("{name} is compressed as a whole and left out: unpack it first (unzstd {name})"))
        }
        _ => None,
    };
    named.iter().filter_map(remark).collect()
}

/// The files that rosbag2 says it wrote: `metadata.yaml` lists them as `- name.mcap`.
fn named_in_metadata(folder: &Path) -> Vec<String> {
    let text = read_whole(&folder.join("metadata.yaml"), LARGEST_DOCUMENT).unwrap_or_default();
    let text = String::from_utf8(text).unwrap_or_default();
    let items = text.lines().filter_map(|line| line.trim().strip_prefix("- "));
    // Later also as `- path: name.mcap`, of `files`.
    let names = items.map(|item| item.trim().trim_start_matches("path:").trim().trim_matches(['"', '\'']));
    let is_file = |name: &&str| [".mcap", ".db3", ".zstd"].iter().any(|ending| name.ends_with(ending));
    names.filter(is_file).map(str::to_owned).collect()
}
