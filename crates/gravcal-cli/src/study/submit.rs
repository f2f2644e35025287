//! `gravcal study submit`, `status` and `cancel`: a study as an array of tasks of Slurm.
//!
//! Task K of N runs share K/N into a folder of its own below the study's results, `shares/K-of-N`; a job that waits for all of them puts
//! these together. What a task has done stays where it is killed, requeued or out of time: it, or a study that is submitted again, goes on.

use std::path::{Path, PathBuf};

use clap::Args;
use gravcal_recording::{LARGEST_RESULTS, in_command, read_whole, write_atomically};
use gravcal_study::batch::{Manifest, Shard, StudyFolder};
use gravcal_study::plan::Study;
use serde::{Deserialize, Serialize};

use super::slurm;
use super::{check_apart, folder_beside, open, refused};
use crate::exit::Exit;
use crate::failure::Failure;
use crate::terminal;

/// Which jobs do a study, in the folder of its results.
const JOBS: &str = "slurm.json";
const SHARES: &str = "shares";
const LOGS: &str = "logs";

/// Submit a study to Slurm: an array of tasks, and a job that puts their shares together
///
/// The results' folder must be one that all nodes see. Submit again what was cancelled or failed: what is done is not done again.
#[derive(Debug, Args)]
#[command(after_help = EXAMPLES)]
pub struct SubmitArguments {
    /// The study, such as experiments/joint-against-sequential/study.toml
    #[arg(value_name = "STUDY")]
    pub study: PathBuf,

    /// Tasks of the array; where Slurm takes fewer (MaxArraySize), each does more
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub tasks: u32,

    /// Folder for the results [default: `results` beside study.toml, `NAME-results` beside NAME.toml]
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,

    /// Processors of each task
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=256))]
    pub threads: u16,

    /// An option for sbatch, such as --sbatch=--time=02:00:00; may be given several times
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    pub sbatch: Vec<String>,
}

const EXAMPLES: &str = "\
Examples:
  gravcal study submit study.toml --tasks 100 --output /shared/noise
  gravcal study submit study.toml --tasks 100 --sbatch=--partition=short --sbatch=--time=00:30:00
  gravcal study status /shared/noise
  gravcal study cancel /shared/noise

Exit codes:
  0  submitted
  2  bad input or usage, no Slurm, or Slurm refuses; nothing is submitted";

