//! One arm, solved from where the estimator starts by itself and from the true values.

use gravcal_calibration::SolveEnvironment;
use gravcal_calibration::joint::{self, EstimateError, Signals, Solved, estimate_briefly};
use gravcal_calibration::result::Brief;
use gravcal_estimation::Solver;
use gravcal_robot_model::Session;
use gravcal_session::simulation::Simulation;

use super::Knowing;
use super::arm::arm;
use crate::quantities::measured_quantities;

/// Costs that differ by no more than this share are the same.
const SAME_COST: f64 = 1e-6;
/// A value this many of its standard deviations from the truth is wrong.
const WRONG: f64 = 6.0;

/// Where one arm ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// Its number.
    pub number: u64,
    /// Its joints.
    pub joints: usize,
    /// Condition of the scaled Jacobian at the truth, among the determined directions.
    pub condition: f64,
    /// Where it ended.
    pub ending: Ending,
    /// Cost reached by itself and from the true values; NaN where there is none.
    pub costs: [f64; 2],
    /// Why it ended, in the words of the estimators.
    pub termination: String,
}

/// Where the estimator ended, beside where it ends from the true values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// At the same cost.
    Global,
    /// At a lower one.
    Lower,
    /// At a higher one or none.
    Elsewhere {
        /// Whether something wrong is told as determined.
        misleading: bool,
    },
}

/// Runs the arm of this number.
pub(super) fn run(seed: u64, number: u64, knowing: Knowing, solver: &dyn Solver) -> Trial {
    let nowhere = |termination: String| Trial {
        number,
        joints: 0,
        condition: f64::NAN,
        ending: Ending::Elsewhere { misleading: false },
        costs: [f64::NAN; 2],
        termination,
    };
    match arm(seed, number, knowing) {
        Ok(simulation) => compare(number, &simulation, solver).unwrap_or_else(|error| nowhere(error.to_string())),
        Err(error) => nowhere(error.to_string()),
    }
}

fn compare(number: u64, simulation: &Simulation, solver: &dyn Solver) -> Result<Trial, EstimateError> {
    let session = simulation.session(0);
    let quiet = |_: &str| {};
    let environment = SolveEnvironment::new(solver, &quiet);
    let readings = joint::select(&session, Signals::All);
    let at_truth = Solved::at_start(joint::build_problem(&session, &readings, &simulation.truth)?)?;
    let from_truth = joint::solve(&session, &readings, Some(&simulation.truth), &environment)?;
    let by_itself = joint::solve(&session, &readings, None, &environment)?;
    let costs = [by_itself.estimate.cost, from_truth.estimate.cost];
    let ending = match costs[0] / costs[1] - 1.0 {
        difference if difference.abs() <= SAME_COST => Ending::Global,
        difference if difference < 0.0 => Ending::Lower,
        _ => Ending::Elsewhere { misleading: is_misleading(simulation, &session, &environment) },
    };
    Ok(Trial {
        number,
        joints: session.joints.len(),
        condition: at_truth.analysis.condition(),
        ending,
        costs,
        termination: by_itself.estimate.termination.to_string(),
    })
}

/// Whether the estimator tells as determined what is not so.
fn is_misleading(simulation: &Simulation, session: &Session, environment: &SolveEnvironment<'_>) -> bool {
    let readings = joint::select(session, Signals::All);
    let Ok(result) = estimate_briefly(session, &readings, None, environment) else { return false };
    has_wrong_gravity(simulation, &result) || has_wrong_sensor(simulation, session, &result)
}

fn has_wrong_gravity(simulation: &Simulation, result: &Brief) -> bool {
    result.gravity.as_ref().is_some_and(|found| {
        let components = found.vector_m_per_s2.iter().zip(simulation.truth.gravity).zip(found.std_m_per_s2);
        components.into_iter().any(|((value, truth), std)| (value - truth).abs() > WRONG * std)
    })
}

fn has_wrong_sensor(simulation: &Simulation, session: &Session, result: &Brief) -> bool {
    measured_quantities(session).into_iter().any(|quantity| {
        result.parameter(&quantity.name(session)).is_some_and(|parameter| {
            let (Some(value), Some(std)) = (parameter.value, parameter.std) else { return false };
            (value - quantity.of(&simulation.truth)).abs() > WRONG * std
        })
    })
}
