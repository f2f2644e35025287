//! The estimators that take readings group by group: where theory says so they agree with the joint ones, and where they
//! cannot be used they say it.

use std::sync::atomic::{AtomicUsize, Ordering};

use gravcal_estimation::{IterationRecord, Loss, LossName};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::EstimatorName;
use gravcal_robot_model::session::{Session, UncertaintyChoice};
use gravcal_session::simulation::Simulation;
use gravcal_solvers::LevenbergMarquardt;

use crate::calibrate::{UnsuitableChoice, calibrate, check_choice};
use crate::result::{EstimatorResult, Verdict};
use crate::testing::{sarcos_shoulder, shared_session};

use EstimatorName::{Joint, JointPaperSignals, Recursive, SequentialWithCovariance};

/// Each with the joint estimator that reads the same.
const PAIRS: [[EstimatorName; 2]; 2] = [[SequentialWithCovariance, JointPaperSignals], [Recursive, Joint]];

fn results<const N: usize>(session: &Session, names: [EstimatorName; N]) -> [EstimatorResult; N] {
    let solver = LevenbergMarquardt::default();
    let results = calibrate(session, &names, &SolveEnvironment::new(&solver, &|_: &str| {}));
    results.try_into().unwrap()
}

/// The reference protocol with another noise, which the readings state.
fn with_noise(torque_std: f64) -> Simulation {
    let mut simulation = sarcos_shoulder();
    simulation.disturbance.torque_std = vec![torque_std; 3];
    simulation
}

/// Largest difference of gravity or a parameter, in standard deviations of the second.
fn apart(one: &EstimatorResult, other: &EstimatorResult) -> f64 {
    let parameters = one.parameters.iter().zip(&other.parameters).filter(|(_, other)| other.held.is_none());
    let parameters = parameters.map(|(one, other)| (one.value.unwrap(), other.value.unwrap(), other.std.unwrap()));
    let [one, other] = [one, other].map(|result| result.gravity.as_ref().unwrap());
    let gravity = (0..3).map(|i| (one.vector_m_per_s2[i], other.vector_m_per_s2[i], other.std_m_per_s2[i]));
    parameters.chain(gravity).map(|(one, other, std)| (one - other).abs() / std).fold(0.0, f64::max)
}

/// The difference is of second order: in standard deviations it falls with the noise.
#[test]
fn they_equal_the_joint_estimates_where_noise_is_small() {
    for pair in PAIRS {
        let departure = |noise: f64| {
            let [grouped, jointly] = results(&with_noise(noise).session(2), pair);
            assert_eq!(grouped.verdict, Verdict::Determined, "{}", pair[0]);
            apart(&grouped, &jointly)
        };
        let (real, small, tiny) = (departure(0.8), departure(0.08), departure(0.008));
        assert!(real < 1.0 && small < 0.3 * real + 1e-4 && tiny < 3e-3, "{}: {real} {small} {tiny}", pair[0]);
    }
}

#[test]
fn their_standard_deviations_are_those_of_the_joint_estimates() {
    for pair in PAIRS {
        let [grouped, jointly] = results(&with_noise(0.08).session(1), pair);
        for (one, other) in grouped.parameters.iter().zip(&jointly.parameters).filter(|(one, _)| one.held.is_none()) {
            let stds = one.std.zip(other.std);
            assert!(stds.is_none_or(|(one, other)| (one / other - 1.0).abs() < 0.01), "{}: {stds:?}", one.name);
        }
        assert_eq!(grouped.covariance.order, jointly.covariance.order);
    }
}

/// Loaded poses first: other readings begin, and others are linearized where they come.
#[test]
fn the_order_of_the_poses_matters_to_second_order_only() {
    let departure = |noise: f64| {
        let session = with_noise(noise).session(3);
        let mut reversed = session.clone();
        reversed.poses.reverse();
        let [[forward], [backward]] = [&session, &reversed].map(|session| results(session, [Recursive]));
        assert_ne!(forward.termination, backward.termination, "as many poses began");
        apart(&backward, &forward)
    };
    let (real, small) = (departure(0.8), departure(0.08));
    assert!(real < 1.0 && real > 1e-6 && small < 0.3 * real, "{real} {small}");
}

