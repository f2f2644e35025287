//! What a session may have got wrong, found by trying: where the readings contradict the model, a session that differs from it in one
//! thing and explains them names that thing.
//!
//! Tried are torque sensors that read the other way (`reversed.rs`), position sensors that do, or whose zero is half a turn away, joints that turn the other way
//! than the robot's description says, columns of two joints that are
//! swapped, of torques, of positions or of both, orientations that turn the other way, gravity in the other hemisphere than the declared one, tables
//! with and without the load exchanged, axes of a force-torque sensor that are (`exchanged_axes.rs`), loads on another link than stated (`other_link.rs`), and a load that is taken off or put on in the middle
//! of a table (`changed_load.rs`).
//!
//! A mistake is no image of the solution (`symmetries/`): its session states another problem, and the estimate stays that of the session as it
//! stands. Of few readings some mistake always explains more, by chance. One is named only where the likelihood is decisively higher, the noise
//! found anew with it, and allowing for how many were tried.

use std::borrow::Cow;
use std::f64::consts::PI;

use gravcal_dynamics::JointKind;
use gravcal_estimation::{EvaluateError, Termination, in_parallel};
use gravcal_identification::{DECISIVE, SolveEnvironment};
use gravcal_recording::Orientation;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;
use nalgebra::Vector3;

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::{MeasurementSet, first_noise};
use crate::joint::mistakes::changed_load::{ChangedLoad, changed_loads};
use crate::joint::mistakes::exchanged_axes::ExchangedAxes;
use crate::joint::mistakes::other_link::OtherLink;
use crate::joint::mistakes::reversed::{all_reversed, reversed_beside_others, reversed_wrist, solve_with};
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::starting::sample::telling_part;
use crate::joint::starting::start::start_cost;
use crate::joint::variables::State;

/// A mistake must lower the cost of a start to this share of it; the cost of a solution likewise.
const BETTER_START: f64 = 0.7;
const BETTER: f64 = 0.2;
/// Noise that is found from fewer degrees of freedom than this part of the numbers that are fitted may by chance be anything, and with it the
/// likelihood.
const TELLING: usize = 2;
/// From so far from the middle of the declared hemisphere on gravity may lie in the other one, rad.
const EDGE: f64 = std::f64::consts::FRAC_PI_3;
/// How many of the most promising are solved for.
const SOLVED: usize = 3;
/// Arms of few joints look much alike with one axis turned round as with another mistake: that one must explain the readings so much better to be named.
const TURNED_ROUND: f64 = 0.5;

/// A mistake, and what to do about it.
#[derive(Clone, Debug)]
pub(in crate::joint) struct Mistake {
    /// In a few words.
    pub what: String,
    /// In sentences.
    pub advice: String,
}

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
) -> Result<Option<Mistake>, EstimateError> {
    if solved.estimate.termination == Termination::Stopped || environment.stopped() {
        return Ok(None);
    }
    match reversed_beside_others(session, solved, environment)? {
        Some(reversed) => Ok(Some(reversed)),
        None => mistaken_columns(session, solved, environment),
    }
}

/// Looks for a mistake of which residuals say nothing: signs that turn those of all masses.
pub(in crate::joint) fn hidden_mistake(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Mistake>, EstimateError> {
    if solved.estimate.termination == Termination::Stopped || environment.stopped() {
        return Ok(None);
    }
    let reversed = all_reversed(session, solved, environment)?;
    Ok(reversed.or_else(|| reversed_wrist(session, solved)))
}

/// One thing that a session may have got wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hypothesis {
    PositionReversed(usize),
    /// Torque and position sensor both: its axis points the other way.
    AxisReversed(usize),
    /// Its zero is half a turn from where it is said to be.
    PositionHalfTurned(usize),
    TorquesSwapped(usize, usize),
    PositionsSwapped(usize, usize),
    /// Torques and positions both: columns in another order than the robot's joints.
    JointsSwapped(usize, usize),
    OrientationsInverted,
    /// Gravity points to the other hemisphere than the declared one.
    HemisphereInverted,
    /// Poses that are said to be bare carry the one load there is, and the other way round.
    LoadExchanged,
    /// From a pose of its table on, or before it, the load is another than said.
    LoadChanged(ChangedLoad),
    /// Loads are on another link than stated.
    LoadsElsewhere(OtherLink),
    /// Of a force-torque sensor.
    AxesExchanged(ExchangedAxes),
}

