//! What deflection of standing joints does to the estimates, and what seeing or modelling it mends.
//!
//! Treatments of the same draws, the first two by the sequential and by the joint estimator:
//!
//! - *unseen*: position sensors say where the joints were sent, and nobody asks further;
//! - *seen*: position sensors say where the joints are, and each pose's own reading is used (the remedy of the paper,
//!   eq. (16));
//! - *modelled*: sensors do not see it, and the joint estimator has it as an unknown.

use gravcal_calibration::SolveEnvironment;
use gravcal_calibration::joint::{EstimateError, Signals, State, estimate_briefly, select};
use gravcal_calibration::result::Brief;
use gravcal_calibration::sequential::{Plan, report_steps_briefly, run_steps};
use gravcal_estimation::Solver;
use gravcal_estimation::statistics::Quantile;
use gravcal_robot_model::Session;
use gravcal_session::simulation::Simulation;
use rayon::prelude::*;

use crate::bounds::bound;
use crate::quantities::{Measured, measured_quantities};

/// How deflection is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Treatment {
    /// Neither seen nor modelled, the paper's steps.
    SequentialUnseen,
    /// Neither seen nor modelled, all unknowns together.
    JointUnseen,
    /// Seen by the position sensors, the paper's steps.
    SequentialSeen,
    /// Seen by the position sensors, all unknowns together.
    JointSeen,
    /// Not seen, and modelled.
    JointModelled,
}

impl Treatment {
    /// In the order of a table.
    pub const ALL: [Treatment; 5] = [
        Treatment::SequentialUnseen,
        Treatment::JointUnseen,
        Treatment::SequentialSeen,
        Treatment::JointSeen,
        Treatment::JointModelled,
    ];

    /// Heading.
    pub fn name(self) -> &'static str {
        match self {
            Treatment::SequentialUnseen => "sequential, unseen",
            Treatment::JointUnseen => "joint, unseen",
            Treatment::SequentialSeen => "sequential, seen",
            Treatment::JointSeen => "joint, seen",
            Treatment::JointModelled => "joint, modelled",
        }
    }

    fn is_seen(self) -> bool {
        matches!(self, Treatment::SequentialSeen | Treatment::JointSeen)
    }
}

/// Errors of one treatment in one quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeflectionColumn {
    /// Trials that gave a value.
    pub answers: usize,
    /// Mean error over those, in the unit of the quantity.
    pub mean_error: f64,
    /// Root mean square error over those; NaN without any.
    pub rms_error: f64,
    /// Share of them whose 95 % interval, as the result tells it, holds the truth.
    pub coverage: f64,
}

/// Errors of all treatments in all quantities.
#[derive(Clone, Debug)]
pub struct DeflectionStudy {
    /// Trials run.
    pub trials: u64,
    /// Quantity, Cramér-Rao bound of the model with deflection (its prior included), treatments in the order of
    /// [`Treatment::ALL`].
    pub rows: Vec<(Measured, Option<f64>, [DeflectionColumn; 5])>,
}

/// Runs `trials` trials of a simulation. `model`: what makes a session one whose deflection is modelled.
///
/// # Errors
/// Where the bound cannot be computed. A trial without an answer is counted, not an error.
pub fn deflection_study(
    simulation: &Simulation,
    model: &(dyn Fn(&mut Session) + Sync),
    trials: u64,
    solver: &dyn Solver,
    progress: &(dyn Fn() + Sync),
) -> Result<DeflectionStudy, EstimateError> {
    let mut session = simulation.session(0);
    let quantities = measured_quantities(&session);
    model(&mut session);
    let bounds = bound(&session, &with_true_compliance(simulation, &session).truth, Signals::All, &quantities)?;
    let study = Study { simulation, model, solver, quantities: &quantities };
    let outcomes: Vec<[Vec<Option<Outcome>>; 5]> = (0..trials)
        .into_par_iter()
        .map(|trial| {
            let outcome = study.trial(trial);
            progress();
            outcome
        })
        .collect();
    let rows = quantities.iter().zip(bounds).enumerate().map(|(index, (quantity, bound))| {
        let column = |treatment: usize| summarize(outcomes.iter().filter_map(|trial| trial[treatment][index].as_ref()));
        (*quantity, bound, [0, 1, 2, 3, 4].map(column))
    });
    Ok(DeflectionStudy { trials, rows: rows.collect() })
}

