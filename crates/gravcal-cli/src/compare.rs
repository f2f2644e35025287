//! `gravcal compare`: which sensor moved between calibrations.

use std::path::PathBuf;

use clap::Args;
use gravcal_calibration::comparison::{ComparisonError, compare};
use gravcal_recording::{
    Digest, DigestError, EarlierError, EarlierEstimate, EarlierInput, read_earlier, read_earlier_inputs,
};
use gravcal_report::comparison::{ComparisonReport, different_robots, shared_inputs};
use gravcal_robot_model::EstimatorName;

use crate::exit::Exit;
use crate::failure::Failure;
use crate::names::estimator_parser;
use crate::terminal;

/// Tell which sensor moved between calibrations of one robot
///
/// Tests for each sensor, and for gravity's direction, whether one value fits all calibrations (χ², with their covariances). Give the files
/// in the order of their time.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Two or more calibration.json
    #[arg(value_name = "CALIBRATION", required = true, num_args = 2..)]
    calibrations: Vec<PathBuf>,

    /// Estimator whose answers are compared; not sequential, whose steps leave out the errors of those before
    #[arg(long, value_name = "NAME", value_parser = estimator_parser(), default_value = "joint")]
    estimator: EstimatorName,

    /// Print JSON instead of a table
    #[arg(long, conflicts_with = "quiet")]
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
  0  nothing that can be compared moved
  1  what was found could not be printed or shown in full; files are complete
  2  bad input or usage
  3  a sensor moved";

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<Exit, Failure> {
    let Arguments { calibrations, estimator, json, verbose, quiet } = arguments;
    if *estimator == EstimatorName::Sequential {
        return Err(conditional(*estimator));
    }
    let files: Vec<String> = calibrations.iter().map(|path| path.display().to_string()).collect();
    let estimates =
        calibrations.iter().map(|path| read_earlier(path, estimator.as_str())).collect::<Result<Vec<_>, _>>();
    let estimates = estimates.map_err(|error| unread(&error))?;
    let comparison =
        compare(&estimates.iter().collect::<Vec<&EarlierEstimate>>()).map_err(|error| refused(&error, &files))?;
    let inputs = calibrations.iter().map(|path| read_earlier_inputs(path)).collect::<Result<Vec<_>, _>>();
    let inputs = inputs.map_err(|error| unread(&error))?;
    let (shared, robots) = (shared(calibrations, &inputs)?, different_robots(&inputs));
    let report = ComparisonReport {
        files: &files,
        shared: &shared,
        robots: &robots,
        comparison: &comparison,
        verbose: *verbose,
    };
    if *json {
        terminal::print_exactly(&report.to_json().map_err(|error| Failure::bad_input(&error))?)?;
    } else if !quiet {
        terminal::print(&report.to_string())?;
    }
    Ok(if comparison.moved().next().is_some() { Exit::PartlyDetermined } else { Exit::Determined })
}

/// The errors of one step are not in the deviations of the next: most sensors would seem to have moved.
fn conditional(estimator: EstimatorName) -> Failure {
    let message = format!(
        "estimator `{estimator}` cannot be compared: the standard deviations of each step leave out the errors of the steps before, \
         so that sensors would seem to move that have not"
    );
    Failure::said(message)
        .hint("leave --estimator away: the joint estimate, or `sequential-with-covariance`, has them all")
}

fn shared(calibrations: &[PathBuf], inputs: &[Vec<EarlierInput>]) -> Result<Vec<String>, Failure> {
    let own = calibrations.iter().map(|path| Ok(Digest::of(path)?.sha256));
    let own: Vec<String> = own.collect::<Result<_, DigestError>>().map_err(|error| Failure::bad_input(&error))?;
    Ok(shared_inputs(&own, inputs))
}

fn unread(error: &EarlierError) -> Failure {
    let failure = Failure::bad_input(error);
    match error {
        EarlierError::NoEstimator { .. } => failure.hint("--estimator NAME names one that all of them have"),
        _ => failure,
    }
}

fn refused(error: &ComparisonError, files: &[String]) -> Failure {
    let failure = Failure::bad_input(error);
    match error {
        ComparisonError::Units { calibrations, .. } => {
            let named: Vec<&str> =
                calibrations.iter().filter_map(|index| files.get(*index)).map(String::as_str).collect();
            failure.about(named.join(" and ")).hint("compare calibrations whose sensors are read in the same units")
        }
        ComparisonError::NoSensorInCommon => failure
            .about(files.join(", "))
            .hint("compare calibrations of one robot, whose joints have the same names in all"),
        ComparisonError::NothingInCommon => {
            failure.about(files.join(", ")).hint("what each of them determines stands in the table.txt beside it")
        }
        ComparisonError::One => failure,
    }
}
