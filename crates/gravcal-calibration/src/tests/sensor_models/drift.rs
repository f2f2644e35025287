//! Biases that drift are told from constant ones.

use gravcal_robot_model::sensors::Options;

use crate::testing::sensor_models::{assert_distinguished, shoulder, undetermined, with_model};

fn warm() -> Options {
    Options::default().with("reference_degC", 30)
}

#[test]
fn a_drift_in_time_is_distinguished_from_a_constant_bias() {
    assert_distinguished(&with_model(shoulder(), 1, "torque-bias-in-time", &Options::default(), &[2e-3]));
}

#[test]
fn a_drift_with_temperature_is_distinguished_from_a_constant_bias() {
    assert_distinguished(&with_model(shoulder(), 2, "torque-bias-with-temperature", &warm(), &[0.6]));
}

#[test]
fn poses_of_one_time_determine_no_drift() {
    let mut simulation = with_model(shoulder(), 1, "torque-bias-in-time", &Options::default(), &[2e-3]);
    simulation.conditions.pose_interval = Some(0.0);
    assert_eq!(undetermined(&simulation.session(0)), ["joint2.torque_bias_drift"]);
}

#[test]
fn where_temperature_rises_evenly_with_time_only_their_sum_is_determined() {
    let both = with_model(shoulder(), 1, "torque-bias-in-time", &Options::default(), &[2e-3]);
    let mut session = with_model(both, 1, "torque-bias-with-temperature", &warm(), &[0.6]).session(0);
    for conditions in session.poses.iter_mut().map(|pose| &mut pose.conditions) {
        conditions.temperature = vec![30.0 + 1e-3 * conditions.time.unwrap(); 3];
    }
    assert_eq!(undetermined(&session), ["joint2.torque_bias_drift", "joint2.torque_bias_temperature_drift"]);
}