/// The simulation with the true values of the parameters that a session has for its compliances.
fn with_true_compliance(simulation: &Simulation, session: &Session) -> Simulation {
    let mut reported = simulation.clone();
    if !session.compliances().is_empty() {
        let further = [&simulation.truth.further[..], &simulation.disturbance.deflection.compliance].concat();
        reported.truth = State { further, ..reported.truth };
    }
    reported
}

/// Error of one value, and whether its interval held the truth.
struct Outcome {
    error: f64,
    held: bool,
}

struct Study<'a> {
    simulation: &'a Simulation,
    model: &'a (dyn Fn(&mut Session) + Sync),
    solver: &'a dyn Solver,
    quantities: &'a [Measured],
}

impl Study<'_> {
    fn trial(&self, trial: u64) -> [Vec<Option<Outcome>>; 5] {
        let mut seen = self.simulation.clone();
        seen.disturbance.deflection.seen = true;
        let (unseen, seen) = (self.simulation.session(trial), seen.session(trial));
        Treatment::ALL.map(|treatment| {
            let mut session = if treatment.is_seen() { seen.clone() } else { unseen.clone() };
            if treatment == Treatment::JointModelled {
                (self.model)(&mut session);
            }
            match self.estimate(treatment, &session) {
                Ok(result) => {
                    self.quantities.iter().map(|quantity| self.outcome(*quantity, &session, &result)).collect()
                }
                Err(_) => self.quantities.iter().map(|_| None).collect(),
            }
        })
    }

    fn estimate(&self, treatment: Treatment, session: &Session) -> Result<Brief, EstimateError> {
        let quiet = |_: &str| {};
        let environment = SolveEnvironment::new(self.solver, &quiet);
        let steps = run_steps(session, &Plan::new(session), &environment);
        match treatment {
            Treatment::SequentialUnseen | Treatment::SequentialSeen => Ok(report_steps_briefly(session, &steps)),
            _ => {
                let readings = select(session, Signals::All);
                estimate_briefly(session, &readings, steps.as_start(session).as_ref(), &environment)
            }
        }
    }

    fn outcome(&self, quantity: Measured, session: &Session, result: &Brief) -> Option<Outcome> {
        let truth = quantity.of(&self.simulation.truth);
        let (value, [low, high]) = match quantity {
            Measured::Gravity(axis) => {
                let gravity = result.gravity.as_ref()?;
                let (value, std) = (gravity.vector_m_per_s2[axis], gravity.std_m_per_s2[axis]);
                (value, Quantile::normal().interval(value, std))
            }
            Measured::Sensor(..) => {
                let name = quantity.name(session);
                let parameter = result.parameter(&name)?;
                (parameter.value?, parameter.ci95?)
            }
        };
        Some(Outcome { error: value - truth, held: (low..=high).contains(&truth) })
    }
}

fn summarize<'a>(outcomes: impl Iterator<Item = &'a Outcome>) -> DeflectionColumn {
    let outcomes: Vec<&Outcome> = outcomes.collect();
    let mean =
        |of: &dyn Fn(&Outcome) -> f64| outcomes.iter().map(|outcome| of(outcome)).sum::<f64>() / outcomes.len() as f64;
    DeflectionColumn {
        answers: outcomes.len(),
        mean_error: mean(&|outcome| outcome.error),
        rms_error: mean(&|outcome| outcome.error.powi(2)).sqrt(),
        coverage: mean(&|outcome| f64::from(u8::from(outcome.held))),
    }
}
