//! Eccentricity and ripple of position sensors are told from an even scale.

use gravcal_robot_model::sensors::Options;

use crate::testing::sensor_models::{assert_distinguished, shoulder, undetermined, with_model};

fn orders(orders: &[i64]) -> Options {
    Options::default().with("orders", orders.to_vec())
}

#[test]
fn eccentricity_is_distinguished_from_an_even_scale() {
    let truth = [0.02, -0.015];
    assert_distinguished(&with_model(shoulder(), 1, "position-harmonics", &orders(&[1]), &truth));
}

#[test]
fn ripple_is_distinguished_from_an_even_scale() {
    let truth = [0.01, 0.004, -0.003, 0.006];
    assert_distinguished(&with_model(shoulder(), 2, "position-harmonics", &orders(&[2, 4]), &truth));
}

/// Nothing is said of a joint's scale by readings at one place of it.
#[test]
fn a_joint_that_stands_still_has_no_harmonics() {
    let simulation = with_model(shoulder(), 2, "position-harmonics", &orders(&[1]), &[0.02, 0.01]);
    let mut session = simulation.session(0);
    session.poses.retain(|pose| pose.position[2] == -std::f64::consts::FRAC_PI_2);
    let open = undetermined(&session);
    for name in ["joint3.position_sine_1", "joint3.position_cosine_1"] {
        assert!(open.contains(&name.to_owned()), "{open:?}");
    }
}
