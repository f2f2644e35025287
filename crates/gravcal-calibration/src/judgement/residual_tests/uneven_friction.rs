//! Friction of a joint that moves, or that is left where it stands, which need not be the same both ways.
//!
//! ```text
//!     F₊ = F (1 + a)  one way,   F₋ = F (1 − a)  the other:      readings are a F more, whichever way the joint moves
//! ```
//!
//! This is a bias of the torque sensor, and no reading of an arm that comes both ways tells them apart.

use gravcal_robot_model::sensors::{Moment, Need};
use gravcal_robot_model::session::{Pose, Session};

use super::columns::Columns;
use crate::joint::{Solved, State};

/// `a`, as is usual.
pub const UNEVEN: f64 = 0.05;

/// What is left at rest is told where it is so many of its standard deviations.
const TOLD: f64 = 3.0;

/// `F` of a joint in each pose, in the unit of its reading, as far as its sweeps, the model's friction or what is left at rest tell it; zero where it is not known
/// from which side the joint came.
pub fn friction_in_poses(of: &Columns, joint: usize) -> Vec<f64> {
    let (session, solved) = (of.session, of.solved);
    let modelled = modelled_friction(session, solved, joint, &[Need::Direction, Need::Presliding]);
    let modelled = modelled.into_iter().map(f64::abs).fold(0.0, f64::max);
    let of_sweeps = session.find_static_friction().get(joint).copied().unwrap_or(0.0);
    let friction = if modelled > 0.0 { modelled } else { of_sweeps };
    let at_rest = solved.friction_at_rest(joint).filter(|found| found.size.abs() > TOLD * found.std);
    let at_rest = at_rest.map_or(0.0, |found| found.size.abs());
    let of_pose = |(place, pose): (usize, &Pose)| {
        let came = pose.conditions.direction.get(joint).is_some_and(|direction| *direction != 0.0);
        if came && modelled > 0.0 || session.swept_in_recording(pose) == Some(joint) {
            friction
        } else if of.side(joint, place) != 0.0 {
            at_rest
        } else {
            0.0
        }
    };
    session.poses.iter().enumerate().map(of_pose).collect()
}

/// What the terms of a joint's torque sensor that read any of these add to its reading, by pose, in its unit; empty where it has none.
pub fn modelled_friction(session: &Session, solved: &Solved, joint: usize, read: &[Need]) -> Vec<f64> {
    let own =
        || session.terms.of_torque(joint).filter(|term| term.reads.needs().iter().any(|need| read.contains(need)));
    if own().next().is_none() {
        return Vec::new();
    }
    let values = solved.state(&State::nominal(session)).further;
    let none = vec![0.0; session.joints.len()];
    let added = |pose: &Pose| {
        let at = Moment::new(&none, &pose.position, &pose.position, &pose.conditions);
        own().map(|term| term.value(&at, &values, None)).sum()
    };
    session.poses.iter().map(added).collect()
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::sensors::Options;

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::sensor_models::{errors, estimate, shoulder, with_model};
    use crate::testing::with_environment;

    const FRICTION: f64 = 20.0;

    /// Of the one joint whose model has friction, as much as that is, in poses of which the side is known.
    #[test]
    fn it_is_that_of_the_model_where_the_joint_moves() {
        let simulation = with_model(shoulder(), 1, "coulomb-friction", &Options::default(), &[FRICTION]);
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        let columns = Columns::new(&session, &solved, solved.judged_problem().rows()).unwrap();
        let friction = friction_in_poses(&columns, 1);
        let estimated = solved.state(&State::nominal(&session)).further[0];
        assert!((estimated / FRICTION - 1.0).abs() < 0.02, "{estimated}");
        for (pose, friction) in session.poses.iter().zip(&friction) {
            let expected = if pose.conditions.direction[1] == 0.0 { 0.0 } else { estimated };
            assert!((friction - expected).abs() < 1e-9, "{friction} {expected}");
        }
        assert!(friction.iter().any(|friction| *friction > 0.0));
        assert!(friction_in_poses(&columns, 0).iter().all(|friction| *friction == 0.0));
    }

    /// A joint whose friction is a tenth more one way has another bias by a twentieth of it, which no residual shows: a remark says so.
    #[test]
    fn friction_that_is_more_one_way_passes_for_a_bias_and_that_is_told() {
        let simulation = with_model(shoulder(), 1, "coulomb-friction", &Options::default(), &[FRICTION]);
        let mut session = simulation.session(0);
        let known = estimate(&session);
        let before = errors(&session, &simulation, &known);
        for pose in session.poses.iter_mut().filter(|pose| pose.conditions.direction[1] != 0.0) {
            pose.torque[1].iter_mut().for_each(|reading| reading.value += UNEVEN * FRICTION);
        }
        let result = estimate(&session);
        let told = known.taken_as_exact.iter().find(|exact| exact.wrong.contains("friction of each joint")).unwrap();
        let (parameter, off_in_std) = (&told.parameter, told.off_in_std);
        let of = |errors: &[(String, f64)]| errors.iter().find(|(name, _)| name == parameter).unwrap().1;
        let off = (of(&errors(&session, &simulation, &result)) - of(&before)).abs();
        assert!(off > 2.0 && (off / off_in_std - 1.0).abs() < 0.2, "{parameter} {off} {off_in_std}");
    }
}
