//! Losses and uncertainties of the joint estimator on the reference protocol.

use gravcal_estimation::{Loss, LossName};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::{Session, UncertaintyChoice};
use gravcal_solvers::LevenbergMarquardt;
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

use crate::joint::{Signals, State, estimate_jointly};
use crate::result::{EstimatorResult, UncertaintyResult, Verdict};
use crate::testing::sarcos_shoulder;

fn estimate(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap()
}

/// Errors of the estimated sensor parameters in their own standard deviations.
fn errors_in_std(result: &EstimatorResult, truth: &State) -> Vec<f64> {
    let estimated = result.parameters.iter().enumerate().filter(|(_, p)| p.determined && p.held.is_none());
    estimated.map(|(i, p)| (p.value.unwrap() - truth.sensors[i / 4][i % 4]) / p.std.unwrap()).collect()
}

/// Every twentieth reading is off by a lot, in one direction.
fn with_outliers(trial: u64) -> Session {
    let mut session = sarcos_shoulder().session(trial);
    for (k, reading) in session.poses.iter_mut().flat_map(|p| p.torque.iter_mut().flatten()).enumerate() {
        if k % 20 == 7 {
            reading.value += 60.0;
        }
    }
    session
}

#[test]
fn losses_find_the_truth_among_outliers_and_name_them() {
    let truth = sarcos_shoulder().truth;
    let mut session = with_outliers(0);
    assert_eq!(estimate(&session).verdict, Verdict::Failed, "by least squares the model contradicts the readings");
    let spoilt = session.poses.iter().flat_map(|p| p.torque.iter().flatten()).count().div_ceil(20);
    for name in &LossName::ALL[1..] {
        session.loss = name.efficient();
        let result = estimate(&session);
        assert_eq!(result.verdict, Verdict::Determined, "{name}");
        let errors = errors_in_std(&result, &truth);
        assert!(errors.iter().all(|e| e.abs() < 4.5), "{name}: {errors:?}");
        let far: Vec<_> = result.outliers.iter().filter(|o| o.residual_in_std.abs() > 30.0).collect();
        assert!(far.len().abs_diff(spoilt) <= 1, "{name}: {} of {spoilt}", far.len());
        assert!(result.outliers[..far.len()].iter().all(|o| o.residual_in_std < -30.0 && o.weight < 0.05), "{name}");
        assert_eq!(result.loss.map(|loss| loss.kind), Some(name.as_str()));
        let fit = result.fit.unwrap();
        assert!(fit.p_value.unwrap() > 1e-3 && (fit.median_ratio.unwrap() - 1.0).abs() < 0.15, "{name}: {fit:?}");
        assert!(result.notes.iter().any(|n| n.contains("readings count less than half. The worst: sweep-")), "{name}");
    }
}

#[test]
fn noise_that_is_not_stated_is_found_among_outliers() {
    let mut session = with_outliers(1);
    session.poses.iter_mut().flat_map(|p| p.torque.iter_mut().flatten()).for_each(|reading| reading.std = None);
    for name in [LossName::Huber, LossName::Tukey] {
        session.loss = name.efficient();
        let result = estimate(&session);
        assert_eq!(result.verdict, Verdict::Determined, "{name}");
        let fit = result.fit.as_ref().unwrap();
        assert!(fit.joints.iter().all(|j| j.noise_estimated && (j.noise_std - 0.8).abs() < 0.12), "{name}: {fit:?}");
        assert!(errors_in_std(&result, &sarcos_shoulder().truth).iter().all(|e| e.abs() < 4.5), "{name}");
    }
}

/// A model that is wrong for every reading is not taken for outliers.
#[test]
fn a_loss_does_not_hide_a_model_that_contradicts_the_readings() {
    let mut session = sarcos_shoulder().session(0);
    session.loss = LossName::Huber.efficient();
    for reading in session.poses.iter_mut().flat_map(|p| p.torque.iter_mut().flatten()) {
        reading.std = Some(0.1); // an eighth of what it is
    }
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Failed);
    assert!(result.notes.iter().any(|note| note.contains("need no widening")), "{:?}", result.notes);
}

/// Neighbouring poses share an error, as those of a model do.
fn with_shared_errors(trial: u64) -> Session {
    let mut session = sarcos_shoulder().session(trial);
    let mut random = Pcg64::new(99, u128::from(trial));
    for block in session.poses.chunks_mut(11) {
        for joint in 0..3 {
            let shared: f64 = StandardNormal.sample(&mut random);
            block.iter_mut().filter_map(|pose| pose.torque[joint].as_mut()).for_each(|r| r.value += 0.8 * shared);
        }
    }
    session
}

