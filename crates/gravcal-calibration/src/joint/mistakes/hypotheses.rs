//! What a session may have got wrong, found by trying: where the readings contradict the model, a session that differs from it in one
//! thing and explains them names that thing.
//!
//! Tried are torque sensors that read the other way (`reversed.rs`), position sensors that do, columns of two joints that are
//! swapped, of torques or of positions, orientations that turn the other way, gravity in the other hemisphere than the declared one, tables
//! with and without the load exchanged, axes of a force-torque sensor that are (`exchanged_axes.rs`), and a load that is lost in the middle
//! of a table (`lost_load.rs`).
//!
//! A mistake is no image of the solution (`symmetries/`): its session states another problem, and the estimate stays that of the session as it
//! stands. Of few readings some mistake always explains more, by chance. One is named only where the likelihood is decisively higher, the noise
//! found anew with it, and allowing for how many were tried.

use gravcal_estimation::Termination;
use gravcal_identification::{DECISIVE, SolveEnvironment};
use gravcal_recording::Orientation;
use gravcal_robot_model::parameter::SensorParameter;
use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::{MeasurementSet, first_noise};
use crate::joint::mistakes::exchanged_axes::ExchangedAxes;
use crate::joint::mistakes::lost_load::{LostLoad, lost_loads};
use crate::joint::mistakes::reversed::{reversed_sensors, reversed_wrist, solve_with};
use crate::joint::solved::Solved;
use crate::joint::solving::solve_from::solve_from;
use crate::joint::starting::start::start_cost;
use crate::joint::variables::State;

/// A mistake must lower the cost of a start to this share of it; the cost of a solution likewise.
const BETTER_START: f64 = 0.7;
const BETTER: f64 = 0.2;
/// Noise that is found from fewer degrees of freedom than this part of the numbers that are fitted may by chance be anything, and with it the
/// likelihood.
const TELLING: usize = 2;
/// How many of the most promising are solved for.
const SOLVED: usize = 3;

/// A mistake, and what to do about it.
pub(in crate::joint) struct Mistake {
    /// In a few words.
    pub what: String,
    /// In sentences.
    pub advice: String,
}

/// Looks for a mistake behind a solution. `doubtful`: whether its fit says nothing for it.
pub(in crate::joint) fn find_mistake(
    session: &Session,
    solved: &Solved,
    doubtful: bool,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Mistake>, EstimateError> {
    if solved.estimate.termination == Termination::Stopped || environment.stopped() {
        return Ok(None);
    }
    if let Some(reversed) = reversed_sensors(session, solved, doubtful, environment)? {
        return Ok(Some(reversed));
    }
    // What explains readings that are not explained comes before what turns the sign of a mass and explains nothing.
    let mistaken = if doubtful { mistaken_columns(session, solved, environment)? } else { None };
    Ok(mistaken.or_else(|| reversed_wrist(session, solved)))
}

/// One thing that a session may have got wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Hypothesis {
    PositionReversed(usize),
    TorquesSwapped(usize, usize),
    PositionsSwapped(usize, usize),
    OrientationsInverted,
    /// Gravity points to the other hemisphere than the declared one.
    HemisphereInverted,
    /// Poses that are said to be bare carry the one load there is, and the other way round.
    LoadExchanged,
    /// The load is gone from a pose of its table on.
    LoadLost(LostLoad),
    /// Of a force-torque sensor.
    AxesExchanged(ExchangedAxes),
}

