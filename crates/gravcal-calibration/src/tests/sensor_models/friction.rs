//! Friction is told from a constant bias.

use gravcal_robot_model::sensors::Options;

use crate::result::{ResidualTest, ResidualTestKind};
use crate::testing::sensor_models::{
    assert_distinguished, assert_found, estimate, shoulder, taken_as_affine, undetermined, with_model,
};

fn with(model: &str, truth: f64) -> gravcal_session::simulation::Simulation {
    with_model(shoulder(), 1, model, &Options::default(), &[truth])
}

/// A session that says from which side joints came, and nothing of friction, has it as an unknown all the same.
#[test]
fn coulomb_friction_is_distinguished_from_a_constant_bias() {
    let simulation = with("coulomb-friction", 3.0);
    let unsaid = estimate(&taken_as_affine(&simulation.session(0)));
    let friction = |test: &ResidualTest| {
        test.kind == ResidualTestKind::Direction && test.channel == "joint2" && test.named && !test.spoils_intervals
    };
    assert!(unsaid.residual_tests.iter().any(friction), "{:?}", unsaid.notes);
    assert_found(&simulation);
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
