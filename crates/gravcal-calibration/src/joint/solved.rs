//! A solved joint problem, and what the data determine there.

use gravcal_estimation::{
    Covariance, Estimate, EvaluateError, Problem, RankAnalysis, Termination, Uncertainty, Values,
};
use gravcal_identification::{End, Known, Place};
use gravcal_robot_model::parameter::{ParameterId, SensorParameter};
use gravcal_robot_model::session::Session;

use crate::joint::error::EstimateError;
use crate::joint::measurement_set::MeasurementSet;
use crate::joint::order::Order;
use crate::joint::problem::JointProblem;
use crate::joint::variables::State;

/// A solved and judged joint problem.
#[derive(Debug)]
pub struct Solved {
    /// The problem, with the readings that entered.
    pub built: JointProblem,
    /// Its solution.
    pub estimate: Estimate,
    /// What the data determine there, along the active constraints.
    pub analysis: RankAnalysis,
    /// The problem with what the active constraints hold as readings; nothing where none is active.
    pub(super) along_constraints: Option<Problem>,
    /// How well: from the noise, unless another uncertainty was chosen.
    pub uncertainty: Uncertainty,
    /// Values nearby that may be the true ones, and at which the readings say less.
    pub(super) nearby: Vec<Nearby>,
    /// Column and standard deviation where a profile tells a larger one than the linear model.
    pub(super) profiles: Vec<(usize, f64)>,
    /// By how much ½ χ² is larger than the least that was found: where much is open, the solution rests beside that.
    pub(crate) growth_at_rest: f64,
    /// Ends of other starts that explain the readings as plausibly.
    pub(super) elsewhere: Vec<State>,
    /// By how many standard deviations the readings would like to pass each active constraint.
    pub(super) leans: Vec<f64>,
    /// Whether gravity's sign is declared, or decided by the readings.
    pub(crate) sign_known: bool,
    /// Whether the readings decide for the other hemisphere than the declared one.
    pub(super) hemisphere_contradicted: bool,
}

/// Values that may be the true ones, and what the readings say there.
#[derive(Debug)]
pub(super) struct Nearby {
    pub values: Values,
    pub analysis: RankAnalysis,
    /// Share of standard deviations there that is told at least.
    pub share: f64,
    /// Columns that are beyond their limit there, and so much worse known that what the readings say at the estimate has no basis.
    pub open: Vec<usize>,
}

impl Solved {
    /// Whether it is a minimum, and that of all readings together.
    pub(super) fn is_minimum_of_all(&self) -> bool {
        self.estimate.termination.converged() && self.readings().order == Order::Together
    }

    /// ½ χ² of the readings where they are explained best: what is held against other solutions.
    pub(crate) fn least_cost(&self) -> f64 {
        self.estimate.cost - self.growth_at_rest
    }

    /// χ² of the readings where they are explained best.
    pub(crate) fn least_chi_squared(&self) -> f64 {
        2.0 * self.least_cost()
    }

    /// As an end of a start among others.
    ///
    /// # Errors
    /// Where the problem cannot be evaluated there.
    pub(super) fn into_end(self, session: &Session) -> Result<End<Solved, State>, EvaluateError> {
        let place = Place {
            minus_log_likelihood: self.minus_log_likelihood(session)?,
            values: self.estimate.values.clone(),
            start: self.state(&State::nominal(session)),
        };
        Ok(End { place, termination: self.estimate.termination, solution: self })
    }

    /// Another solution of the same session in the place of this one, with what is known of its images and of other ends.
    pub(super) fn replaced_by(&self, other: Solved) -> Solved {
        let Solved { sign_known, hemisphere_contradicted, ref elsewhere, .. } = *self;
        Solved { sign_known, hemisphere_contradicted, elsewhere: elsewhere.clone(), ..other }
    }

    /// Judges a problem at its start, without solving it.
    ///
    /// # Errors
    /// Where it cannot be evaluated there.
    pub fn at_start(built: JointProblem) -> Result<Solved, EstimateError> {
        let estimate = Estimate {
            values: built.initial.clone(),
            cost: built.problem.without_reference().cost(&built.initial)?,
            termination: Termination::AsGiven,
            iterations: Vec::new(),
            iterates: Vec::new(),
            active: Vec::new(),
            without_effect: Vec::new(),
            normal_equations: None,
        };
        Solved::judged(built, estimate)
    }

    pub(super) fn judged(built: JointProblem, estimate: Estimate) -> Result<Solved, EstimateError> {
        let Known { analysis, along_constraints, leans, uncertainty } =
            Known::at::<EstimateError>(&built.problem, &estimate)?;
        Ok(Solved {
            built,
            estimate,
            analysis,
            along_constraints,
            uncertainty,
            leans,
            nearby: Vec::new(),
            profiles: Vec::new(),
            elsewhere: Vec::new(),
            growth_at_rest: 0.0,
            sign_known: true,
            hemisphere_contradicted: false,
        })
    }

    /// The readings that entered, with the noise that was stated or found.
    pub fn readings(&self) -> &MeasurementSet {
        self.built.readings()
    }

    /// The problem as it is judged: along the active constraints.
    pub(crate) fn judged_problem(&self) -> &Problem {
        self.along_constraints.as_ref().unwrap_or(&self.built.problem)
    }

    /// Covariance of the columns.
    pub fn covariance(&self) -> &Covariance {
        self.uncertainty.covariance()
    }

    /// Standard deviation of a joint's sensor parameter, in its unit; 0 where it is fixed.
    pub fn sensor_std(&self, joint: usize, quantity: SensorParameter) -> f64 {
        self.parameter_std(ParameterId::Sensor(joint, quantity))
    }

    /// Standard deviation of any parameter, in its unit; 0 where it is fixed.
    pub fn parameter_std(&self, id: ParameterId) -> f64 {
        let id = self.built.variables.block(id);
        self.built.problem.columns_of(id).next().map_or(0.0, |column| self.covariance().std(column))
    }

    /// Covariance of gravity in base coordinates, 3 × 3, row-major, (m/s²)².
    pub fn gravity_covariance(&self) -> Vec<f64> {
        self.covariance().stored(&self.built.problem, &self.estimate.values, &[self.built.variables.gravity])
    }

    /// The solution as plain numbers.
    pub fn state(&self, fallback: &State) -> State {
        self.built.variables.state(&self.estimate.values, fallback)
    }
}
