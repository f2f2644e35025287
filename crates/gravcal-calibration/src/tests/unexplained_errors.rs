//! Readings with errors far beyond their noise, as means of standstills have them: intervals hold, and mistakes are still found.

use gravcal_estimation::LossName;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::{Session, UnexplainedError};
use gravcal_session::simulation::{Disturbance, Simulation};
use gravcal_solvers::LevenbergMarquardt;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_pcg::Pcg64;

use crate::joint::{Signals, State, estimate_jointly};
use crate::result::{EstimatorResult, NoiseSource, UncertaintyResult, UnexplainedResult, Verdict};
use crate::testing::sarcos_shoulder;

/// Noise of a mean, counts.
const MEAN: f64 = 0.08;

fn shoulder() -> Simulation {
    with_noise(MEAN)
}

/// The reference protocol with another noise, counts.
fn with_noise(noise: f64) -> Simulation {
    let mut simulation = sarcos_shoulder();
    simulation.disturbance = Disturbance::noise(vec![noise; 3]);
    simulation
}

/// The shoulder's readings with errors of these standard deviations besides their noise, which are estimated.
fn with_errors(simulation: &Simulation, std: [f64; 3], trial: u64) -> Session {
    let mut session = simulation.session(trial);
    let mut random = Pcg64::seed_from_u64(1000 + trial);
    for (std, reading) in session.poses.iter_mut().flat_map(|pose| std.into_iter().zip(&mut pose.torque)) {
        let error: f64 = random.sample(StandardNormal);
        reading.iter_mut().for_each(|reading| reading.value += std * error);
    }
    session.unexplained = vec![UnexplainedError::Estimated; 3];
    session
}

fn estimate(session: &Session) -> EstimatorResult {
    let solver = LevenbergMarquardt::default();
    estimate_jointly(session, Signals::All, None, &SolveEnvironment::new(&solver, &|_: &str| {})).unwrap()
}

fn errors_in_std(result: &EstimatorResult, truth: &State) -> Vec<f64> {
    let estimated = result.parameters.iter().enumerate().filter(|(_, p)| p.determined && p.held.is_none());
    estimated.map(|(i, p)| (p.value.unwrap() - truth.sensors[i / 4][i % 4]) / p.std.unwrap()).collect()
}

fn sizes(result: &EstimatorResult) -> Vec<UnexplainedResult> {
    result.fit.as_ref().unwrap().joints.iter().map(|joint| joint.unexplained.unwrap()).collect()
}

/// Another noise of the readings than was drawn.
fn stating(mut session: Session, std: f64) -> Session {
    let readings = session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten());
    readings.for_each(|reading| reading.std = Some(std));
    session
}

#[test]
fn errors_of_each_joint_are_found_in_its_own_size() {
    let result = estimate(&with_errors(&shoulder(), [0.4, 2.0, 0.0], 0));
    assert_eq!(result.verdict, Verdict::Determined, "{} {:?}", result.termination, result.notes);
    let sizes = sizes(&result);
    for (size, truth) in sizes.iter().zip([0.4, 2.0]) {
        assert!((size.std / truth - 1.0).abs() < 0.1 && size.estimated, "{sizes:?}");
        assert!((size.times_noise - size.std / MEAN).abs() < 1e-9, "{sizes:?}");
        let share = size.share_of_gravity.unwrap();
        assert!((0.001..0.1).contains(&share) && (share - size.std / size.gravity_std).abs() < 1e-12, "{sizes:?}");
    }
    assert!(sizes[2].std < 0.5 * MEAN, "{sizes:?}");
    let source = match result.uncertainty {
        Some(UncertaintyResult::LargerOfNoiseAndJackknife { source, widened_by: None, .. }) => source,
        other => panic!("{other:?}"),
    };
    assert_eq!(source, NoiseSource::StatedAndUnexplained);
    let fit = result.fit.unwrap();
    assert!((fit.chi_squared / fit.degrees_of_freedom as f64 - 1.0).abs() < 0.01 && fit.p_value.is_none(), "{fit:?}");
}

