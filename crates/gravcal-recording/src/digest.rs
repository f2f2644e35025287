//! What a file is known by, wherever it lies: the hash of its contents.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};
use thiserror::Error;

use crate::file::opened;

/// Hash and size of what is in a file, or in all files of a folder (a recording in several files).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Digest {
    /// Hexadecimal.
    pub sha256: String,
    /// Size.
    pub bytes: u64,
}

/// A file could not be read for its hash.
#[derive(Debug, Error)]
#[error("{}: cannot be read", path.display())]
pub struct DigestError {
    path: PathBuf,
    #[source]
    cause: io::Error,
}

impl Digest {
    /// Of bytes that are at hand.
    pub fn of_bytes(bytes: &[u8]) -> Digest {
        Digest { sha256: hexadecimal(&Sha256::digest(bytes)), bytes: bytes.len() as u64 }
    }

    /// Reads a file, or every file of a folder in the order of their names.
    ///
    /// # Errors
    /// Where one cannot be read.
    pub fn of(path: &Path) -> Result<Digest, DigestError> {
        let (mut hash, mut bytes) = (Sha256::new(), 0);
        let files = files_of(path).map_err(|cause| DigestError { path: path.to_owned(), cause })?;
        for file in files {
            bytes += hash_file(&file, &mut hash).map_err(|cause| DigestError { path: file.clone(), cause })?;
        }
        Ok(Digest { sha256: hexadecimal(&hash.finalize()), bytes })
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

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
    let mut file = opened(path)?;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_the_contents() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("poses.csv");
        fs::write(&path, "abc").unwrap();
        let found = Digest::of(&path).unwrap();
        assert_eq!(found.bytes, 3);
        // FIPS 180-2, appendix B.1.
        assert_eq!(found.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert_eq!(Digest::of(folder.path()).unwrap(), found, "a folder of one file");
    }

    #[test]
    fn an_absent_file_is_named() {
        assert_eq!(Digest::of(Path::new("absent.csv")).unwrap_err().to_string(), "absent.csv: cannot be read");
    }
}
