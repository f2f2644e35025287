//! The answer does not depend on the method, and a session's options reach it.

use std::fs;

use crate::answer::Estimator;
use crate::program::Calibration;
use crate::small_session::{calibrate, small_session};
use crate::tree;

/// Methods that take the joint problem of every session.
const METHODS: [&str; 4] = ["levenberg-marquardt", "gauss-newton", "dogleg", "variable-projection"];
/// How far their answers may lie apart, in standard deviations.
const AGREEMENT: f64 = 1e-6;

#[test]
fn every_method_gives_the_same_answer() {
    for experiment in ["sarcos-shoulder", "seven-joints-tilted"] {
        let session = tree::experiment(experiment).join("session.toml");
        let [first, others @ ..] = METHODS.map(|solver| {
            let calibration = Calibration::with(&session, &["--estimator", "joint", "--solver", solver]);
            assert_eq!(calibration.run.code, 0, "{experiment} by {solver}: {:?}", calibration.run);
            calibration.estimator("joint")
        });
        for (other, solver) in others.iter().zip(&METHODS[1..]) {
            let apart = largest_difference(&first, other);
            assert!(apart < AGREEMENT, "{experiment} by {solver}: {apart:e} standard deviations");
        }
    }
}

/// Largest difference of a parameter or a component of gravity, in standard deviations.
fn largest_difference(one: &Estimator, other: &Estimator) -> f64 {
    let gravity = |estimator: &Estimator| {
        let gravity = estimator.gravity.as_ref().unwrap();
        gravity.vector_m_per_s2.into_iter().zip(gravity.std_m_per_s2).collect::<Vec<_>>()
    };
    let parameters =
        |estimator: &Estimator| estimator.estimated().map(|p| (p.value.unwrap(), p.std.unwrap())).collect::<Vec<_>>();
    let numbers = |estimator: &Estimator| [gravity(estimator), parameters(estimator)].concat();
    let pairs = numbers(one).into_iter().zip(numbers(other));
    pairs.map(|((a, std), (b, _))| (a - b).abs() / std).fold(0.0, f64::max)
}

#[test]
fn the_sequential_steps_run_by_every_method() {
    let session = tree::experiment("sarcos-shoulder").join("session.toml");
    for solver in METHODS {
        let calibration = Calibration::with(&session, &["--solver", solver]);
        assert_eq!(calibration.run.code, 0, "{solver}: {:?}", calibration.run);
        assert_eq!(calibration.estimator("sequential").without_value().len(), 2, "{solver}");
    }
}

#[test]
fn a_loss_is_reported_to_a_method_that_cannot_take_it_before_anything_is_solved() {
    let folder = small_session();
    let session = folder.path().join("session.toml");
    let text = fs::read_to_string(&session).unwrap();
    let robust = text.replace("[gravity]", "[loss]\nkind = \"huber\"\n\n[gravity]");
    fs::write(&session, format!("solver = \"variable-projection\"\n{robust}")).unwrap();
    let refused = calibrate(folder.path());
    assert_eq!(refused.refusal(&["session.toml:1: solver: variable-projection cannot take", "robust losses"]), None);
}

#[test]
fn options_of_the_session_reach_the_method_that_it_names() {
    let folder = small_session();
    let session = folder.path().join("session.toml");
    let text = fs::read_to_string(&session).unwrap();
    let options = "[solver]\nname = \"levenberg-marquardt\"\nmax_iterations = 1\n\n[gravity]";
    fs::write(&session, text.replace("[gravity]", options)).unwrap();

    let limited = Calibration::with(&session, &["--estimator", "joint"]);
    assert_eq!(limited.run.code, 4, "{:?}", limited.run);
    let joint = limited.estimator("joint");
    assert_eq!((joint.termination.as_str(), joint.trace.len()), ("not converged after 1 iteration", 2));
    let chosen = limited.answer().provenance.options;
    assert_eq!(chosen.solver, "levenberg-marquardt");
    assert_eq!(chosen.solver_options["max_iterations"].as_integer(), Some(1));

    // Named again on the command line they still apply; with another method they do not.
    let named = Calibration::with(&session, &["--estimator", "joint", "--solver", "levenberg-marquardt"]);
    assert_eq!(named.run.code, 4, "{:?}", named.run);
    let other = Calibration::with(&session, &["--estimator", "joint", "--solver", "dogleg"]);
    assert_eq!(other.run.code, 0, "{:?}", other.run);
    assert!(other.answer().provenance.options.solver_options.is_empty());
}

#[test]
fn the_iterates_of_the_joint_solve_are_reported() {
    let trace = Calibration::of(&tree::experiment("sarcos-shoulder").join("session.toml")).estimator("joint").trace;
    assert!(trace.len() > 3);
    assert!(trace.first().unwrap().cost > trace.last().unwrap().cost);
    assert!(trace.last().unwrap().largest_cosine < 1e-7);
}