/// What leaving out poses tells scatters, and the larger of two deviations is too wide where the model is right.
#[test]
fn poses_are_left_out_where_errors_show_alone() {
    let told = |std: [f64; 3], trial: u64| {
        let result = estimate(&with_errors(&shoulder(), std, trial));
        assert_eq!(result.verdict, Verdict::Determined, "{} {:?}", result.termination, result.notes);
        (matches!(result.uncertainty, Some(UncertaintyResult::LargerOfNoiseAndJackknife { .. })), sizes(&result))
    };
    // Half of the sensors of right readings have some error by chance.
    let right: Vec<_> = (0..12).map(|trial| told([0.0; 3], trial)).collect();
    assert!(right.iter().filter(|(_, sizes)| sizes.iter().any(|size| size.std > 0.0)).count() > 6);
    assert!(right.iter().filter(|(left_out, _)| *left_out).count() <= 3, "one of twenty tests, and a few of four");
    assert!((0..4).all(|trial| told([0.0, 0.5 * MEAN, 0.0], trial).0), "half the noise of one of three sensors");
}

/// Errors of positions move torques, too; what they explain is none of the others.
#[test]
fn errors_beside_those_of_positions_are_found_in_their_own_size() {
    for position_std in [1e-6, 0.003, 0.01] {
        let mut simulation = shoulder();
        simulation.disturbance.position_std = vec![position_std; 3];
        let mut session = with_errors(&simulation, [0.4, 2.0, 0.0], 0);
        session.deflection.reading_std = vec![position_std; 3];
        let result = estimate(&session);
        assert_eq!(result.verdict, Verdict::Determined, "{position_std}: {} {:?}", result.termination, result.notes);
        let sizes = sizes(&result);
        for (size, truth) in sizes.iter().zip([0.4, 2.0]) {
            assert!((size.std / truth - 1.0).abs() < 0.15, "{position_std}: {sizes:?}");
        }
        // What noise of positions does to a joint that reads 100 counts a radian is told from such errors by chance alone.
        assert!(sizes[2].std < 0.5 * MEAN.hypot(100.0 * position_std), "{position_std}: {sizes:?}");
        let worst = errors_in_std(&result, &simulation.truth).into_iter().map(f64::abs).fold(0.0, f64::max);
        assert!(worst < 4.5, "{position_std}: {worst}");
    }
}

#[test]
fn errors_are_as_large_as_intervals_say() {
    let simulation = shoulder();
    let trials = (0..30).flat_map(|trial| {
        let result = estimate(&with_errors(&simulation, [0.4, 2.0, 0.1], trial));
        // Tests on residuals may name something in one right session of a hundred: of these draws they do in one, a pull, and intervals hold all the same.
        let expected = if trial == 21 { Verdict::PartlyDetermined } else { Verdict::Determined };
        assert_eq!(result.verdict, expected, "{trial}: {} {:?}", result.termination, result.notes);
        errors_in_std(&result, &simulation.truth)
    });
    let errors: Vec<f64> = trials.collect();
    let rms = (errors.iter().map(|z| z * z).sum::<f64>() / errors.len() as f64).sqrt();
    let covered = errors.iter().filter(|z| z.abs() < 1.96).count() as f64 / errors.len() as f64;
    assert!(errors.len() >= 300 && (0.88..1.12).contains(&rms) && covered > 0.92, "{} {rms} {covered}", errors.len());
}

/// To the bit, whether errors are looked for or not.
#[test]
fn noise_that_explains_the_readings_leaves_the_answer_as_it_was() {
    let session = stating(with_errors(&shoulder(), [0.0; 3], 1), 1.2 * MEAN);
    let (looked, not) = (estimate(&session), estimate(&Session { unexplained: Vec::new(), ..session.clone() }));
    assert!(sizes(&looked).iter().all(|size| size.std == 0.0 && size.share_of_gravity == Some(0.0)));
    let reported = |result: &EstimatorResult| {
        let EstimatorResult { verdict, parameters, covariance, termination, .. } = result;
        format!("{verdict:?} {parameters:?} {covariance:?} {termination}")
    };
    assert_eq!(reported(&looked), reported(&not));
    assert_eq!((looked.uncertainty, looked.fit.unwrap().p_value), (not.uncertainty, not.fit.unwrap().p_value));
}

