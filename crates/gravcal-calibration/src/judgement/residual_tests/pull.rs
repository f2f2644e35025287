//! Something that pulls at the arm, as a hose, a cable or an air line does.
//!
//! ```text
//!     y_i is less by k_i J_i(θ)ᵀ f        f in base coordinates; J_i of a point of the last link
//! ```
//!
//! The point is its centre of mass, as the robot's description has it, or its origin. The force's part along gravity is a mass at that point, which most models have already; what is across passes for a turn of gravity.

use gravcal_dynamics::LinkInertia;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use crate::joint::{Solved, State};

/// What a newton along each axis of the base does to the whitened residuals; nothing of an arm that has several ends, or no joint.
pub fn pulled(session: &Session, solved: &Solved) -> Vec<Vec<f64>> {
    let chain = &session.robot.chain;
    let mut ends = chain.last_links();
    let (Some(last), None, joints) = (ends.next(), ends.next(), chain.joint_count()) else { return Vec::new() };
    let state = solved.state(&State::nominal(session));
    // A newton pulls down as a body of 1 kg does where gravity is 1 m/s².
    let center = match &chain.links()[last].inertia {
        Some(LinkInertia { mass, first_moment }) if *mass > 0.0 => first_moment.map(|moment| moment / mass),
        _ => [0.0; 3],
    };
    let mut body = vec![0.0; 4 * chain.link_count()];
    body[4 * last] = 1.0;
    body[4 * last + 1..4 * last + 4].copy_from_slice(&center);
    let along = |axis: usize| {
        let mut force = [0.0; 3];
        force[axis] = 1.0;
        let mut by_pose = vec![vec![0.0; joints]; session.poses.len()];
        for (pose, torques) in session.poses.iter().zip(&mut by_pose) {
            let coordinates = session.terms.coordinates(&pose.position, &pose.conditions, &state);
            chain.gravity_torque(&coordinates, force, &body, torques);
        }
        solved.whitened(session, |id| match by_pose[id.pose].get(id.channel) {
            Some(torque) => torque * state.sensors[id.channel][SensorParameter::TorqueGain as usize],
            None => 0.0,
        })
    };
    if joints == 0 { Vec::new() } else { (0..3).map(along).collect() }
}
