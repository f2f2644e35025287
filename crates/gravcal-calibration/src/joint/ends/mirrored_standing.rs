//! Joints that stand near a multiple of a quarter turn, mirrored about it.
//!
//! There torques know the angle of a standing joint by its cosine alone: `cos θ = cos(−θ)`. Between the two ends readings may be explained so badly
//! that nothing near one of them tells of the other, and nothing tells which of them is the true one. Where a joint beyond it that moves turns about a
//! parallel axis, readings know the sum of both angles well, and the other end has that joint turned back by as much.

use gravcal_dynamics::JointKind;
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use crate::joint::ends::aligned::{NEAR, off_quarter_turn};
use crate::joint::ends::other_start::OtherStart;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// Axes whose cosine differs from 1 by no more are parallel.
const PARALLEL: f64 = 1e-3;

/// The solution with one standing joint on the other side of a quarter turn, for each joint that stands near one: alone, and with what turns it back.
pub(super) fn mirrored_standing(
    solved: &Solved,
    session: &Session,
    _: &SolveEnvironment<'_>,
) -> Result<Vec<OtherStart>, EstimateError> {
    let found = solved.state(&State::nominal(session));
    let off = solved.standing_angles(session).into_iter().map(|(joint, angle)| (joint, off_quarter_turn(angle)));
    let mirrored = |(joint, off): (usize, f64)| {
        let offset = SensorParameter::PositionOffset as usize;
        let mut alone = found.clone();
        alone.sensors[joint][offset] -= 2.0 * off;
        let turned_back = solved.turns_back(session, joint).map(|(other, side)| {
            let mut start = alone.clone();
            start.sensors[other][offset] += 2.0 * side * off;
            start
        });
        std::iter::once(alone).chain(turned_back).collect::<Vec<State>>()
    };
    let starts = off.filter(|(_, off)| off.abs() <= NEAR).flat_map(mirrored);
    Ok(starts.map(|start| OtherStart { start, declared: Vec::new() }).collect())
}

impl Solved {
    /// The first joint beyond a standing one that moves about a parallel axis, and whose offset is unknown; and 1 where it turns the same way, else −1.
    fn turns_back(&self, session: &Session, standing: usize) -> Option<(usize, f64)> {
        let (chain, unknowns) = (&session.robot.chain, self.state(&State::nominal(session)));
        let stands: Vec<usize> = self.standing_angles(session).into_iter().map(|(joint, _)| joint).collect();
        let pose = session.poses.iter().zip(&self.readings().used).find(|(_, used)| !used.is_empty())?.0;
        let axes = chain.axes(&session.terms.coordinates(&pose.position, &pose.conditions, &unknowns));
        let axis = |joint: usize| Some(Vector3::from(axes[chain.links_of(joint).next()?]));
        let own = axis(standing)?;
        let side =
            |joint: usize| axis(joint).map(|axis| own.dot(&axis)).filter(|cosine| 1.0 - cosine.abs() <= PARALLEL);
        let is_free = |joint: &usize| {
            let offset = self.built.variables.sensors[*joint][SensorParameter::PositionOffset as usize];
            chain.joints()[*joint].kind == JointKind::Revolute && !self.judged_problem().columns_of(offset).is_empty()
        };
        let beyond = |joint: &usize| chain.links_of(*joint).next().is_some_and(|link| chain.moves(standing, link));
        let moving = (0..chain.joint_count()).filter(|joint| *joint != standing && !stands.contains(joint));
        let mut moving = moving.filter(beyond).filter(is_free);
        moving.find_map(|joint| Some((joint, side(joint)?.signum())))
    }
}

#[cfg(test)]
mod tests {
    use gravcal_session::simulation::Run;

    use super::*;
    use crate::joint::ends::other_ends::or_other_end;
    use crate::joint::ends::symmetries::in_hemisphere;
    use crate::joint::solving::solve_from::solve_from;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// The shoulder with its second axis turned by a quarter turn in any direction, so that one of these is along the first.
    #[test]
    fn a_moving_joint_turns_a_standing_one_back_where_their_axes_are_parallel() {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let solved = with_environment(|environment| solve(&session, &readings, None, environment)).unwrap();
        assert_eq!(solved.turns_back(&session, 0), None, "the axes cross");
        let quarter = std::f64::consts::FRAC_PI_2;
        let turned = [0, 1, 2].map(|axis| {
            let chain = session.robot.chain.with_joint_turned(1, (quarter * Vector3::ith(axis, 1.0)).into());
            let mut session = session.clone();
            session.robot.chain = chain;
            let axes: Vec<Vector3<f64>> = session.robot.chain.axes(&[0.0; 3]).into_iter().map(Vector3::from).collect();
            (solved.turns_back(&session, 0), axes[0].dot(&axes[1]))
        });
        for (back, cosine) in turned {
            let parallel = (cosine.abs() > 0.99).then(|| (1, cosine.signum()));
            assert_eq!(back, parallel);
        }
        assert!(turned.iter().any(|(back, _)| back.is_some()), "{turned:?}");
        assert_eq!(solved.turns_back(&session, 2), None, "nothing moves beyond the last");
    }

    #[test]
    fn of_both_sides_of_a_quarter_turn_the_likelier_is_taken_and_the_other_kept_where_it_may_be() {
        let mut simulation = sarcos_shoulder();
        let [_, _, gain, offset] = simulation.truth.sensors[1];
        for run in &mut simulation.runs {
            let Run::Sweep { swept, held, .. } = run else { panic!("all are sweeps") };
            (*swept, held[1]) = (if *swept == 0 { 0 } else { 2 }, (0.05 - offset) / gain);
        }
        let session = simulation.session(0);
        let readings = select(&session, Signals::All);
        with_environment(|environment| {
            let solved = solve(&session, &readings, None, environment)?;
            let standing = solved.standing_angles(&session);
            assert!(standing.len() == 1 && standing[0].0 == 1, "{standing:?}");
            let mut start = solved.state(&State::nominal(&session));
            start.sensors[1][3] -= 2.0 * off_quarter_turn(standing[0].1);
            let other = in_hemisphere(&session, solve_from(&session, &readings, start, environment)?, environment)?;
            let [one, mirrored] = [solved.minus_log_likelihood(&session)?, other.minus_log_likelihood(&session)?];
            let looked = or_other_end(solved, &session, environment)?;
            assert!((looked.minus_log_likelihood(&session)? - one.min(mirrored)).abs() < 1e-6);
            assert_eq!(
                looked.elsewhere.len(),
                usize::from((one - mirrored).abs() < gravcal_identification::IMPLAUSIBLE)
            );
            Ok::<_, EstimateError>(())
        })
        .unwrap();
    }
}