/// Means of longer dwells have less noise, and errors that are none of noise stay: nothing is refused, and nothing wider.
#[test]
fn longer_dwells_are_neither_refused_nor_wider() {
    let mut widths = Vec::new();
    for noise in [0.8, 0.08, 0.008, 0.0008] {
        let simulation = with_noise(noise);
        let result = estimate(&with_errors(&simulation, [0.5; 3], 3));
        assert_eq!(result.verdict, Verdict::Determined, "{noise}: {} {:?}", result.termination, result.notes);
        widths.push(result.parameters.iter().filter_map(|p| p.std.filter(|std| *std > 0.0)).collect::<Vec<_>>());
    }
    for (longer, shorter) in widths.iter().skip(1).zip(&widths) {
        assert_eq!(longer.len(), shorter.len());
        assert!(longer.iter().zip(shorter).all(|(longer, shorter)| *longer < 1.03 * shorter), "{widths:?}");
    }
}

#[test]
fn a_stated_size_weighs_and_is_held_against_the_residuals() {
    let mut session = with_errors(&shoulder(), [2.0; 3], 4);
    session.unexplained = vec![UnexplainedError::Stated { std: 2.0 }; 3];
    let result = estimate(&session);
    assert_eq!((result.verdict, sizes(&result)[1].std), (Verdict::Determined, 2.0), "{:?}", result.notes);
    let fit = result.fit.unwrap();
    assert!(fit.p_value.unwrap() > 1e-3, "{:?}", fit.p_value);
    session.unexplained = vec![UnexplainedError::Stated { std: 0.5 }; 3];
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Failed, "four times as large as stated");
    assert!(result.termination.contains("4 times the stated noise"), "{}", result.termination);
}

#[test]
fn outliers_are_no_errors_of_all_readings_under_a_loss() {
    let mut session = with_errors(&shoulder(), [1.0; 3], 5);
    for reading in session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).skip(7).step_by(20) {
        reading.value += 60.0;
    }
    session.loss = LossName::Tukey.efficient();
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Determined, "{} {:?}", result.termination, result.notes);
    assert!(sizes(&result).iter().all(|size| (size.std - 1.0).abs() < 0.25), "{:?}", sizes(&result));
    let errors = errors_in_std(&result, &shoulder().truth);
    assert!(errors.iter().all(|z| z.abs() < 4.5), "{errors:?}");
}

fn assert_names(result: &EstimatorResult, names: &str) {
    assert_eq!(result.verdict, Verdict::Failed, "{:?} {:?}", result.termination, result.notes);
    assert!(result.termination.contains(names), "{} {:?}", result.termination, result.notes);
    assert!(result.parameters.iter().all(|reported| reported.value.is_none() || reported.held.is_some()));
}

#[test]
fn a_reversed_sensor_is_named() {
    let mut simulation = shoulder();
    simulation.truth.sensors[1][0] *= -1.0;
    assert_names(&estimate(&with_errors(&simulation, [0.5; 3], 6)), "reversed torque sensor: joint2");
}

#[test]
fn swapped_columns_are_named() {
    let mut session = with_errors(&shoulder(), [0.5; 3], 7);
    session.poses.iter_mut().for_each(|pose| pose.torque.swap(1, 2));
    assert_names(&estimate(&session), "swapped torque columns: joint2 and joint3");
}

/// A ninth of the bare poses: their errors are 4 to 6 % of what gravity makes the joints read.
#[test]
fn loads_on_some_wrong_poses_are_a_warning_with_the_joints_named() {
    let mut session = with_errors(&shoulder(), [0.5; 3], 8);
    let bare = session.poses.iter_mut().filter(|pose| pose.load.is_none()).step_by(9);
    bare.for_each(|pose| pose.load = Some(0));
    let result = estimate(&session);
    let warning = "Errors that the noise does not explain, beside what gravity makes the sensor read: joint2 (";
    assert!(result.notes.iter().any(|note| note.starts_with(warning)), "{:?}", result.notes);
}