#[test]
fn what_the_readings_leave_open_is_reported_as_by_the_joint_estimates() {
    let mut session = sarcos_shoulder().session(0);
    session.poses.retain(|pose| pose.load.is_none());
    for pair in PAIRS {
        let reported = results(&session, pair).map(|result| {
            let combinations: Vec<String> = result.undetermined.iter().map(|u| u.combination.clone()).collect();
            (result.verdict, combinations, result.gravity.is_some())
        });
        assert_eq!(reported[0], reported[1], "{}", pair[0]);
        assert!(reported[0].1.len() > 1, "{reported:?}");
    }
}

/// Standing joints that tremble seem to tell a little of their gains and offsets, step by step.
#[test]
fn joints_that_tremble_lead_no_step_astray() {
    let mut simulation = sarcos_shoulder();
    simulation.disturbance.deflection.pose_std = 2e-3;
    simulation.disturbance.deflection.seen = true;
    for trial in 0..3 {
        let [grouped, jointly] = results(&simulation.session(trial), PAIRS[0]);
        let apart = apart(&grouped, &jointly);
        assert!(apart < 0.2, "{trial}: {apart}");
    }
}

#[test]
fn noise_that_no_reading_states_is_estimated() {
    let mut session = sarcos_shoulder().session(0);
    for reading in session.poses.iter_mut().flat_map(|p| p.torque.iter_mut().flatten()) {
        reading.std = None;
    }
    let [result] = results(&session, [Recursive]);
    assert_eq!(result.verdict, Verdict::Determined);
    assert!(result.fit.unwrap().joints.iter().all(|j| j.noise_estimated && (j.noise_std - 0.8).abs() < 0.1));
}

#[test]
fn what_needs_all_readings_at_once_is_refused_by_name() {
    let session = sarcos_shoulder().session(0);
    let solver = LevenbergMarquardt::default();
    let refused = |change: fn(&mut Session), named: &str| {
        let mut changed = session.clone();
        change(&mut changed);
        assert_eq!(check_choice(&changed, &[Joint], &solver), Ok(()), "{named}");
        for estimator in [SequentialWithCovariance, Recursive] {
            let error = check_choice(&changed, &[Joint, estimator], &solver).unwrap_err();
            assert!(
                matches!(error, UnsuitableChoice::NotByGroups { estimator: reported, .. } if reported == estimator)
            );
            let reported = error.to_string();
            assert!(reported.starts_with(&format!("`{estimator}`")) && reported.contains(named), "{reported}");
        }
    };
    refused(|session| session.loss = LossName::Huber.efficient(), "[loss]");
    refused(|session| session.uncertainty = UncertaintyChoice::Sandwich { block_poses: 10 }, "[uncertainty]");
    refused(|session| session.deflection.reading_std = vec![1e-3; 3], "`position`");
    assert_eq!(session.loss, Loss::None);
    assert_eq!(check_choice(&session, &EstimatorName::ALL, &solver), Ok(()));

    let mut no_sweeps = session.clone();
    no_sweeps.poses = session.poses.iter().step_by(12).cloned().collect();
    for estimator in [SequentialWithCovariance, JointPaperSignals] {
        let error = check_choice(&no_sweeps, &[estimator], &solver).unwrap_err();
        assert_eq!(error, UnsuitableChoice::NoSweeps(estimator));
    }
    assert_eq!(check_choice(&no_sweeps, &[Recursive], &solver), Ok(()));
}

/// A session whose noise is stated too small is tried from other starts, none of which the steps are to wander from.
#[test]
fn other_starts_are_no_work_without_end() {
    let Some(mut session) = shared_session("sequential-with-covariance-slow") else { return };
    for reading in session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()) {
        reading.std = Some(0.025); // half of what it is
    }
    let iterations = AtomicUsize::new(0);
    let count = |_: &IterationRecord| {
        iterations.fetch_add(1, Ordering::Relaxed);
    };
    let (solver, silent) = (LevenbergMarquardt::default(), |_: &str| {});
    let environment = SolveEnvironment::new(&solver, &silent).observed_by(&count);
    let result = calibrate(&session, &[SequentialWithCovariance], &environment).remove(0);
    assert_eq!(result.verdict, Verdict::PartlyDetermined, "such a misfit is told");
    let iterations = iterations.into_inner();
    assert!(iterations < 5000, "{iterations}");
}

#[test]
fn same_bits_on_one_thread_and_on_two() {
    let session = sarcos_shoulder().session(5);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| format!("{:?}", results(&session, [SequentialWithCovariance, Recursive])))
    };
    assert_eq!(run(1), run(2));
}
