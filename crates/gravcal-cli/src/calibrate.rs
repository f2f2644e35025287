//! `gravcal calibrate`: reads a session, runs the estimators, tells and writes what they answer.

use std::path::{Path, PathBuf};

use clap::Args;
use gravcal_calibration::result::EstimatorResult;
use gravcal_calibration::{SolveEnvironment, doubts_of_results};
use gravcal_estimation::IterationRecord;
#[cfg(feature = "rerun")]
use gravcal_recording::Digest;
use gravcal_recording::in_command;
use gravcal_report::{
    CalibrationFile, CalibrationPage, CalibrationSummary, CalibrationTable, Contents, Input, Options, OutputError,
    OutputFolder, Provenance, Written, report_doubts, report_further_doubts,
};
#[cfg(feature = "rerun")]
use gravcal_rerun::CalibrationRecording;
use gravcal_robot_model::{EstimatorName, Registry, Session};

use crate::exit::Exit;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::names::{Choice, estimator_parser};
use crate::progress::Progress;
use crate::rerun::RerunArguments;
use crate::stopwatch::{Phase, Stopwatch};
use crate::{targets, terminal};

/// Find gains, offsets and gravity of a session, with their uncertainty
///
/// Runs the estimators on all static poses of the session, prints what they come to on one screen, and writes their answers to the
/// output folder: calibration.json for programs, table.txt and report.html for people, timing.json. What the poses do not determine
/// is named together with what would cure it, and has no value.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// The session, such as experiments/sarcos-shoulder/session.toml
    #[arg(value_name = "SESSION")]
    session: PathBuf,

    /// Estimator to run; may be given several times [default: what the session says, else sequential and joint]
    #[arg(long = "estimator", value_name = "NAME", value_parser = estimator_parser())]
    estimators: Vec<EstimatorName>,

    /// Method that minimises [default: what the session says, else levenberg-marquardt]. Options in the session apply
    /// only if it names the same method
    #[arg(long, value_name = "NAME")]
    solver: Option<String>,

    /// Folder for the results [default: `calibration` beside session.toml, `NAME-calibration` beside NAME.toml]
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Replace other results in the output folder
    #[arg(long)]
    overwrite: bool,

    /// Print all tables, as in table.txt, and not the summary alone
    #[arg(long)]
    full: bool,

    /// Print calibration.json instead of the summary
    #[arg(long, conflicts_with = "quiet")]
    json: bool,

    /// Show no progress and print no summary; the exit code tells the verdict
    #[arg(long, short)]
    quiet: bool,

    /// Tell every stage and iteration in a line of its own
    #[arg(long, short, conflicts_with = "quiet")]
    verbose: bool,

    /// Number of threads; results do not depend on it [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,

    #[command(flatten)]
    rerun: RerunArguments,
}

const EXAMPLES: &str = "\
Examples:
  gravcal calibrate session.toml
  gravcal calibrate session.toml --estimator joint --output /tmp/trial
  gravcal calibrate session.toml --overwrite --full

Exit codes, of the joint estimator if it ran:
  0  everything that is asked for is determined
  1  what was found could not be printed or shown in full; files are complete
  2  bad input or usage; nothing is written
  3  solved, but something that is asked for is undetermined or cannot be relied on
  4  no answer to rely on: no convergence, stopped by Ctrl-C, or readings that contradict the model

Ctrl-C stops after the current iteration, and what is known is printed and written; a second one ends the program at once.";

/// Runs the command.
pub fn run(arguments: &Arguments, registry: &Registry) -> Result<Exit, Failure> {
    limit_threads(arguments.threads)?;
    let watch = Stopwatch::start(Phase::Read);
    let path = arguments.session.as_path();
    let session = progress(arguments).read_session(path, registry).map_err(|error| Failure::bad_input(&error))?;
    let said = (arguments.estimators.as_slice(), arguments.solver.as_deref());
    let choice = Choice::new(said, (&session, path), registry)?;
    let folder = output_folder(arguments);
    targets::check(session.input_paths(), &written_files(arguments, &folder))?;
    folder.check().map_err(|error| refused(&error))?;
    arguments.rerun.check(arguments.overwrite)?;
    let provenance = provenance(&session, path, &choice)?;

    // Before a solve that may last, and may be for nothing.
    let doubts = report_doubts(&session.doubts);
    if !(doubts.is_empty() || arguments.quiet || arguments.json) {
        terminal::print(&format!("{doubts}\n"))?;
    }
    let interrupt = Interrupt::listen()?;
    let results = calibrate(&session, &choice, &watch, (progress(arguments), &interrupt));

    let found = doubts_of_results(&session, &results);
    let doubts = [&session.doubts[..], &found].concat();
    let further = if session.doubts.is_empty() { report_doubts(&found) } else { report_further_doubts(&found) };
    let (robot, results) = (session.robot.name.as_str(), results.as_slice());
    let table = CalibrationTable { robot, doubts: &doubts, results }.to_string();
    let file = folder.path().join("calibration.json");
    let shown = match arguments.full {
        true => format!("{}\n", CalibrationTable { robot, doubts: &[], results }),
        false => CalibrationSummary { robot, results, file: &in_command(&file) }.to_string(),
    };
    let page = CalibrationPage { session: &session, results, provenance: &provenance };
    let calibration = CalibrationFile { doubts: &doubts, estimators: results, provenance: &provenance }.to_json();
    let calibration = calibration.map_err(|error| Failure::no_convergence(&error));
    let written = calibration
        .as_ref()
        .map_err(Clone::clone)
        .and_then(|calibration| write(&folder, calibration, &page, &table, &watch));
    let printed = match arguments.quiet || arguments.json {
        true => Ok(()),
        false if further.is_empty() => terminal::print(&shown),
        false => terminal::print(&format!("{further}\n{shown}")),
    };
    let (calibration, written) = (calibration?, written?);
    printed?;
    if arguments.json {
        terminal::print_exactly(&calibration)?;
    } else {
        terminal::print(&format!("{}\n", where_to(&folder, written)))?;
    }
    #[cfg(feature = "rerun")]
    show(arguments, &session, results, (&calibration, &table))?;
    if interrupt.is_asked() {
        terminal::complain("note: stopped by Ctrl-C: what would have come after that is not in the results");
        return Ok(Exit::Failed);
    }
    Ok(Exit::of_calibration(results))
}

