//! `gravcal apply`: a recording with what its readings truly say.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use gravcal_calibration::application::{Application, ApplicationError, Effort};
use gravcal_recording::{
    CsvWriting, Digest, EarlierEstimate, RewriteError, Rewriting, Rows, WriteError, open_as, read_earlier,
    read_earlier_session, rewrite,
};
use gravcal_robot_model::{EstimatorName, Registry, Session};
use gravcal_session::read_session_with;

use crate::attached::Attached;
use crate::columns::ColumnNames;
use crate::exit::Exit;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::names::{estimator_of, estimator_parser};
use crate::progress::Progress;
use crate::{targets, terminal};

/// What is said of a recording that a calibration has been applied to.
const CALIBRATED: &str = "calibrated";

/// Write a recording again with calibrated torques and angles
///
/// Everything else in it is kept, other columns, topics, schemas, metadata, attachments, but for messages that are damaged. An MCAP file
/// becomes an MCAP file, a CSV file a CSV file. The session that the calibration was made from says which column belongs to which joint. Angles stay in the unit of their
/// column (rad, where that is the sensor's own), torques are in N·m (N for prismatic joints).
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// What `gravcal calibrate` found: its calibration.json
    #[arg(value_name = "CALIBRATION")]
    calibration: PathBuf,

    /// The recording; it stays as it is
    #[arg(value_name = "IN")]
    input: PathBuf,

    /// The new recording
    #[arg(value_name = "OUT")]
    output: PathBuf,

    /// The session [default: the one that the calibration was made from, if it has not changed]
    #[arg(long, value_name = "SESSION")]
    session: Option<PathBuf>,

    /// Estimator whose answer is applied [default: the only one, else joint]
    #[arg(long, value_name = "NAME", value_parser = estimator_parser())]
    estimator: Option<EstimatorName>,

    /// Subtract the gravity torque from the torques
    #[arg(long)]
    residual: bool,

    /// Load of the session that is attached [default: what the recording says of itself as `load`, else what the session says of it]
    #[arg(long, value_name = "NAME", requires = "residual")]
    load: Option<String>,

    /// Take nominal values for what the calibration does not determine
    #[arg(long)]
    nominal: bool,

    #[command(flatten)]
    columns: ColumnNames,

    /// Replace OUT if it exists
    #[arg(long)]
    overwrite: bool,

    /// Show no progress
    #[arg(long, short)]
    quiet: bool,
}

const EXAMPLES: &str = "\
Examples:
  gravcal apply calibration/calibration.json day1.mcap day1-calibrated.mcap
  gravcal apply calibration/calibration.json day1.csv contact.csv --residual

Exit codes:
  0  the new recording is written
  1  what was found could not be printed or shown in full; files are complete
  2  bad input or usage; nothing is written
  4  stopped by Ctrl-C; nothing is written";

/// Runs the command.
pub fn run(arguments: &Arguments, registry: &Registry) -> Result<Exit, Failure> {
    let bad = |error: &dyn std::error::Error| Failure::bad_input(error);
    let estimator = estimator_of(&arguments.calibration, arguments.estimator)?;
    let calibration = read_earlier(&arguments.calibration, estimator.as_str()).map_err(|error| bad(&error))?;
    let path = session_path(&arguments.calibration, arguments.session.as_deref())?;
    let session = read_session_with(&path, registry).map_err(|error| bad(&error))?;
    let own = [&arguments.calibration, &arguments.input];
    targets::check(own.into_iter().chain(session.input_paths()), std::slice::from_ref(&arguments.output))?;
    let csv = arguments.columns.of(&arguments.input, &session.readings.csv)?;
    let recording = open_as(&arguments.input, &csv).map_err(|error| bad(&error))?;
    let said = recording.metadata();
    if let Some(by) = said.get(CALIBRATED) {
        let subject = arguments.input.display();
        let hint = "apply calibrations to the recording as it was read from the sensors";
        return Err(Failure::said(format!("{subject}: it is calibrated already, by {by}")).hint(hint));
    }
    let attached = attached(arguments, &session, &said)?;
    let columns = recording.columns().to_vec();
    let mut application = application(arguments, &session, &calibration, attached.as_ref(), recording)?;
    application.find(&columns).map_err(|error| bad(&error).about(arguments.input.display()))?;

    let remarks = write(arguments, &mut application, &csv, &notes(arguments, estimator, attached.as_ref())?)?;
    let assumed = attached.and_then(|attached| attached.remark());
    let remarks = remarks.into_iter().chain(application.remarks()).chain(assumed);
    let reported: String = remarks.map(|remark| format!("note: {remark}\n")).collect();
    terminal::print(&format!("{reported}{}\n", arguments.output.display()))?;
    Ok(Exit::Determined)
}

