//! Other starts, where it is doubtful that the first one led to the answer.

use std::borrow::Cow;

use gravcal_estimation::{EvaluateError, Termination};
use gravcal_identification::{DECISIVE, IMPLAUSIBLE, Likeliest, Place, SolveEnvironment};
use gravcal_robot_model::session::Session;

use crate::joint::ends::displaced::{gains_disagree, otherwise_displaced};
use crate::joint::ends::symmetries::{in_hemisphere, not_as_declared, settled, turned_gains};
use crate::joint::error::EstimateError;
use crate::joint::identifiability::judged::mostly_open;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::order::Order;
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::starting::sample::{Sample, telling_part};
use crate::joint::starting::start::{best_start, further_starts};
use crate::joint::variables::State;
use crate::judgement::explained;

/// Where most is open, fits have valleys beside the true one that explain the readings all but as well: there other starts are tried where residuals
/// as large have less than this probability.
const UNLIKELY: f64 = 0.1;
/// Starts at most that each of the method's companions follows but for the first.
const LAST_RESORT: usize = 3;

/// Whether other starts are worth it: the readings contradict the solution, excuse it by noise that was found there, or leave it mostly open.
///
/// # Errors
/// Where the problem cannot be evaluated there.
pub(in crate::joint) fn is_doubtful(session: &Session, solved: &Solved) -> Result<bool, EvaluateError> {
    if solved.estimate.termination == Termination::Stopped {
        return Ok(false);
    }
    let together = solved.readings().order == Order::Together;
    Ok(together && (solved.readings().noise_found(session) || gains_disagree(session, solved))
        || !solved.estimate.termination.converged()
        || solved.misfit(session)?.is_some()
        || solved.is_hardly_explained(session)? && mostly_open(session, &solved.judge(session)))
}

/// The solution, or a likelier one from another start: a minimum that the stated noise rules out may be a local one, and noise that was
/// found at a minimum excuses it. The method's first companion looks from where the first one began, as one that creeps along a bent valley is
/// where the other goes through; from elsewhere the method itself, and the companions where that does not suffice. `of_part`: the solution of the part of many readings
/// by which ends are told apart.
pub(in crate::joint) fn likeliest_of_other_starts(
    session: &Session,
    readings: &MeasurementSet,
    sample: &Sample,
    (solved, of_part): (Solved, Option<Solved>),
    known: Option<&State>,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    environment.report("other starting values");
    let readings = &readings.with_rough_unexplained(session);
    let mut companions = environment.solver().companions();
    companions.retain(|other| other.check(&solved.built.problem).is_ok());
    let companions: Vec<_> = companions.iter().map(|other| environment.by(other.as_ref())).collect();
    let methods = (environment, companions.as_slice());
    let nominal = State::nominal(session);
    let follow = |start: State, environment: &SolveEnvironment<'_>| -> Result<_, EstimateError> {
        Ok(solve_from(session, readings, start, environment)?.into_end(session)?)
    };
    let is_another = |best: &Solved, place: &Place<State>| best.has_moved_from(session, &place.start);
    let settle = |solved: Solved| settled(session, solved, sample, companions.first().unwrap_or(environment));
    let likeliest = match telling_part(session, readings) {
        Cow::Borrowed(all) => {
            let mut likeliest = from_other_starts(session, (all, sample), solved, known, methods)?;
            if likeliest.is_another {
                likeliest.best.solution = settle(likeliest.best.solution)?;
            }
            likeliest
        }
        Cow::Owned(part) => {
            let first = match of_part {
                Some(of_part) => of_part,
                None => solve_from(session, &part, solved.state(&nominal), environment)?,
            };
            let of_part = from_other_starts(session, (&part, sample), first, known, methods)?;
            // The first end of the part is that of all readings.
            // An end that was followed roughly is the best one where what is told lies within its errors.
            let best = &of_part.best.solution;
            let others = of_part.plausible().into_iter().skip(1).filter(|other| best.has_moved_from(session, other));
            let mut starts: Vec<State> = others.cloned().collect();
            if of_part.is_another {
                starts.insert(0, settle(of_part.best.solution)?.state(&nominal));
            }
            let mut likeliest = Likeliest::first(solved.into_end(session)?);
            likeliest.or_from(starts, follow, is_another, environment);
            likeliest
        }
    };
    let Likeliest { best, mut others, .. } = likeliest;
    let solved = as_declared(session, readings, best.solution, &others, environment)?;
    let least = solved.minus_log_likelihood(session)?;
    // A sign is declared: an end of another sign that is not likelier beyond doubt is an image, no value that the parameters may have.
    let here = turned_gains(session, &solved.state(&nominal));
    let is_image = |start: &State| turned_gains(session, start).iter().any(|gain| !here.contains(gain));
    others.retain(|place| place.minus_log_likelihood < least + IMPLAUSIBLE && !is_image(&place.start));
    Ok(Solved { elsewhere: others.into_iter().map(|place| place.start).collect(), ..solved })
}

