//! `--rerun`, `--rerun-connect`, `--rerun-spawn`: a calibration to look at in Rerun.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use gravcal_recording::{NewFile, WriteError};
use gravcal_rerun::{CalibrationRecording, RecordingError, VIEWER_URL, check_address};

use crate::failure::Failure;

/// Where to show the calibration.
#[derive(Debug, Args)]
pub struct RerunArguments {
    /// Also write the arm, the fits, the residuals and the verdict to a recording for Rerun (https://rerun.io)
    #[arg(long = "rerun", value_name = "FILE.rrd")]
    file: Option<PathBuf>,

    /// Also show them in a Rerun viewer that is open
    #[arg(long = "rerun-connect", value_name = "URL", num_args = 0..=1, require_equals = true,
          default_missing_value = VIEWER_URL)]
    connect: Option<String>,

    /// Also show them in a new Rerun viewer (needs the program `rerun`: pip install rerun-sdk)
    #[arg(long = "rerun-spawn")]
    spawn: bool,
}

impl RerunArguments {
    /// The file that is asked for.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Whether the file can be written and the address names a viewer, as far as can be seen before the solve. Leaves nothing behind.
    pub fn check(&self, overwrite: bool) -> Result<(), Failure> {
        if let Some(url) = &self.connect {
            check_address(url).map_err(|error| Failure::bad_input(&error).about("--rerun-connect"))?;
        }
        match &self.file {
            Some(path) => NewFile::create(path, overwrite).map(drop).map_err(|error| unwritable(&error)),
            None => Ok(()),
        }
    }

    /// Writes and shows what is asked for; gives a line for each.
    pub fn show(&self, recording: &CalibrationRecording<'_>, overwrite: bool) -> Result<String, Failure> {
        let mut told = String::new();
        if let Some(path) = &self.file {
            let bytes = recording.to_rrd().map_err(|error| failed(&error))?;
            write(path, &bytes, overwrite).map_err(|error| not_shown(&error))?;
            told += &format!("Rerun recording in {} (show it with `rerun {0}`)\n", path.display());
        }
        if let Some(url) = &self.connect {
            recording.connect(url).map_err(|error| failed(&error))?;
            told += &format!("Shown in the Rerun viewer at {url}\n");
        }
        if self.spawn {
            recording.spawn().map_err(|error| failed(&error))?;
            told += "Shown in a new Rerun viewer\n";
        }
        Ok(told)
    }
}

fn write(path: &Path, bytes: &[u8], overwrite: bool) -> Result<(), WriteError> {
    let mut file = NewFile::create(path, overwrite)?;
    file.write_all(bytes).map_err(|cause| WriteError::Io { path: path.to_owned(), cause })?;
    file.finish()
}

fn unwritable(error: &WriteError) -> Failure {
    let failure = Failure::bad_input(error);
    match error {
        WriteError::Exists { .. } => failure.hint("--overwrite replaces it"),
        _ => failure.hint("--rerun FILE.rrd names another file"),
    }
}

/// The results are there already: only who wanted to see them in Rerun does not.
fn failed(error: &RecordingError) -> Failure {
    let failure = not_shown(error);
    match error {
        RecordingError::Unreachable { .. } => failure.hint(
            "start `rerun` first, or write a file with --rerun FILE.rrd; the results of the calibration are written",
        ),
        _ => failure,
    }
}

fn not_shown(error: &dyn std::error::Error) -> Failure {
    Failure::not_shown(error).hint("the results of the calibration are written all the same")
}
