//! `--rerun`, `--rerun-connect`, `--rerun-spawn`: a calibration to look at in Rerun. A program that is built without the feature `rerun`
//! knows them, and says how to build one that serves them.

#[cfg(feature = "rerun")]
mod shown;

use std::path::{Path, PathBuf};

use clap::Args;

#[cfg(not(feature = "rerun"))]
use crate::failure::Failure;

/// Where to show the calibration.
#[derive(Debug, Args)]
pub struct RerunArguments {
    /// Also write the arm, the fits, the residuals and the verdict to a recording for Rerun (https://rerun.io)
    #[arg(long = "rerun", value_name = "FILE.rrd")]
    file: Option<PathBuf>,

    /// Also show them in a Rerun viewer that is open
    #[arg(long = "rerun-connect", value_name = "URL", num_args = 0..=1, require_equals = true)]
    connect: Option<Option<String>>,

    /// Also show them in a new Rerun viewer (needs the program `rerun`: pip install rerun-sdk)
    #[arg(long = "rerun-spawn")]
    spawn: bool,
}

impl RerunArguments {
    /// The file that is asked for.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_deref()
    }

    /// Which of the options is given, if any.
    #[cfg(not(feature = "rerun"))]
    fn given(&self) -> Option<&'static str> {
        let given = [
            ("--rerun", self.file.is_some()),
            ("--rerun-connect", self.connect.is_some()),
            ("--rerun-spawn", self.spawn),
        ];
        given.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }

    /// Refuses what this program cannot serve.
    #[cfg(not(feature = "rerun"))]
    pub fn check(&self, _overwrite: bool) -> Result<(), Failure> {
        let Some(option) = self.given() else { return Ok(()) };
        let message = format!("{option}: this program is built without Rerun");
        Err(Failure::said(message).hint("build one with it: cargo build --release --features rerun"))
    }
}
