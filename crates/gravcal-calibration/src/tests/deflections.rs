//! Unknown positions: what each model leaves known (last table of section 4 of the estimation model), and that modelling
//! deflection finds the truth.

use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::{Deflection, Session};
use gravcal_session::simulation::Simulation;
use gravcal_solvers::{LevenbergMarquardt, VariableProjection};

use crate::joint::{self, Signals, Solved, State};
use crate::result::{EstimatorResult, ParameterResult, Verdict};
use crate::testing::sarcos_shoulder;
use crate::testing::sensor_models::estimate_by;

/// So wide a prior, rad, that it says nothing.
const FREE: f64 = 1.0;

/// Standard deviations at the truth of the reference protocol: of gravity's components, torque gains and offset of joint 2.
fn deviations(simulation: &Simulation, session: &Session, signals: Signals) -> Vec<f64> {
    let built = joint::build_problem(session, &joint::select(session, signals), &simulation.truth).unwrap();
    let solved = Solved::at_start(built).unwrap();
    let gravity = solved.gravity_covariance();
    let gains = (0..3).map(|joint| solved.sensor_std(joint, SensorParameter::TorqueGain));
    (0..3)
        .map(|i| gravity[4 * i].sqrt())
        .chain(gains)
        .chain([solved.sensor_std(1, SensorParameter::PositionOffset)])
        .collect()
}

/// The same as multiples of those without deflection.
fn ratios(deflection: Deflection, signals: Signals) -> Vec<f64> {
    let simulation = sarcos_shoulder();
    let mut session = simulation.session(0);
    let without = deviations(&simulation, &session, signals);
    session.deflection = deflection;
    let with = deviations(&simulation, &session, signals);
    with.iter().zip(&without).map(|(with, without)| with / without).collect()
}

fn hold(std: f64) -> Deflection {
    Deflection { hold_std: Some(std), ..Deflection::default() }
}

fn pose(std: f64) -> Deflection {
    Deflection { pose_std: Some(std), ..Deflection::default() }
}

fn every_joint(std: f64) -> Deflection {
    Deflection { reading_std: vec![std; 3], ..Deflection::default() }
}

#[track_caller]
fn assert_between(ratios: &[f64], low: f64, high: f64) {
    assert!(ratios.iter().all(|ratio| (low..high).contains(ratio)), "{ratios:?}");
}

/// A hundred times worse than without deflection: the paper's signals alone do not tell deflection from what is wanted.
#[test]
fn without_a_prior_the_papers_signals_know_nothing() {
    for deflection in [hold(FREE), pose(FREE), every_joint(FREE)] {
        assert_between(&ratios(deflection, Signals::PaperSteps), 70.0, 400.0);
    }
}

#[test]
fn all_torques_tell_deflection_of_standing_joints_without_a_prior() {
    let by_hold = ratios(hold(FREE), Signals::All);
    assert!((by_hold[0] - 3.3).abs() < 0.1, "gravity along x: {by_hold:?}");
    assert_between(&by_hold[3..6], 1.4, 1.7);
    let by_pose = ratios(pose(FREE), Signals::All);
    assert!((by_pose[0] - 6.5).abs() < 0.1, "gravity along x: {by_pose:?}");
    assert_between(&by_pose[3..6], 2.0, 2.3);
    assert_between(&ratios(every_joint(FREE), Signals::All), 60.0, 150.0);
}

#[test]
fn a_prior_of_two_milliradians_suffices() {
    for signals in [Signals::PaperSteps, Signals::All] {
        assert_between(&ratios(hold(0.002), signals), 1.1, 1.7);
        assert_between(&ratios(pose(0.002), signals), 1.02, 1.1);
        assert_between(&ratios(every_joint(0.002), signals), 1.04, 1.13);
    }
}

/// Compliances are known to about 1e-4 rad/(N·m) without a prior, and cost little; joints that sweep bend as well.
#[test]
fn compliance_is_determined_by_the_readings() {
    let mut simulation = sarcos_shoulder();
    let mut session = simulation.session(0);
    let signals = [Signals::PaperSteps, Signals::All];
    let without = signals.map(|signals| deviations(&simulation, &session, signals));
    session.let_joints_give_way(&[FREE; 3]);
    simulation.truth.further = vec![0.0; 3];
    for ((signals, without), most) in signals.into_iter().zip(without).zip([1.5e-4, 5e-5]) {
        let readings = joint::select(&session, signals);
        let built = joint::build_problem(&session, &readings, &simulation.truth).unwrap();
        let solved = Solved::at_start(built).unwrap();
        for id in &solved.built.variables.further {
            let std = solved.covariance().std(solved.built.problem.columns_of(*id).start);
            assert!((0.5 * most..most).contains(&std), "{signals:?}: {std}");
        }
        let with = deviations(&simulation, &session, signals);
        assert_between(&with.iter().zip(&without).map(|(a, b)| a / b).collect::<Vec<_>>(), 1.0, 1.35);
    }
}

