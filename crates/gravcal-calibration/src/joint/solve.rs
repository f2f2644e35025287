//! Solving the joint problem: start, unstated noise.

use gravcal_estimation::statistics::{NoiseKnowledge, Solution, along_constraints, leans};
use gravcal_estimation::{
    Covariance, Estimate, EvaluateError, Loss, Problem, Spectrum, Termination, Uncertainty, Values,
};

use super::Unknowns;
use super::error::EstimateError;
use super::fit::{fit, fit_in_rounds};
use super::nearby::Nearby;
use super::order::Order;
use super::posing::pose_with_constraints;
use super::problem::JointProblem;
use super::readings::Readings;
use super::sample::Sample;
use super::start::{best_start, further_starts, start_around};
use super::twins::{DECISIVE, settled};
use crate::judgement::{Explained, IMPLAUSIBLE};
use crate::parameter::{ParameterId, Quantity};
use crate::session::{Session, UnexplainedError};
use crate::workbench::Workbench;

/// Rounds of noise estimation at most, and the relative change at which they end.
const NOISE_ROUNDS: usize = 8;
const NOISE_TOLERANCE: f64 = 1e-3;
/// The same where errors of single joints are told from their noise, which shift from one to the other.
const UNEXPLAINED_ROUNDS: usize = 30;
/// Iterations of each: the next goes on from there.
const NOISE_ITERATIONS: usize = 100;
/// Iterations of a fit at most: what has not converged by then creeps.
const ITERATIONS: usize = 2000;

/// A solved and judged joint problem.
#[derive(Debug)]
pub struct Solved {
    /// The readings that entered, with the noise that was stated or found.
    pub readings: Readings,
    /// The problem.
    pub posed: JointProblem,
    /// Its solution.
    pub estimate: Estimate,
    /// What the data determine there, along the active constraints.
    pub spectrum: Spectrum,
    /// The problem with what the active constraints hold as readings; nothing where none is active.
    pub(super) along_constraints: Option<Problem>,
    /// How well: from the noise, unless another uncertainty was chosen.
    pub uncertainty: Uncertainty,
    /// Values nearby that may be the true ones, and at which the readings say less.
    pub(super) nearby: Vec<Nearby>,
    /// Ends of other starts that explain the readings as plausibly.
    pub(super) elsewhere: Vec<Values>,
    /// By how many standard deviations the readings would like to pass each active constraint.
    pub(super) leans: Vec<f64>,
    /// Whether gravity's sign is declared, or decided by the readings.
    pub(crate) sign_known: bool,
    /// Whether the readings decide for the other hemisphere than the declared one.
    pub(super) hemisphere_contradicted: bool,
}

/// Solves for everything, from `known` values if they start the problem better than the nominal ones; noise that no
/// reading states is estimated from the residuals of each joint; the readings' loss is heeded.
///
/// # Errors
/// Where there is no answer at all; not converging is a [`gravcal_estimation::Termination`].
pub fn solve(
    session: &Session,
    readings: &Readings,
    known: Option<&Unknowns>,
    workbench: &Workbench<'_>,
) -> Result<Solved, EstimateError> {
    workbench.tell("starting values");
    let sample = Sample::new(session, readings)?;
    let start = match (&readings.order, known) {
        (Order::Together, _) => best_start(session, &sample, known, workbench)?,
        (Order::StepByStep(_), Some(of_steps)) => start_around(session, readings, of_steps)?,
        // What fewer readings show need not be so for all.
        _ => best_start(session, &Sample::new(session, &readings.first())?, known, workbench)?,
    };
    let solved = solve_from(session, readings, start, workbench)?;
    let sample = sample.with_noise_of(session, &solved.readings)?;
    let solved = settled(session, solved, &sample, workbench)?;
    let stopped = solved.estimate.termination == Termination::Stopped;
    let noise_is_found = solved.readings.noise_found(session) && readings.order == Order::Together;
    let doubtful = noise_is_found || !solved.estimate.termination.converged() || solved.misfit(session)?.is_some();
    if doubtful && !stopped {
        let readings = &readings.with_rough_unexplained(session);
        return lowest_elsewhere(session, readings, &sample, solved, known, workbench);
    }
    Ok(solved)
}

