//! Where a result comes from: program, input files, options.

use std::fs;
use std::io::{self, Read};
use std::path::{Component, Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};
use thiserror::Error;
use toml::Table;

use crate::json::{JsonError, json};

/// Where a result comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Provenance {
    program: &'static str,
    version: &'static str,
    inputs: Vec<Input>,
    options: Options,
}

/// What was chosen.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Options {
    /// Names of the estimators that ran, in order.
    pub estimators: Vec<String>,
    /// Name of the solver.
    pub solver: String,
    /// Its options, as far as they were given.
    pub solver_options: Table,
}

/// One file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Input {
    /// Path relative to the session's folder, wherever it was reached that way.
    pub path: String,
    /// Hash of its contents, hexadecimal.
    pub sha256: String,
    /// Size.
    pub bytes: u64,
}

/// An input file could not be read again for its hash.
#[derive(Debug, Error)]
#[error("{}: cannot be read", path.display())]
pub struct InputError {
    path: PathBuf,
    #[source]
    cause: io::Error,
}

impl Provenance {
    /// With the version of this build.
    pub fn new(inputs: Vec<Input>, options: Options) -> Provenance {
        Provenance { program: "gravcal", version: env!("CARGO_PKG_VERSION"), inputs, options }
    }

    /// A hash of all of it, hexadecimal: a name for what follows from it.
    ///
    /// # Errors
    /// As [`CalibrationFile::to_json`](crate::CalibrationFile::to_json).
    pub fn fingerprint(&self) -> Result<String, JsonError> {
        Ok(hexadecimal(&Sha256::digest(json(self)?)))
    }
}

impl Input {
    /// Reads and hashes a file. `base` is the session's folder.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn read(path: &Path, base: &Path) -> Result<Input, InputError> {
        let (mut hash, mut bytes) = (Sha256::new(), 0);
        let files = files_of(path).map_err(|cause| InputError { path: path.to_owned(), cause })?;
        for file in files {
            bytes += hash_file(&file, &mut hash).map_err(|cause| InputError { path: file.clone(), cause })?;
        }
        let sha256 = hexadecimal(&hash.finalize());
        Ok(Input { path: with_slashes(&relative(path, base)), sha256, bytes })
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// A file itself, and of a folder (a recording in several files) every file in the order of their names.
fn files_of(path: &Path) -> io::Result<Vec<PathBuf>> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let entries: Vec<PathBuf> = fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    let mut files: Vec<PathBuf> = entries.into_iter().filter(|entry| entry.is_file()).collect();
    files.sort();
    Ok(files)
}

/// Hashes a file piece by piece, as it may be longer than memory. Gives its length.
fn hash_file(path: &Path, hash: &mut Sha256) -> io::Result<u64> {
    let mut file = fs::File::open(path)?;
    let (mut piece, mut bytes) = (vec![0; 1 << 16], 0);
    loop {
        match file.read(&mut piece)? {
            0 => return Ok(bytes),
            length => {
                hash.update(&piece[..length]);
                bytes += length as u64;
            }
        }
    }
}

/// `path` as seen from `base`, so that a result does not depend on where on a machine the session lies. A file that
/// was named by an absolute path from elsewhere stays where it is.
fn relative(path: &Path, base: &Path) -> PathBuf {
    if path.is_absolute() == base.is_absolute()
        && let Ok(below) = path.strip_prefix(base)
    {
        return below.to_owned();
    }
    let canonical = |path: &Path| fs::canonicalize(if path.as_os_str().is_empty() { Path::new(".") } else { path });
    match (canonical(path), canonical(base)) {
        (Ok(full), Ok(base)) => full.strip_prefix(&base).map_or_else(|_| path.to_owned(), Path::to_owned),
        _ => path.to_owned(),
    }
}

/// The same text on every system.
fn with_slashes(path: &Path) -> String {
    let mut text = String::new();
    for component in path.components() {
        if !text.is_empty() && !text.ends_with('/') {
            text.push('/');
        }
        match component {
            Component::RootDir => text.push('/'),
            other => text += &other.as_os_str().to_string_lossy(),
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_the_contents() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.csv");
        fs::write(&path, "abc").unwrap();
        let input = Input::read(&path, folder.path()).unwrap();
        assert_eq!(input.path, "poses.csv");
        assert_eq!(input.bytes, 3);
        // FIPS 180-2, appendix B.1.
        assert_eq!(input.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn paths_are_relative_to_the_session() {
        let seen = |path: &str, base: &str| with_slashes(&relative(Path::new(path), Path::new(base)));
        assert_eq!(seen("a/b/poses.csv", "a/b"), "poses.csv");
        assert_eq!(seen("a/b/../../models/x/robot.toml", "a/b"), "../../models/x/robot.toml");
        assert_eq!(seen("poses.csv", ""), "poses.csv");
        assert_eq!(seen("./a/./poses.csv", "./a"), "poses.csv");
        assert_eq!(seen("/elsewhere/poses.csv", "a"), "/elsewhere/poses.csv");
    }

    #[test]
    fn an_absolute_path_below_a_relative_session_is_recognised() {
        let here = fs::canonicalize("src/provenance.rs").unwrap();
        assert_eq!(relative(&here, Path::new("src")), Path::new("provenance.rs"));
        assert_eq!(relative(&here, Path::new("")), here.strip_prefix(fs::canonicalize(".").unwrap()).unwrap());
    }

    #[test]
    fn an_absent_file_is_named() {
        let error = Input::read(Path::new("absent.csv"), Path::new("")).unwrap_err();
        assert_eq!(error.to_string(), "absent.csv: cannot be read");
    }
}
