//! Whether another session explains the readings beyond doubt: by its likelihood, the noise found anew with it.

use std::borrow::Cow;

use gravcal_identification::{DECISIVE, SolveEnvironment};
use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::{MeasurementSet, first_noise};
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::starting::sample::telling_part;
use crate::joint::variables::State;

/// Noise that is found from fewer degrees of freedom than this part of the numbers that are fitted may by chance be anything, and with it the
/// likelihood.
const TELLING: usize = 2;

/// Whether a session with its readings, started there, explains them so much better than the solution that it is no accident of having
/// tried so many, nor of few readings without stated noise. Of many readings those of a part suffice ([`telling_part`]).
pub(in crate::joint) fn decisively_likelier(
    (made, readings, start): (&Session, MeasurementSet, State),
    (session, solved): (&Session, &Solved),
    tried: f64,
    environment: &SolveEnvironment<'_>,
) -> Result<bool, EstimateError> {
    let (rank, rows) = (solved.analysis.rank(), solved.judged_problem().rows());
    if solved.readings().noise_found(session) && rows < rank + rank / TELLING {
        return Ok(false);
    }
    let noise = first_noise(session, &solved.readings().spreads);
    let readings = MeasurementSet { noise, ..readings }.with_rough_unexplained(session);
    let other = solve_from(made, &readings, start, &environment.roughly())?;
    let own = match telling_part(session, solved.readings()) {
        Cow::Borrowed(_) => solved.minus_log_likelihood(session)?,
        Cow::Owned(part) => {
            let here = solved.state(&State::nominal(session));
            solve_from(session, &part, here, &environment.roughly())?.minus_log_likelihood(session)?
        }
    };
    let gain = own - other.minus_log_likelihood(made)?;
    Ok(gain > DECISIVE + tried.ln())
}

#[cfg(test)]
mod tests {
    use gravcal_robot_model::parameter::SensorParameter;
    use gravcal_robot_model::session::{ParameterPrior, PriorKind};

    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// A shoulder whose session takes the second position offset for exact and is wrong by so much, rad, solved; and the session that is right.
    fn with_wrong_offset(off: f64) -> (Session, Solved, Session) {
        let simulation = sarcos_shoulder();
        let truth = simulation.truth.sensors[1][SensorParameter::PositionOffset as usize];
        let with = |nominal: f64| {
            let mut session = simulation.session(0);
            session.joints[1].parameters[SensorParameter::PositionOffset as usize] =
                ParameterPrior { nominal, kind: PriorKind::Fixed };
            session
        };
        let (wrong, right) = (with(truth + off), with(truth));
        let readings = select(&wrong, Signals::All);
        let solved = with_environment(|environment| solve(&wrong, &readings, None, environment)).unwrap();
        (wrong, solved, right)
    }

    /// Where the right session starts.
    fn start(right: &Session, solved: &Solved) -> State {
        let mut start = solved.state(&State::nominal(right));
        start.sensors[1][SensorParameter::PositionOffset as usize] =
            right.joints[1].of(SensorParameter::PositionOffset).nominal;
        start
    }

    /// By how much the right session is likelier, and whether that is beyond doubt after so many were tried.
    fn gain_and_verdicts(off: f64, tried: impl Fn(f64) -> [usize; 2]) -> (f64, [bool; 2]) {
        let (wrong, solved, right) = with_wrong_offset(off);
        with_environment(|environment| {
            let start = start(&right, &solved);
            let other = solve_from(&right, solved.readings(), start.clone(), environment)?;
            let gain = solved.minus_log_likelihood(&wrong)? - other.minus_log_likelihood(&right)?;
            let decided = |tried: usize| {
                let made = (&right, solved.readings().clone(), start.clone());
                decisively_likelier(made, (&wrong, &solved), tried as f64, environment)
            };
            let [a, b] = tried(gain);
            Ok::<_, EstimateError>((gain, [decided(a)?, decided(b)?]))
        })
        .unwrap()
    }

    /// An error that makes the right session likelier by about this: it goes with the square of the error.
    fn error_of_gain(gain: f64) -> f64 {
        let off = 0.01;
        let (of_this, _) = gain_and_verdicts(off, |_| [1, 1]);
        off * (gain / of_this).sqrt()
    }

    #[test]
    fn of_many_that_were_tried_one_must_be_likelier_by_that_many_times() {
        let (gain, verdicts) = gain_and_verdicts(error_of_gain(20.0), |gain| {
            let most = (gain - DECISIVE).exp();
            [(0.9 * most) as usize, (1.1 * most) as usize + 1]
        });
        assert!(gain > DECISIVE + 2.0 && gain < DECISIVE + 30.0, "{gain}");
        assert_eq!(verdicts, [true, false], "{gain}");
    }

    #[test]
    fn what_is_not_beyond_doubt_is_no_mistake() {
        let (gain, verdicts) = gain_and_verdicts(error_of_gain(6.0), |_| [1, 1]);
        assert!(gain > 0.0 && gain < DECISIVE, "{gain}");
        assert_eq!(verdicts, [false, false]);
    }

    /// A session of so few readings that noise found from them may be anything names nothing, however well something else explains them.
    #[test]
    fn noise_that_few_readings_found_accuses_nobody() {
        let (mut wrong, _, mut right) = with_wrong_offset(0.1);
        for session in [&mut wrong, &mut right] {
            session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).for_each(|r| r.std = None);
        }
        let decided = |every: usize| {
            let readings = select(&wrong, Signals::All).only(|id| id.pose % every == 0);
            with_environment(|environment| {
                let solved = solve(&wrong, &readings, None, environment)?;
                let (rows, rank) = (solved.judged_problem().rows(), solved.analysis.rank());
                let made = (&right, solved.readings().clone(), start(&right, &solved));
                let decided = decisively_likelier(made, (&wrong, &solved), 1.0, environment)?;
                Ok::<_, EstimateError>((rows as f64 / rank as f64, decided))
            })
            .unwrap()
        };
        let ((many, of_many), (few, of_few)) = (decided(6), decided(45));
        assert!(many > 1.5 && of_many, "{many}");
        assert!(few < 1.5 && !of_few, "{few}");
    }
}
