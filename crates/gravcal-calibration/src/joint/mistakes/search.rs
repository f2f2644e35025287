//! What a session may have got wrong, found by trying: where the readings contradict the model, a session that differs from it in one
//! thing and explains them names that thing.
//!
//! Tried are torque sensors that read the other way (`reversed.rs`), then each [`Hypothesis`]: [`hypotheses`] lists them, each kind has a file.
//!
//! A mistake is no image of the solution (`symmetries/`): its session states another problem, and the estimate stays that of the session as it
//! stands. Of few readings some mistake always explains more, by chance. One is named only where the likelihood is decisively higher, the noise
//! found anew with it, and allowing for how many were tried.

use std::sync::Arc;

use gravcal_estimation::{EvaluateError, Termination, in_parallel};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use super::changed_load::changed_loads;
use super::exchanged_axes::ExchangedAxes;
use super::exchanged_load::hidden_exchange;
use super::hypothesis::{Cause, Hypothesis, Mistake, Rival};
use super::likelihood::decisively_likelier;
use super::other_link::OtherLink;
use super::reversed::{all_reversed, reversed_beside_others, reversed_wrist, solve_with};
use super::turned_sensors::TurnedSensors;
use super::{
    exchanged_load, mislabelled_poses, other_hemisphere, other_unit, reversed_in_table, swapped_columns,
    turned_orientations,
};
use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::solved::Solved;
use crate::joint::starting::sample::telling_part;
use crate::joint::starting::start::start_cost;
use crate::joint::variables::State;

/// A mistake must lower the cost of a start to this share of it; the cost of a solution likewise.
pub(super) const BETTER_START: f64 = 0.7;
pub(super) const BETTER: f64 = 0.2;
/// A mistake that leaves so large a share of the residuals is not the only one.
const MOST_OF_IT: f64 = 0.25;
/// How many of the most promising are solved for.
pub(super) const SOLVED: usize = 3;
/// Arms of few joints look much alike with one axis turned round as with another mistake: that one must explain the readings so much better to be named.
const TURNED_ROUND: f64 = 0.5;

impl Solved {
    /// Whether its fit says nothing for the session: noise or errors that were found may excuse a mistake, or the stated noise rules it out.
    ///
    /// # Errors
    /// Where the model has no finite value at the solution.
    pub(in crate::joint) fn may_hide_mistake(&self, session: &Session) -> Result<bool, EvaluateError> {
        let found = session.noise_estimated().contains(&true) || !self.estimate.termination.converged();
        Ok(found || self.has_large_unexplained_errors(session)? || self.misfit(session)?.is_some())
    }
}

