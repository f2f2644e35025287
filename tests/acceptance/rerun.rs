//! `--rerun`: a calibration to look at in Rerun.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::program::{NOT_SHOWN, Run, gravcal};
use crate::tree;

#[path = "../../crates/gravcal-rerun/src/read_back.rs"]
#[allow(dead_code)]
mod read_back;

use read_back::ReadBack;

/// Calibrates the Sarcos shoulder into `results` of a folder, with further options.
fn calibrate(folder: &Path, options: &[&str]) -> Run {
    let session = tree::root().join("experiments/sarcos-shoulder/session.toml");
    let (session, results) = (session.display().to_string(), folder.join("results").display().to_string());
    gravcal(["calibrate", &session, "--quiet", "--output", &results].into_iter().chain(options.iter().copied()))
}

fn names_in(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_recording_is_written_and_two_runs_say_the_same() {
    let folder = TempDir::new().unwrap();
    let recorded = ["a.rrd", "b.rrd"].map(|name| {
        let path = folder.path().join(name);
        let run = calibrate(folder.path(), &["--rerun", &path.display().to_string()]);
        assert!(run.code == 0 && run.stdout.contains(&format!("Rerun recording in {}", path.display())), "{run:?}");
        ReadBack::of(&fs::read(path).unwrap())
    });
    assert_eq!(names_in(folder.path()), ["a.rrd", "b.rrd", "results"]);

    let [a, b] = recorded.each_ref().map(ReadBack::contents);
    assert_eq!(a.len(), b.len());
    assert!(a.iter().zip(&b).all(|(a, b)| a == b));
    let rows = recorded[0].rows();
    for path in ["/verdict", "/arm/link1", "/gravity/joint", "/sweeps/sequential", "/residuals/in_std/joint/joint3"] {
        assert!(rows.contains_key(path), "{path} is not among {:?}", rows.keys());
    }
}

#[test]
fn a_file_that_cannot_be_written_is_reported_before_the_solve() {
    let folder = TempDir::new().unwrap();
    let there = folder.path().join("there.rrd");
    fs::write(&there, "mine").unwrap();
    for (path, reported) in [
        (folder.path().join("absent/a.rrd"), "there is no such folder"),
        (folder.path().to_owned(), "this is a folder"),
        (there.clone(), "--overwrite replaces it"),
    ] {
        let run = calibrate(folder.path(), &["--rerun", &path.display().to_string()]);
        let fault = run.refusal(&[reported, &path.display().to_string()]);
        assert_eq!(fault, None);
        assert_eq!(names_in(folder.path()), ["there.rrd"]);
    }
    assert_eq!(fs::read_to_string(&there).unwrap(), "mine");
    let run = calibrate(folder.path(), &["--overwrite", "--rerun", &there.display().to_string()]);
    assert_eq!(run.code, 0, "{run:?}");
    assert_ne!(fs::read(&there).unwrap(), b"mine");
}

#[test]
fn a_viewer_that_is_not_there_costs_no_result() {
    let folder = TempDir::new().unwrap();
    // Nobody listens at a port below 1024 that is given to no service.
    let run = calibrate(folder.path(), &["--rerun-connect=rerun+http://127.0.0.1:4/proxy"]);
    // Nothing is bad about the input.
    assert_eq!(run.code, NOT_SHOWN, "{run:?}");
    for reported in ["no Rerun viewer", "127.0.0.1:4", "results of the calibration are written"] {
        assert!(run.stderr.contains(reported), "{run:?}");
    }
    assert_eq!(
        names_in(&folder.path().join("results")),
        ["calibration.json", "report.html", "table.txt", "timing.json"]
    );

    let other = TempDir::new().unwrap();
    let run = calibrate(other.path(), &["--rerun-connect=somewhere"]);
    assert_eq!(run.refusal(&["`somewhere` is no address of a Rerun viewer"]), None);
    assert!(names_in(other.path()).is_empty());
}

#[test]
fn scripts_read_json_alone() {
    let folder = TempDir::new().unwrap();
    let session = tree::root().join("experiments/sarcos-shoulder/session.toml").display().to_string();
    let [results, shown] = ["results", "a.rrd"].map(|name| folder.path().join(name).display().to_string());
    let run = gravcal(["calibrate", &session, "--json", "--output", &results, "--rerun", &shown]);
    assert!(run.code == 0 && serde_json::from_str::<serde_json::Value>(&run.stdout).is_ok(), "{run:?}");
    assert!(!ReadBack::of(&fs::read(shown).unwrap()).rows().is_empty());
}
