//! A part of the poses, posed once: starts are compared and judged by it.

use gravcal_estimation::NormalEquations;

use super::linear_part::FAINT_DAMPING;
use super::problem::{JointProblem, PosingError, pose};
use super::readings::Readings;
use super::unknowns::Unknowns;
use crate::session::Session;
use crate::workbench::Workbench;

/// Poses that suffice to compare candidates.
const POSES: usize = 120;
/// Iterations from a start that tell how low it leads.
const BRIEF: usize = 30;
/// A cost for each reading below this explains them: noise alone makes it ½.
const EXPLAINED: f64 = 1.0;

/// The joint problem of a part of the poses.
pub(super) struct Sample {
    pub readings: Readings,
    posed: JointProblem,
}

/// Where some iterations lead.
pub(super) struct Nearby {
    /// The cost there; infinite where the solver takes no such problem.
    pub cost: f64,
    pub end: Unknowns,
}

/// Where one step leads.
pub(super) struct OneStep {
    /// The cost there.
    pub cost: f64,
    pub end: Unknowns,
    /// Those of the sample where it starts.
    pub normal_equations: Option<NormalEquations>,
}

impl Sample {
    /// Of these readings, to start from anywhere.
    ///
    /// # Errors
    /// Where no problem can be posed.
    pub fn new(session: &Session, readings: &Readings) -> Result<Sample, PosingError> {
        let readings = thinned(readings);
        let posed = pose(session, &readings, &Unknowns::nominal(session))?;
        Ok(Sample { readings, posed })
    }

    /// The same with the noise of these readings, which are those that it is part of.
    ///
    /// # Errors
    /// As [`Sample::new`].
    pub fn with_noise_of(self, session: &Session, readings: &Readings) -> Result<Sample, PosingError> {
        if self.readings.noise == readings.noise { Ok(self) } else { Sample::new(session, readings) }
    }

    /// Its problem, started from here.
    pub fn posed_at(&self, session: &Session, start: &Unknowns) -> JointProblem {
        self.posed.starting_at(session, &self.readings, start)
    }

    /// A cost that explains its readings.
    pub fn explained(&self) -> f64 {
        EXPLAINED * self.readings.count() as f64
    }

    /// Where a few iterations from `start` lead, or fewer where the cost is no higher than `enough` before.
    pub fn nearby(&self, session: &Session, start: &Unknowns, enough: f64, workbench: &Workbench<'_>) -> Nearby {
        let posed = self.posed_at(session, start);
        match workbench.solve_briefly(&posed.problem, &posed.initial, BRIEF, enough) {
            Ok(estimate) => Nearby { cost: estimate.cost, end: Unknowns::of(&estimate.values, &posed.layout, start) },
            Err(_) => Nearby { cost: f64::INFINITY, end: start.clone() },
        }
    }

    /// The step to the minimum of the linear model; nothing if the cost is no lower where it leads.
    pub fn one_step(&self, session: &Session, start: &Unknowns) -> Option<OneStep> {
        let JointProblem { problem, initial, layout, .. } = &self.posed_at(session, start);
        let mut linearization = problem.linearize(initial).ok()?;
        let mut step = vec![0.0; problem.columns().len()];
        linearization.damped_step(FAINT_DAMPING, &linearization.column_scales(), &mut step);
        let there = problem.retract(initial, &step);
        let cost = problem.cost(&there).ok().filter(|cost| *cost < linearization.cost())?;
        let end = Unknowns::of(&there, layout, start);
        Some(OneStep { cost, end, normal_equations: linearization.normal_equations() })
    }

    /// Whether normal equations of its problem show that gravity and every parameter is determined.
    pub fn determines_all(&self, session: &Session, shown: &NormalEquations) -> bool {
        let JointProblem { problem, layout, .. } = &self.posed;
        let parameters = session.parameters().into_iter().map(|id| layout.block(id));
        let blocks = std::iter::once(layout.gravity).chain(parameters);
        shown.determine(&blocks.flat_map(|id| problem.columns_of(id)).collect::<Vec<_>>())
    }
}

/// Every so many poses of the readings, so that about [`POSES`] are left.
pub(super) fn thinned(readings: &Readings) -> Readings {
    let stride = readings.poses().div_ceil(POSES).max(1);
    readings.only(|pose, _| pose % stride == 0)
}
