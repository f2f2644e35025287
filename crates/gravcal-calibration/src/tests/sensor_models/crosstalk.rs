//! Cross-talk is told from sensors of one joint each.

use gravcal_robot_model::sensors::Options;

use crate::testing::sensor_models::{assert_distinguished, shoulder, undetermined, with_model};

#[test]
fn a_banded_matrix_is_distinguished_from_a_diagonal_one() {
    let options = Options::default().with("from", vec!["joint3"]);
    assert_distinguished(&with_model(shoulder(), 1, "torque-crosstalk", &options, &[0.2]));
}

#[test]
fn a_full_matrix_is_distinguished_from_a_diagonal_one() {
    let mut simulation = shoulder();
    for (joint, truth) in [[0.1, -0.15], [0.2, 0.1], [-0.1, 0.12]].into_iter().enumerate() {
        simulation = with_model(simulation, joint, "torque-crosstalk", &Options::default(), &truth);
    }
    assert_distinguished(&simulation);
}

/// Bare poses in which only the last joint moves do not fill a full matrix.
#[test]
fn a_matrix_that_the_data_cannot_fill_is_undetermined_by_name() {
    let simulation = with_model(shoulder(), 0, "torque-crosstalk", &Options::default(), &[0.1, 0.1]);
    let mut session = simulation.session(0);
    session.poses.retain(|pose| pose.load.is_none() && pose.table == 2);
    let open = undetermined(&session);
    for name in ["joint1.torque_crosstalk_joint2", "joint1.torque_crosstalk_joint3"] {
        assert!(open.contains(&name.to_owned()), "{open:?}");
    }
}
