//! The commands of Slurm that a study needs: `sbatch`, `squeue`, `scancel`, `scontrol`.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

use crate::failure::Failure;

/// Tasks of an array where Slurm does not tell how many it takes: its own default.
const MOST_TASKS: usize = 1000;

/// Fails where there is no Slurm.
///
/// # Errors
/// `sbatch` does not run here.
pub fn check_there() -> Result<(), Failure> {
    run("sbatch", &["--version".to_owned()], None).map(|_| ())
}

/// Hands a script in, and returns the number of its job.
///
/// # Errors
/// There is no Slurm, or it refuses.
pub fn submit(script: &str, options: &[String]) -> Result<String, Failure> {
    let printed = run("sbatch", &[&["--parsable".to_owned()], options].concat(), Some(script))?;
    // `12`, or `12;cluster`.
    Ok(printed.trim().split(';').next().unwrap_or_default().to_owned())
}

/// The options by which a job waits for another, which must succeed.
pub fn waiting_for(job: &str) -> Vec<String> {
    vec![format!("--dependency=afterok:{job}"), "--kill-on-invalid-dep=yes".to_owned()]
}

/// Tasks of an array that Slurm takes.
pub fn most_tasks() -> usize {
    let Ok(reported) = run("scontrol", &["show".to_owned(), "config".to_owned()], None) else { return MOST_TASKS };
    let lines = reported.lines().filter_map(|line| line.split_once('='));
    let size = lines.filter(|(key, _)| key.trim() == "MaxArraySize").find_map(|(_, value)| value.trim().parse().ok());
    size.map_or(MOST_TASKS, |size: usize| size.saturating_sub(1).max(1))
}

/// The states of the tasks of a job that Slurm still has in its queue, such as `RUNNING`; none where it has ended.
///
/// # Errors
/// There is no Slurm, or it cannot be asked.
pub fn states(job: &str) -> Result<Vec<String>, Failure> {
    let options = ["--noheader", "--array", "--format=%T", "--jobs"].map(str::to_owned);
    match run("squeue", &[&options[..], &[job.to_owned()]].concat(), None) {
        Ok(reported) => {
            Ok(reported.lines().map(|line| line.trim().to_owned()).filter(|line| !line.is_empty()).collect())
        }
        // What Slurm has forgotten has ended.
        Err(failure) if failure.to_string().contains("Invalid job id") => Ok(Vec::new()),
        Err(failure) => Err(failure),
    }
}

/// Cancels jobs; those that have ended stay as they are.
///
/// # Errors
/// There is no Slurm, or it refuses.
pub fn cancel(jobs: &[&str]) -> Result<(), Failure> {
    let jobs: Vec<String> = jobs.iter().map(|job| (*job).to_owned()).collect();
    run("scancel", &jobs, None).map(|_| ())
}

/// A word as a shell takes it.
pub fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', r"'\''"))
}

fn run(program: &str, arguments: &[String], input: Option<&str>) -> Result<String, Failure> {
    let missing = |error: std::io::Error| {
        Failure::bad_input(&error)
            .about(program)
            .hint("this command needs Slurm; without it, share the trials out by `gravcal study run --shard K/N`")
    };
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(missing)?;
    if let (Some(mut stdin), Some(input)) = (child.stdin.take(), input) {
        stdin.write_all(input.as_bytes()).map_err(missing)?;
    }
    let Output { status, stdout, stderr } = child.wait_with_output().map_err(missing)?;
    match status.success() {
        true => Ok(String::from_utf8_lossy(&stdout).into_owned()),
        false => Err(Failure::said(format!("{program}: {}", String::from_utf8_lossy(&stderr).trim()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_one_word_of_a_shell() {
        assert_eq!(quoted(Path::new("/a b/it's")), r"'/a b/it'\''s'");
    }
}
