//! What is asked for, written and shown.

use std::io::Write;
use std::path::Path;

use gravcal_recording::{NewFile, WriteError};
use gravcal_rerun::{CalibrationRecording, RecordingError, VIEWER_URL, check_address};

use super::RerunArguments;
use crate::failure::Failure;

impl RerunArguments {
    /// The address of the viewer that is open, where it shall show the calibration.
    fn viewer(&self) -> Option<&str> {
        self.connect.as_ref().map(|url| url.as_deref().unwrap_or(VIEWER_URL))
    }

    /// Whether the file can be written and the address names a viewer, as far as can be seen before the solve. Leaves nothing behind.
    pub fn check(&self, overwrite: bool) -> Result<(), Failure> {
        if let Some(url) = self.viewer() {
            check_address(url).map_err(|error| Failure::bad_input(&error).about("--rerun-connect"))?;
        }
        match &self.file {
            Some(path) => NewFile::create(path, overwrite).map(drop).map_err(|error| unwritable(&error)),
            None => Ok(()),
        }
    }

    /// Writes and shows what is asked for; gives a line for each.
    pub fn show(&self, recording: &CalibrationRecording<'_>, overwrite: bool) -> Result<String, Failure> {
        let mut reported = String::new();
        if let Some(path) = &self.file {
            let bytes = recording.to_rrd().map_err(|error| failed(&error))?;
            write(path, &bytes, overwrite).map_err(|error| not_shown(&error))?;
            reported += &format!("Rerun recording in {} (show it with `rerun {0}`)\n", path.display());
        }
        if let Some(url) = self.viewer() {
            recording.connect(url).map_err(|error| failed(&error))?;
            reported += &format!("Shown in the Rerun viewer at {url}\n");
        }
        if self.spawn {
            recording.spawn().map_err(|error| failed(&error))?;
            reported += "Shown in a new Rerun viewer\n";
        }
        Ok(reported)
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