/// The solution, or a likelier one from another start: a minimum that the stated noise rules out may be a local one, and noise that was
/// found at a minimum excuses it. The method's companion looks, from where the first one began and from elsewhere: one that creeps along a bent
/// valley is where the other goes through.
fn lowest_elsewhere(
    session: &Session,
    readings: &Readings,
    sample: &Sample,
    mut solved: Solved,
    known: Option<&Unknowns>,
    workbench: &Workbench<'_>,
) -> Result<Solved, EstimateError> {
    workbench.tell("other starting values");
    let companion = workbench.solver().companion().filter(|other| other.check(&solved.posed.problem).is_ok());
    let second = workbench.by(companion.as_deref().unwrap_or(workbench.solver()));
    let (mut lower, mut ends) = (false, Vec::new());
    let same = best_start(session, sample, known, &second)?;
    for start in std::iter::once(same).chain(further_starts(session, sample, known, &second)?) {
        // A start that leads nowhere says nothing of the others.
        let Ok(other) = solve_from(session, readings, start, &second) else { continue };
        let gain = solved.minus_log_likelihood(session) - other.minus_log_likelihood(session);
        let converged = [&other, &solved].map(|solved| solved.estimate.termination.converged());
        if converged[0] {
            ends.push((other.minus_log_likelihood(session), other.estimate.values.clone()));
        }
        if gain > DECISIVE || gain > 0.0 && converged == [true, false] {
            (solved, lower) = (other, true);
        }
    }
    let solved = if lower { settled(session, solved, sample, &second)? } else { solved };
    let lowest = solved.minus_log_likelihood(session);
    ends.retain(|(height, _)| *height < lowest + IMPLAUSIBLE);
    Ok(Solved { elsewhere: ends.into_iter().map(|(_, values)| values).collect(), ..solved })
}

/// The same from where it is said to start.
pub(super) fn solve_from(
    session: &Session,
    readings: &Readings,
    start: Unknowns,
    workbench: &Workbench<'_>,
) -> Result<Solved, EstimateError> {
    let (mut readings, mut start) = (readings.clone(), start);
    let loss = readings.loss;
    let posed = |readings: &Readings, start: &Unknowns| pose_with_constraints(session, readings, start);
    let estimated = session.unexplained_errors().contains(&UnexplainedError::Estimated);
    if !session.noise_estimated().contains(&true) && !readings.unexplained_found(session) {
        workbench.tell("all unknowns together");
        let solved = solve_posed(readings.clone(), posed(&readings, &start)?, workbench)?;
        let stopped = solved.estimate.termination == Termination::Stopped;
        if !estimated || stopped || solved.unexplained(session)? == readings.unexplained {
            return Ok(solved);
        }
        // Noise that explains so little weighs the joints wrongly: they begin alike.
        readings = readings.with_rough_unexplained(session);
    }
    for round in 0..if estimated { UNEXPLAINED_ROUNDS } else { NOISE_ROUNDS } {
        workbench.tell("all unknowns together");
        // Where nothing is known of the noise, nothing is known of outliers, nor where unknowns should rest.
        readings.loss = if round == 0 { Loss::None } else { loss };
        let problem = posed(&readings, &start)?;
        let problem = if round == 0 { problem } else { problem.resting_at_start() };
        let (problem, estimate) = fit_in_rounds(&problem, &readings, 1, &workbench.within(NOISE_ITERATIONS))?;
        let solved = Solved::judged(readings.clone(), problem, estimate)?;
        let noise = match loss {
            Loss::None => solved.residual_noise(session)?,
            _ => solved.median_noise(session)?,
        };
        let unexplained = solved.unexplained(session)?;
        let settled = readings.loss == loss
            && solved.stands_with(session, &unexplained, NOISE_TOLERANCE)
            && noise.iter().zip(&readings.noise).all(|(new, old)| (new / old - 1.0).abs() < NOISE_TOLERANCE);
        start = Unknowns::of(&solved.estimate.values, &solved.posed.layout, &start);
        (readings.noise, readings.unexplained) = (noise, unexplained);
        if settled || solved.estimate.termination == Termination::Stopped {
            break;
        }
    }
    readings.loss = loss;
    workbench.tell("all unknowns together");
    solve_posed(readings.clone(), posed(&readings, &start)?.resting_at_start(), workbench)
}

