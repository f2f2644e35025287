//! Root-mean-square errors of the estimators over many simulated sessions, beside the Cramér-Rao bound.

use gravcal_calibration::Workbench;
use gravcal_calibration::joint::{self, EstimateError, Readings, Signals, Unknowns};
use gravcal_calibration::sequential::{Plan, run_steps};
use gravcal_calibration::simulation::Simulation;
use gravcal_estimation::Solver;
use rayon::prelude::*;
use thiserror::Error;

use crate::bounds::bound;
use crate::quantities::{Measured, measured_quantities};

/// What is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Column {
    /// The paper's steps.
    Sequential,
    /// The paper's steps with each step's covariance passed on.
    SequentialWithCovariance,
    /// Joint estimation from the torque readings that the paper's steps read.
    JointPaperSignals,
    /// All torque readings, pose by pose.
    Recursive,
    /// Joint estimation from all torque readings.
    Joint,
}

impl Column {
    /// In the order of a table.
    pub const ALL: [Column; 5] = [
        Column::Sequential,
        Column::SequentialWithCovariance,
        Column::JointPaperSignals,
        Column::Recursive,
        Column::Joint,
    ];

    /// Heading.
    pub fn name(self) -> &'static str {
        match self {
            Column::Sequential => "sequential",
            Column::SequentialWithCovariance => "sequential, covariance",
            Column::JointPaperSignals => "joint, paper's signals",
            Column::Recursive => "recursive, all signals",
            Column::Joint => "joint, all signals",
        }
    }
}

/// The study has no answer.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The true values cannot be judged.
    #[error("the Cramér-Rao bound cannot be computed: {0}")]
    Bound(#[from] EstimateError),
}

/// Errors of one estimator in one quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColumnAccuracy {
    /// Trials in which the estimator gave a value.
    pub answers: usize,
    /// Root mean square error over those, in the unit of the quantity; NaN without any.
    pub rms_error: f64,
    /// Mean error.
    pub mean_error: f64,
    /// Cramér-Rao bound of the readings it uses; `None` for the sequential steps, and where the readings do not
    /// determine the quantity.
    pub bound: Option<f64>,
}

/// Accuracy of all estimators in all quantities.
#[derive(Clone, Debug)]
pub struct Accuracy {
    /// Trials run.
    pub trials: u64,
    /// Quantities, each with the columns that were asked for, in their order.
    pub rows: Vec<(Measured, Vec<ColumnAccuracy>)>,
    /// Mean over the trials of the largest residual of the sinusoids of step 1 (largest over the joints), unit of
    /// the torque reading; `None` where no trial had one.
    pub largest_sinusoid_residual: Option<f64>,
}

/// Runs `trials` trials of a simulation, each with the estimators of these columns.
///
/// # Errors
/// Where the bound cannot be computed. A trial in which an estimator gives no answer is counted, not an error.
pub fn accuracy(
    simulation: &Simulation,
    trials: u64,
    columns: &[Column],
    solver: &dyn Solver,
    progress: &(dyn Fn() + Sync),
) -> Result<Accuracy, StudyError> {
    let session = simulation.session(0);
    let quantities = measured_quantities(&session);
    let bounds =
        [Signals::PaperSteps, Signals::All].map(|signals| bound(&session, &simulation.truth, signals, &quantities));
    let [paper, all] = bounds;
    let (paper, all) = (paper?, all?);
    let outcomes: Vec<Trial> = (0..trials)
        .into_par_iter()
        .map(|trial| {
            let outcome = run_trial(simulation, trial, (columns, &quantities), solver);
            progress();
            outcome
        })
        .collect();
    let rows = quantities
        .iter()
        .enumerate()
        .map(|(index, quantity)| {
            let bound_of = |column: Column| match column {
                Column::Sequential => None,
                Column::SequentialWithCovariance | Column::JointPaperSignals => paper[index],
                Column::Recursive | Column::Joint => all[index],
            };
            let summary = |(place, column): (usize, &Column)| summarize(&outcomes, (place, index), bound_of(*column));
            (*quantity, columns.iter().enumerate().map(summary).collect())
        })
        .collect();
    let largest: Vec<f64> = outcomes.iter().filter_map(|t| t.largest_sinusoid_residual).collect();
    Ok(Accuracy {
        trials,
        rows,
        largest_sinusoid_residual: (!largest.is_empty()).then(|| largest.iter().sum::<f64>() / largest.len() as f64),
    })
}

/// Errors of one trial: by column and quantity.
struct Trial {
    errors: Vec<Vec<Option<f64>>>,
    largest_sinusoid_residual: Option<f64>,
}

fn run_trial(
    simulation: &Simulation,
    trial: u64,
    (columns, quantities): (&[Column], &[Measured]),
    solver: &dyn Solver,
) -> Trial {
    let session = simulation.session(trial);
    let quiet = |_: &str| {};
    let workbench = Workbench::new(solver, &quiet);
    let steps = run_steps(&session, &Plan::new(&session), &workbench);
    let known = steps.as_start(&session);
    let error = |quantity: &Measured, value: f64| value - quantity.of(&simulation.truth);
    let answer = |readings: Result<Readings, EstimateError>, known: Option<&Unknowns>| -> Vec<Option<f64>> {
        match readings.and_then(|readings| joint::solve(&session, &readings, known, &workbench)) {
            Ok(solved) if solved.estimate.termination.converged() => {
                let found = solved.unknowns(&simulation.truth);
                quantities.iter().map(|q| Some(error(q, q.of(&found)))).collect()
            }
            _ => vec![None; quantities.len()],
        }
    };
    let of_column = |column: &Column| match column {
        Column::Sequential => quantities.iter().map(|q| Some(error(q, q.of_steps(&steps)?))).collect(),
        Column::SequentialWithCovariance => answer(Ok(joint::step_by_step(&session)), known.as_ref()),
        Column::JointPaperSignals => answer(Ok(joint::select(&session, Signals::PaperSteps)), known.as_ref()),
        Column::Recursive => answer(joint::pose_by_pose(&session, &workbench), None),
        Column::Joint => answer(Ok(joint::select(&session, Signals::All)), known.as_ref()),
    };
    Trial {
        errors: columns.iter().map(of_column).collect(),
        largest_sinusoid_residual: steps.largest_residuals.iter().flatten().copied().reduce(f64::max),
    }
}

fn summarize(outcomes: &[Trial], (column, quantity): (usize, usize), bound: Option<f64>) -> ColumnAccuracy {
    let errors: Vec<f64> = outcomes.iter().filter_map(|t| t.errors[column][quantity]).collect();
    let count = errors.len() as f64;
    ColumnAccuracy {
        answers: errors.len(),
        rms_error: (errors.iter().map(|e| e * e).sum::<f64>() / count).sqrt(),
        mean_error: errors.iter().sum::<f64>() / count,
        bound,
    }
}
