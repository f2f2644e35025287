//! `gravcal compare`: which sensor moved between calibrations.

use std::path::PathBuf;

use clap::Args;
use gravcal_calibration::EstimatorName;
use gravcal_calibration::comparison::{ComparisonError, compare};
use gravcal_recording::{Digest, DigestError, EarlierEstimate, read_earlier, read_earlier_inputs};
use gravcal_report::comparison::{ComparisonReport, shared_inputs};

use crate::exit::Exit;
use crate::failure::Failure;
use crate::names::estimator_parser;
use crate::terminal;

/// Tell which sensor moved between calibrations of one robot
///
/// Each sensor's parameters (and gravity's direction) are held against one value for all calibrations, by their covariances. Give the
/// files in the order of their time.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Two or more calibration.json
    #[arg(value_name = "CALIBRATION", required = true, num_args = 2..)]
    calibrations: Vec<PathBuf>,

    /// Estimator whose answers are compared
    #[arg(long, value_name = "NAME", value_parser = estimator_parser(), default_value = "joint")]
    estimator: EstimatorName,

    /// Print JSON instead of a table
    #[arg(long)]
    json: bool,

    /// Tell the values of sensors that have not moved, too
    #[arg(long, short, conflicts_with = "quiet")]
    verbose: bool,

    /// Print nothing; the exit code tells
    #[arg(long, short)]
    quiet: bool,
}

const EXAMPLES: &str = "\
Examples:
  gravcal compare last-week/calibration.json calibration/calibration.json
  gravcal compare week*/calibration.json --json

Exit codes:
  0  nothing moved, as far as the calibrations tell
  2  bad input or usage
  3  a sensor moved";

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Exit, Failure> {
    let Arguments { calibrations, estimator, json, verbose, quiet } = arguments;
    let estimates =
        calibrations.iter().map(|path| read_earlier(path, estimator.as_str())).collect::<Result<Vec<_>, _>>();
    let estimates = estimates.map_err(|error| Failure::bad_input(&error))?;
    let comparison = compare(&estimates.iter().collect::<Vec<&EarlierEstimate>>()).map_err(|error| refused(&error))?;
    let files: Vec<String> = calibrations.iter().map(|path| path.display().to_string()).collect();
    let shared = shared(calibrations)?;
    let report = ComparisonReport { files: &files, shared: &shared, comparison: &comparison, verbose: *verbose };
    if *json {
        terminal::print_exactly(&report.to_json().map_err(|error| Failure::bad_input(&error))?)?;
    } else if !quiet {
        terminal::print(&report.to_string())?;
    }
    Ok(if comparison.moved().next().is_some() { Exit::PartlyDetermined } else { Exit::Determined })
}

fn shared(calibrations: &[PathBuf]) -> Result<Vec<String>, Failure> {
    let own = calibrations.iter().map(|path| Ok(Digest::of(path)?.sha256));
    let own: Vec<String> = own.collect::<Result<_, DigestError>>().map_err(|error| Failure::bad_input(&error))?;
    let inputs: Vec<_> = calibrations
        .iter()
        .map(|path| read_earlier_inputs(path))
        .collect::<Result<_, _>>()
        .map_err(|error| Failure::bad_input(&error))?;
    Ok(shared_inputs(&own, &inputs))
}

fn refused(error: &ComparisonError) -> Failure {
    let failure = Failure::bad_input(error);
    match error {
        ComparisonError::Units { .. } => failure.hint("compare calibrations whose sensors are read in the same units"),
        _ => failure,
    }
}
