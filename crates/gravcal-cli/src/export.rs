//! `gravcal export`: a calibration in the forms that others take.

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use gravcal_calibration::application::check_units;
use gravcal_recording::{
    Digest, EarlierEstimate, InputRole, LARGEST_DOCUMENT, read_earlier, read_earlier_inputs, read_whole,
};
use gravcal_report::export::{Export, ExportError, ExportFormat, RobotDescription, RobotModel};
use gravcal_robot_model::{EstimatorName, Registry, Session};
use gravcal_session::read_session_with;

use crate::apply::{session_path, source};
use crate::exit::Exit;
use crate::failure::Failure;
use crate::names::{estimator_of, estimator_parser};
use crate::{targets, terminal};

/// Write a calibration for a driver, a program, a robot description or a paper
///
/// ros2: parameters of a ROS 2 node (YAML), forward and inverse. urdf: the session's URDF with joints' origins moved by their position
/// offsets, an upright root link, and identified inertias. mujoco: the arm with identified inertias and gravity. payload: loads of unknown mass and the mount's gravity for drivers' calls. c, python: functions from a reading to what it truly says. csv: every parameter with its
/// interval. markdown, latex: tables, rounded. Each states its convention.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// What `gravcal calibrate` found: its calibration.json
    #[arg(value_name = "CALIBRATION")]
    calibration: PathBuf,

    /// Format
    #[arg(long, value_name = "FORMAT", value_parser = format_parser())]
    to: ExportFormat,

    /// File to write [default: it is printed]
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,

    /// Estimator whose answer is exported [default: the only one, else joint]
    #[arg(long, value_name = "NAME", value_parser = estimator_parser())]
    estimator: Option<EstimatorName>,

    /// Take nominal values, marked as such, for what the calibration does not determine
    #[arg(long)]
    nominal: bool,

    /// The session, whose URDF is corrected [default: the one that the calibration was made from, if it and the URDF have not changed]
    #[arg(long, value_name = "SESSION")]
    session: Option<PathBuf>,

    /// Replace FILE if it exists
    #[arg(long)]
    overwrite: bool,
}

const EXAMPLES: &str = "\
Examples:
  gravcal export calibration/calibration.json --to ros2 -o calibration.yaml
  gravcal export calibration/calibration.json --to urdf -o arm-calibrated.urdf
  gravcal export calibration/calibration.json --to mujoco -o arm.xml
  gravcal export calibration/calibration.json --to latex

Exit codes:
  0  it is written
  1  what was found could not be printed or shown in full; files are complete
  2  bad input or usage, or something is not determined; nothing is written";

fn format_parser() -> impl TypedValueParser<Value = ExportFormat> {
    PossibleValuesParser::new(ExportFormat::ALL.map(ExportFormat::as_str)).try_map(|name| name.parse())
}

/// Runs the command.
pub fn run(arguments: &Arguments, registry: &Registry) -> Result<Exit, Failure> {
    let calibration = &arguments.calibration;
    let estimator = estimator_of(calibration, arguments.estimator)?;
    let estimate = read_earlier(calibration, estimator.as_str()).map_err(|error| Failure::bad_input(&error))?;
    let session = arguments.to.is_robot().then(|| read_own_session(arguments, registry, &estimate)).transpose()?;
    let urdf = match (&session, arguments.to) {
        (Some(session), ExportFormat::Urdf) => Some(read_urdf(session)?),
        _ => None,
    };
    let read = session.iter().flat_map(|session| session.input_paths()).chain([calibration]);
    targets::check(read, arguments.output.as_slice())?;
    let robot = urdf.as_ref().zip(session.as_ref());
    let robot = robot.map(|(urdf, session)| RobotDescription { urdf, base: session.robot.chain.base() });
    let model = session.as_ref().map(|session| RobotModel { name: &session.robot.name, chain: &session.robot.chain });
    let source = source(calibration, estimator)?;
    let export = Export { estimate: &estimate, source: &source, nominal: arguments.nominal, robot, model };
    let exported = export.to(arguments.to).map_err(|error| refused(&error).about(calibration.display()))?;
    match &arguments.output {
        None => terminal::print_exactly(&exported.text)?,
        Some(output) => {
            write(output, &exported.text, arguments.overwrite)?;
            terminal::print(&format!("{}\n", output.display()))?;
        }
    }
    for remark in &exported.remarks {
        terminal::complain(&format!("note: {remark}"));
    }
    Ok(Exit::Determined)
}

/// The session whose robot is described.
fn read_own_session(
    arguments: &Arguments,
    registry: &Registry,
    estimate: &EarlierEstimate,
) -> Result<Session, Failure> {
    let path = session_path(&arguments.calibration, arguments.session.as_deref())?;
    let session = read_session_with(&path, registry).map_err(|error| Failure::bad_input(&error))?;
    check_units(&session, estimate).map_err(|error| Failure::bad_input(&error).about(path.display()))?;
    if let (None, Some(robot)) = (&arguments.session, session.robot_file()) {
        check_robot(&arguments.calibration, robot)?;
    }
    Ok(session)
}

/// The text of its URDF.
fn read_urdf(session: &Session) -> Result<String, Failure> {
    let robot = session.robot_file().ok_or_else(|| refused(&ExportError::NoUrdf))?;
    let failed = |error: &dyn std::error::Error| Failure::bad_input(error).about(robot.display());
    let text = read_whole(robot, LARGEST_DOCUMENT).map_err(|error| failed(&error))?;
    let text = String::from_utf8(text).map_err(|error| failed(&error))?;
    match text.trim_start().starts_with('<') {
        true => Ok(text),
        false => Err(refused(&ExportError::NoUrdf).about(robot.display())),
    }
}

/// That the robot is the one that the calibration was made from, as [`session_path`] checks of the session.
fn check_robot(calibration: &Path, robot: &Path) -> Result<(), Failure> {
    let inputs = read_earlier_inputs(calibration).map_err(|error| Failure::bad_input(&error))?;
    let now = Digest::of(robot).map_err(|error| Failure::bad_input(&error))?;
    match inputs.iter().any(|then| then.role == InputRole::Robot && then.sha256 == now.sha256) {
        true => Ok(()),
        false => {
            let message = format!("{}: the robot has changed since the calibration was made from it", robot.display());
            Err(Failure::said(message).hint("calibrate again; --session SESSION takes session and robot as they are"))
        }
    }
}

fn write(path: &Path, text: &str, overwrite: bool) -> Result<(), Failure> {
    if path.exists() && !overwrite {
        let message = format!("{}: there is such a file already", path.display());
        return Err(Failure::said(message).hint("--overwrite replaces it"));
    }
    gravcal_recording::write_atomically(path, text.as_bytes()).map_err(|error| Failure::bad_input(&error))
}

fn refused(error: &ExportError) -> Failure {
    let failure = Failure::bad_input(error);
    match error {
        ExportError::Undetermined { .. } => {
            failure.hint("`gravcal check` tells what would; --nominal takes nominal values instead, and says so")
        }
        ExportError::NoUrdf => {
            failure.hint("describe the robot by robot = { urdf = \"…\", base = \"…\", tip = \"…\" }")
        }
        ExportError::NoPayload => {
            failure.hint("write [[load]] mass_kg = \"unknown\" in the session, and calibrate again")
        }
        ExportError::OpenPayloads { .. } => failure.hint("`gravcal check` tells what would"),
        ExportError::NoInertias => {
            failure.hint("add [constraints] inertia = \"physical\" to the session, and calibrate again")
        }
        _ => failure,
    }
}