fn mistaken_columns(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Mistake>, EstimateError> {
    // Noise found from residuals would excuse the very joints that are swapped.
    let unexcused = solved.readings().unexcused(session);
    let readings = telling_part(session, &unexcused);
    let start = start_cost(session, &readings)?;
    let hypotheses = hypotheses(session);
    let promise = |hypothesis: &Hypothesis| {
        Ok((start_cost(&hypothesis.made(session), &hypothesis.read(&readings))?, *hypothesis))
    };
    let promising: Result<Vec<_>, EstimateError> = in_parallel(&hypotheses, promise).into_iter().collect();
    let mut promising = promising?;
    let (changed, tried_of_changed) = changed_loads(session, &readings, start)?;
    promising.extend(changed.into_iter().map(|(cost, changed)| (cost, Hypothesis::LoadChanged(changed))));
    // Beyond the edge of the declared hemisphere lies gravity that starts on this side of it as well.
    let near_edge = near_edge(session, solved);
    let worth = |cost: f64, hypothesis: Hypothesis| {
        cost < BETTER_START * start || near_edge && hypothesis == Hypothesis::HemisphereInverted
    };
    promising.retain(|(cost, hypothesis)| worth(*cost, *hypothesis));
    if promising.is_empty() {
        return Ok(None);
    }
    let later = |hypothesis: Hypothesis| !(near_edge && hypothesis == Hypothesis::HemisphereInverted);
    promising.sort_by(|(a, of_a), (b, of_b)| later(*of_a).cmp(&later(*of_b)).then(a.total_cmp(b)));
    environment.report("looking for swapped columns");
    let (as_it_stands, _) = solve_with(session, &readings, solved, environment)?;
    let (turned_round, others): (Vec<_>, Vec<_>) =
        promising.into_iter().partition(|(_, hypothesis)| matches!(hypothesis, Hypothesis::AxisReversed(_)));
    let best = |promising: Vec<(f64, Hypothesis)>| {
        let mut best: Option<Explanation> = None;
        for (_, hypothesis) in promising.into_iter().take(SOLVED) {
            // Sensors that all read the other way explain gravity in the other hemisphere as well, and are not as declared: there the solution counts.
            let before = match hypothesis {
                Hypothesis::HemisphereInverted => cost_of(session, &readings, solved)?,
                Hypothesis::LoadsElsewhere(other) => {
                    solve_with(&other.anywhere(session), &readings, solved, environment)?.0.min(as_it_stands)
                }
                _ => as_it_stands,
            };
            let solve = |hypothesis: Hypothesis| {
                solve_with(&hypothesis.made(session), &hypothesis.read(&readings), solved, environment)
            };
            let (mut after, mut end) = solve(hypothesis)?;
            let mut hypothesis = hypothesis;
            if let Hypothesis::LoadChanged(changed) = hypothesis {
                hypothesis = Hypothesis::LoadChanged(changed.placed(session, &readings, &end)?);
                (after, end) = solve(hypothesis)?;
            }
            if after < BETTER * before && best.as_ref().is_none_or(|best| after < best.after) {
                best = Some(Explanation { hypothesis, before, after, end });
            }
        }
        Ok::<_, EstimateError>(best)
    };
    let Some((best, as_good)) = likeliest(best(others)?, best(turned_round)?) else { return Ok(None) };
    let Explanation { hypothesis, before, after, end } = best;
    let tried = hypotheses.len() + tried_of_changed;
    let part = telling_part(session, solved.readings());
    let made = (&hypothesis.made(session), hypothesis.read(&part), end);
    let likelier = decisively_likelier(made, (session, solved), tried, environment)?;
    Ok(likelier.then(|| hypothesis.report(session, 100.0 * (after / before).sqrt(), as_good)))
}

/// A hypothesis that explains the readings: their cost without it and with it, and where its solution ends.
#[derive(Clone, Debug)]
struct Explanation {
    hypothesis: Hypothesis,
    before: f64,
    after: f64,
    end: State,
}

/// The one of two that is named, and an axis turned round that explains the readings about as well as the other.
fn likeliest(
    other: Option<Explanation>,
    turned_round: Option<Explanation>,
) -> Option<(Explanation, Option<Hypothesis>)> {
    let Some(other) = other else { return turned_round.map(|turned_round| (turned_round, None)) };
    match turned_round {
        Some(turned_round) if turned_round.after < TURNED_ROUND * other.after => Some((turned_round, None)),
        Some(turned_round) if TURNED_ROUND * turned_round.after < other.after => {
            Some((other, Some(turned_round.hypothesis)))
        }
        _ => Some((other, None)),
    }
}

/// The cost of the solution with the noise of these readings.
fn cost_of(session: &Session, readings: &MeasurementSet, solved: &Solved) -> Result<f64, EstimateError> {
    let built = build_with_constraints(session, readings, &solved.state(&State::nominal(session)))?;
    Ok(built.problem.cost(&built.initial)?)
}

/// Whether a session with its readings, started there, explains them so much better than the solution that it is no accident of having
/// tried so many, nor of few readings without stated noise. Of many readings those of a part suffice ([`telling_part`]).
pub(in crate::joint) fn decisively_likelier(
    (made, readings, start): (&Session, MeasurementSet, State),
    (session, solved): (&Session, &Solved),
    tried: usize,
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
    Ok(gain > DECISIVE + (tried as f64).ln())
}

fn hypotheses(session: &Session) -> Vec<Hypothesis> {
    let joints = session.joints.len();
    let pairs = || (0..joints).flat_map(|second| (0..second).map(move |first| (first, second)));
    let torques = pairs().filter(|(a, b)| {
        let [a, b] = [a, b].map(|joint| &session.joints[*joint]);
        a.torque_unit.is_some() && a.torque_unit == b.torque_unit
    });
    let positions = pairs().filter(|(a, b)| session.joints[*a].position_unit == session.joints[*b].position_unit);
    let turns = |joint: &usize| session.robot.chain.joints()[*joint].kind == JointKind::Revolute;
    (0..joints)
        .map(Hypothesis::PositionReversed)
        .chain((0..joints).map(Hypothesis::AxisReversed))
        .chain((0..joints).filter(turns).map(Hypothesis::PositionHalfTurned))
        .chain(torques.map(|(a, b)| Hypothesis::TorquesSwapped(a, b)))
        .chain(positions.clone().map(|(a, b)| Hypothesis::PositionsSwapped(a, b)))
        .chain(
            positions
                .filter(|(a, b)| {
                    session.joints[*a].torque_unit.is_some()
                        && session.joints[*a].torque_unit == session.joints[*b].torque_unit
                })
                .map(|(a, b)| Hypothesis::JointsSwapped(a, b)),
        )
        .chain(session.readings.orientation.is_some().then_some(Hypothesis::OrientationsInverted))
        .chain(session.gravity.hemisphere.is_some().then_some(Hypothesis::HemisphereInverted))
        .chain(exchangeable(session).then_some(Hypothesis::LoadExchanged))
        .chain(OtherLink::all(session).into_iter().map(Hypothesis::LoadsElsewhere))
        .chain(ExchangedAxes::all(session).into_iter().map(Hypothesis::AxesExchanged))
        .collect()
}

/// Whether gravity came out so far from the middle of the declared hemisphere that the truth may lie in the other one.
fn near_edge(session: &Session, solved: &Solved) -> bool {
    let (Some(pole), g) = (session.gravity.hemisphere, solved.state(&State::nominal(session)).gravity) else {
        return false;
    };
    let (pole, g) = (Vector3::from(pole), Vector3::from(g));
    g.dot(&pole) < EDGE.cos() * g.norm() * pole.norm()
}

/// Whether some poses carry the only load, and some none.
fn exchangeable(session: &Session) -> bool {
    let loaded = session.poses.iter().filter(|pose| pose.load.is_some()).count();
    session.loads.len() == 1 && (1..session.poses.len()).contains(&loaded)
}

impl Hypothesis {
    /// The session as it would be right.
    fn made(self, session: &Session) -> Session {
        let mut made = session.clone();
        match self {
            Hypothesis::PositionReversed(joint) => {
                made.joints[joint].parameters[SensorParameter::PositionGain as usize].nominal *= -1.0;
            }
            Hypothesis::AxisReversed(joint) => {
                for gain in [SensorParameter::PositionGain, SensorParameter::TorqueGain] {
                    made.joints[joint].parameters[gain as usize].nominal *= -1.0;
                }
            }
            Hypothesis::PositionHalfTurned(joint) => {
                let offset = &mut made.joints[joint].parameters[SensorParameter::PositionOffset as usize].nominal;
                *offset += if *offset > 0.0 { -PI } else { PI };
            }
            Hypothesis::TorquesSwapped(a, b) => made.poses.iter_mut().for_each(|pose| pose.torque.swap(a, b)),
            Hypothesis::PositionsSwapped(a, b) => made.poses.iter_mut().for_each(|pose| pose.swap_positions(a, b)),
            Hypothesis::JointsSwapped(a, b) => made.poses.iter_mut().for_each(|pose| {
                pose.torque.swap(a, b);
                pose.swap_positions(a, b);
            }),
            Hypothesis::HemisphereInverted => {
                made.gravity.hemisphere = session.gravity.hemisphere.map(|pole| pole.map(|component| -component));
            }
            Hypothesis::LoadExchanged => {
                made.poses.iter_mut().for_each(|pose| pose.load = if pose.load.is_some() { None } else { Some(0) });
            }
            Hypothesis::LoadChanged(changed) => return changed.made(session),
            Hypothesis::LoadsElsewhere(other) => return other.made(session),
            Hypothesis::AxesExchanged(axes) => return axes.made(session),
            Hypothesis::OrientationsInverted => {
                for pose in &mut made.poses {
                    let transposed = |rows: Orientation| [0, 1, 2].map(|i| [0, 1, 2].map(|j| rows[j][i]));
                    pose.orientation = pose.orientation.map(transposed);
                }
            }
        }
        made
    }

    /// The readings as that session has them.
    fn read(self, readings: &MeasurementSet) -> MeasurementSet {
        match self {
            Hypothesis::TorquesSwapped(a, b) | Hypothesis::JointsSwapped(a, b) => readings.exchanged(a, b),
            _ => readings.clone(),
        }
    }

    /// `share`: of the residuals that is left, %; `as_good`: what explains the readings about as well.
    fn report(self, session: &Session, share: f64, as_good: Option<Hypothesis>) -> Mistake {
        let (what, cure) = self.words(session);
        let or = as_good.map(|other| other.words(session)).map_or_else(String::new, |(what, cure)| {
            format!(" Another cause explains them about as well: {what}. {cure}")
        });
        let advice = format!(
            "The likely cause is {what}: with that mended, the residuals of all readings fall to {share:.2} % of what they \
             were. {cure}{or}"
        );
        Mistake { what, advice }
    }

    /// What it is, and what to do about it.
    fn words(self, session: &Session) -> (String, String) {
        let name = |joint: usize| session.robot.chain.joints()[joint].name.as_str();
        match self {
            Hypothesis::PositionReversed(joint) => (
                format!("reversed position sensor: {}", name(joint)),
                "Say position_sign = \"reversed\" in its [[joint]].".to_owned(),
            ),
            Hypothesis::AxisReversed(joint) => (
                format!("joint that turns the other way than the robot's description says: {}", name(joint)),
                "Turn its axis round there, or say position_sign = \"reversed\" and torque_sign = \"reversed\" in its [[joint]].".to_owned(),
            ),
            Hypothesis::PositionHalfTurned(joint) => (
                format!("position sensor whose zero is half a turn away: {}", name(joint)),
                "Say position_offset = { nominal = 180, unit = \"deg\" } in its [[joint]], or add half a turn to what stands there.".to_owned(),
            ),
            Hypothesis::TorquesSwapped(a, b) => (
                format!("swapped torque columns: {} and {}", name(a), name(b)),
                "Exchange them in [readings] torque columns.".to_owned(),
            ),
            Hypothesis::PositionsSwapped(a, b) => (
                format!("swapped position columns: {} and {}", name(a), name(b)),
                "Exchange them in [readings] position columns.".to_owned(),
            ),
            Hypothesis::JointsSwapped(a, b) => (
                format!("torque and position columns of {} and {}, which are swapped", name(a), name(b)),
                "Exchange them in [readings], in the columns of position and of torque: columns stand in the order of the robot's joints.".to_owned(),
            ),
            Hypothesis::HemisphereInverted => (
                "gravity in the other hemisphere than the declared one".to_owned(),
                "Correct [gravity] hemisphere; or, if it is right, all torques have the other sign (torque_sign = \"reversed\" in [joints])."
                    .to_owned(),
            ),
            Hypothesis::LoadExchanged => (
                format!("tables with and without load {} exchanged", session.loads[0].name),
                "Exchange load = … among the [[poses]].".to_owned(),
            ),
            Hypothesis::LoadChanged(changed) => changed.report(session),
            Hypothesis::LoadsElsewhere(other) => other.report(session),
            Hypothesis::AxesExchanged(axes) => axes.report(session),
            Hypothesis::OrientationsInverted => {
                let inverse = session.readings.orientation.as_ref().is_some_and(|columns| columns.body_from_base);
                let other = if inverse { "base-from-body" } else { "body-from-base" };
                (
                    "orientations that turn the other way".to_owned(),
                    format!("Say rotation = \"{other}\" in readings.orientation."),
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::{Signals, select, solve};
    use crate::result::Verdict;
    use crate::testing::sensor_models::estimate;
    use crate::testing::{sarcos_shoulder, with_environment};
    use gravcal_robot_model::session::{ParameterPrior, PriorKind};

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
                decisively_likelier(made, (&wrong, &solved), tried, environment)
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
                let decided = decisively_likelier(made, (&wrong, &solved), 1, environment)?;
                Ok::<_, EstimateError>((rows as f64 / rank as f64, decided))
            })
            .unwrap()
        };
        let ((many, of_many), (few, of_few)) = (decided(6), decided(45));
        assert!(many > 1.5 && of_many, "{many}");
        assert!(few < 1.5 && !of_few, "{few}");
    }

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
        let explains = |hypothesis: Hypothesis, after: f64| {
            Some(Explanation { hypothesis, before: 100.0, after, end: State::nominal(&session) })
        };
        let (half_turned, turned_round) = (Hypothesis::PositionHalfTurned(0), Hypothesis::AxisReversed(1));
        let named = |after: [f64; 2]| {
            let of_two = likeliest(explains(half_turned, after[0]), explains(turned_round, after[1])).unwrap();
            (of_two.0.hypothesis, of_two.1)
        };
        assert_eq!(named([1.0, 0.4]), (turned_round, None));
        assert_eq!(named([1.0, 0.6]), (half_turned, Some(turned_round)));
        assert_eq!(named([1.0, 1.9]), (half_turned, Some(turned_round)));
        assert_eq!(named([1.0, 2.1]), (half_turned, None));
        assert!(likeliest(None, explains(turned_round, 1.0)).is_some() && likeliest(None, None).is_none());
        let advice = half_turned.report(&session, 1.0, Some(turned_round)).advice;
        assert!(
            advice.contains("half a turn away: joint1") && advice.contains("as well: joint that turns"),
            "{advice}"
        );
    }

    /// From 60° on the other hemisphere is tried whatever its start costs.
    #[test]
    fn gravity_far_from_the_middle_of_its_hemisphere_may_lie_in_the_other_one() {
        let (_, solved, mut session) = with_wrong_offset(0.0);
        let g = Vector3::from(solved.state(&State::nominal(&session)).gravity).normalize();
        let across = g.cross(&Vector3::x()).normalize();
        let mut near = |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            session.gravity.hemisphere = Some((cosine * g + sine * across).into());
            near_edge(&session, &solved)
        };
        assert_eq!([0.0, 59.0, 61.0, 87.0].map(&mut near), [false, false, true, true]);
        session.gravity.hemisphere = None;
        assert!(!near_edge(&session, &solved));
    }

    #[test]
    fn each_hypothesis_is_its_own_reverse() {
        let mut session = sarcos_shoulder().session(0);
        session.loads.truncate(1);
        session.poses.iter_mut().for_each(|pose| pose.load = pose.load.map(|_| 0));
        let rounded = |number: f64| (1e9 * number).round();
        let (elsewhere, hypotheses): (Vec<_>, Vec<_>) = hypotheses(&session)
            .into_iter()
            .partition(|hypothesis| matches!(hypothesis, Hypothesis::LoadsElsewhere(_)));
        assert_eq!(elsewhere.len(), 2, "what they forget cannot be had back (`other_link.rs`)");
        assert!(hypotheses.contains(&Hypothesis::LoadExchanged) && hypotheses.len() == 3 + 3 + 3 + 3 + 3 + 3 + 1 + 1);
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
