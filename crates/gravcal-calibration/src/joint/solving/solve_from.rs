//! Where one start leads: noise that no reading states, and what the readings show to be unknown, are found on the way.

use std::sync::Arc;

use gravcal_estimation::{Loss, Termination};
use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::{Session, UnexplainedError};

use crate::joint::building::build::build_with_constraints;
use crate::joint::error::EstimateError;
use crate::joint::measurement_set::{Bending, MeasurementSet};
use crate::joint::problem::JointProblem;
use crate::joint::solved::Solved;
use crate::joint::solving::fit::{fit, fit_in_rounds};
use crate::joint::variables::State;

/// Rounds of noise estimation at most.
const NOISE_ROUNDS: usize = 8;
/// The same where errors of single joints are told from their noise, which shift from one to the other, unless ends are only compared.
const UNEXPLAINED_ROUNDS: usize = 30;
/// Iterations of each round: the next goes on from there, and what noise shifts is little beside what it costs to follow it to the last digit.
const NOISE_ITERATIONS: usize = 12;
/// The relative change of noise at which rounds end.
const NOISE_TOLERANCE: f64 = 1e-3;
/// The same where ends are only compared: − ln L is least at the noise that is found, and one per cent beside it larger by a ten thousandth of
/// the number of readings.
const ROUGH_TOLERANCE: f64 = 0.01;
/// Noise that still changes by so much after so many rounds goes round in circles: the model explains too little for it to settle.
const STEADY_ROUNDS: usize = 8;
const STEADY: f64 = 0.1;
/// How often, at most, what is constant in a solve is taken anew from its solution: the torques that bend joints, what that does in motion, what displacements of joints do, and how
/// errors at rest grow with what joints carry.
const FURTHER_TAKES: usize = 3;
/// Iterations of a fit at most: what has not converged by then creeps.
const ITERATIONS: usize = 2000;
/// How often, at most, noise is looked for anew where a solve was given up.
const FURTHER_ROUNDS: usize = 3;

/// Solves for everything from one start: noise that no reading states, what friction leaves at rest, what lasts while a joint stands, how far joints bend, and how far they are from
/// where they are described, are found on the way.
///
/// # Errors
/// Where there is no answer at all; not converging is a [`Termination`].
pub(in crate::joint) fn solve_from(
    session: &Session,
    readings: &MeasurementSet,
    start: State,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let solved = solve_with_noise(session, readings, start, environment)?;
    let converged = solved.estimate.termination.converged();
    if !converged {
        return Ok(solved);
    }
    // What a displaced joint does would pass for errors at rest, or for bending.
    let solved = match solved.displaced_anew(session)? {
        Some(displaced) => {
            let readings = MeasurementSet { displaced: Some(displaced), ..solved.readings().clone() };
            solve_again(session, &solved, &readings, environment)?
        }
        None => solved,
    };
    let at_rest = solved.readings().with_friction_at_rest(session, &solved.carried_by_joints(session)?);
    let bending = Bending::of(session, &solved)?;
    let lasting = solved.with_lasting_errors(session)?;
    let solved = match at_rest.is_some() || bending.is_some() || lasting.is_some() {
        true => {
            let mut readings = lasting.unwrap_or_else(|| solved.readings().clone());
            readings.at_rest = at_rest.map_or(readings.at_rest, |with| with.at_rest);
            readings.bending = bending.map(Arc::new).or(readings.bending);
            solve_again(session, &solved, &readings, environment)?
        }
        false => solved,
    };
    with_constants_anew(session, solved, environment)
}

/// Takes anew from a solution what is constant in a solve, and goes on from there, until no reading moves: after an image of a solution, too.
///
/// # Errors
/// Those of [`solve_from`].
pub(in crate::joint) fn with_constants_anew(
    session: &Session,
    mut solved: Solved,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    for _ in 0..if environment.is_rough() { 0 } else { FURTHER_TAKES } {
        let (bent, displaced) = (solved.bent_anew(session)?, solved.displaced_anew(session)?);
        let growing = solved.growing_anew();
        if bent.is_none() && displaced.is_none() && growing.is_none() {
            break;
        }
        let mut readings = bent.unwrap_or_else(|| solved.readings().clone());
        readings.displaced = displaced.or(readings.displaced);
        readings.at_rest = growing.map_or(readings.at_rest, |with| with.at_rest);
        solved = solve_again(session, &solved, &readings, environment)?;
    }
    Ok(solved)
}

/// Goes on from a solution with other unknowns.
fn solve_again(
    session: &Session,
    solved: &Solved,
    readings: &MeasurementSet,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    solve_with_noise(session, readings, solved.state(&State::nominal(session)), environment)
}