fn progress(arguments: &Arguments) -> Progress {
    if arguments.verbose { Progress::in_lines() } else { Progress::new(arguments.quiet) }
}

pub fn limit_threads(threads: Option<u16>) -> Result<(), Failure> {
    let Some(threads) = threads else { return Ok(()) };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
    pool.build_global().map_err(|error| Failure::bad_input(&error).about(format!("--threads {threads}")))
}

fn written_files(arguments: &Arguments, folder: &OutputFolder) -> Vec<PathBuf> {
    folder.files().into_iter().chain(arguments.rerun.file().map(Path::to_owned)).collect()
}

fn output_folder(arguments: &Arguments) -> OutputFolder {
    let path = arguments.output.clone().unwrap_or_else(|| OutputFolder::beside(&arguments.session));
    OutputFolder::new(path, arguments.overwrite)
}

/// Hashes the inputs of the session at `path` as they were read, before the solve.
///
/// # Errors
/// One of them cannot be read.
pub fn provenance(session: &Session, path: &Path, choice: &Choice) -> Result<Provenance, Failure> {
    let base = path.parent().unwrap_or(Path::new(""));
    let inputs: Result<Vec<Input>, _> =
        session.inputs.iter().map(|input| Input::read(input.role, &input.path, base)).collect();
    let options = Options {
        estimators: choice.estimators.iter().map(ToString::to_string).collect(),
        solver: choice.solver.name.clone(),
        solver_options: choice.solver.options.clone(),
    };
    Ok(Provenance::new(inputs.map_err(|error| Failure::bad_input(&error))?, options))
}

fn calibrate(
    session: &Session,
    choice: &Choice,
    watch: &Stopwatch,
    (progress, interrupt): (Progress, &Interrupt),
) -> Vec<EstimatorResult> {
    let report = |stage: &str| {
        watch.enter(Phase::of_stage(stage));
        progress.stage(stage);
    };
    let observe = |record: &IterationRecord| progress.iteration(record);
    watch.enter(Phase::Start);
    let environment = SolveEnvironment::new(choice.solver.method.as_ref(), &report);
    let environment = environment.observed_by(&observe).stopped_by(interrupt.flag());
    gravcal_calibration::calibrate(session, &choice.estimators, &environment)
}

fn write(
    folder: &OutputFolder,
    calibration: &str,
    page: &CalibrationPage<'_>,
    table: &str,
    watch: &Stopwatch,
) -> Result<Written, Failure> {
    let timing = watch.times().to_json().map_err(|error| Failure::no_convergence(&error))?;
    let page = page.to_html().map_err(|error| Failure::no_convergence(&error))?;
    let contents = Contents { calibration, table, page: &page, timing: &timing };
    folder.write(&contents).map_err(|error| refused(&error))
}

/// What decides the results decides the recording's name.
#[cfg(feature = "rerun")]
fn show(
    arguments: &Arguments,
    session: &Session,
    results: &[EstimatorResult],
    (calibration, table): (&str, &str),
) -> Result<(), Failure> {
    let id = &Digest::of_bytes(calibration.as_bytes()).sha256;
    let reported = arguments.rerun.show(&CalibrationRecording { id, session, results, table }, arguments.overwrite)?;
    if arguments.json { Ok(()) } else { terminal::print(&reported) }
}

fn refused(error: &OutputError) -> Failure {
    let failure = Failure::bad_input(error);
    match error {
        OutputError::Occupied { .. } => failure.hint("--overwrite replaces them, --output DIR writes elsewhere"),
        _ => failure.hint("--output DIR writes elsewhere"),
    }
}

fn where_to(folder: &OutputFolder, written: Written) -> String {
    let files = match written {
        Written::New => "report.html, table.txt, calibration.json",
        Written::Unchanged => "already there, unchanged",
    };
    format!("Results in {} ({files})", folder.path().display())
}