/// Where other starts lead, beside the first end.
fn from_other_starts(
    session: &Session,
    (readings, sample): (&MeasurementSet, &Sample),
    first: Solved,
    known: Option<&State>,
    (own, companions): (&SolveEnvironment<'_>, &[SolveEnvironment<'_>]),
) -> Result<Likeliest<Solved, State>, EstimateError> {
    let second = companions.first().unwrap_or(own);
    let follow = |start: State, environment: &SolveEnvironment<'_>| -> Result<_, EstimateError> {
        Ok(solve_from(session, readings, start, environment)?.into_end(session)?)
    };
    let is_another = |best: &Solved, place: &Place<State>| best.has_moved_from(session, &place.start);
    let mut likeliest = Likeliest::first(first.into_end(session)?);
    likeliest.or_from(vec![best_start(session, sample, known, second)?], follow, is_another, second);
    likeliest.or_from(otherwise_displaced(session, &likeliest.best.place.start), follow, is_another, own);
    likeliest.or_from(further_starts(session, sample, known, own)?, follow, is_another, own);
    for (place, other) in companions.iter().enumerate() {
        if likeliest.best.termination.converged() && likeliest.best.solution.misfit(session)?.is_none() {
            break;
        }
        let mut starts = further_starts(session, sample, known, other)?;
        starts.truncate(if place == 0 { usize::MAX } else { LAST_RESORT });
        likeliest.or_from(starts, follow, is_another, other);
    }
    Ok(likeliest)
}

/// The solution, or, of other ends that are not less likely beyond doubt, the one with the fewest gains and offsets that are not as declared.
fn as_declared(
    session: &Session,
    readings: &MeasurementSet,
    solved: Solved,
    others: &[Place<State>],
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let wrong = |state: &State| not_as_declared(session, state);
    let state = |solved: &Solved| solved.state(&State::nominal(session));
    let (own, least) = (wrong(&state(&solved)), solved.minus_log_likelihood(session)?);
    let plausible = others.iter().filter(|place| place.minus_log_likelihood < least + DECISIVE);
    let fewest = |a: &&Place<State>, b: &&Place<State>| {
        wrong(&a.start).cmp(&wrong(&b.start)).then(a.minus_log_likelihood.total_cmp(&b.minus_log_likelihood))
    };
    let Some(best) = plausible.min_by(fewest) else { return Ok(solved) };
    if own == 0 || wrong(&best.start) >= own {
        return Ok(solved);
    }
    let other = solve_from(session, readings, best.start.clone(), environment)?;
    let other = in_hemisphere(session, other, environment)?;
    let fewer = wrong(&state(&other)) < own && !other.hemisphere_contradicted;
    let plausible = other.minus_log_likelihood(session)? < least + DECISIVE;
    Ok(if fewer && plausible && other.estimate.termination.converged() { solved.replaced_by(other) } else { solved })
}