/// Say how far a study is that was submitted
#[derive(Debug, Args)]
pub struct StatusArguments {
    /// Folder of its results
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Cancel the jobs of a study that was submitted; what is done stays
#[derive(Debug, Args)]
pub struct CancelArguments {
    /// Folder of its results
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// The jobs of a study.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Jobs {
    /// The array of tasks.
    array_job: String,
    /// What puts their shares together.
    merge_job: String,
    tasks: usize,
}

/// Where a share's results are.
pub fn share_folder(results: &Path, shard: Shard) -> PathBuf {
    results.join(SHARES).join(format!("{}-of-{}", shard.number, shard.of))
}

/// Submits a study whose parts can be run.
pub fn submit(arguments: &SubmitArguments, study: &Study, solvers: &[String]) -> Result<Exit, Failure> {
    let path = arguments.output.clone().unwrap_or_else(|| folder_beside(&arguments.study));
    check_apart(&study.inputs, &path)?;
    // Before anything is written.
    slurm::check_there()?;
    let folder = StudyFolder::begin(&path, Manifest::new(study, solvers)).map_err(|error| refused(&error))?;
    if folder.is_complete() {
        terminal::print(&format!("All trials are there: gravcal study report {}\n", in_command(&path)))?;
        return Ok(Exit::Determined);
    }
    let path = absolute(&path)?;
    let tasks = (arguments.tasks as usize).min(slurm::most_tasks()).min(folder.parts());
    check_earlier(&path, tasks)?;
    // Their merging writes here.
    drop(folder);
    let logs = path.join(LOGS);
    std::fs::create_dir_all(&logs).map_err(|error| Failure::bad_input(&error).about(logs.display()))?;
    let jobs = hand_in(arguments, &absolute(&arguments.study)?, &path, tasks)?;
    let text = serde_json::to_string_pretty(&jobs).map_err(|error| Failure::bad_input(&error))?;
    write_atomically(&path.join(JOBS), format!("{text}\n").as_bytes()).map_err(|error| Failure::bad_input(&error))?;
    terminal::print(&format!(
        "Submitted {tasks} tasks (job {}), and what puts their shares together (job {}).\nResults in {}, what tasks print in {}\n\
         gravcal study status {} says how far they are\n",
        jobs.array_job,
        jobs.merge_job,
        path.display(),
        logs.display(),
        in_command(&path)
    ))?;
    Ok(Exit::Determined)
}

fn hand_in(arguments: &SubmitArguments, study: &Path, results: &Path, tasks: usize) -> Result<Jobs, Failure> {
    let program = std::env::current_exe().map_err(|error| Failure::bad_input(&error).about("gravcal"))?;
    let (program, results_quoted) = (slurm::quoted(&program), slurm::quoted(results));
    let script = |command: String| format!("#!/bin/sh\nexec {program} study {command}\n");
    let name = |what: &str| format!("--job-name=gravcal-{what}");
    // Slurm fills in what stands behind a per cent sign.
    let logs = results.join(LOGS).display().to_string().replace('%', "%%");
    let log = |name: &str| format!("--output={logs}/{name}");

    let run = format!("run {} --output {results_quoted} --threads {} --quiet", slurm::quoted(study), arguments.threads);
    let mut options = vec![name("study"), log("task-%a.log"), format!("--array=0-{}", tasks - 1), "--requeue".into()];
    options.push(format!("--cpus-per-task={}", arguments.threads));
    // Behind ours: of two options of a name Slurm takes the last.
    options.extend(arguments.sbatch.iter().cloned());
    let array_job = slurm::submit(&script(run), &options)?;

    let merge = format!("merge {results_quoted} {results_quoted}/{SHARES}/*-of-{tasks} --quiet");
    let mut options = vec![name("merge"), log("merge.log")];
    options.extend(slurm::waiting_for(&array_job));
    match slurm::submit(&script(merge), &options) {
        Ok(merge_job) => Ok(Jobs { array_job, merge_job, tasks }),
        Err(refused) => {
            slurm::cancel(&[&array_job])?;
            Err(refused)
        }
    }
}

/// Tells how many parts are done, and what the tasks are at.
pub fn status(arguments: &StatusArguments) -> Result<Exit, Failure> {
    let folder = open(&arguments.folder)?;
    let jobs = jobs(&arguments.folder)?;
    let parts = folder.parts();
    if folder.is_complete() {
        terminal::print(&format!("done: {parts} of {parts} parts, put together\n"))?;
        return Ok(Exit::Determined);
    }
    let shares = (1..=jobs.tasks).map(|number| share_folder(&arguments.folder, Shard { number, of: jobs.tasks }));
    // A task that has just begun has a folder, and nothing in it.
    let begun = shares.filter(|share| share.join("study.json").is_file());
    let shares = begun.map(|share| open(&share)).collect::<Result<Vec<_>, _>>()?;
    let done = std::iter::once(&folder).chain(&shares).map(StudyFolder::parts_done);
    let done: usize = done.sum::<Result<usize, _>>().map_err(|error| refused(&error))?;
    let (tasks, merge) = (slurm::states(&jobs.array_job)?, slurm::states(&jobs.merge_job)?);
    terminal::print(&format!(
        "{done} of {parts} parts done\n{} tasks (job {}): {}\nmerge (job {}): {}\n",
        jobs.tasks,
        jobs.array_job,
        counted(&tasks),
        jobs.merge_job,
        counted(&merge),
    ))?;
    if tasks.is_empty() && merge.is_empty() {
        terminal::print(&format!(
            "No job is left, and the table is not there: look at {}, and submit the study again; what is done is not done again\n",
            arguments.folder.join(LOGS).display()
        ))?;
    }
    Ok(Exit::Determined)
}

/// Cancels what is still in the queue.
pub fn cancel(arguments: &CancelArguments) -> Result<Exit, Failure> {
    open(&arguments.folder)?;
    let jobs = jobs(&arguments.folder)?;
    slurm::cancel(&[&jobs.array_job, &jobs.merge_job])?;
    terminal::print(&format!(
        "Cancelled jobs {} and {}; what is done stays, and the study can be submitted again\n",
        jobs.array_job, jobs.merge_job
    ))?;
    Ok(Exit::Determined)
}

/// `2 RUNNING, 5 PENDING`.
fn counted(states: &[String]) -> String {
    let mut kinds: Vec<&String> = states.iter().collect();
    kinds.sort();
    kinds.dedup();
    let count = |kind: &String| states.iter().filter(|state| *state == kind).count();
    let reported: Vec<String> = kinds.into_iter().map(|kind| format!("{} {kind}", count(kind))).collect();
    if reported.is_empty() { "none in the queue".into() } else { reported.join(", ") }
}

/// That no jobs are at work on these results, and that earlier ones had the same shares.
fn check_earlier(results: &Path, tasks: usize) -> Result<(), Failure> {
    if !results.join(JOBS).is_file() {
        return Ok(());
    }
    let earlier = jobs(results)?;
    let Jobs { array_job, merge_job, .. } = &earlier;
    if !slurm::states(array_job)?.is_empty() || !slurm::states(merge_job)?.is_empty() {
        let message = format!("{}: jobs {array_job} and {merge_job} are at work on this study", results.display());
        return Err(Failure::said(message).hint("wait for them, or cancel them: gravcal study cancel DIR"));
    }
    if earlier.tasks != tasks {
        let message =
            format!("{}: what is done here was shared out to {} tasks, not {tasks}", results.display(), earlier.tasks);
        return Err(Failure::said(message)
            .hint(format!("--tasks {} goes on; --output DIR begins anew elsewhere", earlier.tasks)));
    }
    Ok(())
}

fn jobs(results: &Path) -> Result<Jobs, Failure> {
    let path = results.join(JOBS);
    let unknown = |why: String| {
        Failure::said(format!("{}: {why}", path.display()))
            .hint("gravcal study submit makes it: name the folder of the results")
    };
    let text = read_whole(&path, LARGEST_RESULTS).map_err(|error| unknown(error.to_string()))?;
    serde_json::from_slice(&text).map_err(|error| unknown(error.to_string()))
}

fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    path.canonicalize().map_err(|error| Failure::bad_input(&error).about(path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_counted_by_kind() {
        let states = ["RUNNING", "PENDING", "RUNNING"].map(str::to_owned);
        assert_eq!(counted(&states), "1 PENDING, 2 RUNNING");
        assert_eq!(counted(&[]), "none in the queue");
    }
}
