//! The project's folders and files.

use std::fs;
use std::path::{Path, PathBuf};

/// The folder that holds `crates`, `models` and `experiments`.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Every folder of `experiments` that holds a session, in the order of their names.
pub fn experiments() -> Vec<PathBuf> {
    let found: Vec<PathBuf> = folders(&root().join("experiments"))
        .into_iter()
        .filter(|folder| folder.join("session.toml").exists())
        .collect();
    assert!(!found.is_empty(), "there is no experiment");
    found
}

/// The folder of an experiment.
pub fn experiment(name: &str) -> PathBuf {
    root().join("experiments").join(name)
}

/// The folders in a folder, in the order of their names.
pub fn folders(folder: &Path) -> Vec<PathBuf> {
    entries(folder).into_iter().filter(|entry| entry.is_dir()).collect()
}

/// What a folder holds, in the order of the names.
pub fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    entries
}

/// Every file in a folder and the folders below.
pub fn files_below(folder: &Path) -> Vec<PathBuf> {
    let deeper = |entry: PathBuf| if entry.is_dir() { files_below(&entry) } else { vec![entry] };
    entries(folder).into_iter().flat_map(deeper).collect()
}

/// The last part of a path, for messages.
pub fn name(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

/// A file of the project or a test as TOML.
pub fn read_toml<T: serde::de::DeserializeOwned>(path: &Path) -> T {
    let text = fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    toml::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}