/// Mean square of the errors in their own standard deviations: 1 where these are right.
#[test]
fn blocks_of_poses_tell_the_errors_that_poses_share() {
    const TRIALS: u64 = 30;
    let truth = sarcos_shoulder().truth;
    let mean_square = |choice: UncertaintyChoice| {
        let errors: Vec<f64> = (0..TRIALS)
            .flat_map(|trial| {
                let session = Session { uncertainty: choice, ..with_shared_errors(trial) };
                errors_in_std(&estimate(&session), &truth)
            })
            .collect();
        errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64
    };
    let sandwich = mean_square(UncertaintyChoice::Sandwich { block_poses: 11 });
    // Errors over a standard deviation known with ν degrees of freedom have the mean square ν/(ν − 2).
    assert!((0.7..1.8).contains(&sandwich), "{sandwich}");
}

#[test]
fn what_is_chosen_is_what_is_reported() {
    let session = |uncertainty| Session { uncertainty, ..with_shared_errors(0) };
    let noise = estimate(&session(UncertaintyChoice::Noise));
    let Some(UncertaintyResult::LargerOfNoiseAndJackknife { widened_by: Some(widened), .. }) = noise.uncertainty else {
        panic!("{noise:?}")
    };
    assert!((1.2..1.6).contains(&widened), "{widened}");
    let sandwich = estimate(&session(UncertaintyChoice::Sandwich { block_poses: 11 }));
    assert_eq!(sandwich.uncertainty, Some(UncertaintyResult::Sandwich { blocks: 37, block_poses: 11 }));
    let bootstrap = estimate(&session(UncertaintyChoice::Bootstrap { block_poses: 11, replicates: 100, seed: 1 }));
    let Some(UncertaintyResult::Bootstrap { blocks: 37, replicates, not_converged, undetermined, .. }) =
        bootstrap.uncertainty
    else {
        panic!("{bootstrap:?}")
    };
    assert_eq!((replicates, not_converged, undetermined), (100, 0, 0));
    for (a, b) in sandwich.parameters.iter().zip(&bootstrap.parameters) {
        assert_eq!(a.value, b.value);
        if let (true, None, Some(a), Some(b)) = (a.determined, &a.held, a.std, b.std) {
            assert!((0.5..2.0).contains(&(a / b)), "{a} {b}");
        }
    }
    let variance = bootstrap.covariance.matrix[3][3];
    assert_eq!(bootstrap.covariance.order[3], "joint1.torque_gain");
    assert!((variance.sqrt() / bootstrap.parameters[0].std.unwrap() - 1.0).abs() < 1e-9);
}

#[test]
fn a_bootstrap_gives_the_same_bits_on_one_thread_and_on_two() {
    let choice = UncertaintyChoice::Bootstrap { block_poses: 13, replicates: 100, seed: 3 };
    let session = Session { uncertainty: choice, loss: Loss::Huber(2.0), ..with_shared_errors(2) };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| format!("{:?}", estimate(&session)))
    };
    assert_eq!(run(1), run(2));
}

/// A load of two grams hardly tells the common scale of the torque gains, however little noise there is.
#[test]
fn a_combination_that_is_hardly_known_is_named() {
    let mut simulation = sarcos_shoulder();
    simulation.template.loads.iter_mut().for_each(|load| load.mass = 0.002);
    simulation.disturbance.torque_std = vec![1e-5; 3];
    let session = simulation.session(0);
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Determined, "{result:?}");
    let [weak] = result.weak.as_slice() else { panic!("{:?}", result.weak) };
    let names: Vec<&str> = weak.terms.iter().map(|(name, _, _)| name.as_str()).collect();
    assert_eq!(names, ["joint1.torque_gain", "joint2.torque_gain", "joint3.torque_gain"]);
    assert!(weak.combination.starts_with("1.00 joint1.torque_gain + 0."), "{}", weak.combination);
    assert!(weak.times_worse > 1000.0);
    assert!(result.notes.iter().any(|note| note.contains(&weak.combination)));
    assert!(estimate(&sarcos_shoulder().session(0)).weak.is_empty());
}

#[test]
fn choices_of_frame_are_reported_with_their_reasons() {
    let mut session = sarcos_shoulder().session(0);
    session.poses.retain(|pose| pose.load.is_none());
    let held = estimate(&session).held;
    let reported: Vec<(&str, &str)> = held.iter().map(|h| (h.name.as_str(), h.why.as_str())).collect();
    assert!(reported.contains(&("joint1.position_offset", "it defines the base frame")), "{reported:?}");
    assert!(reported.contains(&("joint3.position_offset", "a choice of the last link's frame")), "{reported:?}");
    assert_eq!(held.len(), 2, "the common scale of torque gains is open, and nothing is held for it");
}
