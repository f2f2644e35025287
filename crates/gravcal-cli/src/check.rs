//! `gravcal check`: what a session can and cannot determine, before any solve.

use std::path::PathBuf;

use clap::Args;
use gravcal_calibration::check::check;
use gravcal_report::{CheckSummary, CheckTable, check_json};
use gravcal_robot_model::Registry;

use crate::exit::Exit;
use crate::failure::Failure;
use crate::names::Choice;
use crate::progress::Progress;
use crate::terminal;

/// Tell what a session can and cannot determine, before any solve
///
/// Reads the session and its poses, and predicts at nominal values how well each parameter can be known. For a parameter that cannot be
/// known it says why, and which smallest additions (something stated, poses, a load, a tilted base) would help. It also lists the sweeps that
/// the sequential procedure would use.
///
/// Of the torques, `check` uses only which readings there are, their noise and their unit. Likely mistakes (units, rows of an arm in motion
/// taken as static poses) are printed first.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The session, such as experiments/sarcos-shoulder/session.toml
    #[arg(value_name = "SESSION")]
    session: PathBuf,

    /// Print all tables, every cure and the sweeps, and not the summary alone
    #[arg(long)]
    full: bool,

    /// Print JSON instead of the summary
    #[arg(long)]
    json: bool,

    /// Show no progress
    #[arg(long, short)]
    quiet: bool,
}

const EXAMPLES: &str = "\
Examples:
  gravcal check session.toml
  gravcal check session.toml --json

Exit codes:
  0  everything that is asked for can be determined
  1  what was found could not be printed or shown in full; files are complete
  2  bad input or usage
  3  something that is asked for cannot be determined";

/// Runs the command.
pub fn run(arguments: &Arguments, registry: &Registry) -> Result<Exit, Failure> {
    let progress = Progress::new(arguments.quiet);
    let session = progress.read_session(&arguments.session, registry).map_err(|error| Failure::bad_input(&error))?;
    drop(progress);
    // Names that `calibrate` would refuse are refused here already.
    let choice = Choice::new((&[], None), (&session, &arguments.session), registry)?;
    let steps = choice.estimators.iter().any(|estimator| estimator.follows_steps());
    let (subject, robot) = (arguments.session.display(), session.robot.name.as_str());
    let report = check(&session).map_err(|error| Failure::bad_input(&error).about(subject))?;
    match arguments.json {
        true => terminal::print_exactly(&check_json(&report).map_err(|error| Failure::bad_input(&error))?)?,
        false if arguments.full => terminal::print(&CheckTable { robot, report: &report, steps }.to_string())?,
        false => terminal::print(&CheckSummary { robot, report: &report, steps }.to_string())?,
    }
    Ok(if report.complete { Exit::Determined } else { Exit::PartlyDetermined })
}