/// Solves a problem as it is posed, and judges the solution.
pub(crate) fn solve_posed(
    readings: Readings,
    posed: JointProblem,
    workbench: &Workbench<'_>,
) -> Result<Solved, EstimateError> {
    let (posed, estimate) = fit(&posed, &readings, &workbench.within(ITERATIONS))?;
    Solved::judged(readings, posed, estimate)
}

impl Solved {
    /// − ln of the likelihood with the noise as stated or found here, but for what all solutions share.
    pub(super) fn minus_log_likelihood(&self, session: &Session) -> f64 {
        let size = |(pose, channel): &(usize, usize)| self.readings.std(session, *pose, *channel).ln();
        self.estimate.cost + self.posed.rows.iter().map(size).sum::<f64>()
    }

    /// How many times worse than their stated noise the readings are explained, where that is no accident.
    pub(super) fn misfit(&self, session: &Session) -> Result<Option<f64>, EvaluateError> {
        Ok(Explained::of(session, self, 2.0 * self.estimate.cost)?.misfit())
    }

    /// Judges a problem at its start, without solving it.
    ///
    /// # Errors
    /// Where it cannot be evaluated there.
    pub fn at_start(readings: Readings, posed: JointProblem) -> Result<Solved, EstimateError> {
        let estimate = Estimate {
            values: posed.initial.clone(),
            cost: posed.problem.without_reference().cost(&posed.initial)?,
            termination: Termination::AsGiven,
            iterations: Vec::new(),
            way: Vec::new(),
            active: Vec::new(),
            without_effect: Vec::new(),
            normal_equations: None,
        };
        Solved::judged(readings, posed, estimate)
    }

    pub(super) fn judged(readings: Readings, posed: JointProblem, estimate: Estimate) -> Result<Solved, EstimateError> {
        let mut spectrum = Spectrum::of(&posed.problem, &estimate)?;
        let leans = leans(&posed.problem, &estimate, &spectrum);
        let along = along_constraints(&posed.problem, &estimate, &spectrum)?;
        if let Some(problem) = &along {
            spectrum = Spectrum::new(problem, &estimate.values)?;
        }
        let problem = along.as_ref().unwrap_or(&posed.problem);
        let solution = Solution { problem, values: &estimate.values, spectrum: &spectrum };
        let uncertainty = Uncertainty::from_noise(&solution, NoiseKnowledge::Stated)?;
        Ok(Solved {
            readings,
            posed,
            estimate,
            spectrum,
            along_constraints: along,
            uncertainty,
            leans,
            nearby: Vec::new(),
            elsewhere: Vec::new(),
            sign_known: true,
            hemisphere_contradicted: false,
        })
    }

    /// The problem as it is judged: along the active constraints.
    pub(crate) fn judged_problem(&self) -> &Problem {
        self.along_constraints.as_ref().unwrap_or(&self.posed.problem)
    }

    /// Covariance of the columns.
    pub fn covariance(&self) -> &Covariance {
        self.uncertainty.covariance()
    }

    /// Standard deviation of a joint's sensor parameter, in its unit; 0 where it is held.
    pub fn sensor_std(&self, joint: usize, quantity: Quantity) -> f64 {
        self.parameter_std(ParameterId::Sensor(joint, quantity))
    }

    /// Standard deviation of any parameter, in its unit; 0 where it is held.
    pub fn parameter_std(&self, id: ParameterId) -> f64 {
        let id = self.posed.layout.block(id);
        self.posed.problem.columns_of(id).next().map_or(0.0, |column| self.covariance().std(column))
    }

    /// Covariance of gravity in base coordinates, 3 × 3, row-major, (m/s²)².
    pub fn gravity_covariance(&self) -> Vec<f64> {
        self.covariance().stored(&self.posed.problem, &self.estimate.values, &[self.posed.layout.gravity])
    }

    /// The solution as plain numbers.
    pub fn unknowns(&self, fallback: &Unknowns) -> Unknowns {
        Unknowns::of(&self.estimate.values, &self.posed.layout, fallback)
    }
}
