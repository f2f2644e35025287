//! Joints that stand near a multiple of a quarter turn, mirrored about it.
//!
//! There torques know the angle of a standing joint by its cosine alone: `cos θ = cos(−θ)`. Between the two ends readings may be explained so badly
//! that nothing near one of them tells of the other, and nothing tells which of them is the true one.

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use crate::joint::ends::aligned::{NEAR, off_quarter_turn};
use crate::joint::ends::other_start::OtherStart;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;
use crate::joint::variables::State;

/// The solution with one standing joint on the other side of a quarter turn, for each joint that stands near one.
pub(super) fn mirrored_standing(
    solved: &Solved,
    session: &Session,
    _: &SolveEnvironment<'_>,
) -> Result<Vec<OtherStart>, EstimateError> {
    let found = solved.state(&State::nominal(session));
    let off = solved.standing_angles(session).into_iter().map(|(joint, angle)| (joint, off_quarter_turn(angle)));
    let mirrored = |(joint, off): (usize, f64)| {
        let mut start = found.clone();
        start.sensors[joint][SensorParameter::PositionOffset as usize] -= 2.0 * off;
        OtherStart { start, declared: Vec::new() }
    };
    Ok(off.filter(|(_, off)| off.abs() <= NEAR).map(mirrored).collect())
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