fn mistaken_columns(
    session: &Session,
    solved: &Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Option<Mistake>, EstimateError> {
    // Noise found from residuals would excuse the very joints that are swapped.
    let readings = solved.readings.unexcused(session);
    let start = start_cost(session, &readings)?;
    let mut promising = Vec::new();
    let hypotheses = hypotheses(session);
    for hypothesis in &hypotheses {
        promising.push((start_cost(&hypothesis.made(session), &hypothesis.read(&readings))?, *hypothesis));
    }
    let (lost, tried_of_lost) = lost_loads(session, &readings)?;
    promising.extend(lost.into_iter().map(|(cost, lost)| (cost, Hypothesis::LoadLost(lost))));
    promising.retain(|(cost, _)| *cost < BETTER_START * start);
    if promising.is_empty() {
        return Ok(None);
    }
    promising.sort_by(|(a, _), (b, _)| a.total_cmp(b));
    environment.report("looking for swapped columns");
    let (before, _) = solve_with(session, &readings, solved, environment)?;
    let mut best: Option<(f64, Hypothesis, State)> = None;
    for (_, hypothesis) in promising.into_iter().take(SOLVED) {
        let (after, end) = solve_with(&hypothesis.made(session), &hypothesis.read(&readings), solved, environment)?;
        if after < BETTER * before && best.as_ref().is_none_or(|(lowest, ..)| after < *lowest) {
            best = Some((after, hypothesis, end));
        }
    }
    let Some((after, hypothesis, end)) = best else { return Ok(None) };
    let tried = hypotheses.len() + tried_of_lost;
    let made = (&hypothesis.made(session), hypothesis.read(&solved.readings), end);
    let likelier = decisively_likelier(made, (session, solved), tried, environment)?;
    Ok(likelier.then(|| hypothesis.report(session, 100.0 * (after / before).sqrt())))
}

/// Whether a session with its readings, started there, explains them so much better than the solution that it is no accident of having
/// tried so many, nor of few readings without stated noise.
pub(in crate::joint) fn decisively_likelier(
    (made, readings, start): (&Session, MeasurementSet, State),
    (session, solved): (&Session, &Solved),
    tried: usize,
    environment: &SolveEnvironment<'_>,
) -> Result<bool, EstimateError> {
    let (rank, rows) = (solved.analysis.rank(), solved.judged_problem().rows());
    if solved.readings.noise_found(session) && rows < rank + rank / TELLING {
        return Ok(false);
    }
    let noise = first_noise(session, &solved.readings.spreads);
    let readings = MeasurementSet { noise, ..readings }.with_rough_unexplained(session);
    let other = solve_from(made, &readings, start, environment)?;
    let gain = solved.minus_log_likelihood(session)? - other.minus_log_likelihood(made)?;
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
    (0..joints)
        .map(Hypothesis::PositionReversed)
        .chain(torques.map(|(a, b)| Hypothesis::TorquesSwapped(a, b)))
        .chain(positions.map(|(a, b)| Hypothesis::PositionsSwapped(a, b)))
        .chain(session.readings.orientation.is_some().then_some(Hypothesis::OrientationsInverted))
        .chain(session.gravity.hemisphere.is_some().then_some(Hypothesis::HemisphereInverted))
        .chain(exchangeable(session).then_some(Hypothesis::LoadExchanged))
        .chain(ExchangedAxes::all(session).into_iter().map(Hypothesis::AxesExchanged))
        .collect()
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
            Hypothesis::TorquesSwapped(a, b) => made.poses.iter_mut().for_each(|pose| pose.torque.swap(a, b)),
            Hypothesis::PositionsSwapped(a, b) => made.poses.iter_mut().for_each(|pose| pose.swap_positions(a, b)),
            Hypothesis::HemisphereInverted => {
                made.gravity.hemisphere = session.gravity.hemisphere.map(|pole| pole.map(|component| -component));
            }
            Hypothesis::LoadExchanged => {
                made.poses.iter_mut().for_each(|pose| pose.load = if pose.load.is_some() { None } else { Some(0) });
            }
            Hypothesis::LoadLost(lost) => return lost.made(session),
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
            Hypothesis::TorquesSwapped(a, b) => readings.exchanged(a, b),
            _ => readings.clone(),
        }
    }

    fn report(self, session: &Session, share: f64) -> Mistake {
        let name = |joint: usize| session.robot.chain.joints()[joint].name.as_str();
        let (what, cure) = match self {
            Hypothesis::PositionReversed(joint) => (
                format!("reversed position sensor: {}", name(joint)),
                "Say position_sign = \"reversed\" in its [[joint]].".to_owned(),
            ),
            Hypothesis::TorquesSwapped(a, b) => (
                format!("swapped torque columns: {} and {}", name(a), name(b)),
                "Exchange them in [readings] torque columns.".to_owned(),
            ),
            Hypothesis::PositionsSwapped(a, b) => (
                format!("swapped position columns: {} and {}", name(a), name(b)),
                "Exchange them in [readings] position columns.".to_owned(),
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
            Hypothesis::LoadLost(lost) => lost.report(session),
            Hypothesis::AxesExchanged(axes) => axes.report(session),
            Hypothesis::OrientationsInverted => {
                let inverse = session.readings.orientation.as_ref().is_some_and(|columns| columns.body_from_base);
                let other = if inverse { "base-from-body" } else { "body-from-base" };
                (
                    "orientations that turn the other way".to_owned(),
                    format!("Say rotation = \"{other}\" in readings.orientation."),
                )
            }
        };
        let advice = format!(
            "The likely cause is {what}: with that mended, the residuals of all readings fall to {share:.2} % of what they \
             were. {cure}"
        );
        Mistake { what, advice }
    }
}