/// Where the session is, which must be the one of the calibration if it is not named.
pub fn session_path(calibration: &Path, named: Option<&Path>) -> Result<PathBuf, Failure> {
    if let Some(session) = named {
        return Ok(session.to_owned());
    }
    let hint = "--session SESSION names it";
    let said = read_earlier_session(calibration).map_err(|error| Failure::bad_input(&error))?;
    let absent =
        || Failure::said(format!("{}: it does not say of which session it is", calibration.display())).hint(hint);
    let said = said.ok_or_else(absent)?;
    // Results lie in a folder beside the session, or where the session lies.
    let folder = calibration.parent().unwrap_or(Path::new(""));
    let above = folder.parent().map_or_else(|| PathBuf::from(".."), Path::to_owned);
    let found = [above.as_path(), folder].map(|folder| folder.join(&said.path)).into_iter().find(|path| path.is_file());
    let Some(found) = found else {
        let message = format!("{}: its session {} is not beside it", calibration.display(), said.path);
        return Err(Failure::said(message).hint(hint));
    };
    let now = Digest::of(&found).map_err(|error| Failure::bad_input(&error))?;
    match now.sha256 == said.sha256 {
        true => Ok(found),
        false => {
            let message =
                format!("{}: the session has changed since the calibration was made from it", found.display());
            Err(Failure::said(message).hint("calibrate again; --session SESSION takes it as it is"))
        }
    }
}

/// The calibration as what is made from it names it: file, estimator and hash.
pub fn source(calibration: &Path, estimator: EstimatorName) -> Result<String, Failure> {
    let digest = Digest::of(calibration).map_err(|error| Failure::bad_input(&error))?;
    let name = calibration.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    Ok(format!("{name} ({estimator}, sha256 {})", digest.sha256))
}

/// What is attached, where that matters.
fn attached(
    arguments: &Arguments,
    session: &Session,
    said: &BTreeMap<String, String>,
) -> Result<Option<Attached>, Failure> {
    let said = said.get("load").map(String::as_str);
    let attached = || Attached::new(arguments.load.as_deref(), said, session, &arguments.input);
    arguments.residual.then(attached).transpose()
}

fn application<'a>(
    arguments: &Arguments,
    session: &'a Session,
    calibration: &EarlierEstimate,
    attached: Option<&Attached>,
    recording: Box<dyn Rows>,
) -> Result<Application<'a>, Failure> {
    let effort = match attached {
        None => Effort::Torque,
        Some(attached) => Effort::Residual { load: attached.load.clone() },
    };
    Application::new(session, calibration, &effort, arguments.nominal, Some(recording)).map_err(|error| {
        let failure = Failure::bad_input(&error).about(arguments.calibration.display());
        match error {
            ApplicationError::Undetermined { .. }
            | ApplicationError::NoGravity
            | ApplicationError::NoMoments { .. } => {
                failure.hint("`gravcal check` tells what would; --nominal takes nominal values instead")
            }
            ApplicationError::Unit { .. } => {
                failure.hint("apply it with the session that it was made from, or calibrate with this one")
            }
            _ => failure,
        }
    })
}

/// What is said of the new recording.
fn notes(
    arguments: &Arguments,
    estimator: EstimatorName,
    attached: Option<&Attached>,
) -> Result<BTreeMap<String, String>, Failure> {
    let effort = match attached {
        None => "torque, N·m or N".to_owned(),
        Some(attached) => format!("torque without that which carries gravity, N·m or N; {}", attached.reported()),
    };
    let by = source(&arguments.calibration, estimator)?;
    Ok(BTreeMap::from([(CALIBRATED.to_owned(), by), ("effort".to_owned(), effort)]))
}

fn write(
    arguments: &Arguments,
    application: &mut Application<'_>,
    csv: &CsvWriting,
    notes: &BTreeMap<String, String>,
) -> Result<Vec<String>, Failure> {
    let interrupt = Interrupt::listen()?;
    let progress = Progress::new(arguments.quiet);
    let mut watch = |share: f64| {
        progress.stage(&format!("writing {}: {:.0} %", arguments.output.display(), 100.0 * share));
        !interrupt.is_asked()
    };
    let mut change = |columns: &[String], cells: &mut [f64]| application.apply(columns, cells);
    let Arguments { input, output, overwrite, .. } = arguments;
    let what = Rewriting { input, output, overwrite: *overwrite, csv, notes };
    rewrite(&what, &mut change, &mut watch).map_err(|error| match &error {
        RewriteError::Write(WriteError::Exists { .. }) => Failure::bad_input(&error).hint("--overwrite replaces it"),
        RewriteError::Stopped => Failure::no_convergence(&error),
        _ => Failure::bad_input(&error),
    })
}
