//! `--rerun` in a program that is built without it.

use tempfile::TempDir;

use crate::program::gravcal;
use crate::tree;

#[test]
fn what_cannot_be_shown_is_refused_with_the_build_that_can() {
    let session = tree::root().join("experiments/sarcos-shoulder/session.toml").display().to_string();
    for option in ["--rerun=shown.rrd", "--rerun-connect", "--rerun-spawn"] {
        let folder = TempDir::new().unwrap();
        let results = folder.path().join("results");
        let run = gravcal(["calibrate", &session, "--output", &results.display().to_string(), option]);
        let name = option.split('=').next().unwrap();
        let reported =
            [&format!("error: {name}: this program is built without Rerun"), "cargo build --release --features rerun"];
        assert_eq!(run.refusal(&reported), None);
        assert!(!results.exists(), "{option}");
    }
}