fn estimate(session: &Session) -> EstimatorResult {
    estimate_by(&LevenbergMarquardt::default(), session)
}

/// Largest error of what is determined, in its own standard deviations.
fn worst(result: &EstimatorResult, truth: &State) -> f64 {
    let sensors =
        result.parameters.iter().filter(|p| p.determined && p.held.is_none() && !p.name.ends_with("compliance"));
    let error = |p: &ParameterResult| {
        let (joint, quantity) = p.name.split_once('.').unwrap();
        let joint: usize = joint[5..].parse::<usize>().unwrap() - 1;
        let quantity = SensorParameter::ALL.into_iter().find(|q| q.as_str() == quantity).unwrap();
        (p.value.unwrap() - truth.sensors[joint][quantity as usize]).abs() / p.std.unwrap()
    };
    sensors.map(error).fold(0.0, f64::max)
}

/// Half a degree of deflection of standing joints: unmodelled it spoils the answer, modelled it is found.
#[test]
fn deflection_by_hold_is_found_where_it_is_modelled() {
    let mut simulation = sarcos_shoulder();
    simulation.disturbance.deflection.hold_std = 0.5_f64.to_radians();
    let mut session = simulation.session(0);
    let unmodelled = estimate(&session).fit.unwrap();
    assert!(unmodelled.p_value.unwrap() < 1e-9, "the readings contradict a model without it");
    session.deflection = hold(0.5_f64.to_radians());
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Determined);
    assert!(worst(&result, &simulation.truth) < 4.0);
    assert!(result.fit.unwrap().p_value.unwrap() > 1e-3);
    assert_eq!(result.deflections.len(), 2 * 11);
    assert!(result.deflections.iter().filter(|d| d.value.is_some()).count() > 15);
}

#[test]
fn noise_of_position_readings_is_no_longer_taken_as_exact() {
    let mut simulation = sarcos_shoulder();
    simulation.disturbance.position_std = vec![0.003; 3];
    let mut session = simulation.session(1);
    session.deflection = every_joint(0.003);
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Determined);
    assert!(worst(&result, &simulation.truth) < 4.0);
    assert!(result.fit.unwrap().p_value.unwrap() > 1e-3);
    assert_eq!(result.position_errors.iter().map(|e| e.poses).collect::<Vec<_>>(), [407; 3]);
    assert!(result.position_errors.iter().all(|e| e.std < e.prior_std && e.rms < e.prior_std));
}

#[test]
fn compliance_is_found_or_said_not_to_be() {
    let mut simulation = sarcos_shoulder();
    let truth = [8e-4, 0.0, -6e-4];
    simulation.disturbance.deflection.compliance = truth.to_vec();
    let mut session = simulation.session(2);
    session.let_joints_give_way(&[1e-3, 1e-3, 1e-3]);
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Determined);
    assert!(worst(&result, &simulation.truth) < 4.0);
    let reported = |result: &EstimatorResult| -> Vec<ParameterResult> {
        result.parameters.iter().filter(|p| p.name.ends_with("compliance")).cloned().collect()
    };
    for (reported, truth) in reported(&result).iter().zip(truth) {
        assert!(!reported.asked && reported.unit == "rad/(N·m)");
        assert!((reported.value.unwrap() - truth).abs() < 4.0 * reported.std.unwrap(), "{reported:?}");
    }
    // Readings are not linear in moments that turn joints, and variable projection must not take them for it.
    let projected = estimate_by(&VariableProjection::default(), &session);
    for (found, expected) in projected.parameters.iter().zip(&result.parameters).filter(|(_, p)| p.held.is_none()) {
        let off = (found.value.unwrap() - expected.value.unwrap()).abs() / expected.std.unwrap();
        assert!(off < 1e-3, "{}: {off} standard deviations off", found.name);
    }
    // A prior that says as much as the readings.
    let mut session = sarcos_shoulder().session(2);
    session.let_joints_give_way(&[1e-5, 1e-5, 0.0]);
    let result = estimate(&session);
    assert_eq!(result.verdict, Verdict::Determined, "compliance is not asked for");
    let compliances = reported(&result);
    assert!(compliances[..2].iter().all(|p| p.value.is_none()) && compliances[2].held.is_some());
    assert!(result.undetermined.iter().any(|u| u.combination == "joint1.compliance"), "{:?}", result.undetermined);
}
