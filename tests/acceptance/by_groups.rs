//! The estimators that take readings group by group, as a user meets them.

use std::fs;

use crate::answer::Estimator;
use crate::program::Calibration;
use crate::small_session::small_session;
use crate::tree;

/// Each with the joint estimator that reads the same, and how far apart they may be in standard deviations.
const PAIRS: [(&str, &str, f64); 2] =
    [("sequential-with-covariance", "joint-paper-signals", 0.05), ("recursive", "joint", 0.5)];
/// Methods that take the joint problem of every session.
const METHODS: [&str; 4] = ["levenberg-marquardt", "gauss-newton", "dogleg", "variable-projection"];

#[test]
fn they_answer_as_the_joint_estimators_do_by_every_method() {
    let session = tree::experiment("sarcos-shoulder").join("session.toml");
    for solver in METHODS {
        for (grouped, jointly, most) in PAIRS {
            let options = ["--solver", solver, "--estimator", grouped, "--estimator", jointly];
            let calibration = Calibration::with(&session, &options);
            assert_eq!(calibration.run.code, 0, "{grouped} by {solver}: {:?}", calibration.run);
            let [one, other] = [grouped, jointly].map(|name| calibration.estimator(name));
            assert_eq!((one.verdict.as_str(), one.undetermined.len()), ("determined", other.undetermined.len()));
            let apart = largest_difference(&one, &other);
            assert!(apart < most && apart > 0.0, "{grouped} by {solver}: {apart} standard deviations");
            assert!(calibration.run.stdout.contains(grouped), "{}", calibration.run.stdout);
        }
    }
}

/// Largest difference of a parameter, in standard deviations.
fn largest_difference(one: &Estimator, other: &Estimator) -> f64 {
    let pairs = one.estimated().zip(other.estimated());
    pairs.map(|(a, b)| (a.value.unwrap() - b.value.unwrap()).abs() / b.std.unwrap()).fold(0.0, f64::max)
}

#[test]
fn what_goes_against_it_is_reported_before_anything_is_solved() {
    let folder = small_session();
    let session = folder.path().join("session.toml");
    let text = fs::read_to_string(&session).unwrap();
    let robust = text.replace("[gravity]", "[loss]\nkind = \"huber\"\n\n[gravity]");
    fs::write(&session, format!("estimators = [\"recursive\"]\n{robust}")).unwrap();
    let refused = Calibration::of(&session).run;
    let reported =
        ["session.toml:1: estimators: `recursive` takes readings group by group", "[loss]", "choose `joint`"];
    assert_eq!(refused.refusal(&reported), None);

    let scattered = tree::experiment("seven-joints-tilted").join("session.toml");
    for estimator in ["sequential-with-covariance", "joint-paper-signals"] {
        let refused = Calibration::with(&scattered, &["--estimator", estimator]).run;
        assert_eq!(refused.refusal(&[&format!("`{estimator}` reads what the paper's steps read"), "no sweeps"]), None);
    }
}