impl Solved {
    /// Whether the readings are explained so badly that it happens to one of ten right models.
    fn is_hardly_explained(&self, session: &Session) -> Result<bool, EvaluateError> {
        Ok(explained(session, self, self.least_chi_squared())?.p_value.is_some_and(|p| p < UNLIKELY))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use gravcal_robot_model::parameter::SensorParameter::{PositionGain, PositionOffset, TorqueGain};

    use super::*;
    use crate::joint::building::build::build_problem;
    use crate::joint::starting::start::start_around;
    use crate::joint::{Signals, select, solve};
    use crate::testing::{sarcos_shoulder, with_environment};

    /// A shoulder, its readings, and its solution as declared.
    fn declared(environment: &SolveEnvironment<'_>) -> Result<(Session, MeasurementSet, Solved), EstimateError> {
        let session = sarcos_shoulder().session(0);
        let readings = select(&session, Signals::All);
        let solved = solve(&session, &readings, None, environment)?;
        Ok((session, readings, solved))
    }

    /// The same with the last axis counted from its other end: two gains of the other sign, and an offset half a turn on.
    fn image(session: &Session, solved: &Solved, environment: &SolveEnvironment<'_>) -> Result<Solved, EstimateError> {
        let mut turned = solved.state(&State::nominal(session));
        turned.sensors[1][PositionOffset as usize] += PI;
        turned.sensors[2][TorqueGain as usize] *= -1.0;
        turned.sensors[2][PositionGain as usize] *= -1.0;
        let start = start_around(session, solved.readings(), &turned)?;
        solve_from(session, solved.readings(), start, environment)
    }

    #[test]
    fn of_ends_that_are_as_likely_the_one_with_fewer_signs_turned_is_the_answer() {
        with_environment(|environment| {
            let (session, readings, solved) = declared(environment)?;
            let image = image(&session, &solved, environment)?;
            let wrong = |solved: &Solved| not_as_declared(&session, &solved.state(&State::nominal(&session)));
            assert_eq!((wrong(&solved), wrong(&image)), (0, 3));
            assert!((image.estimate.cost - solved.estimate.cost).abs() < 1e-3, "an image reads the same");
            let place = |solved: &Solved, later: f64| {
                let minus_log_likelihood = solved.minus_log_likelihood(&session).unwrap() + later;
                let start = solved.state(&State::nominal(&session));
                [Place { minus_log_likelihood, values: solved.estimate.values.clone(), start }]
            };
            let (as_likely, of_image) = (place(&solved, 0.0), place(&image, 0.0));
            let less_likely = place(&solved, DECISIVE + 0.1);
            let again = |image: Solved, others| as_declared(&session, &readings, image, others, environment);
            let kept = again(image, &less_likely)?;
            assert_eq!(wrong(&kept), 3, "what is less likely beyond doubt is no answer");
            assert_eq!(wrong(&again(kept, &as_likely)?), 0);
            assert_eq!(wrong(&again(solved, &of_image)?), 0);
            Ok::<_, EstimateError>(())
        })
        .unwrap();
    }

    #[test]
    fn from_elsewhere_leads_to_the_end_that_is_as_declared_and_no_image_is_kept() {
        with_environment(|environment| {
            let (session, readings, solved) = declared(environment)?;
            let sample = Sample::new(&session, &readings)?;
            let least = solved.estimate.cost;
            let image = image(&session, &solved, environment)?;
            let found = likeliest_of_other_starts(&session, &readings, &sample, (image, None), None, environment)?;
            let nominal = State::nominal(&session);
            assert_eq!(not_as_declared(&session, &found.state(&nominal)), 0);
            assert!((found.estimate.cost - least).abs() < 1e-3);
            assert!(found.elsewhere.iter().all(|other| turned_gains(&session, other).is_empty()));
            Ok::<_, EstimateError>(())
        })
        .unwrap();
    }

    /// At nominal values nothing has converged: any minimum is likelier. At the minimum itself nothing else is.
    #[test]
    fn a_likelier_end_of_another_start_is_taken_and_no_other() {
        with_environment(|environment| {
            let (session, readings, solved) = declared(environment)?;
            let sample = Sample::new(&session, &readings)?;
            let (least, values) = (solved.estimate.cost, solved.estimate.values.clone());
            let stays = likeliest_of_other_starts(&session, &readings, &sample, (solved, None), None, environment)?;
            assert_eq!(stays.estimate.values, values);
            let built = build_problem(&session, &readings, &State::nominal(&session))?;
            let nowhere = Solved::at_start(built)?;
            assert!(nowhere.estimate.cost > 2.0 * least);
            let found = likeliest_of_other_starts(&session, &readings, &sample, (nowhere, None), None, environment)?;
            assert!(found.estimate.termination.converged() && (found.estimate.cost - least).abs() < 1e-3);
            Ok::<_, EstimateError>(())
        })
        .unwrap();
    }
}