/// Looks for a mistake that explains what a solution does not: to be asked where its fit says nothing for it.
pub(in crate::joint) fn contradicting_mistake(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Cause>, EstimateError> {
    if solved.estimate.termination == Termination::Stopped || environment.stopped() {
        return Ok(None);
    }
    match reversed_beside_others(session, solved, environment)? {
        Some(reversed) => Ok(Some(reversed.into())),
        None => other_mistake(session, solved, environment),
    }
}

/// Looks for a mistake of which residuals say nothing: exchanged tables, and signs that turn those of all masses.
pub(in crate::joint) fn hidden_mistake(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Cause>, EstimateError> {
    if solved.estimate.termination == Termination::Stopped || environment.stopped() {
        return Ok(None);
    }
    if let Some(exchanged) = hidden_exchange(session, solved, environment)? {
        return Ok(Some(exchanged.into()));
    }
    let reversed = all_reversed(session, solved, environment)?;
    Ok(reversed.or_else(|| reversed_wrist(session, solved)).map(Cause::from))
}

/// Looks for one thing other than a torque sensor's sign that explains what a solution does not.
fn other_mistake(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Cause>, EstimateError> {
    // Noise found from residuals would excuse the very joints that are swapped.
    let unexcused = solved.readings().unexcused(session);
    let readings = telling_part(session, &unexcused);
    let Promising { hypotheses, tried } = promising(session, &readings, solved)?;
    // A start hardly costs less without so few: they are tried in any case.
    let of_poses = mislabelled_poses::all(session, &unexcused, solved)?;
    if hypotheses.is_empty() && of_poses.is_none() {
        return Ok(None);
    }
    environment.report("looking for swapped columns");
    let (as_it_stands, _) = solve_with(session, &readings, solved, environment)?;
    let trial = Trial { session, readings: &readings, solved, environment, as_it_stands };
    let (turned_round, others): (Vec<_>, Vec<_>) =
        hypotheses.into_iter().partition(|hypothesis| hypothesis.looks_like_others());
    let others = others.into_iter().take(SOLVED).chain(of_poses);
    let turned_round = turned_round.into_iter().take(SOLVED);
    let Some((best, as_good)) = likeliest(trial.best(others)?, trial.best(turned_round)?) else { return Ok(None) };
    let part = telling_part(session, solved.readings());
    let made = (&best.hypothesis.made(session), best.hypothesis.read(&part), best.end.clone());
    let tried = tried as f64 + best.hypothesis.alternatives(session);
    let likelier = decisively_likelier(made, (session, solved), tried, environment)?;
    Ok(likelier.then(|| best.report(session, as_good.as_deref())))
}

/// All that is tried, but for what hangs on a place.
fn hypotheses(session: &Session) -> Vec<Arc<dyn Hypothesis>> {
    TurnedSensors::all(session)
        .into_iter()
        .chain(swapped_columns::all(session))
        .chain(turned_orientations::all(session))
        .chain(other_hemisphere::all(session))
        .chain(exchanged_load::all(session))
        .chain(reversed_in_table::all(session))
        .chain(other_unit::all(session))
        .chain(OtherLink::all(session).into_iter().map(|other| Arc::new(other) as Arc<dyn Hypothesis>))
        .chain(ExchangedAxes::all(session).into_iter().map(|axes| Arc::new(axes) as Arc<dyn Hypothesis>))
        .collect()
}

/// What is worth solving, the most promising first, and how many were tried.
struct Promising {
    hypotheses: Vec<Arc<dyn Hypothesis>>,
    tried: usize,
}

/// By what their starts cost.
fn promising(session: &Session, readings: &MeasurementSet, solved: &Solved) -> Result<Promising, EstimateError> {
    let start = start_cost(session, readings)?;
    let tried = hypotheses(session);
    let promise = |hypothesis: &Arc<dyn Hypothesis>| {
        Ok((start_cost(&hypothesis.made(session), &hypothesis.read(readings))?, Arc::clone(hypothesis)))
    };
    let (changed, tried_of_changed) = changed_loads(session, readings, start)?;
    let changed = changed.into_iter().map(|(cost, changed)| (cost, Arc::new(changed) as Arc<dyn Hypothesis>));
    let promises: Result<Vec<_>, EstimateError> = in_parallel(&tried, promise).into_iter().collect();
    let with_suspicion =
        |(cost, hypothesis): (f64, Arc<dyn Hypothesis>)| (!hypothesis.is_suspected(session, solved), cost, hypothesis);
    let mut promises: Vec<_> = promises?.into_iter().chain(changed).map(with_suspicion).collect();
    promises.retain(|(unsuspected, cost, _)| !unsuspected || *cost < BETTER_START * start);
    promises.sort_by(|(a, of_a, _), (b, of_b, _)| a.cmp(b).then(of_a.total_cmp(of_b)));
    let hypotheses = promises.into_iter().map(|(.., hypothesis)| hypothesis).collect();
    Ok(Promising { hypotheses, tried: tried.len() + tried_of_changed })
}

/// What hypotheses are tried with.
struct Trial<'a> {
    session: &'a Session,
    readings: &'a MeasurementSet,
    solved: &'a Solved,
    environment: &'a SolveEnvironment<'a>,
    /// What the session as it stands costs.
    as_it_stands: f64,
}

impl Trial<'_> {
    /// The one that explains the readings best, if any does so far better than its rival.
    fn best(&self, promising: impl Iterator<Item = Arc<dyn Hypothesis>>) -> Result<Option<Explanation>, EstimateError> {
        let mut best: Option<Explanation> = None;
        for hypothesis in promising {
            let explanation = self.explanation(hypothesis)?;
            let explains = explanation.after < BETTER * explanation.before;
            if explains && best.as_ref().is_none_or(|best| explanation.after < best.after) {
                best = Some(explanation);
            }
        }
        Ok(best)
    }

    fn explanation(&self, mut hypothesis: Arc<dyn Hypothesis>) -> Result<Explanation, EstimateError> {
        let before = match hypothesis.rival(self.session) {
            Rival::AsItStands => self.as_it_stands,
            Rival::Solution => self.cost_of_solution()?,
            Rival::AlsoWith(less_stated) => self.solve(&less_stated, self.readings)?.0.min(self.as_it_stands),
        };
        let solve =
            |hypothesis: &dyn Hypothesis| self.solve(&hypothesis.made(self.session), &hypothesis.read(self.readings));
        let (mut after, mut end) = solve(&*hypothesis)?;
        if let Some(placed) = hypothesis.placed(self.session, self.readings, &end)? {
            hypothesis = placed;
            (after, end) = solve(&*hypothesis)?;
        }
        Ok(Explanation { hypothesis, before, after, end })
    }

    fn solve(&self, session: &Session, readings: &MeasurementSet) -> Result<(f64, State), EstimateError> {
        solve_with(session, readings, self.solved, self.environment)
    }

    /// The cost of the solution with the noise of these readings.
    fn cost_of_solution(&self) -> Result<f64, EstimateError> {
        let here = self.solved.state(&State::nominal(self.session));
        let built = build_with_constraints(self.session, self.readings, &here)?;
        Ok(built.problem.cost(&built.initial)?)
    }
}

/// A hypothesis that explains the readings: their cost without it and with it, and where its solution ends.
#[derive(Clone, Debug)]
struct Explanation {
    hypothesis: Arc<dyn Hypothesis>,
    before: f64,
    after: f64,
    end: State,
}

impl Explanation {
    /// `as_good`: what explains the readings about as well.
    fn report(&self, session: &Session, as_good: Option<&dyn Hypothesis>) -> Cause {
        in_words(&*self.hypothesis, session, (self.after / self.before).sqrt(), as_good)
    }
}

/// A hypothesis that leaves such a share of the residuals; `as_good`: what explains the readings about as well.
pub(super) fn in_words(
    hypothesis: &dyn Hypothesis,
    session: &Session,
    share: f64,
    as_good: Option<&dyn Hypothesis>,
) -> Cause {
    let (what, cure) = hypothesis.words(session);
    let or = as_good
        .map(|other| other.words(session))
        .map_or_else(String::new, |(what, cure)| format!(" Another cause explains them about as well: {what}. {cure}"));
    let percent = 100.0 * share;
    let advice = match share < MOST_OF_IT {
        true => format!(
            "The likely cause is {what}: with that mended, the residuals of all readings fall to {percent:.2} % of what they \
             were. {cure}{or}"
        ),
        false => format!(
            "One cause may be {what}: with that mended, the residuals of all readings fall, but only to {percent:.0} % of what \
             they were. Something else is wrong, or this is what looks most like it. {cure}{or}"
        ),
    };
    Cause { mistake: Mistake { what, advice }, explains_all: share < MOST_OF_IT }
}

/// The one of two that is named, and an axis turned round that explains the readings about as well as the other.
fn likeliest(
    other: Option<Explanation>,
    turned_round: Option<Explanation>,
) -> Option<(Explanation, Option<Arc<dyn Hypothesis>>)> {
    let Some(other) = other else { return turned_round.map(|turned_round| (turned_round, None)) };
    match turned_round {
        Some(turned_round) if turned_round.after < TURNED_ROUND * other.after => Some((turned_round, None)),
        Some(turned_round) if TURNED_ROUND * turned_round.after < other.after => {
            Some((other, Some(turned_round.hypothesis)))
        }
        _ => Some((other, None)),
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::result::Verdict;
    use crate::testing::sarcos_shoulder;
    use crate::testing::sensor_models::estimate;

    /// The reference protocol without a stated noise, the signs of its sensors declared.
    fn without_noise() -> Session {
        let mut session = sarcos_shoulder().session(0);
        session.poses.iter_mut().flat_map(|pose| pose.torque.iter_mut().flatten()).for_each(|r| r.std = None);
        session.joints.iter_mut().for_each(|joint| joint.torque_sign_declared = true);
        session
    }

    fn assert_blamed(session: &Session, what: &str) {
        let result = estimate(session);
        assert_eq!(result.verdict, Verdict::Failed, "{:?}", result.notes);
        assert!(result.notes.iter().any(|note| note.contains(what)), "{:?}", result.notes);
    }

    #[test]
    fn a_zero_half_a_turn_away_is_named() {
        let mut session = without_noise();
        session.poses.iter_mut().for_each(|pose| pose.position[1] += PI);
        assert_blamed(&session, "zero is half a turn away: joint2");
    }

    #[test]
    fn an_axis_turned_round_is_named_where_it_explains_twice_as_much_and_told_where_as_much() {
        let session = sarcos_shoulder().session(0);
        let explains = |hypothesis: TurnedSensors, after: f64| {
            let hypothesis = Arc::new(hypothesis);
            Some(Explanation { hypothesis, before: 100.0, after, end: State::nominal(&session) })
        };
        let (half_turned, turned_round) = (TurnedSensors::half_a_turn(0), TurnedSensors::axis(1));
        let what = |hypothesis: &dyn Hypothesis| hypothesis.words(&session).0;
        let named = |after: [f64; 2]| {
            let of_two = likeliest(explains(half_turned, after[0]), explains(turned_round, after[1])).unwrap();
            (what(&*of_two.0.hypothesis), of_two.1.as_deref().map(what))
        };
        assert_eq!(named([1.0, 0.4]), (what(&turned_round), None));
        assert_eq!(named([1.0, 0.6]), (what(&half_turned), Some(what(&turned_round))));
        assert_eq!(named([1.0, 1.9]), (what(&half_turned), Some(what(&turned_round))));
        assert_eq!(named([1.0, 2.1]), (what(&half_turned), None));
        assert!(likeliest(None, explains(turned_round, 1.0)).is_some() && likeliest(None, None).is_none());
        let advice = explains(half_turned, 1.0).unwrap().report(&session, Some(&turned_round)).mistake.advice;
        assert!(
            advice.contains("half a turn away: joint1") && advice.contains("as well: joint that turns"),
            "{advice}"
        );
    }

    #[test]
    fn each_hypothesis_is_its_own_reverse() {
        let mut session = sarcos_shoulder().session(0);
        session.loads.truncate(1);
        session.poses.iter_mut().for_each(|pose| pose.load = pose.load.map(|_| 0));
        let rounded = |number: f64| (1e9 * number).round();
        // Loads on another link forget what is stated of their places, which cannot be had back.
        let (elsewhere, hypotheses): (Vec<_>, Vec<_>) = hypotheses(&session)
            .into_iter()
            .partition(|hypothesis| matches!(hypothesis.rival(&session), Rival::AlsoWith(_)));
        // Nor is another unit its own reverse.
        let (units, hypotheses): (Vec<_>, Vec<_>) =
            hypotheses.into_iter().partition(|hypothesis| hypothesis.words(&session).0.contains("declared as"));
        let in_tables = 3 * session.tables.len();
        assert_eq!((elsewhere.len(), units.len(), hypotheses.len()), (2, 1, 3 + 3 + 3 + 3 + 3 + 3 + 1 + 1 + in_tables));
        for hypothesis in hypotheses {
            let once = hypothesis.made(&session);
            let twice = hypothesis.made(&once);
            let said = |session: &Session| {
                let sensors: Vec<[f64; 3]> = session
                    .joints
                    .iter()
                    .map(|joint| [0, 2, 3].map(|p| rounded(joint.parameters[p].nominal)))
                    .collect();
                (session.poses.clone(), sensors, session.gravity.hemisphere)
            };
            assert!(said(&once) != said(&session), "{hypothesis:?} changes nothing");
            assert!(said(&twice) == said(&session), "{hypothesis:?}");
        }
    }
}
