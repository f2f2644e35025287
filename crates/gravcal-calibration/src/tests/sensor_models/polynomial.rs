//! Curved characteristics are told from straight ones.

use gravcal_robot_model::sensors::Options;
use gravcal_solvers::VariableProjection;

use crate::result::EstimatorResult;
use crate::testing::sensor_models::{assert_distinguished, estimate, estimate_by, shoulder, undetermined, with_model};

#[test]
fn a_curved_characteristic_is_distinguished_from_a_straight_one() {
    let truth = [4e-3, -4e-4];
    let options = Options::default();
    assert_distinguished(&with_model(shoulder(), 1, "torque-gain-polynomial", &options, &truth));
}

/// Readings are no longer linear in the moments, and variable projection must not take them for it.
#[test]
fn every_method_ends_at_the_same_polynomial() {
    let options = Options::default().with("degree", 2);
    let simulation = with_model(shoulder(), 1, "torque-gain-polynomial", &options, &[4e-3]);
    let session = simulation.session(0);
    let value = |result: EstimatorResult| {
        let reported = result.parameters.into_iter().find(|reported| reported.name == "joint2.torque_gain_2").unwrap();
        (reported.value.unwrap(), reported.std.unwrap())
    };
    let (expected, std) = value(estimate(&session));
    let (found, _) = value(estimate_by(&VariableProjection::default(), &session));
    assert!((found - expected).abs() < 1e-4 * std, "{found} {expected}");
}

/// Without the load the scale of all gains is free, and the polynomial's coefficients with it.
#[test]
fn bare_poses_leave_its_scale_with_that_of_the_gains() {
    let options = Options::default().with("degree", 2);
    let simulation = with_model(shoulder(), 1, "torque-gain-polynomial", &options, &[4e-3]);
    let mut session = simulation.session(0);
    session.poses.retain(|pose| pose.load.is_none());
    let open = undetermined(&session);
    assert!(open.contains(&"joint2.torque_gain".to_owned()), "{open:?}");
    assert!(!open.contains(&"joint2.torque_bias".to_owned()), "{open:?}");
}
