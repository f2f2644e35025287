//! Studies on a cluster: shares as tasks of Slurm come to the table of one run.
//!
//! By default Slurm's commands are scripts that run each task at once. `cargo test --release -p gravcal-cli --test acceptance cluster --
//! --ignored` takes the Slurm that `SLURM_CONF` names.

use std::ffi::OsString;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use tempfile::TempDir;

use crate::program::Run;
use crate::studies::Study;

/// Runs the tasks of an array one after the other, and what waits for a job only where that did not fail.
const SBATCH: &str = r#"#!/bin/sh
[ "$1" = --version ] && exit 0
here=$(dirname "$0"); job=$(( $(cat "$here/jobs" 2>/dev/null || echo 0) + 1 )); echo $job > "$here/jobs"
cat > "$here/script-$job"; last=; after=
for option in "$@"; do case $option in --array=0-*) last=${option#--array=0-};; --dependency=afterok:*) after=${option#*:};; esac; done
echo "$@" > "$here/options-$job"
if [ -n "$after" ] && [ -e "$here/failed-$after" ]; then echo $job; exit 0; fi
for task in $(seq 0 ${last:-0}); do
  if [ -n "$last" ]; then export SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_COUNT=$((last + 1)) SLURM_ARRAY_TASK_MIN=0; fi
  if [ "$task" = "$(cat "$here/broken" 2>/dev/null)" ]; then touch "$here/failed-$job"; continue; fi
  sh "$here/script-$job" >> "$here/printed" 2>&1 || touch "$here/failed-$job"
done
echo $job
"#;
const NOTHING_QUEUED: &str = "#!/bin/sh\nexit 0\n";
const SCONTROL: &str = "#!/bin/sh\necho 'MaxArraySize            = 4'\n";

/// A folder with Slurm's commands.
fn scripts() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in
        [("sbatch", SBATCH), ("squeue", NOTHING_QUEUED), ("scancel", NOTHING_QUEUED), ("scontrol", SCONTROL)]
    {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
    }
    folder
}

fn run(search: &OsString, arguments: &[String]) -> Run {
    let program = env!("CARGO_BIN_EXE_gravcal");
    let output = Command::new(program).arg("study").args(arguments).env("PATH", search).output().unwrap();
    Run {
        code: output.status.code().unwrap_or(-1),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    }
}

fn before_path(folder: &Path) -> OsString {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::join_paths(std::iter::once(folder.to_owned()).chain(std::env::split_paths(&path))).unwrap()
}

fn submission(study: &Study, tasks: &str) -> Vec<String> {
    submission_to("submitted", study, tasks)
}

fn submission_to(folder: &str, study: &Study, tasks: &str) -> Vec<String> {
    let mut arguments = study.arguments(folder, &["--tasks", tasks, "--sbatch=--time=01:00:00"]);
    arguments[1] = "submit".into();
    arguments.remove(0);
    arguments
}

#[test]
fn a_study_that_was_submitted_comes_to_the_table_of_one_run() {
    let study = Study::small(40);
    assert_eq!(study.run("alone", &["--quiet"]).code, 0);
    let slurm = scripts();
    let search = before_path(slurm.path());
    let folder = study.results("submitted").display().to_string();

    // A task that its node loses: no table, and nothing that was done is lost.
    fs::write(slurm.path().join("broken"), "1").unwrap();
    let submitted = run(&search, &submission(&study, "3"));
    assert_eq!(submitted.code, 0, "{submitted:?}");
    assert!(submitted.stdout.contains("Submitted 3 tasks (job 1)"), "{submitted:?}");
    let options = fs::read_to_string(slurm.path().join("options-1")).unwrap();
    assert!(options.contains("--array=0-2") && options.contains("--time=01:00:00") && options.contains("--requeue"));
    let waiting = fs::read_to_string(slurm.path().join("options-2")).unwrap();
    assert!(waiting.contains("--dependency=afterok:1"), "{waiting}");
    let status = run(&search, &["status".into(), folder.clone()]);
    assert!(status.stdout.contains("parts done") && status.stdout.contains("submit the study again"), "{status:?}");
    let other = run(&search, &submission(&study, "2"));
    assert_eq!(other.refusal(&["3 tasks, not 2", "--tasks 3"]), None);

    fs::remove_file(slurm.path().join("broken")).unwrap();
    assert_eq!(run(&search, &submission(&study, "3")).code, 0);
    let status = run(&search, &["status".into(), folder.clone()]);
    let printed = || fs::read_to_string(slurm.path().join("printed")).unwrap();
    assert!(status.stdout.starts_with("done:"), "{status:?} {}", printed());
    assert_eq!(study.table("submitted"), study.table("alone"));
    assert_eq!(run(&search, &["cancel".into(), folder]).code, 0);
}

#[test]
fn more_tasks_than_an_array_takes_are_fewer_that_do_more() {
    let (study, slurm) = (Study::small(40), scripts());
    let submitted = run(&before_path(slurm.path()), &submission(&study, "5000"));
    assert!(submitted.code == 0 && submitted.stdout.contains("Submitted 3 tasks"), "{submitted:?}");
}

/// Slurm fills in `%a`, and would any other sign behind a per cent sign.
#[test]
fn a_folder_may_have_spaces_and_per_cent_signs() {
    let (study, slurm) = (Study::small(4), scripts());
    let submitted = run(&before_path(slurm.path()), &submission_to("90 % a", &study, "2"));
    assert_eq!(submitted.code, 0, "{submitted:?}");
    let options = fs::read_to_string(slurm.path().join("options-1")).unwrap();
    assert!(options.contains("90 %% a/logs/task-%a.log"), "{options}");
    let status = submitted.stdout.lines().find(|line| line.starts_with("gravcal study status ")).unwrap();
    assert!(status.contains("90 % a' says how far they are"), "{status}");
}

#[test]
fn where_there_is_no_slurm_that_is_said() {
    let (study, nowhere) = (Study::small(2), tempfile::tempdir().unwrap());
    let refused = run(&nowhere.path().into(), &submission(&study, "2"));
    assert_eq!(refused.refusal(&["sbatch", "--shard K/N"]), None);
    assert!(!study.results("submitted").exists());
    let unknown = run(&nowhere.path().into(), &["status".into(), nowhere.path().display().to_string()]);
    assert_eq!(unknown.refusal(&["study"]), None);
}

#[test]
#[ignore = "needs a Slurm, whose SLURM_CONF is in the environment"]
fn slurm_itself_comes_to_the_table_of_one_run() {
    let study = Study::small(200);
    assert_eq!(study.run("alone", &["--quiet"]).code, 0);
    let search = std::env::var_os("PATH").unwrap();
    let submitted = run(&search, &submission(&study, "4"));
    assert_eq!(submitted.code, 0, "{submitted:?}");
    let folder = study.results("submitted").display().to_string();
    for _ in 0..240 {
        let status = run(&search, &["status".into(), folder.clone()]);
        if status.stdout.starts_with("done:") {
            assert_eq!(study.table("submitted"), study.table("alone"));
            return;
        }
        std::thread::sleep(Duration::from_millis(500));
    }
    panic!("not done after two minutes: {:?}", run(&search, &["status".into(), folder]));
}