/// The same with the unknowns that the readings are said to have, and the noise that they show. Where the last solve was given up, as no noise of the size
/// that was found explains its residuals, the noise is looked for anew from there.
fn solve_with_noise(
    session: &Session,
    readings: &MeasurementSet,
    start: State,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let mut solved = solve_with_noise_from(session, readings, start, environment)?;
    for _ in 0..if environment.is_rough() { 0 } else { FURTHER_ROUNDS } {
        let gave_up =
            matches!(solved.estimate.termination, Termination::IterationLimit { limit } if limit < ITERATIONS);
        if !gave_up || !session.noise_estimated().contains(&true) {
            break;
        }
        let (rows, mut readings) = (solved.row_residuals()?, solved.readings().clone());
        readings.noise = solved.noise_shown(session, readings.loss, &rows);
        readings.unexplained = solved.unexplained(session, &rows);
        let start = solved.state(&State::nominal(session));
        solved = solve_with_noise_from(session, &readings, start, environment)?;
    }
    Ok(solved)
}

/// The same from this start and this noise.
fn solve_with_noise_from(
    session: &Session,
    readings: &MeasurementSet,
    start: State,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    let (mut readings, mut start) = (readings.clone(), start);
    let loss = readings.loss;
    let built = |readings: &MeasurementSet, start: &State| build_with_constraints(session, readings, start);
    let lasting = readings.lasting.is_some();
    let estimated = lasting || session.unexplained_errors().contains(&UnexplainedError::Estimated);
    if !session.noise_estimated().contains(&true) && !readings.unexplained_found(session) && !lasting {
        environment.report("all unknowns together");
        let solved = solve_built(built(&readings, &start)?, environment)?;
        let stopped = solved.estimate.termination == Termination::Stopped;
        if !estimated || stopped || solved.unexplained(session, &solved.row_residuals()?) == readings.unexplained {
            return Ok(solved);
        }
        // Noise that explains so little weighs the joints wrongly: they begin alike.
        readings = readings.with_rough_unexplained(session);
    }
    let rough = environment.is_rough();
    let tolerance = if rough { ROUGH_TOLERANCE } else { NOISE_TOLERANCE };
    for round in 0..if estimated && !rough { UNEXPLAINED_ROUNDS } else { NOISE_ROUNDS } {
        environment.report("all unknowns together");
        // Where nothing is known of the noise, nothing is known of outliers, nor where unknowns should rest.
        readings.loss = if round == 0 { Loss::None } else { loss };
        let problem = built(&readings, &start)?;
        let problem = if round == 0 { problem } else { problem.resting_at_start() };
        let (problem, estimate) = fit_in_rounds(&problem, 1, &environment.within(NOISE_ITERATIONS))?;
        let solved = Solved::judged(problem, estimate)?;
        let rows = solved.row_residuals()?;
        let noise = solved.noise_shown(session, loss, &rows);
        let unexplained = solved.unexplained(session, &rows);
        let (lasting, lasting_changed) = solved.lasting_anew(session, &rows);
        let changes = noise.iter().zip(&readings.noise).map(|(new, old)| (new / old - 1.0).abs());
        let changed = changes.fold(lasting_changed, f64::max);
        let settled =
            readings.loss == loss && solved.stands_with(session, &unexplained, tolerance) && changed < tolerance;
        start = solved.built.variables.state(&solved.estimate.values, &start);
        (readings.noise, readings.unexplained, readings.lasting) = (noise, unexplained, lasting);
        let in_circles = round >= STEADY_ROUNDS && changed > STEADY;
        if settled || in_circles || solved.estimate.termination == Termination::Stopped {
            break;
        }
    }
    readings.loss = loss;
    environment.report("all unknowns together");
    solve_built(built(&readings, &start)?.resting_at_start(), environment)
}

/// Where a few iterations lead with the noise as it is stated, or first guessed: for a session that nothing explains.
///
/// # Errors
/// As [`solve_from`].
pub(in crate::joint) fn solve_briefly(
    session: &Session,
    readings: &MeasurementSet,
    start: &State,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    solve_built(build_with_constraints(session, readings, start)?, &environment.within(NOISE_ITERATIONS))
}

/// Solves a problem as it is built, and judges the solution.
pub(crate) fn solve_built(built: JointProblem, environment: &SolveEnvironment<'_>) -> Result<Solved, EstimateError> {
    let (built, estimate) = fit(&built, &environment.within(ITERATIONS))?;
    Solved::judged(built, estimate)
}
