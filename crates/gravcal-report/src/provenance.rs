//! Where a result comes from: program, input files, options.

use std::fs;
use std::path::{Component, Path, PathBuf};

use gravcal_recording::{Digest, DigestError, InputRole};
use serde::Serialize;
use toml::Table;

/// Where a result comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Provenance {
    /// `gravcal`.
    program: &'static str,
    /// Its version.
    version: &'static str,
    /// Every file that was read.
    inputs: Vec<Input>,
    /// What was chosen.
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
    /// What it is for.
    pub role: InputRole,
}

impl Provenance {
    /// With the version of this build.
    pub fn new(inputs: Vec<Input>, options: Options) -> Provenance {
        Provenance { program: "gravcal", version: env!("CARGO_PKG_VERSION"), inputs, options }
    }

    /// Program with version, inputs, and what was chosen: for people.
    pub(crate) fn reported(&self) -> (String, &[Input], &Options) {
        (format!("{} {}", self.program, self.version), &self.inputs, &self.options)
    }
}

impl Input {
    /// Reads and hashes a file that is there for `role`. `base` is the session's folder.
    ///
    /// # Errors
    /// Where the file cannot be read.
    pub fn read(role: InputRole, path: &Path, base: &Path) -> Result<Input, DigestError> {
        let Digest { sha256, bytes } = Digest::of(path)?;
        Ok(Input { path: with_slashes(&relative(path, base)), sha256, bytes, role })
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
}
