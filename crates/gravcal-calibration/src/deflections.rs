//! Unknown positions: what each model leaves known (last table of section 4 of the estimation model), and that modelling
//! deflection finds the truth.

use crate::joint::{self, Signals, Solved};
use crate::parameter::Quantity;
use crate::session::{Deflection, Session};
use crate::simulation::Simulation;
use crate::testing::sarcos_shoulder;

/// So wide a prior, rad, that it says nothing.
const FREE: f64 = 1.0;

/// Standard deviations at the truth of the reference protocol: of gravity's components, torque gains and offset of joint 2.
fn deviations(simulation: &Simulation, session: &Session, signals: Signals) -> Vec<f64> {
    let posed = joint::pose(session, &joint::select(session, signals), &simulation.truth).unwrap();
    let solved = Solved::at_start(joint::select(session, signals), posed).unwrap();
    let gravity = solved.gravity_covariance();
    let gains = (0..3).map(|joint| solved.sensor_std(joint, Quantity::TorqueGain));
    (0..3).map(|i| gravity[4 * i].sqrt()).chain(gains).chain([solved.sensor_std(1, Quantity::PositionOffset)]).collect()
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
