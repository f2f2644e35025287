//! Friction is told from a constant bias.

use gravcal_robot_model::sensors::Options;

use crate::testing::sensor_models::{assert_distinguished, shoulder, undetermined, with_model};

fn with(model: &str, truth: f64) -> gravcal_session::simulation::Simulation {
    with_model(shoulder(), 1, model, &Options::default(), &[truth])
}

#[test]
fn coulomb_friction_is_distinguished_from_a_constant_bias() {
    assert_distinguished(&with("coulomb-friction", 3.0));
}

#[test]
fn viscous_friction_is_distinguished_from_a_constant_bias() {
    assert_distinguished(&with("viscous-friction", 120.0));
}

#[test]
fn the_sign_of_the_velocity_is_a_direction() {
    let mut simulation = with("coulomb-friction", 3.0);
    simulation.conditions.direction = false;
    assert_distinguished(&simulation);
}

#[test]
fn poses_reached_from_one_side_leave_coulomb_friction_in_the_bias() {
    let mut session = with("coulomb-friction", 3.0).session(0);
    session.poses.iter_mut().for_each(|pose| pose.conditions.direction = vec![1.0; 3]);
    assert_eq!(undetermined(&session), ["joint2.torque_bias", "joint2.coulomb_friction"]);
}
