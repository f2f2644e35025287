//! `gravcal study`: batches of simulated calibrations, and what they come to.

mod share;
mod slurm;
mod submit;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args, Subcommand};
use gravcal_report::study::{StudyReport, StudySummary, report_files};
use gravcal_robot_model::Registry;
use gravcal_solvers::SolverName;
use gravcal_study::batch::{self, BatchError, Ended, Helpers, Manifest, NamedSolver, Shard, StudyFolder};
use gravcal_study::measures::measure;
use gravcal_study::plan::Study;
use indicatif::{ProgressBar, ProgressStyle};

use crate::exit::Exit;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::names::solver_named;
use crate::terminal;
use submit::{CancelArguments, StatusArguments, SubmitArguments};

/// Compare estimators over many simulated sessions with known truth
///
/// A study file says what is simulated, what is varied, how many trials there are and which estimators are compared.
#[derive(Debug, Args)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(RunArguments),
    Merge(MergeArguments),
    Report(ReportArguments),
    Submit(SubmitArguments),
    Status(StatusArguments),
    Cancel(CancelArguments),
}

/// Run the trials that are missing, and report
///
/// Results go to the output folder as they come, so that a run which was interrupted or killed goes on where it was.
#[derive(Debug, Args)]
#[command(after_help = RUN_EXAMPLES)]
struct RunArguments {
    /// The study, such as experiments/joint-against-sequential/study.toml
    #[arg(value_name = "STUDY")]
    study: PathBuf,

    /// Folder for the results [default: `results` beside study.toml, `NAME-results` beside NAME.toml]
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,

    /// Run only the K-th of N shares, such as 1/4; `gravcal study merge` puts them together
    ///
    /// In a task of a Slurm array that is the task's own share, with its results in `shares/K-of-N` of the folder.
    #[arg(long, value_name = "K/N", value_parser = share::named)]
    shard: Option<Shard>,

    /// Number of threads; results do not depend on it [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=256))]
    threads: Option<u16>,

    /// Print all tables, and not the summary alone
    #[arg(long)]
    full: bool,

    /// Show no progress and print no summary
    #[arg(long, short)]
    quiet: bool,
}

const RUN_EXAMPLES: &str = "\
Examples:
  gravcal study run experiments/joint-against-sequential/study.toml
  gravcal study run study.toml --shard 1/2 --output a      on one machine
  gravcal study run study.toml --shard 2/2 --output b      on another
  gravcal study merge a b

Exit codes:
  0  all trials (of the shard) are done; one that fails is a row with its reason
  1  what was found could not be printed in full; files are complete
  2  bad input or usage; earlier results are untouched
  4  stopped by Ctrl-C: run the same command again to go on";

/// Put the shares of a study together
///
/// The table is the same to the byte as that of a run without shares.
#[derive(Debug, Args)]
struct MergeArguments {
    /// Folder that gets the whole table
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// Folders with other shares, which stay as they are
    #[arg(value_name = "DIR")]
    others: Vec<PathBuf>,

    /// Print all tables, and not the summary alone
    #[arg(long)]
    full: bool,

    /// Print no summary
    #[arg(long, short)]
    quiet: bool,
}

/// Write tables and figures of a study that is complete
///
/// report.txt, report.md, study.html, measures.csv and figures (SVG) go into the study's folder; what they come to is printed, too.
#[derive(Debug, Args)]
struct ReportArguments {
    /// Folder with the results, such as experiments/joint-against-sequential/results
    #[arg(value_name = "DIR")]
    folder: PathBuf,

    /// Print all tables, and not the summary alone
    #[arg(long)]
    full: bool,

    /// Print no summary
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments, registry: &Registry) -> Result<Exit, Failure> {
    match &arguments.command {
        Command::Run(arguments) => run_study(arguments, registry),
        Command::Merge(arguments) => merge(arguments),
        Command::Report(arguments) => report(&open(&arguments.folder)?, Printed::new(arguments.full, arguments.quiet)),
        Command::Submit(arguments) => {
            let (study, solvers) = checked(&arguments.study, registry)?;
            submit::submit(arguments, &study, &names(&solvers))
        }
        Command::Status(arguments) => submit::status(arguments),
        Command::Cancel(arguments) => submit::cancel(arguments),
    }
}

/// How the names of results end.
const KINDS: [&str; 7] = ["json", "parquet", "csv", "txt", "md", "html", "svg"];

fn run_study(arguments: &RunArguments, registry: &Registry) -> Result<Exit, Failure> {
    crate::calibrate::limit_threads(arguments.threads)?;
    let (study, solvers) = checked(&arguments.study, registry)?;
    let path = arguments.output.clone().unwrap_or_else(|| folder_beside(&arguments.study));
    let (shard, path) = match (arguments.shard, share::of_slurm_task()) {
        (Some(shard), _) => (shard, path),
        (None, Some(shard)) => (shard, submit::share_folder(&path, shard)),
        (None, None) => (Shard { number: 1, of: 1 }, path),
    };
    check_apart(&study.inputs, &path)?;
    let folder = StudyFolder::begin(&path, Manifest::new(&study, &names(&solvers))).map_err(|error| refused(&error))?;

    let interrupt = Interrupt::listen()?;
    let bar = progress_bar(arguments.quiet);
    let began = Instant::now();
    let helpers = Helpers {
        solvers: &solvers,
        clock: &|| began.elapsed().as_secs_f64(),
        progress: &|done, total| {
            bar.set_length(total);
            bar.set_position(done);
        },
        stop: interrupt.flag(),
    };
    let ended = batch::run(&study, &folder, shard, &helpers).map_err(|error| refused(&error))?;
    bar.finish_and_clear();
    let Ended::Done { trials } = ended else {
        terminal::complain(
            "stopped; parts that are done are kept, those under way are not: run the same command again to go on",
        );
        return Ok(Exit::Failed);
    };
    let seconds = began.elapsed().as_secs_f64();
    let rate = if trials > 0 { format!(" ({:.0} a second)", trials as f64 / seconds) } else { String::new() };
    if shard.of > 1 || share::of_slurm_task().is_some() {
        terminal::print(&format!(
            "{trials} trials in {seconds:.1} s{rate}: share {}/{} in {}\n",
            shard.number,
            shard.of,
            path.display()
        ))?;
        return Ok(Exit::Determined);
    }
    batch::merge(&folder, &[]).map_err(|error| refused(&error))?;
    report(&folder, Printed::new(arguments.full, arguments.quiet))?;
    terminal::print(&format!("{trials} trials in {seconds:.1} s{rate}\n"))?;
    Ok(Exit::Determined)
}

