//! The same input gives the same bytes, and what is there already is not overwritten unless told.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::program::{Calibration, Run, calibrate_into, gravcal};
use crate::tree;

/// Bytes of files by name.
type Contents = BTreeMap<String, Vec<u8>>;

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    for experiment in ["sarcos-shoulder", "seven-joints-tilted"] {
        let session = tree::experiment(experiment).join("session.toml");
        let [one, two] = ["1", "2"].map(|threads| Calibration::with(&session, &["--threads", threads]));
        for file in ["calibration.json", "table.txt"] {
            assert!(one.bytes(file) == two.bytes(file), "{experiment}: {file} depends on the number of threads");
        }
    }
}

#[test]
fn every_simulation_gives_the_files_beside_it() {
    let simulated = |experiment: &PathBuf| experiment.join("simulation.toml").exists();
    let experiments: Vec<PathBuf> = tree::experiments().into_iter().filter(simulated).collect();
    assert!(!experiments.is_empty(), "no experiment is simulated");
    for experiment in experiments {
        let made = simulated_anew(&experiment);
        assert!(made == simulated_anew(&experiment), "{}: two runs differ", experiment.display());
        for (file, bytes) in made {
            assert!(fs::read(experiment.join(&file)).unwrap() == bytes, "{}: {file} differs", experiment.display());
        }
    }
}

#[test]
fn another_trial_is_not_written_over_the_first_unless_reported() {
    let project = copied_project(&tree::experiment("sarcos-shoulder"));
    let simulation = project.path().join("experiments/sarcos-shoulder/simulation.toml");
    let simulate =
        |options: &[&str]| gravcal([["simulate", simulation.to_str().unwrap()].as_slice(), options].concat());
    let folder = simulation.parent().unwrap();

    assert_eq!(simulate(&[]).code, 0);
    let first = contents(folder);
    let refused = simulate(&["--trial", "1"]);
    assert_eq!(refused.refusal(&["--overwrite"]), None);
    assert!(contents(folder) == first, "a refused simulation wrote files");
    assert_eq!(simulate(&["--trial", "1", "--overwrite"]).code, 0);
    assert!(contents(folder) != first, "another trial is the same");
}

#[test]
fn the_same_results_are_left_alone() {
    let results = tempfile::tempdir().unwrap();
    let first = calibrate_sarcos(results.path(), &[]);
    let written = contents(results.path());
    let second = calibrate_sarcos(results.path(), &[]);
    assert_eq!((first.code, second.code), (0, 0), "{second:?}");
    assert!(!first.stdout.contains("unchanged"), "{}", first.stdout);
    assert!(second.stdout.contains("unchanged"), "{}", second.stdout);
    assert!(contents(results.path()) == written, "the second run touched the results");
}

#[test]
fn other_results_are_not_overwritten_unless_reported() {
    let results = tempfile::tempdir().unwrap();
    calibrate_sarcos(results.path(), &[]);
    let written = contents(results.path());

    let refused = calibrate_sarcos(results.path(), &["--estimator", "joint"]);
    assert_eq!(refused.refusal(&["--overwrite"]), None);
    assert!(contents(results.path()) == written, "a refused calibration wrote files");

    let reported = calibrate_sarcos(results.path(), &["--estimator", "joint", "--overwrite"]);
    assert_eq!(reported.code, 0, "{reported:?}");
    let joint = Calibration::with(&sarcos(), &["--estimator", "joint"]);
    assert!(contents(results.path())["calibration.json"] == joint.bytes("calibration.json"));
}

fn sarcos() -> PathBuf {
    tree::experiment("sarcos-shoulder").join("session.toml")
}

fn calibrate_sarcos(results: &Path, options: &[&str]) -> Run {
    calibrate_into(results, &sarcos(), options)
}

/// What simulating an experiment writes, in a copy of the project: paths in a session depend on where it lies.
fn simulated_anew(experiment: &Path) -> Contents {
    let project = copied_project(experiment);
    let folder = project.path().join("experiments").join(tree::name(experiment));
    let run = gravcal(["simulate".as_ref(), folder.join("simulation.toml").as_os_str()]);
    assert_eq!(run.code, 0, "{run:?}");
    let made = contents(&folder);
    assert!(["session.toml", "truth.toml"].iter().all(|file| made.contains_key(*file)), "{:?}", made.keys());
    made
}

/// The models and one simulation, laid out as in the project.
fn copied_project(experiment: &Path) -> TempDir {
    let project = tempfile::tempdir().unwrap();
    let simulation = experiment.join("simulation.toml");
    for file in tree::files_below(&tree::root().join("models")).into_iter().chain([simulation]) {
        let copy = project.path().join(file.strip_prefix(tree::root()).unwrap());
        fs::create_dir_all(copy.parent().unwrap()).unwrap();
        fs::copy(&file, copy).unwrap();
    }
    project
}

fn contents(folder: &Path) -> Contents {
    tree::files_below(folder).iter().map(|file| (tree::name(file), fs::read(file).unwrap())).collect()
}
