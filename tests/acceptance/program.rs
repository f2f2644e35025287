//! Runs the program as a user does, and keeps what it answers.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;

use tempfile::TempDir;

use crate::answer::{Answer, Estimator};
use crate::tree;

/// Exit code of bad input and usage.
pub const BAD_INPUT: i32 = 2;

/// Exit code of results that cannot be printed or shown.
pub const NOT_SHOWN: i32 = 1;

/// How one run of the program ended, and what it said.
#[derive(Debug)]
pub struct Run {
    /// Exit code; −1 where a signal ended the program.
    pub code: i32,
    /// What it printed.
    pub stdout: String,
    /// What it complained of.
    pub stderr: String,
}

impl Run {
    /// What is wrong with the way in which the program refuses bad input, if it is: it must end with its code, tell each
    /// of the texts, and not fall over.
    pub fn refusal(&self, reported: &[&str]) -> Option<String> {
        let untold: Vec<&&str> = reported.iter().filter(|reported| !self.stderr.contains(**reported)).collect();
        let proper = self.code == BAD_INPUT && self.stderr.starts_with("error") && !self.stderr.contains("panicked");
        let reported = format!("exit code {}, {}", self.code, self.stderr);
        (!proper || !untold.is_empty()).then(|| format!("expected a refusal that tells {untold:?}, found {reported}"))
    }
}

/// Runs `gravcal` in the project's root folder.
pub fn gravcal<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Run {
    gravcal_in(&tree::root(), arguments)
}

/// Runs `gravcal` in a folder.
pub fn gravcal_in<A: AsRef<OsStr>>(folder: &Path, arguments: impl IntoIterator<Item = A>) -> Run {
    let output = Command::new(env!("CARGO_BIN_EXE_gravcal")).args(arguments).current_dir(folder).output().unwrap();
    Run {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

/// A calibration, with a folder for its results that goes with this value.
#[derive(Debug)]
pub struct Calibration {
    /// How the program ended.
    pub run: Run,
    results: TempDir,
}

impl Calibration {
    /// Calibrates a session.
    pub fn of(session: &Path) -> Calibration {
        Calibration::with(session, &[])
    }

    /// Calibrates a session with options.
    pub fn with(session: &Path, options: &[&str]) -> Calibration {
        let results = tempfile::tempdir().unwrap();
        let run = calibrate_into(results.path(), session, options);
        Calibration { run, results }
    }

    /// The contents of `calibration.json`.
    pub fn answer(&self) -> Answer {
        let text = self.bytes("calibration.json");
        let answer: Answer = serde_json::from_slice(&text).unwrap_or_else(|error| panic!("{error}\n{:?}", self.run));
        assert_eq!(answer.format, "gravcal-calibration/1");
        answer
    }

    /// One estimator's entry in `calibration.json`.
    pub fn estimator(&self, name: &str) -> Estimator {
        let found = self.answer().estimators.into_iter().find(|estimator| estimator.name == name);
        found.unwrap_or_else(|| panic!("there is no answer of {name}"))
    }

    /// One of the files written.
    pub fn bytes(&self, file: &str) -> Vec<u8> {
        fs::read(self.results.path().join(file)).unwrap_or_else(|error| panic!("{file}: {error}\n{:?}", self.run))
    }
}

/// Calibrates a session into a folder.
pub fn calibrate_into(results: &Path, session: &Path, options: &[&str]) -> Run {
    let fixed =
        [OsStr::new("calibrate"), OsStr::new("--full"), session.as_ref(), OsStr::new("--output"), results.as_ref()];
    gravcal(fixed.into_iter().chain(options.iter().map(OsStr::new)))
}