/// The study, which its methods can take.
fn checked(path: &Path, registry: &Registry) -> Result<(Study, Vec<NamedSolver>), Failure> {
    let study = Study::read_with(path, registry).map_err(|error| Failure::bad_input(&error))?;
    let solvers = solvers(&study, registry)?;
    batch::check(&study, &solvers).map_err(|error| refused(&error))?;
    Ok((study, solvers))
}

fn names(solvers: &[NamedSolver]) -> Vec<String> {
    solvers.iter().map(|(name, _)| name.clone()).collect()
}

fn merge(arguments: &MergeArguments) -> Result<Exit, Failure> {
    let folder = StudyFolder::open_to_write(&arguments.folder).map_err(|error| refused(&error))?;
    let others = arguments.others.iter().map(|other| open(other)).collect::<Result<Vec<_>, _>>()?;
    batch::merge(&folder, &others).map_err(|error| refused(&error))?;
    report(&folder, Printed::new(arguments.full, arguments.quiet))
}

/// What of a report is printed.
#[derive(Clone, Copy)]
enum Printed {
    Nothing,
    Summary,
    Tables,
}

impl Printed {
    fn new(full: bool, quiet: bool) -> Printed {
        match (quiet, full) {
            (true, _) => Printed::Nothing,
            (false, false) => Printed::Summary,
            (false, true) => Printed::Tables,
        }
    }
}

fn report(folder: &StudyFolder, printed: Printed) -> Result<Exit, Failure> {
    let series = measure(folder).map_err(|error| refused(&error))?;
    let report = StudyReport { manifest: &folder.manifest, series: &series };
    let files = report_files(&report).map_err(|error| Failure::bad_input(&error))?;
    folder.put_report(&files).map_err(|error| refused(&error))?;
    match printed {
        Printed::Nothing => {}
        Printed::Summary => terminal::print(&StudySummary(report).to_string())?,
        Printed::Tables => terminal::print(&format!("{report}\n"))?,
    }
    let (figures, others): (Vec<&str>, Vec<&str>) =
        files.iter().map(|(name, _)| name.as_str()).partition(|name| name.ends_with(".svg"));
    terminal::print(&format!(
        "Results in {} ({}, trials.parquet, times.csv, {} figures)\n",
        folder.path().display(),
        others.join(", "),
        figures.len()
    ))?;
    Ok(Exit::Determined)
}

fn open(path: &Path) -> Result<StudyFolder, Failure> {
    StudyFolder::open(path).map_err(|error| refused(&error))
}

fn refused(error: &BatchError) -> Failure {
    let failure = Failure::bad_input(error);
    match error {
        BatchError::Another { .. } | BatchError::Foreign { .. } => failure.hint("--output DIR writes elsewhere"),
        _ => failure,
    }
}

/// Results do not replace what the study is made of.
fn check_apart(inputs: &[PathBuf], results: &Path) -> Result<(), Failure> {
    let Ok(results) = results.canonicalize() else { return Ok(()) };
    let is_result = |path: &Path| path.extension().is_some_and(|ending| KINDS.iter().any(|kind| ending == *kind));
    let lies_there =
        |path: &Path| path.canonicalize().is_ok_and(|path| path.parent() == Some(&results) && is_result(&path));
    match inputs.iter().find(|input| lies_there(input)) {
        None => Ok(()),
        Some(input) => {
            let message = format!("{}: the study reads this file, which stands among its results", input.display());
            Err(Failure::said(message).hint("--output DIR writes elsewhere"))
        }
    }
}

/// The methods that the study names, or the default one.
fn solvers(study: &Study, registry: &Registry) -> Result<Vec<NamedSolver>, Failure> {
    let default = || vec![SolverName::LevenbergMarquardt.to_string()];
    let names = if study.solvers.is_empty() { default() } else { study.solvers.clone() };
    let named = |name: String| {
        let method =
            solver_named(&name, registry).map_err(|message| Failure::bad_input(&study.solver_error(message)))?;
        Ok((name, method))
    };
    names.into_iter().map(named).collect()
}

/// `results` beside `study.toml`, `name-results` beside `name.toml`.
fn folder_beside(study: &Path) -> PathBuf {
    let name = match study.file_stem() {
        Some(stem) if stem != "study" => format!("{}-results", stem.to_string_lossy()),
        _ => "results".to_owned(),
    };
    study.with_file_name(name)
}

fn progress_bar(quiet: bool) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} trials, {per_sec}, {eta} left");
    match style {
        Ok(style) if !quiet => ProgressBar::new(0).with_style(style),
        _ => ProgressBar::hidden(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_lie_beside_the_study() {
        assert_eq!(folder_beside(Path::new("a/study.toml")), Path::new("a/results"));
        assert_eq!(folder_beside(Path::new("noise.toml")), Path::new("noise-results"));
    }
}
